// SPDX-License-Identifier: Apache-2.0
// A testbench around the machine for any simulator with DPI-C: the driver, the joints and a scenario
// behind one imported call a clock (mmcs_dpi.h, docs/use/dpi.md). §4, §5
//
// The call reads what stood before the edge, and what it drives moves after the edge: blocking
// assignments would be another machine.
`default_nettype none

module mmcs_tb #(
  parameter int NumCards = 3,
  parameter int ClkHz = 8_000_000
);
  timeunit 1ns; timeprecision 1ps;

  import "DPI-C" context function int mmcs_dpi_open(
    input string setup, input string folder, input int cards, input int clk_hz);
  import "DPI-C" context function int mmcs_dpi_clock(
    input  int unsigned     vme,
    input  int unsigned     lines,
    input  bit      [511:0] drive,
    input  bit      [191:0] leds,
    output longint unsigned bus,
    output int unsigned     safety,
    output bit      [ 95:0] encoder,
    output bit      [ 95:0] switches,
    output bit      [511:0] adc);

  localparam int Axes = 2 * NumCards;
  localparam int ResetClks = 8;
  localparam int LastClks = 16;  // what watches the machine has so many clocks after the run

  // --- clock and reset ------------------------------------------------------------------------

  bit clk, rst_n;
  int clks;
  always #(0.5e9 / ClkHz) clk = ~clk;
  always_ff @(posedge clk) begin
    clks <= clks + 1;
    rst_n <= clks >= ResetClks - 1;
  end

  // --- machine --------------------------------------------------------------------------------

  longint unsigned bus;
  int unsigned safety;
  bit [95:0] encoder, switches;
  bit [511:0] adc;
  logic [15:0] d;
  logic d_oe, dtack_n, iackout_n, panic, brake_release, alive, sclock;
  logic [7:1] irq_n;
  logic [16*Axes-1:0] drive;
  logic [11*NumCards-1:0] leds;

  mmcs #(
    .NumCards(NumCards),
    .ClkHz(ClkHz)
  ) u_mmcs (
    .clk_i(clk),
    .rst_ni(rst_n),
    .vme_d_i(bus[15:0]),
    .vme_a_i(bus[30:16]),
    .vme_am_i(bus[36:31]),
    .vme_as_ni(bus[37]),
    .vme_ds_ni(bus[39:38]),
    .vme_write_ni(bus[40]),
    .vme_lword_ni(bus[41]),
    .vme_iack_ni(bus[42]),
    .vme_iackin_ni(bus[43]),
    .vme_sysreset_ni(bus[44]),
    .vme_d_o(d),
    .vme_d_oe_o(d_oe),
    .vme_dtack_no(dtack_n),
    .vme_iackout_no(iackout_n),
    .vme_irq_no(irq_n),
    .estop_closed_i(safety[0]),
    .cable_ok_i(safety[1]),
    .pc_power_i(safety[2]),
    .brake_release_o(brake_release),
    .alive_o(alive),
    .panic_o(panic),
    .sclock_o(sclock),
    .led_irq_o(),
    .enc_a_i(encoder[Axes-1:0]),
    .enc_b_i(encoder[32+:Axes]),
    .enc_i_i(encoder[64+:Axes]),
    .axis_enable_i(switches[Axes-1:0]),
    .dip_i(switches[32+:4*NumCards]),
    .adc_v_i(adc[16*Axes-1:0]),
    .drive_v_o(drive),
    .card_leds_o(leds),
    .pcx_a_o(),
    .pcx_d_o(),
    .pcx_d_oe_o(),
    .pcx_ior_no(),
    .pcx_iow_no(),
    .pcx_aen_o(),
    .pcx_clk_en_o(),
    .pcx_reset_drv_o(),
    .pcx_drq_o(),
    .pcx_d_i(8'h00),
    .pcx_d_oe_i(1'b0),
    .pcx_wait_i(1'b0),
    .pcx_irq_i(5'b00000)
  );

  // --- the call -------------------------------------------------------------------------------

  longint unsigned next_bus;
  int unsigned next_safety;
  bit [95:0] next_encoder, next_switches;
  bit [511:0] next_adc;
  logic [25:0] vme;
  assign vme = {irq_n, iackout_n, dtack_n, d_oe, d};
  int result;
  bit done;  // the run has ended, and all is over LastClks later
  int over_clks;

  always @(posedge clk) begin
    if (rst_n && $isunknown({vme, alive, sclock, brake_release, panic, drive, leds})) begin
      $fatal(1, "mmcs_tb: an output of the machine is X; the call knows 0 and 1 only");
    end
    result = mmcs_dpi_clock(32'(vme), {28'h0, alive, sclock, brake_release, panic}, 512'(drive),
                            192'(leds), next_bus, next_safety, next_encoder, next_switches,
                            next_adc);
    bus <= next_bus;
    safety <= next_safety;
    encoder <= next_encoder;
    switches <= next_switches;
    adc <= next_adc;
    done <= result != 0;
    if (done) over_clks <= over_clks + 1;
    if (over_clks == LastClks) begin
      if (result > 1) $fatal(1, "mmcs_tb: the run ended with status %0d", result - 1);
      $finish(0);
    end
  end

  // --- begin and end --------------------------------------------------------------------------

  string setup, folder, trace;
  initial begin
    if ($value$plusargs("trace=%s", trace)) begin
      $dumpfile(trace);
      $dumpvars(0, mmcs_tb);
    end
    if (!$value$plusargs("setup=%s", setup)) begin
      $fatal(1, "mmcs_tb: no set-up; name one, as in +setup=build/setups/puma560.bin");
    end
    if (!$value$plusargs("out=%s", folder)) folder = ".";
    if (mmcs_dpi_open(setup, folder, NumCards, ClkHz) != 0) begin
      $fatal(1, "mmcs_tb: the run does not begin");
    end
  end

endmodule

`default_nettype wire
