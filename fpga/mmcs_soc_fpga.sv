// SPDX-License-Identifier: Apache-2.0
// mmcs_soc with pins that a board has: analog values and the window to the memory go through
// shift registers, all on one clock. The top of `make fpga`; docs/hardware/fpga.md, docs/hardware/soc.md.
//
// Converters: a frame of 32 NumCards clocks, MSB first, marked by conv_sync_o in its first clock;
// what came in during one frame is in force in the next. Window: 63 bits are shifted in, MSB first,
// while host_shift_i is 1 (write, word address, data), then host_go_i is 1 for one clock; the
// answer stands when host_ready_o is 1 again and is shifted out the same way, 32 bits.
`default_nettype none

module mmcs_soc_fpga #(
  parameter int NumCards = 3,
  parameter int ClkHz = 24_000_000,
  parameter InitFile = ""
) (
  input  wire logic                   clk_i,
  input  wire logic                   rst_ni,
  input  wire logic                   run_i,
  input  wire logic                   host_shift_i,
  input  wire logic                   host_sd_i,
  output logic                        host_sd_o,
  input  wire logic                   host_go_i,
  output logic                        host_ready_o,
  input  wire logic                   ring_i,
  output logic                        report_valid_o,
  output logic      [            7:0] report_o,
  input  wire logic                   report_take_i,
  input  wire logic                   sysreset_ni,
  input  wire logic                   estop_closed_i,
  input  wire logic                   cable_ok_i,
  input  wire logic                   pc_power_i,
  output logic                        brake_release_o,
  output logic                        alive_o,
  output logic                        panic_o,
  output logic                        sclock_o,
  output logic                        led_irq_o,
  input  wire logic [ 2*NumCards-1:0] enc_a_i,
  input  wire logic [ 2*NumCards-1:0] enc_b_i,
  input  wire logic [ 2*NumCards-1:0] enc_i_i,
  input  wire logic [ 2*NumCards-1:0] axis_enable_i,
  input  wire logic [ 4*NumCards-1:0] dip_i,
  output logic                        conv_sync_o,
  input  wire logic                   adc_sd_i,
  output logic                        dac_sd_o,
  output logic      [11*NumCards-1:0] card_leds_o
);

  logic rst_n;   // begins at once, ends with the clock
  sync u_reset (.clk_i, .rst_ni, .en_i(1'b1), .d_i(1'b1), .q_o(rst_n));

  // --- converters -------------------------------------------------------------------------

  localparam int Bits = 32 * NumCards;
  localparam int Width = $clog2(Bits);

  logic [Width-1:0] bit_d, bit_q;
  logic [Bits-1:0] drive, drive_d, drive_q, adc_in, adc_d, adc_q;
  logic [Bits-2:0] adc_shift_q;
  logic last;

  assign last = (bit_q == Width'(Bits - 1));
  assign adc_in = {adc_shift_q, adc_sd_i};
  assign bit_d = last ? '0 : bit_q + 1'b1;
  assign drive_d = last ? drive : {drive_q[Bits-2:0], 1'b0};
  assign adc_d = last ? adc_in : adc_q;

  always_ff @(posedge clk_i or negedge rst_n) begin
    if (!rst_n) begin
      bit_q       <= '0;
      drive_q     <= '0;
      adc_shift_q <= '0;
      adc_q       <= '0;
    end else begin
      bit_q       <= bit_d;
      drive_q     <= drive_d;
      adc_shift_q <= adc_in[Bits-2:0];
      adc_q       <= adc_d;
    end
  end

  assign conv_sync_o = (bit_q == '0);
  assign dac_sd_o = drive_q[Bits-1];

  // --- window -----------------------------------------------------------------------------

  logic [62:0] host_d, host_q;
  logic req_d, req_q, ack;
  logic [31:0] rdata;

  assign req_d = ~ack & (req_q | host_go_i);

  always_comb begin
    host_d = host_q;
    if (ack) host_d = {rdata, 31'd0};
    else if (host_shift_i && !req_q) host_d = {host_q[61:0], host_sd_i};
  end

  always_ff @(posedge clk_i or negedge rst_n) begin
    if (!rst_n) begin
      host_q <= '0;
      req_q  <= 1'b0;
    end else begin
      host_q <= host_d;
      req_q  <= req_d;
    end
  end

  assign host_sd_o = host_q[62];
  assign host_ready_o = !req_q;

  // --- the SoC ----------------------------------------------------------------------------

  /* verilator lint_off PINCONNECTEMPTY */
  mmcs_soc #(
    .NumCards(NumCards),
    .ClkHz(ClkHz),
    .InitFile(InitFile)
  ) u_soc (
    .clk_i,
    .cpu_clk_i(clk_i),
    .rst_ni(rst_n),
    .run_i,
    .box_req_i(req_q),
    .box_write_i(host_q[62]),
    .box_a_i(host_q[61:32]),
    .box_wdata_i(host_q[31:0]),
    .box_ack_o(ack),
    .box_rdata_o(rdata),
    .ring_i, .report_valid_o, .report_o, .report_take_i,
    .sysreset_ni, .estop_closed_i, .cable_ok_i, .pc_power_i,
    .brake_release_o, .alive_o, .panic_o, .sclock_o, .led_irq_o,
    .enc_a_i, .enc_b_i, .enc_i_i, .axis_enable_i, .dip_i,
    .adc_v_i(adc_q),
    .drive_v_o(drive),
    .card_leds_o
  );
  /* verilator lint_on PINCONNECTEMPTY */

endmodule

`default_nettype wire
