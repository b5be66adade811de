// SPDX-License-Identifier: Apache-2.0
// A low pass of the first order between two analog pins, sixteen clocks its time constant.
`default_nettype none

module low_pass (
  input  wire logic               clk_i,
  input  wire logic               rst_ni,
  input  wire logic signed [15:0] vin_i,  // 32768 = 10 V
  output logic signed      [15:0] vout_o
);

  logic signed [19:0] state_q;  // 16 times the output

  assign vout_o = state_q[19:4];

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) state_q <= '0;
    else state_q <= state_q + 20'(vin_i) - 20'(vout_o);
  end

endmodule

`default_nettype wire
