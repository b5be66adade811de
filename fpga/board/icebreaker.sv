// SPDX-License-Identifier: Apache-2.0
// iCEBreaker (iCE40 UP5K): 12 MHz in, 8 MHz inside; pins in icebreaker.pcf. docs/hardware/fpga.md
//
// All inputs from outside have pull-ups in the pin file: an open e-stop loop is a pressed button.
`default_nettype none

module icebreaker (
  input  wire logic       clk_12mhz,
  input  wire logic       btn_n,           // reset while pressed
  input  wire logic       ftdi_txd,        // from the PC
  output logic            ftdi_rxd,
  output logic            ledr_n,          // PANIC
  output logic            ledg_n,          // the PLL has locked
  output logic      [4:0] led,
  output logic            spi_sclk,
  output logic            adc_cs_n,
  output logic            adc_din,
  input  wire logic       adc_dout,
  output logic            dac_sync_n,
  output logic            dac_din,
  input  wire logic [1:0] enc_a,
  input  wire logic [1:0] enc_b,
  input  wire logic [1:0] enc_i,
  input  wire logic [1:0] enable_n,        // switches to ground
  input  wire logic       estop_n,         // the loop to ground is closed
  output logic            brake_release
);

  localparam int ClkHz = 8_000_000;

  logic fast, locked, clk;
  logic [1:0] third_q;
  logic [3:0] reset_q;
  logic rst_n, panic, sclock;
  logic [1:0] beat;

  // 12 MHz * 64 / 32: the PLL makes no less than 16 MHz, so a third of it is taken.
  SB_PLL40_PAD #(
    .FEEDBACK_PATH("SIMPLE"),
    .DIVR(4'd0),
    .DIVF(7'd63),
    .DIVQ(3'd5),
    .FILTER_RANGE(3'd1)
  ) u_pll (
    .PACKAGEPIN(clk_12mhz),
    .PLLOUTCORE(fast),
    .LOCK(locked),
    .RESETB(1'b1),
    .BYPASS(1'b0)
  );

  always_ff @(posedge fast or negedge locked) begin
    if (!locked) third_q <= '0;
    else third_q <= {third_q[0], third_q == '0};
  end

  SB_GB u_clk (
    .USER_SIGNAL_TO_GLOBAL_BUFFER(third_q[1]),
    .GLOBAL_BUFFER_OUTPUT(clk)
  );

  always_ff @(posedge clk or negedge locked) begin
    if (!locked) {rst_n, reset_q} <= '0;
    else {rst_n, reset_q} <= {&reset_q, reset_q[2:0], btn_n};
  end

  mmcs_board #(
    .ClkHz(ClkHz)
  ) u_board (
    .clk_i(clk),
    .rst_ni(rst_n),
    .rx_i(ftdi_txd),
    .tx_o(ftdi_rxd),
    .sclk_o(spi_sclk),
    .adc_cs_no(adc_cs_n),
    .adc_din_o(adc_din),
    .adc_dout_i(adc_dout),
    .dac_sync_no(dac_sync_n),
    .dac_din_o(dac_din),
    .enc_a_i(enc_a),
    .enc_b_i(enc_b),
    .enc_i_i(enc_i),
    .axis_enable_i(~enable_n),
    .estop_closed_i(~estop_n),
    .brake_release_o(brake_release),
    .panic_o(panic),
    .sclock_o(sclock),
    .beat_o(beat)
  );

  assign ledr_n = ~panic;
  assign ledg_n = ~locked;
  assign led = {brake_release, sclock, 1'b0, beat};

endmodule

`default_nettype wire
