// SPDX-License-Identifier: Apache-2.0
// A16 D08(O) slave: turns VME data cycles into requests at the host port. §4.3.1
//
// DTACK* never comes without the strobe that asked for it and never goes before both data strobes
// are high; the data drivers go off with the strobes, combinationally. A strobe withdrawn early
// lets the request finish unanswered.
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

  typedef enum logic [1:0] {
    StIdle,     // looks for a strobe
    StRequest,  // the host port works
    StAnswer    // DTACK* until the strobes go
  } state_e;

  state_e state_q;
  logic ours, strobed;         // raw: the cycle is ours; a data strobe is low
  logic seen, live;            // first stage: our strobe; and its address still stands
  logic seen_q;                // second stage: the address below is that strobe's
  logic own_q;                 // its strobe has not gone since; holds while it is answered
  logic own1_q;                // the same a clock ago, for the state machine
  logic answer_q;
  logic low0_q, low1_q;        // two stages: a data strobe is low, and has not been high since
  logic [10:1] hp_a_q;
  logic [ 7:0] hp_wdata_q;
  logic hp_write_q;

  assign strobed = ~(&vme_ds_ni);
  assign ours = vme_iack_ni && vme_lword_ni && (vme_a_i[15:11] == BaseA15A11) &&
                (vme_am_i == AmShortUser || vme_am_i == AmShortSupervisor);

  vme_strobe u_strobe (
    .clk_i, .rst_ni,
    .as_ni(vme_as_ni),
    .ds0_ni(vme_ds_ni[0]),
    .ours_i(ours),
    .seen_o(seen)
  );

  assign live = seen & ours & ~vme_as_ni;

  // Cleared by the strobes themselves, however short they are high.
  logic own_n, low_n;
  assign own_n = rst_ni & (~vme_ds_ni[0] | answer_q);
  assign low_n = rst_ni & strobed;

  always_ff @(posedge clk_i or negedge own_n) begin
    if (!own_n) own_q <= 1'b0;
    else if (sys_reset_i) own_q <= 1'b0;
    else if (state_q == StIdle) own_q <= live;
    else if (state_q == StAnswer && !low1_q) own_q <= 1'b0;
  end

  always_ff @(posedge clk_i or negedge low_n) begin
    if (!low_n) low0_q <= 1'b0;
    else low0_q <= 1'b1;
  end

  // Address and data have stood since the clock before, or `seen` had been cleared.
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      low1_q     <= 1'b0;
      own1_q     <= 1'b0;
      seen_q     <= 1'b0;
      hp_a_q     <= '0;
      hp_wdata_q <= '0;
      hp_write_q <= 1'b0;
    end else begin
      low1_q <= low0_q;
      own1_q <= own_q;
      seen_q <= live && state_q == StIdle && !sys_reset_i;  // in SYSRESET* none is taken
      if (live && !seen_q && state_q == StIdle) begin
        hp_a_q     <= vme_a_i[10:1];
        hp_wdata_q <= vme_d_i;
        hp_write_q <= ~vme_write_ni;
      end
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q  <= StIdle;
      answer_q <= 1'b0;
    end else begin
      case (state_q)
        StIdle: if (seen_q && !sys_reset_i) state_q <= StRequest;
        StRequest: begin
          if (hp_ack_i) begin
            state_q  <= StAnswer;
            answer_q <= !sys_reset_i;
          end
        end
        default: begin
          if (!low1_q || !own1_q || sys_reset_i) begin
            state_q  <= StIdle;
            answer_q <= 1'b0;
          end
        end
      endcase
    end
  end

  assign hp_req_o = (state_q == StRequest);
  assign hp_a_o = hp_a_q;
  assign hp_wdata_o = hp_wdata_q;
  assign hp_write_o = hp_write_q;
  assign dtack_o = answer_q & own_q;
  // Not after both strobes were high: a strobe there is already the next cycle's.
  assign d_oe_o = (state_q != StIdle) & own_q & ~hp_write_q & low0_q & low1_q & strobed;

  `MMCS_ASSERT(DtackAfterRequest, !answer_q || state_q == StAnswer,
               "DTACK* is low only while an access is being answered")

endmodule

`default_nettype wire
