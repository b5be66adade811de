// SPDX-License-Identifier: Apache-2.0
// AD667: 12-bit D/A converter, digital side; two ranks of latches, offset binary. §5.3.3
//
// A transparent latch is a flip-flop that follows while enabled. With both ranks enabled the data
// reaches the second on the same clock, as the data sheet promises.
`default_nettype none

module ad667 #(
  parameter logic [11:0] PowerUp = 12'h800  // undefined in the real part, which has no reset pin
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  // Pins
  input  wire logic        cs_ni,
  input  wire logic [ 3:0] a_ni,   // 0: bits 3-0, 1: bits 7-4, 2: bits 11-8, 3: second rank
  input  wire logic [11:0] d_i,
  output logic      [11:0] code_o  // second rank: what the analog side converts
);

  logic [11:0] rank1_d, rank1_q;
  logic [11:0] rank2_d, rank2_q;
  logic [ 3:0] enabled;

  assign enabled = cs_ni ? 4'b0000 : ~a_ni;
  assign rank1_d = {
    enabled[2] ? d_i[11:8] : rank1_q[11:8],
    enabled[1] ? d_i[7:4] : rank1_q[7:4],
    enabled[0] ? d_i[3:0] : rank1_q[3:0]
  };
  assign rank2_d = enabled[3] ? rank1_d : rank2_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      rank1_q <= PowerUp;
      rank2_q <= PowerUp;
    end else begin
      rank1_q <= rank1_d;
      rank2_q <= rank2_d;
    end
  end

  assign code_o = rank2_q;

endmodule

`default_nettype wire
