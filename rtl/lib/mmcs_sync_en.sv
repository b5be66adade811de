// SPDX-License-Identifier: Apache-2.0
// Synchroniser with an enable: mmcs_sync whose flip-flops take their inputs in some clocks only.
`default_nettype none

module mmcs_sync_en #(
  parameter int Width = 1,
  parameter logic [Width-1:0] ResetValue = '0
) (
  input  wire logic             clk_i,
  input  wire logic             rst_ni,
  input  wire logic             en_i,   // the two take their inputs in this clock
  input  wire logic [Width-1:0] d_i,    // asynchronous
  output logic      [Width-1:0] q_o
);

  logic [Width-1:0] first_d, second_d;
  (* ASYNC_REG = "TRUE" *) logic [Width-1:0] first_q;
  (* ASYNC_REG = "TRUE" *) logic [Width-1:0] second_q;

  assign first_d = en_i ? d_i : first_q;
  assign second_d = en_i ? first_q : second_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      first_q  <= ResetValue;
      second_q <= ResetValue;
    end else begin
      first_q  <= first_d;
      second_q <= second_d;
    end
  end

  assign q_o = second_q;

endmodule

`default_nettype wire
