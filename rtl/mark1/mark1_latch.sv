// SPDX-License-Identifier: Apache-2.0
// The latch signal: rising SCLOCK, or a software latch. §5.3.2, §5.3.3
//
// Both act by their own rising edge, so that a software latch works while SCLOCK is high.
`default_nettype none

module mark1_latch #(
  parameter bit SoftLatchDac = 1'b1   // E023-E022: the D/As follow the software latch too
) (
  input  wire logic clk_i,
  input  wire logic rst_ni,
  input  wire logic sclock_i,
  input  wire logic sw_latch_i,
  // Port B
  input  wire logic sclock_en_i,
  input  wire logic dac_double_i,
  // One clock each
  output logic      latch_o,        // encoders latch, A/Ds start
  output logic      dac_update_o    // D/A outputs take what was written
);

  logic sclock_q, sw_latch_q;
  logic sclock_rise, sw_latch_rise;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      sclock_q   <= 1'b1;
      sw_latch_q <= 1'b0;
    end else begin
      sclock_q   <= sclock_i;
      sw_latch_q <= sw_latch_i;
    end
  end

  assign sclock_rise = sclock_i & ~sclock_q & sclock_en_i;
  assign sw_latch_rise = sw_latch_i & ~sw_latch_q;
  assign latch_o = sclock_rise | sw_latch_rise;
  assign dac_update_o = dac_double_i & (sclock_rise | (sw_latch_rise & SoftLatchDac));

endmodule

`default_nettype wire
