// SPDX-License-Identifier: Apache-2.0
// Runs one I/O cycle on the PC bus for each request: address, command, hold. §4.2.1, §4.3.2
//
// The command is real time (CmdNs), whatever the rate of CLK. IOCHRDY stretches it by up to
// IochrdyLimitClks periods of CLK; a card that holds it longer is given up and 0xFF is read, so
// that the host never hangs.
`default_nettype none
`include "mmcs_assert.svh"

module pcbus_master #(
  parameter int ClkHz = 8_000_000,
  parameter int CmdNs = 500,
  parameter int IochrdyLimitClks = 10
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  // Request: start_i is taken when idle; address and data are captured then.
  input  wire logic        start_i,
  input  wire logic        write_i,
  input  wire logic [15:0] a_i,
  input  wire logic [ 7:0] wdata_i,
  output logic             done_o,      // one clock, rdata_o is valid and stays
  output logic      [ 7:0] rdata_o,
  // State of the link
  input  wire logic        link_ok_i,   // cable plugged and PC side powered
  input  wire logic        clk_en_i,    // one per period of CLK
  // Bus
  output logic      [15:0] pc_a_o,
  output logic      [ 7:0] pc_d_o,
  output logic             pc_d_oe_o,   // the data of a write stand: from set-up to hold
  output logic             pc_ior_no,
  output logic             pc_iow_no,
  input  wire logic [ 7:0] pc_d_i,      // 0xFF where nobody drives
  input  wire logic        pc_wait_i    // 1: IOCHRDY is pulled low; asynchronous
);

  localparam int ClkMHz = ClkHz / 1_000_000;
  localparam int CmdClks = (CmdNs * ClkMHz + 999) / 1000;
  // Address set-up and data hold are one period of an 8 MHz bus.
  localparam int SideClks = ClkMHz / 8;
  localparam int TimerWidth = $clog2(CmdClks + SideClks + 1);
  localparam int WaitWidth = $clog2(IochrdyLimitClks + 1);

  typedef enum logic [1:0] {
    StIdle,
    StSetup,    // address and data stand, no command yet
    StCommand,  // IOR# or IOW# low
    StHold      // command over, address and data still stand
  } state_e;

  state_e                  state_d, state_q;
  logic   [TimerWidth-1:0] timer_d, timer_q;  // clocks of this state after the present one
  logic   [ WaitWidth-1:0] waits_d, waits_q;  // periods of CLK that IOCHRDY has stretched
  logic                    write_d, write_q, ior_nd, ior_nq, iow_nd, iow_nq;
  logic   [          15:0] a_d, a_q;
  logic   [           7:0] d_d, d_q, rdata_d, rdata_q;
  logic                    last, iochrdy_low, waiting, counts, command;
  logic   [           1:0] counts_d, counts_q;  // counting begins as late as IOCHRDY is seen

  mmcs_sync u_wait (.clk_i, .rst_ni, .d_i(pc_wait_i), .q_o(iochrdy_low));

  assign last = (timer_q == '0);
  assign waiting = iochrdy_low & link_ok_i;
  assign counts = clk_en_i & counts_q[1];
  // Once the link has failed, a command ends: a cable that bounces makes no second one.
  assign command = (state_d == StCommand) & link_ok_i &
                   ((state_q != StCommand) | ~(ior_nq & iow_nq));
  assign ior_nd = ~command | write_q;
  assign iow_nd = ~command | ~write_q;
  assign counts_d = {counts_q[0], state_q == StCommand && last && waiting};

  always_comb begin
    state_d = state_q;
    timer_d = last ? '0 : timer_q - 1'b1;
    waits_d = waits_q;
    write_d = write_q;
    a_d     = a_q;
    d_d     = d_q;
    rdata_d = rdata_q;
    case (state_q)
      StIdle: begin
        if (start_i) begin
          state_d = StSetup;
          timer_d = TimerWidth'(SideClks - 1);
          write_d = write_i;
          a_d     = a_i;
          if (write_i) d_d = wdata_i;
        end
      end
      StSetup: begin
        if (last) begin
          state_d = StCommand;
          timer_d = TimerWidth'(CmdClks - 1);
          waits_d = '0;
        end
      end
      StCommand: begin
        if (last && waiting && waits_q != WaitWidth'(IochrdyLimitClks)) begin
          if (counts) waits_d = waits_q + 1'b1;
        end else if (last) begin
          state_d = StHold;
          timer_d = TimerWidth'(SideClks - 1);
          rdata_d = (ior_nq || waiting || !link_ok_i) ? 8'hFF : pc_d_i;
        end
      end
      default: if (last) state_d = StIdle;
    endcase
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q  <= StIdle;
      timer_q  <= '0;
      waits_q  <= '0;
      counts_q <= '0;
      write_q  <= 1'b0;
      a_q      <= '0;
      d_q      <= 8'hFF;
      ior_nq   <= 1'b1;
      iow_nq   <= 1'b1;
      rdata_q  <= 8'hFF;
    end else begin
      state_q  <= state_d;
      timer_q  <= timer_d;
      waits_q  <= waits_d;
      counts_q <= counts_d;
      write_q  <= write_d;
      a_q      <= a_d;
      d_q      <= d_d;
      ior_nq   <= ior_nd;
      iow_nq   <= iow_nd;
      rdata_q  <= rdata_d;
    end
  end

  assign pc_a_o = a_q;
  assign pc_d_o = d_q;
  assign pc_d_oe_o = write_q & (state_q != StIdle);
  assign pc_ior_no = ior_nq;
  assign pc_iow_no = iow_nq;
  assign rdata_o = rdata_q;
  assign done_o = (state_q == StHold) && last;

  `MMCS_ASSERT(OneCommand, pc_ior_no || pc_iow_no, "IOR# and IOW# are never low together")
  `MMCS_ASSERT(CommandInState, (state_q == StCommand) || (pc_ior_no && pc_iow_no),
               "a command is low only in the command phase")

endmodule

`default_nettype wire
