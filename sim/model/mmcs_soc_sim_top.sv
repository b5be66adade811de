// SPDX-License-Identifier: Apache-2.0
// The machine with its own processor as the simulator holds it: `mmcs_soc` between its pins and the
// computer above. The twin of mmcs_sim_top.sv, under the same name, for builds with HOST=rv32.
//
// Plant pins are ports, which the C++ side writes between clocks. It looks into the memory of the
// processor directly (soc_memory.h), while the processor waits for its report to be taken. Changes
// of the few lines that an operator would notice, reports and bus errors are told by imported DPI
// functions, so that nobody needs to look at them clock by clock.
//
// Every input passes one flip-flop on its way in, loaded only in clocks in which something changed.
// It stands for the delay of real wires, and it spares the model all work on inputs at rest.

`default_nettype none

// verilog_lint: waive module-filename
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
  // the computer above; a change of soc_errors_i[16] lets so many accesses fail as the rest says
  input  wire logic                   cpu_clk_i,
  output      logic                   cpu_awake_o,
  input  wire logic                   soc_run_i,
  input  wire logic                   soc_ring_i,    // a change rings
  input  wire logic                   soc_irq_open_i,
  input  wire logic [16:0]            soc_errors_i,
  output      logic                   vme_dtack_no,  // no VME here: always 1
  // what the firmware is doing, for the waveform: docs/processors.md
  input  wire logic [            2:0] host_phase_i,
  // faults
  input  wire logic [   NumCards-1:0] card_absent_i,
  input  wire logic [ 4*NumCards-1:0] dip_xor_i,
  input  wire logic [   NumCards-1:0] sclock_open_i,
  input  wire logic [   NumCards-1:0] panic_open_i,
  input  wire logic [24*NumCards-1:0] dac_stuck1_i,
  input  wire logic [24*NumCards-1:0] dac_stuck0_i,
  input  wire logic [ 2*NumCards-1:0] adc_stuck_i,
  input  wire logic                   irq_lost_i
);

  // --- wires: one flip-flop each ------------------------------------------------------------

  logic                   run_q, ring_q, irq_open_q;
  logic [16:0]            errors_q;
  logic                   sysreset_nq, estop_closed_q, cable_ok_q, pc_power_q, irq_lost_q;
  logic [ 2*NumCards-1:0] enc_a_q, enc_b_q, enc_i_q, axis_enable_q, adc_stuck_q;
  logic [32*NumCards-1:0] adc_v_q;
  logic [   NumCards-1:0] card_absent_q, sclock_open_q, panic_open_q;
  logic [ 4*NumCards-1:0] dip_xor_q;
  logic [24*NumCards-1:0] dac_stuck1_q, dac_stuck0_q;

  wire clk_adaptor = Gate ? clk_adaptor_i : clk_i;

  always_ff @(posedge clk_adaptor) if (moved_i) begin
    run_q          <= soc_run_i;
    ring_q         <= soc_ring_i;
    irq_open_q     <= soc_irq_open_i;
    errors_q       <= soc_errors_i;
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

  logic       adaptor_awake, cards_awake;
  logic       brake_release, panic, sclock, led_irq;
  logic       ring_seen_q, report_valid, take_q, bus_error_taken, set_q;
  logic [ 7:0] report;
  logic [15:0] errors_left_q;

  mmcs_soc #(
    .NumCards(NumCards),
    .ClkHz   (ClkHz),
    .Gate    (Gate)
  ) u_soc (
    .clk_i,
    .cpu_clk_i,
    .rst_ni,
    .run_i           (run_q),
    .box_req_i       (1'b0),
    .box_write_i     (1'b0),
    .box_a_i         ('0),
    .box_wdata_i     ('0),
    /* verilator lint_off PINCONNECTEMPTY */  // its memory is looked at directly
    .box_ack_o       (),
    .box_rdata_o     (),
    /* verilator lint_on PINCONNECTEMPTY */
    .ring_i          (ring_q != ring_seen_q),
    .report_valid_o  (report_valid),
    .report_o        (report),
    .report_take_i   (take_q),
    .sysreset_ni     (sysreset_nq),
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
    .bus_error_i     (errors_left_q != '0),
    .bus_error_taken_o(bus_error_taken),
    .irq_open_i      (irq_open_q),
    .card_absent_i   (card_absent_q),
    .dip_xor_i       (dip_xor_q),
    .sclock_open_i   (sclock_open_q),
    .panic_open_i    (panic_open_q),
    .dac_stuck1_i    (dac_stuck1_q),
    .dac_stuck0_i    (dac_stuck0_q),
    .adc_stuck_i     (adc_stuck_q),
    .irq_lost_i      (irq_lost_q),
    .clk_adaptor_i,
    .clk_cards_i,
    .adaptor_awake_o (adaptor_awake),
    .cards_awake_o   (cards_awake),
    .cpu_awake_o
  );

  // --- the computer above -------------------------------------------------------------------

  import "DPI-C" context function void mmcs_soc_reported(input int unsigned what);
  import "DPI-C" context function void mmcs_soc_bus_error(input int unsigned offset);

  always_ff @(posedge clk_adaptor or negedge rst_ni) begin
    if (!rst_ni) begin
      ring_seen_q   <= 1'b0;
      take_q        <= 1'b0;
      set_q         <= 1'b0;
      errors_left_q <= '0;
    end else begin
      ring_seen_q <= ring_q;
      take_q      <= report_valid && !take_q;
      set_q       <= errors_q[16];
      if (errors_q[16] != set_q) errors_left_q <= errors_q[15:0];
      else if (bus_error_taken) errors_left_q <= errors_left_q - 1'b1;
      if (report_valid && !take_q) mmcs_soc_reported({24'd0, report});
      if (bus_error_taken) mmcs_soc_bus_error({21'd0, u_soc.u_host.u_bridge.a_q, 1'b1});
    end
  end

  // What the processor does, as SocStep has it: nothing but these accesses and the fetch of the
  // interrupt's vector tells the phases of a servo pass.
  import "DPI-C" context function void mmcs_soc_stepped(input int unsigned what,
                                                        input int unsigned offset);
  localparam logic [31:0] ServoVector = 32'h2C;  // machine external interrupt

  always_ff @(posedge cpu_clk_i) begin
    if (u_soc.u_host.instr_req && u_soc.u_host.instr_addr == ServoVector) mmcs_soc_stepped(0, 0);
    if (u_soc.u_host.u_bridge.start_i && !u_soc.u_host.u_bridge.clock_i) mmcs_soc_stepped(1, 0);
    if (u_soc.u_host.u_bridge.done_o && !u_soc.u_host.u_bridge.clock_q) begin
      mmcs_soc_stepped(u_soc.u_host.u_bridge.write_q ? 3 : 2,
                       {21'd0, u_soc.u_host.u_bridge.a_q, 1'b1});
    end
  end

  logic [2:0] host_phase;
  assign host_phase = u_soc.u_host.sleep ? 3'd0 : host_phase_i;

  assign vme_dtack_no = 1'b1;
  assign skip_horizon_o = 16'd1;
  logic unused;
  assign unused = Skip ^ (^skip_extra_i) ^ (^host_phase);

  // --- what a host or an operator notices ---------------------------------------------------

  // lines: 5 the adaptor's interrupt, 8 PANIC, 9 brakes released, 10 SCLOCK.
  import "DPI-C" context function void mmcs_lines_changed(input int unsigned lines);

  wire  [10:0] lines = {sclock, brake_release, panic, 2'b00, led_irq, 5'b00000};
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
      u_soc.u_mmcs.u_adaptor.u_core.u_pccsr.sclock_latch_q,
      u_soc.u_mmcs.u_adaptor.u_core.u_pccsr.panic_latch_q,
      u_soc.u_mmcs.u_adaptor.u_core.u_pccsr.csr_q,
      u_soc.u_mmcs.u_adaptor.u_core.vector_q
    };
  endfunction

  for (genvar n = 0; n < NumCards; n++) begin : g_probe
    mmcs_sim_probe #(.Card(n), .Joint(0)) u_joint1 ();
    mmcs_sim_probe #(.Card(n), .Joint(1)) u_joint2 ();
  end

endmodule

`default_nettype wire
