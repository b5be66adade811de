// SPDX-License-Identifier: Apache-2.0
// The latch signal at two cards of a machine. §5.3.2, §5.3.3
`default_nettype none
`include "mmcs_formal.svh"

module same_clock_props (
  input wire logic        clk_i,
  input wire logic [15:1] vme_a_i,
  input wire logic [ 5:0] vme_am_i,
  input wire logic        vme_as_ni,
  input wire logic [ 1:0] vme_ds_ni,
  input wire logic        vme_write_ni,
  input wire logic        vme_lword_ni,
  input wire logic [15:0] vme_d_i,
  input wire logic        vme_iack_ni,
  input wire logic        vme_iackin_ni,
  input wire logic        vme_sysreset_ni,
  input wire logic        cable_ok_i,
  input wire logic        pc_power_i,
  input wire logic [ 3:0] enc_a_i,
  input wire logic [ 3:0] enc_b_i,
  input wire logic [ 3:0] enc_i_i
);

  `MMCS_RESET(1'b1)

  logic [3:1] drq;
  logic [15:0] pc_a;
  logic ior_n, iow_n, aen;
  mmcs #(.NumCards(2)) dut (
    .clk_i, .rst_ni, .vme_a_i, .vme_am_i, .vme_as_ni, .vme_ds_ni, .vme_write_ni, .vme_lword_ni,
    .vme_d_i, .vme_iack_ni, .vme_iackin_ni,
    .vme_sysreset_ni, .estop_closed_i(1'b1), .cable_ok_i,
    .pc_power_i, .enc_a_i,
    .enc_b_i,
    .enc_i_i, .axis_enable_i(4'h0), .dip_i(8'h10), .adc_v_i(64'd0),
    .pcx_a_o(pc_a), .pcx_ior_no(ior_n), .pcx_iow_no(iow_n), .pcx_aen_o(aen),
    .pcx_drq_o(drq), .pcx_d_i(8'hFF),
    .pcx_d_oe_i(1'b0),
    .pcx_wait_i(1'b0), .pcx_irq_i(5'd0)
  );

  // Wires of these names are joined to those of the design when the hierarchy is flattened.
  (* hierconn *) wire \dut.u_cards.g_card[0].u_card.latch_pulse ;
  (* hierconn *) wire \dut.u_cards.g_card[1].u_card.latch_pulse ;
  (* hierconn *) wire \dut.u_cards.g_card[0].u_card.dac_update ;
  (* hierconn *) wire \dut.u_cards.g_card[1].u_card.dac_update ;
  (* hierconn *) wire \dut.u_cards.g_card[0].u_card.u_latch.sclock_q ;
  (* hierconn *) wire \dut.u_cards.g_card[1].u_card.u_latch.sclock_q ;
  (* hierconn *) wire \dut.u_cards.g_card[0].u_card.u_latch.sw_latch_q ;
  (* hierconn *) wire \dut.u_cards.g_card[1].u_card.u_latch.sw_latch_q ;
  (* hierconn *) wire [7:0] \dut.u_cards.g_card[0].u_card.pb , \dut.u_cards.g_card[1].u_card.pb ;
  (* hierconn *) wire \dut.pc_power ;

  logic [1:0] latch, update, enabled, double, sclock_q, sw_q;
  assign latch    = {\dut.u_cards.g_card[1].u_card.latch_pulse ,
                     \dut.u_cards.g_card[0].u_card.latch_pulse };
  assign update   = {\dut.u_cards.g_card[1].u_card.dac_update ,
                     \dut.u_cards.g_card[0].u_card.dac_update };
  assign sclock_q = {\dut.u_cards.g_card[1].u_card.u_latch.sclock_q ,
                     \dut.u_cards.g_card[0].u_card.u_latch.sclock_q };
  assign sw_q     = {\dut.u_cards.g_card[1].u_card.u_latch.sw_latch_q ,
                     \dut.u_cards.g_card[0].u_card.u_latch.sw_latch_q };
  assign enabled  = {\dut.u_cards.g_card[1].u_card.pb [2], \dut.u_cards.g_card[0].u_card.pb [2]};
  assign double   = {\dut.u_cards.g_card[1].u_card.pb [3], \dut.u_cards.g_card[0].u_card.pb [3]};

  // SCLOCK, an access to the register that latches all cards, and what was a clock ago.
  logic drq_was, all, idle_was, power_was;
  assign all = !(ior_n && iow_n) && !aen && pc_a[9:0] == 10'h312;
  always @(posedge clk_i) begin
    drq_was   <= rst_ni && drq[3];
    idle_was  <= rst_ni && ior_n && iow_n;
    power_was <= rst_ni && dut.pc_power;
  end

  logic rises, presses;
  assign rises   = drq[3] && !drq_was && dut.pc_power && power_was;
  assign presses = all && idle_was && dut.pc_power && power_was;

  `MMCS_PROVE(SclockOfAll, "5.3.2", rises, (latch & enabled) == enabled,
              "every card that is enabled samples in the clock in which SCLOCK rises")
  `MMCS_PROVE(OutputsOfAll, "5.3.3", rises, (update & enabled & double) == (enabled & double),
              "and its D/As in double-buffer mode put out what was written")
  `MMCS_PROVE(SoftwareOfAll, "5.3.2", presses, latch == 2'b11,
              "the software latch of all cards reaches all cards in one clock")
  `MMCS_PROVE(NothingElse, "5.3.2", !rises && ior_n && iow_n && dut.pc_power && power_was,
              latch == 2'b00, "without SCLOCK or a bus access no card samples")

  `MMCS_LEMMA(Follows, !power_was || !dut.pc_power ||
              (sclock_q == {2{drq_was}} && (!idle_was || sw_q == 2'b00)),
              "the cards have seen SCLOCK and commands as they were a clock ago")

endmodule

`default_nettype wire
