// SPDX-License-Identifier: Apache-2.0
// AD667: 12-bit D/A converter, digital side; two ranks of latches, offset binary.
// §5.3.3

`default_nettype none

module ad667 #(
  parameter logic [11:0] PowerUp = 12'h800  // undefined in the real part, which has no reset pin
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  // pins
  input  wire logic        cs_ni,
  input  wire logic [ 3:0] a_ni,   // 0: bits 3..0, 1: bits 7..4, 2: bits 11..8, 3: second rank
  input  wire logic [11:0] d_i,
  output      logic [11:0] code_o  // second rank: what the analog side converts
);
  logic [11:0] rank1_q, rank2_q;

  function automatic logic [11:0] merge(input logic [11:0] old, input logic [11:0] d,
                                        input logic [2:0] keep);
    merge = {keep[2] ? old[11:8] : d[11:8], keep[1] ? old[7:4] : d[7:4],
             keep[0] ? old[3:0] : d[3:0]};
  endfunction

  // A transparent latch is a flip-flop that follows while enabled. With both ranks enabled the
  // data reaches the second on the same clock, as the data sheet promises.

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      rank1_q <= PowerUp;
      rank2_q <= PowerUp;
    end else if (!cs_ni) begin
      if (!a_ni[3]) rank2_q <= merge(rank1_q, d_i, a_ni[2:0]);
      rank1_q <= merge(rank1_q, d_i, a_ni[2:0]);
    end
  end

  assign code_o = rank2_q;
endmodule

`default_nettype wire
