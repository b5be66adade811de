// SPDX-License-Identifier: Apache-2.0
// A16 D08(O) slave: turns VME data cycles into requests at the host port. §4.3.1
//
// DTACK* never comes without the strobe that asked for it and never goes before both data strobes
// are high; the data drivers go off with the strobes, combinationally. A strobe withdrawn early
// lets the request finish unanswered. AS* takes the address, DS0* the data; the clock reads both
// when the strobe has been seen, and they stand until the next fall.
`default_nettype none
`include "mmcs_assert.svh"

module vme_slave #(
  parameter logic [4:0] BaseA15A11 = 5'b01100
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  input  wire logic        sys_reset_i,   // SYSRESET*, synchronised: lets go of the bus
  // VME
  input  wire logic [15:1] vme_a_i,
  input  wire logic [ 5:0] vme_am_i,
  input  wire logic        vme_as_ni,
  input  wire logic [ 1:0] vme_ds_ni,
  input  wire logic        vme_write_ni,
  input  wire logic        vme_lword_ni,
  input  wire logic        vme_iack_ni,
  input  wire logic [ 7:0] vme_d_i,
  output logic             d_oe_o,        // drive hp_rdata_i on D07-D00
  output logic             dtack_o,       // pull DTACK* low
  // Host port
  output logic             hp_req_o,
  output logic             hp_write_o,
  output logic      [10:1] hp_a_o,
  output logic      [ 7:0] hp_wdata_o,
  input  wire logic        hp_ack_i
);

  localparam logic [5:0] AmShortUser = 6'h29;
  localparam logic [5:0] AmShortSupervisor = 6'h2D;

  // Each bit is a flip-flop of its own: a strobe was taken, which the first alone decides; the host
  // port has answered; DTACK*.
  typedef enum logic [2:0] {
    StIdle    = 3'b000,
    StRequest = 3'b100,  // the host port is asked
    StAnswer  = 3'b111,  // until both data strobes are high
    StDrop    = 3'b110   // the strobe was withdrawn, or SYSRESET* came: no answer
  } state_e;

  state_e state_d;
  logic busy_d, busy_q, done_d, done_q, answer_d, answer_q;
  logic match, ds0_n, ds0, ds0_valid;
  logic ds_any, ds_any_sync;     // a data strobe is low: the pins; synchronised
  logic ds0_held_d, ds0_held_q;  // neither DS0* high nor SYSRESET* since it was taken
  // Taken by edges of the pins, with a value before the first one.
  /* verilator lint_off PROCASSINIT */
  logic [10:1] bus_a_q = '0;
  logic [ 7:0] bus_d_q = '0;
  logic bus_write_q = 1'b0;
  /* verilator lint_on PROCASSINIT */
  logic bus_write;
  logic [10:1] hp_a_d, hp_a_q;
  logic [ 7:0] hp_wdata_d, hp_wdata_q;
  logic hp_write_d, hp_write_q;

  assign ds_any = ~(&vme_ds_ni);
  assign ds0_n = vme_ds_ni[0];
  assign ds0 = ~ds0_n;
  assign match = vme_iack_ni && vme_lword_ni && (vme_a_i[15:11] == BaseA15A11) &&
                (vme_am_i == AmShortUser || vme_am_i == AmShortSupervisor);

  /* verilator lint_off PINCONNECTEMPTY */
  vme_strobe u_strobe (
    .clk_i, .rst_ni,
    .as_ni(vme_as_ni),
    .ds0_ni(ds0_n),
    .match_i(match),
    .selected_o(),
    .ds0_valid_o(ds0_valid)
  );
  /* verilator lint_on PINCONNECTEMPTY */

  mmcs_sync u_ds_any (.clk_i, .rst_ni, .d_i(ds_any), .q_o(ds_any_sync));

  always_ff @(negedge vme_as_ni or negedge rst_ni) begin
    if (!rst_ni) bus_a_q <= '0;
    else bus_a_q <= vme_a_i[10:1];
  end

  assign bus_write = ~vme_write_ni;

  always_ff @(negedge ds0_n or negedge rst_ni) begin
    if (!rst_ni) {bus_write_q, bus_d_q} <= '0;
    else {bus_write_q, bus_d_q} <= {bus_write, vme_d_i};
  end

  assign ds0_held_d = (ds0_held_q | ~busy_q) & ~sys_reset_i;

  always_ff @(posedge clk_i or negedge ds0) begin
    if (!ds0) ds0_held_q <= 1'b0;
    else ds0_held_q <= ds0_held_d;
  end

  always_comb begin
    state_d = StIdle;
    case ({busy_q, done_q, answer_q})
      StIdle: if (ds0_valid && ds_any_sync && !sys_reset_i) state_d = StRequest;
      StRequest: begin
        if (!hp_ack_i) state_d = StRequest;
        else if (ds0_held_q && !sys_reset_i) state_d = StAnswer;
        else state_d = StDrop;
      end
      StAnswer: if (ds_any_sync && !sys_reset_i) state_d = StAnswer;
      default: state_d = StIdle;
    endcase
  end

  assign {busy_d, done_d, answer_d} = state_d;
  assign {hp_a_d, hp_wdata_d, hp_write_d} = busy_q ? {hp_a_q, hp_wdata_q, hp_write_q} :
                                                     {bus_a_q, bus_d_q, bus_write_q};

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      busy_q     <= 1'b0;
      done_q     <= 1'b0;
      answer_q   <= 1'b0;
      hp_a_q     <= '0;
      hp_wdata_q <= '0;
      hp_write_q <= 1'b0;
    end else begin
      busy_q     <= busy_d;
      done_q     <= done_d;
      answer_q   <= answer_d;
      hp_a_q     <= hp_a_d;
      hp_wdata_q <= hp_wdata_d;
      hp_write_q <= hp_write_d;
    end
  end

  assign hp_req_o = busy_q & ~done_q;
  assign hp_a_o = hp_a_q;
  assign hp_wdata_o = hp_wdata_q;
  assign hp_write_o = hp_write_q;
  assign dtack_o = answer_q & ds_any_sync;
  // Not after both strobes were high: a strobe there is already the next cycle's.
  assign d_oe_o = busy_q & (ds0_held_q | answer_q) & ~hp_write_q & ds_any_sync & ds_any;

  `MMCS_ASSERT(DtackAfterRequest, !answer_q || done_q,
               "DTACK* is low only while an access is being answered")

endmodule

`default_nettype wire
