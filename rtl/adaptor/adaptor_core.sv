// SPDX-License-Identifier: Apache-2.0
// The five functions of an adaptor behind a host-neutral port: one byte request, one answer.
// §4.2.1, §4.3.2-4.3.5
`default_nettype none
`include "mmcs_assert.svh"
`include "mmcs_require.svh"

module adaptor_core #(
  parameter int ClkHz = 8_000_000,
  parameter int SysClkMHz = 8,
  parameter int SclockDrq = 3,
  parameter int PanicIrq = 7,
  parameter int CmdNs = 500,
  parameter int IochrdyLimitClks = 10,
  parameter int ResetDrvUs = 50,   // RESET DRV after the PC side's power returns
  parameter int AliveUs = 500,     // between two edges of alive_o
  parameter bit RandomPowerUp = 1'b0
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  // Host port: req and the rest are held until ack; rdata is valid with ack and stays.
  input  wire logic        hp_req_i,
  input  wire logic        hp_write_i,
  input  wire logic [10:1] hp_a_i,
  input  wire logic [ 7:0] hp_wdata_i,
  output logic             hp_ack_o,
  output logic      [ 7:0] hp_rdata_o,
  // Interrupt
  output logic             irq_req_o,
  output logic      [ 7:0] vector_o,
  // Safety
  input  wire logic        sys_reset_i,     // SYSRESET* is low, asynchronous
  output logic             sys_reset_o,     // the same, synchronised
  input  wire logic        estop_closed_i,
  input  wire logic        cable_ok_i,
  input  wire logic        pc_power_i,
  output logic             panic_o,
  output logic             brake_release_o,
  output logic             alive_o,
  output logic             sclock_o,
  // PC bus, as the cards see it
  output logic      [15:0] pc_a_o,
  output logic             pc_aen_o,
  output logic      [ 7:0] pc_d_o,
  output logic             pc_d_oe_o,
  output logic             pc_ior_no,
  output logic             pc_iow_no,
  output logic             pc_clk_en_o,
  output logic             pc_reset_drv_o,
  output logic      [ 3:1] pc_drq_o,
  output logic             pc_power_o,
  input  wire logic [ 7:0] pc_d_i,
  input  wire logic        pc_wait_i,
  input  wire logic [ 7:3] pc_irq_i
);

  localparam int ClkMHz = ClkHz / 1_000_000;
  // Strobe for the timer chip: it needs 150 ns.
  localparam int LocalClks = ClkMHz / 4;
  localparam int LocalWidth = $clog2(LocalClks + 1);
  localparam int ResetWidth = $clog2(ResetDrvUs * ClkMHz + 1);

  // --- parameters that cannot be ----------------------------------------------------------

  `MMCS_REQUIRE(ReqSysClk, SysClkMHz == 8 || SysClkMHz == 4 || SysClkMHz == 2 || SysClkMHz == 1,
                "mmcs: SysClkMHz must be 8, 4, 2 or 1")
  `MMCS_REQUIRE(ReqDrq, SclockDrq >= 1 && SclockDrq <= 3, "mmcs: SclockDrq must be 1 to 3")
  `MMCS_REQUIRE(ReqPanic, PanicIrq >= 3 && PanicIrq <= 7, "mmcs: PanicIrq must be 3 to 7")
  `MMCS_REQUIRE(ReqCmd, CmdNs >= 125 && CmdNs <= 10_000, "mmcs: CmdNs must be 125 to 10000")
  `MMCS_REQUIRE(ReqIochrdy, IochrdyLimitClks >= 1 && IochrdyLimitClks <= 100,
                "mmcs: IochrdyLimitClks must be 1 to 100")

  // --- host port decode -------------------------------------------------------------------

  localparam logic [10:0] PitOffset = mmcs_regs_pkg::PIT0;
  localparam logic [10:0] PccsrOffset = mmcs_regs_pkg::PCCSR;

  logic sel_pc, sel_pit, sel_pccsr, sel_vector;

  assign sel_pc = ~hp_a_i[10];
  assign sel_vector = hp_a_i[10] & hp_a_i[6];
  assign sel_pit = hp_a_i[10] & ~hp_a_i[6] & (hp_a_i[5:3] == PitOffset[5:3]);
  assign sel_pccsr = hp_a_i[10] & ~hp_a_i[6] & (hp_a_i[5:3] == PccsrOffset[5:3]);

  // --- accesses to the adaptor's own registers --------------------------------------------

  typedef enum logic [1:0] {
    StIdle,
    StStrobe,  // RD# or WR# of the timers low
    StDone     // strobe over: writes take effect, the host is answered
  } state_e;

  state_e                  state_d, state_q;
  logic   [LocalWidth-1:0] timer_d, timer_q;  // clocks of the strobe after the present one
  logic   [           7:0] local_rdata_d, local_rdata_q;
  logic   [           7:0] vector_d, vector_q;
  logic   [           7:0] pit_rdata, pccsr_rdata;
  logic                    strobe;
  logic                    local_write;       // the clock in which a written register changes

  assign strobe = (state_q == StStrobe);
  assign local_write = (state_q == StDone) & hp_write_i;
  assign vector_d = (local_write & sel_vector) ? hp_wdata_i : vector_q;

  always_comb begin
    state_d       = state_q;
    timer_d       = timer_q;
    local_rdata_d = local_rdata_q;
    case (state_q)
      StIdle: begin
        if (hp_req_i && !sel_pc) begin
          state_d = StStrobe;
          timer_d = LocalWidth'(LocalClks - 1);
        end
      end
      StStrobe: begin
        if (timer_q != '0) begin
          timer_d = timer_q - 1'b1;
        end else begin
          state_d = StDone;
          local_rdata_d = 8'hFF;
          if (!hp_write_i && sel_pit) local_rdata_d = pit_rdata;
          if (!hp_write_i && sel_pccsr) local_rdata_d = pccsr_rdata;
        end
      end
      default: state_d = StIdle;
    endcase
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q       <= StIdle;
      timer_q       <= '0;
      local_rdata_q <= 8'hFF;
      vector_q      <= mmcs_regs_pkg::VECTOR_RESET;
    end else begin
      state_q       <= state_d;
      timer_q       <= timer_d;
      local_rdata_q <= local_rdata_d;
      vector_q      <= vector_d;
    end
  end

  assign vector_o = vector_q;

  // --- PC bus -----------------------------------------------------------------------------

  logic sys_rise, sys_fall;
  logic bus_done, link_ok, cable_ok;
  logic [4:0] base;
  logic [7:0] bus_rdata;
  logic ior_n, iow_n, d_oe;

  pcbus_master #(
    .ClkHz(ClkHz),
    .CmdNs(CmdNs),
    .IochrdyLimitClks(IochrdyLimitClks)
  ) u_master (
    .clk_i, .rst_ni,
    .start_i(hp_req_i & sel_pc),
    .write_i(hp_write_i),
    .a_i({2'b00, hp_a_i[9:6], base, hp_a_i[5:1]}),
    .wdata_i(hp_wdata_i),
    .done_o(bus_done),
    .rdata_o(bus_rdata),
    .link_ok_i(link_ok),
    .clk_en_i(sys_rise),
    .pc_a_o, .pc_d_o,
    .pc_d_oe_o(d_oe),
    .pc_ior_no(ior_n),
    .pc_iow_no(iow_n),
    .pc_d_i, .pc_wait_i
  );

  assign hp_ack_o = bus_done | (state_q == StDone);
  // The address is held until the answer is taken, and the last answer is that of the last address.
  logic from_pc_d, from_pc_q;
  assign from_pc_d = hp_req_i ? sel_pc : from_pc_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) from_pc_q <= 1'b0;
    else from_pc_q <= from_pc_d;
  end

  assign hp_rdata_o = from_pc_q ? bus_rdata : local_rdata_q;

  // The lines that a pulled cable lets go idle at the cards.
  assign pc_ior_no = ior_n | ~link_ok;
  assign pc_iow_no = iow_n | ~link_ok;
  assign pc_d_oe_o = d_oe & link_ok;
  assign pc_aen_o = 1'b0;
  assign pc_clk_en_o = sys_rise & cable_ok;

  // --- clocks and timers ------------------------------------------------------------------

  logic [2:0] out;
  logic out0_rise, out0_fall, out1_rise, out1_fall;

  sysclk #(
    .ClkHz(ClkHz),
    .SysClkMHz(SysClkMHz)
  ) u_sysclk (
    .clk_i, .rst_ni,
    .rise_o(sys_rise),
    .fall_o(sys_fall)
  );

  logic [1:0] pit_a;
  assign pit_a = hp_a_i[2:1];

  /* verilator lint_off PINCONNECTEMPTY */  // nothing follows timer 2; the bus is never shared
  i8254 #(
    .PowerUpSeed(RandomPowerUp ? 32'h1989_0217 : 32'h0)
  ) u_pit (
    .clk_i, .rst_ni,
    .cs_ni(~(strobe & sel_pit)),
    .rd_ni(~strobe | hp_write_i),
    .wr_ni(~strobe | ~hp_write_i),
    .a_i(pit_a),
    .d_i(hp_wdata_i),
    .d_o(pit_rdata),
    .d_oe_o(),
    .clk0_rise_i(sys_rise),
    .clk0_fall_i(sys_fall),
    .clk1_rise_i(out0_rise),
    .clk1_fall_i(out0_fall),
    .clk2_rise_i(out1_rise),
    .clk2_fall_i(out1_fall),
    .gate_i(3'b111),
    .out_o(out),
    .out0_rise_o(out0_rise),
    .out0_fall_o(out0_fall),
    .out1_rise_o(out1_rise),
    .out1_fall_o(out1_fall),
    .out2_rise_o(),
    .out2_fall_o()
  );
  /* verilator lint_on PINCONNECTEMPTY */

  assign sclock_o = out[1];

  // After a reconnection SCLOCK reaches the cards from its next low level on: a cable that comes
  // back while it is high makes no edge.
  logic sclock_armed_d, sclock_armed_q;
  assign sclock_armed_d = link_ok & (sclock_armed_q | ~sclock_o);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) sclock_armed_q <= 1'b0;
    else sclock_armed_q <= sclock_armed_d;
  end

  assign pc_drq_o = {2'b00, sclock_o & sclock_armed_q & link_ok} << (SclockDrq - 1);

  // --- panic, resets, interrupts ----------------------------------------------------------

  logic sys_reset;
  logic [ResetWidth-1:0] power_timer_d, power_timer_q;  // clocks that RESET DRV still stands

  panic #(
    .AliveClks(AliveUs * ClkMHz)
  ) u_panic (
    .clk_i, .rst_ni,
    .bus_panic_i(pc_irq_i[PanicIrq]),
    .estop_closed_i, .cable_ok_i, .pc_power_i,
    .panic_o, .brake_release_o, .alive_o,
    .cable_ok_o(cable_ok),
    .pc_power_o
  );

  assign link_ok = cable_ok & pc_power_o;

  // RESET DRV stands from power-on on.
  mmcs_sync #(
    .ResetValue(1'b1)
  ) u_sys_reset (
    .clk_i, .rst_ni,
    .d_i(sys_reset_i),
    .q_o(sys_reset)
  );

  always_comb begin
    power_timer_d = power_timer_q;
    if (!pc_power_o) power_timer_d = ResetWidth'(ResetDrvUs * ClkMHz);
    else if (power_timer_q != '0) power_timer_d = power_timer_q - 1'b1;
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) power_timer_q <= '0;
    else power_timer_q <= power_timer_d;
  end

  assign sys_reset_o = sys_reset;
  assign pc_reset_drv_o = (sys_reset & cable_ok) | (power_timer_q != '0);

  pccsr u_pccsr (
    .clk_i, .rst_ni,
    .sys_reset_i(sys_reset),
    .write_i(local_write & sel_pccsr),
    .wdata_i(hp_wdata_i),
    .rdata_o(pccsr_rdata),
    .sclock_i(sclock_o),
    .panic_i(panic_o),
    .base_o(base),
    .irq_req_o
  );

  logic unused_out;
  assign unused_out = ^{out[2], out[0]};

  `MMCS_ASSERT(OneAnswer, !(hp_ack_o && !hp_req_i), "an answer is given only to a request")

endmodule

`default_nettype wire
