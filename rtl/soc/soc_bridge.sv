// SPDX-License-Identifier: Apache-2.0
// From the processor's data port to the adaptor's host port. §4.3 (the host side), in the way of a
// memory-mapped processor.
//
// One load or store is one access at the host port, never more and never fewer: reads have side
// effects there. Each register has a word of its own, as a processor that reads whole words cannot
// tell two bytes of one apart. An access that the adaptor does not answer in time ends in an error;
// its request stays at the host port, as that port demands, and the next ones wait for its end
// within their own time.
`default_nettype none
`include "mmcs_assert.svh"

module soc_bridge #(
  parameter int TimeoutClks = 128      // of far_clk_i
) (
  // Processor's clock
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  input  wire logic        start_i,    // one clock; only while busy_o is 0
  input  wire logic        clock_i,    // it reads us_i instead of a register
  input  wire logic        write_i,
  input  wire logic [10:1] a_i,
  input  wire logic [ 7:0] wdata_i,
  output logic             busy_o,
  output logic             done_o,     // one clock, with rdata_o and err_o
  output logic      [31:0] rdata_o,
  output logic             err_o,
  // Adaptor's clock
  input  wire logic        far_clk_i,
  input  wire logic        far_rst_ni,
  input  wire logic [31:0] us_i,       // free-running microseconds
  output logic             hp_req_o,
  output logic             hp_write_o,
  output logic      [10:1] hp_a_o,
  output logic      [ 7:0] hp_wdata_o,
  input  wire logic        hp_ack_i,
  input  wire logic [ 7:0] hp_rdata_i
);

  localparam int TimerWidth = $clog2(TimeoutClks + 1);

  typedef enum logic [1:0] {
    StIdle,
    StAccess,   // the host port works, the processor waits
    StLate      // the host port works, the processor has its error
  } state_e;

  // --- processor's side -------------------------------------------------------------------

  logic clock_d, clock_q, write_d, write_q;
  logic [10:1] a_d, a_q;
  logic [ 7:0] wdata_d, wdata_q;

  assign {clock_d, write_d, a_d, wdata_d} = start_i ? {clock_i, write_i, a_i, wdata_i} :
                                                      {clock_q, write_q, a_q, wdata_q};

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      clock_q <= 1'b0;
      write_q <= 1'b0;
      a_q     <= '0;
      wdata_q <= '0;
    end else begin
      clock_q <= clock_d;
      write_q <= write_d;
      a_q     <= a_d;
      wdata_q <= wdata_d;
    end
  end

  logic far_req, finish;

  soc_cross u_cross (
    .clk_i, .rst_ni, .start_i, .busy_o, .done_o,
    .far_clk_i, .far_rst_ni,
    .far_req_o(far_req),
    .far_finish_i(finish)
  );

  // --- adaptor's side ---------------------------------------------------------------------

  state_e state_d, state_q;
  logic [TimerWidth-1:0] timer_d, timer_q;
  logic [31:0] answer_d, answer_q;
  logic err_d, err_q;
  logic hp_req_d, hp_write_d;
  logic [10:1] hp_a_d;
  logic [ 7:0] hp_wdata_d;
  logic expired;

  assign expired = (timer_q == TimerWidth'(TimeoutClks));
  // A request is timed out, answered at the host port, or is for the clock.
  always_comb begin
    finish = 1'b0;
    if (far_req) begin
      case (state_q)
        StIdle: finish = clock_q || expired;  // spent waiting: it reaches nothing
        StAccess: finish = hp_ack_i || expired;
        default: finish = clock_q || expired;
      endcase
    end
  end

  always_comb begin
    state_d    = state_q;
    timer_d    = (far_req && !finish) ? timer_q + 1'b1 : '0;
    answer_d   = answer_q;
    err_d      = err_q;
    hp_req_d   = hp_req_o;
    hp_write_d = hp_write_o;
    hp_a_d     = hp_a_o;
    hp_wdata_d = hp_wdata_o;
    if (finish) begin
      answer_d = clock_q ? us_i : {24'd0, hp_rdata_i};
      err_d    = !clock_q && !(state_q == StAccess && hp_ack_i);
    end
    if (hp_req_o && hp_ack_i) begin
      hp_req_d = 1'b0;
      state_d  = StIdle;
    end else if (state_q == StIdle && far_req && !finish) begin
      hp_req_d   = 1'b1;
      hp_write_d = write_q;
      hp_a_d     = a_q;
      hp_wdata_d = wdata_q;
      state_d    = StAccess;
    end else if (state_q == StAccess && finish) begin
      state_d = StLate;
    end
  end

  always_ff @(posedge far_clk_i or negedge far_rst_ni) begin
    if (!far_rst_ni) begin
      state_q    <= StIdle;
      timer_q    <= '0;
      answer_q   <= '0;
      err_q      <= 1'b0;
      hp_req_o   <= 1'b0;
      hp_write_o <= 1'b0;
      hp_a_o     <= '0;
      hp_wdata_o <= '0;
    end else begin
      state_q    <= state_d;
      timer_q    <= timer_d;
      answer_q   <= answer_d;
      err_q      <= err_d;
      hp_req_o   <= hp_req_d;
      hp_write_o <= hp_write_d;
      hp_a_o     <= hp_a_d;
      hp_wdata_o <= hp_wdata_d;
    end
  end

  assign rdata_o = answer_q;
  assign err_o = err_q;

endmodule

`default_nettype wire
