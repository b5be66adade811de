// SPDX-License-Identifier: Apache-2.0
// A testbench to copy: the machine with one card, one motor, and the driver of firmware/ behind one
// DPI call a clock (host.c). Nothing of the simulator's engine is in it.
`default_nettype none

module example_tb;
  timeunit 1ns; timeprecision 1ps;

  // seen: 15..0 D, 16 DTACK*, 17 IRQ5*. pins: 15..0 D, 30..16 A15..A1, 36..31 AM, 37 AS*, 39..38
  // DS1* DS0*, 40 WRITE*, 41 LWORD*, 42 IACK*, 43 IACKIN*. Result: the program has ended.
  import "DPI-C" context function int host_clock(input int unsigned seen,
                                                 output longint unsigned pins);

  bit clk, rst_n, sysreset_n;
  int clks;
  always #62.5 clk = ~clk;  // 8 MHz

  logic [15:0] d;
  logic dtack_n;
  logic [7:1] irq_n;
  logic [31:0] drive;
  bit [1:0] enc_a, enc_b;
  longint unsigned pins = 64'h0FFF_8000_FFFF;  // nobody on the bus

  mmcs #(
    .NumCards(1)
  ) u_mmcs (
    .clk_i(clk), .rst_ni(rst_n),
    .vme_d_i(pins[15:0]), .vme_a_i(pins[30:16]), .vme_am_i(pins[36:31]), .vme_as_ni(pins[37]),
    .vme_ds_ni(pins[39:38]), .vme_write_ni(pins[40]), .vme_lword_ni(pins[41]),
    .vme_iack_ni(pins[42]), .vme_iackin_ni(pins[43]), .vme_sysreset_ni(sysreset_n),
    .vme_d_o(d), .vme_d_oe_o(), .vme_dtack_no(dtack_n), .vme_iackout_no(), .vme_irq_no(irq_n),
    .estop_closed_i(1'b1), .cable_ok_i(1'b1), .pc_power_i(1'b1),
    .brake_release_o(), .alive_o(), .panic_o(), .sclock_o(), .led_irq_o(),
    .enc_a_i(enc_a), .enc_b_i(enc_b), .enc_i_i(2'b00), .axis_enable_i(2'b11), .dip_i(4'h0),
    .adc_v_i(32'h0), .drive_v_o(drive), .card_leds_o(),
    .pcx_a_o(), .pcx_d_o(), .pcx_d_oe_o(), .pcx_ior_no(), .pcx_iow_no(),
    .pcx_aen_o(), .pcx_clk_en_o(), .pcx_reset_drv_o(), .pcx_drq_o(), .pcx_d_i(8'h00),
    .pcx_d_oe_i(1'b0), .pcx_wait_i(1'b0),
    .pcx_irq_i(5'b00000)
  );

  // A motor of sorts: its speed follows the drive within 5 ms, 8000 counts a second and volt.
  real speed, counts;
  int quarter;
  always @(posedge clk) begin
    speed = speed + (real'($signed(drive[15:0])) / 3276.8 * 8000.0 - speed) * (125.0e-9 / 0.005);
    counts = counts + speed * 125.0e-9;
    quarter = $rtoi($floor(counts));
    enc_a <= {1'b0, quarter[1] ^ quarter[0]};
    enc_b <= {1'b0, quarter[1]};
  end

  // What is read stood before the edge, what is driven moves after it.
  longint unsigned next;
  int done;
  always @(posedge clk) begin
    clks <= clks + 1;
    rst_n <= clks >= 7;
    sysreset_n <= clks >= 31;
    if (clks >= 63) begin
      done = host_clock({14'h0, irq_n[5], dtack_n, d}, next);
      pins <= next;
      if (done != 0) $finish(0);
    end
  end

endmodule

`default_nettype wire
