// SPDX-License-Identifier: Apache-2.0
// The board's top under the names of mmcs_board; the clock is what its PLL would put out.
`default_nettype none

module bench_ulx3s (
  input  wire logic       clk_i,
  input  wire logic       rst_ni,
  input  wire logic       rx_i,
  output logic            tx_o,
  output logic            sclk_o,
  output logic            adc_cs_no,
  output logic            adc_din_o,
  input  wire logic       adc_dout_i,
  output logic            dac_sync_no,
  output logic            dac_din_o,
  input  wire logic [1:0] enc_a_i,
  input  wire logic [1:0] enc_b_i,
  input  wire logic [1:0] enc_i_i,
  input  wire logic [1:0] axis_enable_i,
  input  wire logic       estop_closed_i,
  output logic            brake_release_o,
  output logic            panic_o,
  output logic      [1:0] beat_o
);

  logic [7:0] led;
  logic unused_gpio0, unused;

  ulx3s u_board (
    .clk_25mhz(clk_i), .btn_pwr_n(rst_ni),
    .ftdi_txd(rx_i), .ftdi_rxd(tx_o), .wifi_gpio0(unused_gpio0), .led,
    .spi_sclk(sclk_o), .adc_cs_n(adc_cs_no), .adc_din(adc_din_o), .adc_dout(adc_dout_i),
    .dac_sync_n(dac_sync_no), .dac_din(dac_din_o),
    .enc_a(enc_a_i), .enc_b(enc_b_i), .enc_i(enc_i_i),
    .enable_n(~axis_enable_i), .estop_n(~estop_closed_i), .brake_release(brake_release_o)
  );

  assign panic_o = led[6];
  assign beat_o = led[1:0];
  assign unused = ^{led[7], led[5:2]};

endmodule

`default_nettype wire
