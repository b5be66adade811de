// SPDX-License-Identifier: Apache-2.0
// Stands for rtl/lib in simulation: an input that changed shortly before the clock is taken
// as it was or as it is, each bit by itself and at random; so is a clear that ended then.
`timescale 1ps/1ps
`default_nettype none

module mmcs_sync_en #(
  parameter int Width = 1,
  parameter logic [Width-1:0] ResetValue = '0
) (
  input  wire logic             clk_i,
  input  wire logic             rst_ni,
  input  wire logic             en_i,
  input  wire logic [Width-1:0] d_i,
  output logic      [Width-1:0] q_o
);

  localparam longint WindowPs = 2_000;

  for (genvar n = 0; n < Width; n++) begin : g_bit
    logic first_q, second_q, level, level_q, before_q;
    longint moved_q = 0;
    assign level = rst_ni ? d_i[n] : ResetValue[n];

    always @(level) begin
      if (level != level_q) begin
        before_q = level_q;
        level_q  = level;
        moved_q  = $time;
      end
    end

    always_ff @(posedge clk_i or negedge rst_ni) begin
      if (!rst_ni) begin
        first_q  <= ResetValue[n];
        second_q <= ResetValue[n];
      end else if (en_i) begin
        first_q  <= ($time - moved_q < WindowPs && 1'($urandom)) ? before_q : level;
        second_q <= first_q;
      end
    end
    assign q_o[n] = second_q;
  end

endmodule

module mmcs_sync #(
  parameter int Width = 1,
  parameter logic [Width-1:0] ResetValue = '0
) (
  input  wire logic             clk_i,
  input  wire logic             rst_ni,
  input  wire logic [Width-1:0] d_i,
  output logic      [Width-1:0] q_o
);

  mmcs_sync_en #(.Width(Width), .ResetValue(ResetValue)) u_sync (.en_i(1'b1), .*);

endmodule

`default_nettype wire
