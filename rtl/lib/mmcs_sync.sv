// SPDX-License-Identifier: Apache-2.0
// Synchroniser: two flip-flops, of which the second alone reads the first. §4.3.1
//
// Only a level that stands longer than a clock is sure to be seen, and bits of a bus may come a
// clock apart: what belongs together crosses as one bit.
`default_nettype none

module mmcs_sync #(
  parameter int Width = 1,
  parameter logic [Width-1:0] ResetValue = '0
) (
  input  wire logic             clk_i,
  input  wire logic             rst_ni,
  input  wire logic [Width-1:0] d_i,    // asynchronous
  output logic      [Width-1:0] q_o
);

  (* ASYNC_REG = "TRUE" *) logic [Width-1:0] first_q;
  (* ASYNC_REG = "TRUE" *) logic [Width-1:0] second_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      first_q  <= ResetValue;
      second_q <= ResetValue;
    end else begin
      first_q  <= d_i;
      second_q <= first_q;
    end
  end

  assign q_o = second_q;

endmodule

`default_nettype wire
