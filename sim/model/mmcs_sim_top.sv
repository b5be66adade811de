// SPDX-License-Identifier: Apache-2.0
// The machine as the simulator holds it: `mmcs` between its pins and the VME bus master's hands.
// §4.3 (the VME side), §5.2 (the connectors).
//
// Plant pins are ports, which the C++ side writes between clocks. The VME bus is driven by exported
// DPI functions: every bus cycle of the firmware is a call from C into this module, and nothing
// else touches these lines. Changes of the few lines that a host or an operator would notice are
// reported by one imported DPI function, so that nobody needs to look at them clock by clock.
//
// Every input passes one flip-flop on its way in, loaded only in clocks in which something changed.
// It stands for the delay of real wires, and it spares the model all work on inputs at rest.

`default_nettype none

module mmcs_sim_top #(
  parameter int unsigned NumCards = 3,
  parameter int unsigned ClkHz    = 8_000_000,
  parameter bit          Gate     = 1'b0,
  parameter bit          Skip     = 1'b0
) (
  input  wire logic                   clk_i,
  input  wire logic                   rst_ni,
  input  wire logic                   moved_i,  // a pin below or a hand has changed
  // gating: clk_i, withheld where the block and `moved_i` said before the edge that it is asleep
  input  wire logic                   clk_adaptor_i,
  input  wire logic                   clk_cards_i,
  output      logic                   adaptor_awake_o,
  output      logic                   cards_awake_o,
  // skipping
  input  wire logic [15:0]            skip_extra_i,
  output      logic [15:0]            skip_horizon_o,
  // power, safety (all active high: something is wrong)
  input  wire logic                   sysreset_i,
  input  wire logic                   estop_i,
  input  wire logic                   cable_cut_i,
  input  wire logic                   pc_off_i,
  // connectors
  input  wire logic [ 2*NumCards-1:0] enc_a_i,
  input  wire logic [ 2*NumCards-1:0] enc_b_i,
  input  wire logic [ 2*NumCards-1:0] enc_i_i,
  input  wire logic [ 2*NumCards-1:0] axis_enable_i,
  input  wire logic [32*NumCards-1:0] adc_v_i,
  output      logic [32*NumCards-1:0] drive_v_o,
  output      logic [11*NumCards-1:0] card_leds_o,
  // VME, seen by the master
  output      logic                   vme_dtack_no,
  // faults
  input  wire logic [   NumCards-1:0] card_absent_i,
  input  wire logic [ 4*NumCards-1:0] dip_xor_i,
  input  wire logic [   NumCards-1:0] sclock_open_i,
  input  wire logic [   NumCards-1:0] panic_open_i,
  input  wire logic [24*NumCards-1:0] dac_stuck1_i,
  input  wire logic [24*NumCards-1:0] dac_stuck0_i,
  input  wire logic [ 2*NumCards-1:0] adc_stuck_i,
  input  wire logic                   irq_lost_i,
  // what a processor beside the machine is doing, for the waveform: docs/processors.md
  // verilator lint_off UNUSEDSIGNAL
  input  wire logic [            2:0] host_phase_i,
  input  wire logic [           31:0] host_pc_i
  // verilator lint_on UNUSEDSIGNAL
);

  // --- the bus master's hands ---------------------------------------------------------------

  logic [15:1] hand_a;
  logic [ 5:0] hand_am;
  logic        hand_as_n, hand_write_n, hand_lword_n, hand_iack_n, hand_iackin_n;
  logic [ 1:0] hand_ds_n;
  logic [15:0] hand_d;

  export "DPI-C" function mmcs_vme_address;
  export "DPI-C" function mmcs_vme_strobe;
  export "DPI-C" function mmcs_vme_release;
  export "DPI-C" function mmcs_vme_iackin;
  export "DPI-C" function mmcs_vme_sample;

  // Puts address, modifier, direction and data on the bus; strobes stay high.
  function automatic void mmcs_vme_address(input int unsigned address, input int unsigned am,
                                 input bit write, input bit lword, input int unsigned data);
    hand_a        = address[15:1];
    hand_am       = am[5:0];
    hand_write_n  = !write;
    hand_lword_n  = !lword;
    hand_d        = data[15:0];
  endfunction

  // AS* and the data strobes (bit 0 = DS0*) go low; iack: it is an acknowledge cycle.
  function automatic void mmcs_vme_strobe(input int unsigned ds, input bit iack);
    hand_as_n     = 1'b0;
    hand_ds_n     = ~ds[1:0];
    hand_iack_n   = !iack;
  endfunction

  // The IACK daisy chain driver of slot 1: falls after AS*, rises with it.
  function automatic void mmcs_vme_iackin(input bit low);
    hand_iackin_n = !low;
  endfunction

  // Every line of the master goes back to its idle level.
  function automatic void mmcs_vme_release();
    hand_as_n     = 1'b1;
    hand_ds_n     = 2'b11;
    hand_iack_n   = 1'b1;
    hand_iackin_n = 1'b1;
    hand_write_n  = 1'b1;
    hand_lword_n  = 1'b1;
  endfunction

  // What the master sees: bit 17 IACKOUT*, bit 16 the slave drives D07..D00, 15..0 the data.
  function automatic int unsigned mmcs_vme_sample();
    mmcs_vme_sample = {14'd0, vme_iackout_n, vme_d_oe, vme_d};
  endfunction

  initial begin
    hand_a        = '0;
    hand_am       = '0;
    hand_d        = '0;
    hand_as_n     = 1'b1;
    hand_ds_n     = 2'b11;
    hand_iack_n   = 1'b1;
    hand_iackin_n = 1'b1;
    hand_write_n  = 1'b1;
    hand_lword_n  = 1'b1;
  end

  // --- wires: one flip-flop each ------------------------------------------------------------

  logic [15:1]            vme_a_q;
  logic [ 5:0]            vme_am_q;
  logic                   vme_as_nq, vme_write_nq, vme_lword_nq, vme_iack_nq, vme_iackin_nq;
  logic [ 1:0]            vme_ds_nq;
  logic [15:0]            vme_dm_q, vme_d;
  logic                   vme_d_oe, vme_iackout_n;
  logic                   sysreset_nq, estop_closed_q, cable_ok_q, pc_power_q, irq_lost_q;
  logic [ 2*NumCards-1:0] enc_a_q, enc_b_q, enc_i_q, axis_enable_q, adc_stuck_q;
  logic [32*NumCards-1:0] adc_v_q;
  logic [   NumCards-1:0] card_absent_q, sclock_open_q, panic_open_q;
  logic [ 4*NumCards-1:0] dip_xor_q;
  logic [24*NumCards-1:0] dac_stuck1_q, dac_stuck0_q;

  wire clk_adaptor = Gate ? clk_adaptor_i : clk_i;

  always_ff @(posedge clk_adaptor) if (moved_i) begin
    vme_a_q        <= hand_a;
    vme_am_q       <= hand_am;
    vme_as_nq      <= hand_as_n;
    vme_ds_nq      <= hand_ds_n;
    vme_write_nq   <= hand_write_n;
    vme_lword_nq   <= hand_lword_n;
    vme_iack_nq    <= hand_iack_n;
    vme_iackin_nq  <= hand_iackin_n;
    vme_dm_q       <= hand_d;
    sysreset_nq    <= !sysreset_i;
    estop_closed_q <= !estop_i;
    cable_ok_q     <= !cable_cut_i;
    pc_power_q     <= !pc_off_i;
    enc_a_q        <= enc_a_i;
    enc_b_q        <= enc_b_i;
    enc_i_q        <= enc_i_i;
    axis_enable_q  <= axis_enable_i;
    adc_v_q        <= adc_v_i;
    card_absent_q  <= card_absent_i;
    dip_xor_q      <= dip_xor_i;
    sclock_open_q  <= sclock_open_i;
    panic_open_q   <= panic_open_i;
    dac_stuck1_q   <= dac_stuck1_i;
    dac_stuck0_q   <= dac_stuck0_i;
    adc_stuck_q    <= adc_stuck_i;
    irq_lost_q     <= irq_lost_i;
  end

  // --- the machine --------------------------------------------------------------------------

  logic [7:1] vme_irq_n;
  logic       adaptor_awake, cards_awake;
  logic       brake_release, panic, sclock, led_irq;

  mmcs #(
    .NumCards(NumCards),
    .ClkHz   (ClkHz),
    .Gate    (Gate),
    .Skip    (Skip)
  ) u_mmcs (
    .clk_i,
    .rst_ni,
    .vme_a_i         (vme_a_q),
    .vme_am_i        (vme_am_q),
    .vme_as_ni       (vme_as_nq),
    .vme_ds_ni       (vme_ds_nq),
    .vme_write_ni    (vme_write_nq),
    .vme_lword_ni    (vme_lword_nq),
    .vme_d_i         (vme_dm_q),
    .vme_d_o         (vme_d),
    .vme_d_oe_o      (vme_d_oe),
    .vme_dtack_no    (vme_dtack_no),
    .vme_iack_ni     (vme_iack_nq),
    .vme_iackin_ni   (vme_iackin_nq),
    .vme_iackout_no  (vme_iackout_n),
    .vme_irq_no      (vme_irq_n),
    .vme_sysreset_ni (sysreset_nq),
    .estop_closed_i  (estop_closed_q),
    .cable_ok_i      (cable_ok_q),
    .pc_power_i      (pc_power_q),
    .brake_release_o (brake_release),
    .panic_o         (panic),
    .sclock_o        (sclock),
    .led_irq_o       (led_irq),
    .enc_a_i         (enc_a_q),
    .enc_b_i         (enc_b_q),
    .enc_i_i         (enc_i_q),
    .axis_enable_i   (axis_enable_q),
    .adc_v_i         (adc_v_q),
    .drive_v_o,
    .card_leds_o,
    .hp_req_i        (1'b0),
    .hp_write_i      (1'b0),
    .hp_a_i          ('0),
    .hp_wdata_i      ('0),
    .clk_adaptor_i,
    .clk_cards_i,
    .adaptor_awake_o (adaptor_awake),
    .cards_awake_o   (cards_awake),
    .skip_extra_i,
    .skip_horizon_o,
    .card_absent_i   (card_absent_q),
    .dip_xor_i       (dip_xor_q),
    .sclock_open_i   (sclock_open_q),
    .panic_open_i    (panic_open_q),
    .dac_stuck1_i    (dac_stuck1_q),
    .dac_stuck0_i    (dac_stuck0_q),
    .adc_stuck_i     (adc_stuck_q),
    .irq_lost_i      (irq_lost_q),
    .pcx_d_i         (8'h00),
    .pcx_d_oe_i      (1'b0),
    .pcx_wait_i      (1'b0),
    .pcx_irq_i       ('0),
    /* verilator lint_off PINCONNECTEMPTY */  // no expansion card, no other host here
    .hp_ack_o        (),
    .hp_rdata_o      (),
    .pcx_a_o         (),
    .pcx_d_o         (),
    .pcx_ior_no      (),
    .pcx_iow_no      (),
    .pcx_aen_o       (),
    .pcx_clk_en_o    (),
    .pcx_reset_drv_o (),
    .pcx_drq_o       ()
    /* verilator lint_on PINCONNECTEMPTY */
  );

  // --- what a host or an operator notices ---------------------------------------------------

  // lines: 7..1 IRQ7*..IRQ1* (1 = requesting), 8 PANIC, 9 brakes released, 10 SCLOCK.
  import "DPI-C" context function void mmcs_lines_changed(input int unsigned lines);

  wire  [10:0] lines = {sclock, brake_release, panic, ~vme_irq_n, 1'b0};
  logic [10:0] lines_q;

  always_ff @(posedge clk_adaptor or negedge rst_ni) begin
    if (!rst_ni) begin
      lines_q <= '0;
    end else if (lines != lines_q) begin
      lines_q <= lines;
      mmcs_lines_changed({21'd0, lines});
    end
  end

  // --- gating -------------------------------------------------------------------------------

  // Inputs have moved: both blocks take them in.
  logic [1:0] stay_q;
  always_ff @(posedge clk_adaptor or negedge rst_ni) begin
    if (!rst_ni) stay_q <= 2'd3;
    else if (moved_i) stay_q <= 2'd3;
    else if (stay_q != 2'd0) stay_q <= stay_q - 2'd1;
  end

  logic stay, lines_move;
  always_comb begin
    stay       = 1'b0;
    lines_move = 1'b0;
    if (stay_q != 2'd0) stay = 1'b1;
    if (lines != lines_q) lines_move = 1'b1;
  end
  assign adaptor_awake_o = stay || lines_move || adaptor_awake;
  assign cards_awake_o   = stay || cards_awake;

  // --- looks inside -------------------------------------------------------------------------

  export "DPI-C" function mmcs_adaptor_digest;

  // PCCSR, both latches, vector.
  function automatic int unsigned mmcs_adaptor_digest();
    mmcs_adaptor_digest = {
      14'd0,
      u_mmcs.u_adaptor.u_core.u_pccsr.sclock_latch_q,
      u_mmcs.u_adaptor.u_core.u_pccsr.panic_latch_q,
      u_mmcs.u_adaptor.u_core.u_pccsr.csr_q,
      u_mmcs.u_adaptor.u_core.vector_q
    };
  endfunction

  for (genvar n = 0; n < NumCards; n++) begin : g_probe
    mmcs_sim_probe #(.Card(n), .Joint(0)) u_joint1 ();
    mmcs_sim_probe #(.Card(n), .Joint(1)) u_joint2 ();
  end

  // `led_irq` follows the interrupt request, which `lines` holds already.
  logic unused;
  assign unused = led_irq;

endmodule

`default_nettype wire
