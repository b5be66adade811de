// SPDX-License-Identifier: Apache-2.0
// A quadrature counter: four counts a line, cleared by the index if asked to.
`default_nettype none

module quad_counter (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  // Encoder
  input  wire logic        a_i,
  input  wire logic        b_i,
  input  wire logic        i_i,
  // Count
  input  wire logic        home_i,  // the index clears it
  output logic      [15:0] count_o,
  output logic             error_o  // sticky: A and B moved at once
);

  logic [1:0] sync_q, now_q, was_q;  // {B, A}
  logic index_q, index2_q, up;

  assign up = now_q[0] ^ was_q[1];

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      {sync_q, now_q, was_q} <= '0;
      {index_q, index2_q}    <= '0;
      count_o                <= '0;
      error_o                <= 1'b0;
    end else begin
      {was_q, now_q, sync_q} <= {now_q, sync_q, b_i, a_i};
      {index2_q, index_q}    <= {index_q, i_i};
      if (home_i && index2_q) count_o <= '0;
      else if (&(now_q ^ was_q)) error_o <= 1'b1;
      else if (|(now_q ^ was_q)) count_o <= up ? count_o + 1'b1 : count_o - 1'b1;
    end
  end

endmodule

`default_nettype wire
