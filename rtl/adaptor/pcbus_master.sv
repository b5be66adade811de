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
  parameter int IochrdyLimitClks = 10,
  parameter bit Skip = 1'b0
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  // Request: start_i is taken when idle; address and data are captured then.
  input  wire logic        start_i,
  input  wire logic        write_i,
  input  wire logic [15:0] a_i,
  input  wire logic [ 7:0] wdata_i,
  output logic             done_o,   // one clock, rdata_o is valid and stays
  output logic      [ 7:0] rdata_o,
  output logic             idle_o,
  // State of the link
  input  wire logic        link_ok_i,   // cable plugged and PC side powered
  input  wire logic        clk_en_i,    // one per period of CLK
  // Bus
  output logic      [15:0] pc_a_o,
  output logic      [ 7:0] pc_d_o,
  output logic             pc_ior_no,
  output logic             pc_iow_no,
  input  wire logic [ 7:0] pc_d_i,      // 0xFF where nobody drives
  input  wire logic        pc_wait_i,   // 1: IOCHRDY is pulled low
  // Skipping; ignored if Skip = 0
  input  wire logic [15:0] extra_i,
  output logic      [15:0] horizon_o
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

  state_e                  state_q;
  logic   [TimerWidth-1:0] timer_q;
  logic   [ WaitWidth-1:0] waits_q;
  logic                    write_q;
  logic   [TimerWidth-1:0] extra;      // what this edge stands for beyond one clock
  logic                    waiting;
  logic                    timed_out;

  assign waiting = pc_wait_i & link_ok_i;
  assign extra = Skip ? TimerWidth'(extra_i) : '0;
  assign timed_out = (waits_q == WaitWidth'(IochrdyLimitClks));

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q   <= StIdle;
      timer_q   <= '0;
      waits_q   <= '0;
      write_q   <= 1'b0;
      pc_a_o    <= '0;
      pc_d_o    <= 8'hFF;
      pc_ior_no <= 1'b1;
      pc_iow_no <= 1'b1;
      rdata_o   <= 8'hFF;
    end else if (state_q == StIdle) begin
      if (start_i) begin
        state_q <= StSetup;
        timer_q <= TimerWidth'(SideClks - 1) - extra;
        write_q <= write_i;
        if (extra == TimerWidth'(SideClks)) begin  // only when skipping: the command begins too
          state_q   <= StCommand;
          timer_q   <= TimerWidth'(CmdClks - 1);
          waits_q   <= '0;
          pc_ior_no <= write_i;
          pc_iow_no <= ~write_i;
        end
        pc_a_o  <= a_i;
        if (write_i) pc_d_o <= wdata_i;
      end
    end else if (timer_q != extra) begin
      timer_q <= timer_q - extra - 1'b1;
    end else begin
      timer_q <= '0;
      case (state_q)
        StSetup: begin
          state_q   <= StCommand;
          timer_q   <= TimerWidth'(CmdClks - 1);
          waits_q   <= '0;
          pc_ior_no <= write_q;
          pc_iow_no <= ~write_q;
        end
        StCommand: begin
          if (waiting && !timed_out) begin
            if (clk_en_i) waits_q <= waits_q + 1'b1;
          end else begin
            state_q   <= StHold;
            timer_q   <= TimerWidth'(SideClks - 1);
            pc_ior_no <= 1'b1;
            pc_iow_no <= 1'b1;
            rdata_o   <= (write_q || waiting || !link_ok_i) ? 8'hFF : pc_d_i;
          end
        end
        default: state_q <= StIdle;
      endcase
    end
  end

  assign done_o = (state_q == StHold) && (timer_q == '0);
  assign idle_o = (state_q == StIdle);

  if (Skip) begin : g_skip
    // Until the command begins, or the timer has run out: meanwhile nobody looks at the bus.
    always_comb begin
      horizon_o = 16'hFFFF;
      if (state_q == StHold && timer_q != '0) horizon_o = 16'(timer_q);  // then it is done
      else if (state_q != StIdle) horizon_o = 16'(timer_q) + 16'd1;
      else if (start_i) horizon_o = 16'(SideClks) + 16'd1;
    end
  end else begin : g_step
    assign horizon_o = 16'd1;
  end

  logic unused_extra;  // what no horizon reaches
  assign unused_extra = ^extra_i;

  `MMCS_ASSERT(OneCommand, pc_ior_no || pc_iow_no, "IOR# and IOW# are never low together")
  `MMCS_ASSERT(CommandInState, (state_q == StCommand) || (pc_ior_no && pc_iow_no),
               "a command is low only in the command phase")

endmodule

`default_nettype wire
