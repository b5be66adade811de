// SPDX-License-Identifier: Apache-2.0
// A16 D08(O) slave: turns VME data cycles into requests at the host port. §4.3.1
//
// DTACK* never comes without a strobe and never goes before both data strobes are high; the data
// drivers go off with the strobes, combinationally. A strobe withdrawn early lets the request
// finish unanswered.
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
  logic strobe_q;      // first stage: AS* and DS0* low
  logic fresh_q;       // second stage: a strobe was seen one clock ago, with what it addressed
  logic ours_q;
  logic both_high_q;   // first stage: both data strobes high; DTACK* itself is the second
  logic both_high2_q;
  logic strobed;       // raw: a data strobe is low
  logic dtack_q, gone_q;
  logic strobe, ours;
  logic      [10:1] hp_a_q;
  logic      [ 7:0] hp_wdata_q;
  logic             hp_write_q;

  assign strobed = ~(&vme_ds_ni);
  assign strobe = ~(vme_as_ni | vme_ds_ni[0]);
  assign ours = vme_iack_ni && vme_lword_ni && (vme_a_i[15:11] == BaseA15A11) &&
                (vme_am_i == AmShortUser || vme_am_i == AmShortSupervisor);

  // Address and data are taken on the edge before the one that acts on them, so that a strobe that
  // is still there when the edge acts was there when they were taken.
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      strobe_q     <= 1'b0;
      both_high_q  <= 1'b1;
      both_high2_q <= 1'b1;
      fresh_q      <= 1'b0;
      ours_q       <= 1'b0;
      hp_a_q       <= '0;
      hp_wdata_q   <= '0;
      hp_write_q   <= 1'b0;
    end else begin
      strobe_q     <= strobe;
      both_high_q  <= ~strobed;
      both_high2_q <= both_high_q;
      // not in SYSRESET*: what is taken there may be gone when it ends
      fresh_q      <= strobe_q && (state_q == StIdle) && !sys_reset_i;
      // Taken again while the cycle is not ours: the strobes may be high between two cycles for
      // less than a clock, and nothing but the address tells that the second has come.
      if (strobe_q && !(fresh_q && ours_q) && state_q == StIdle) begin
        ours_q     <= ours;
        hp_a_q     <= vme_a_i[10:1];
        hp_wdata_q <= vme_d_i;
        hp_write_q <= ~vme_write_ni;
      end
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q <= StIdle;
      dtack_q <= 1'b0;
      gone_q  <= 1'b0;
    end else begin
      case (state_q)
        StIdle: begin
          gone_q <= 1'b0;
          if (fresh_q && strobe_q && ours_q && !sys_reset_i) state_q <= StRequest;
        end
        StRequest: begin
          if (both_high_q || sys_reset_i) gone_q <= 1'b1;
          if (hp_ack_i) begin
            state_q <= StAnswer;
            dtack_q <= strobed && !both_high_q && !gone_q && !sys_reset_i;
          end
        end
        default: begin
          if (both_high_q || sys_reset_i) dtack_q <= 1'b0;
          // gone_q: the strobe that may be there now belongs to another cycle
          if (gone_q || both_high2_q) state_q <= StIdle;
        end
      endcase
    end
  end

  assign hp_req_o = (state_q == StRequest);
  assign dtack_o = dtack_q;
  // not in the clock after DTACK*, nor after strobes withdrawn early: a strobe there is already the
  // next cycle's
  assign d_oe_o = (state_q == StRequest | dtack_q) & ~hp_write_q & ~gone_q & ~both_high_q & strobed;
  assign hp_write_o = hp_write_q;
  assign hp_a_o = hp_a_q;
  assign hp_wdata_o = hp_wdata_q;

  `MMCS_ASSERT(DtackAfterRequest, !dtack_q || state_q == StAnswer,
               "DTACK* is low only while an access is being answered")

endmodule

`default_nettype wire
