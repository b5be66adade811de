// SPDX-License-Identifier: Apache-2.0
// The adaptor on the VMEbus, with the bus checkers of the simulation as properties. §4.3.1
//
// The timers are cut out: what they do is free. So are the cards: read data, IOCHRDY, PANIC. The
// master may do what it likes; with Keeps it keeps the rules of vme_master_checker, and the rules
// of the other two checkers are proved as well.
`default_nettype none
`include "mmcs_formal.svh"

module vme_props #(
  parameter bit Keeps = 1'b0,   // the master keeps its rules, and the checkers are proved
  parameter bit Cut = 1'b0,     // the core is cut out and known by its lemmas
  parameter int Answer = 24,    // clocks from a strobe at rest to DTACK*
  parameter int Longest = 47    // the same, whatever went on before
) (
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
  input wire logic        estop_closed_i,
  input wire logic        cable_ok_i,
  input wire logic        pc_power_i,
  input wire logic [ 7:0] pc_d_i,
  input wire logic        pc_wait_i,
  input wire logic [ 7:3] pc_irq_i
);

  `MMCS_RESET(1'b1)

  logic d_oe, dtack_n, iackout_n, pc_ior_n, pc_iow_n, pc_aen;
  logic [7:0] d, pc_wdata;
  logic [7:1] irq_n;
  logic [15:0] pc_a;

  adaptor_vme dut (
    .clk_i, .rst_ni,
    .vme_a_i, .vme_am_i, .vme_as_ni, .vme_ds_ni, .vme_write_ni, .vme_lword_ni,
    .vme_d_i(vme_d_i[7:0]),
    .vme_d_o(d),
    .vme_d_oe_o(d_oe),
    .vme_dtack_no(dtack_n),
    .vme_iack_ni, .vme_iackin_ni,
    .vme_iackout_no(iackout_n),
    .vme_irq_no(irq_n),
    .vme_sysreset_ni, .estop_closed_i, .cable_ok_i, .pc_power_i,
    .pc_a_o(pc_a),
    .pc_aen_o(pc_aen),
    .pc_d_o(pc_wdata),
    .pc_ior_no(pc_ior_n),
    .pc_iow_no(pc_iow_n),
    .pc_d_i, .pc_wait_i, .pc_irq_i
  );

  logic [2:0] reset_q = 3'b011;  // as after SYSRESET*
  logic [3:0] ack_level_q = '0;
  logic [7:0] rdata_q = '1, vector_q = 8'h0F;
  logic request_q = 1'b0, ack_q = 1'b0;
  logic moves, moved_q = 1'b0;   // the address, under AS*
  logic told_q = 1'b0;           // DTACK* fell in this address cycle
  logic [16:0] data_q = '0;      // WRITE* and data a clock ago
  logic [4:0] asked_q = '0;      // clocks of the present request
  logic [4:0] down_q = '0;       // clocks of SYSRESET*
  logic dtack_q = 1'b0, iackin_q = 1'b1, strobed;
  // Wires of these names are joined to those of the design when the hierarchy is flattened.
  (* hierconn *) wire [7:0] \u_master_rules.bad , \dut.hp_rdata , \dut.vector ;
  (* hierconn *) wire \dut.slave_dtack , \dut.hp_req , \dut.hp_ack , \dut.irq_req ;
  (* hierconn *) wire \dut.sys_reset ;

  vme_master_checker #(
    .Stop(1'b0)
  ) u_master_rules (
    .clk_i, .rst_ni, .vme_a_i, .vme_am_i, .vme_as_ni, .vme_ds_ni, .vme_write_ni, .vme_lword_ni,
    .vme_iack_ni, .vme_iackin_ni, .vme_d_i,
    .vme_dtack_no(dtack_n)
  );

  // What the proof of the checkers is told of the core, which it cuts out.
  `define CORE_LEMMAS(how) \
    how(AckAsked, !dut.hp_ack || dut.hp_req, "the core answers what it is asked") \
    how(DataStays, (request_q && !ack_q) || dut.hp_rdata == rdata_q, \
        "read data stands once answered") \
    how(VectorStays, request_q || dut.vector == vector_q, "the vector changes only in a request") \
    how(ResetIn2, dut.sys_reset == reset_q[1], "the core synchronises SYSRESET* in two clocks") \
    how(RequestGone, !reset_q[2] || !dut.irq_req, "SYSRESET* ends the request a clock later") \
    how(AnsweredInTime, asked_q < 5'd20, "the core answers within 20 clocks, IOCHRDY and all")

  if (Cut) begin : g_cut
    `CORE_LEMMAS(`MMCS_GIVEN)
  end else begin : g_whole
    `CORE_LEMMAS(`MMCS_LEMMA)
  end

  if (Keeps) begin : g_keeps
    `MMCS_GIVEN(MasterKeeps, u_master_rules.bad == '0, "the master keeps the rules of its checker")
    `MMCS_GIVEN(ChainWaits, vme_iackin_ni || !iackin_q || (dtack_n && !dtack_q),
                "an acknowledge starts down the chain when DTACK* of the cycle before is high")
    `MMCS_GIVEN(ChainAfter, vme_iackin_ni || !iackin_q ||
                !(as_q || vme_as_ni || moves || moved_q),
                "the driver of the chain waits for AS*, whose address stands, and a data strobe")
    `MMCS_GIVEN(OneAddress, !(moves || moved_q) || (ds_q & ~vme_ds_ni) == 2'b00,
                "every strobe under one AS* has the address with which AS* fell")
    `MMCS_GIVEN(DataSetUp, vme_ds_ni[0] || !ds_q[0] || {vme_write_ni, vme_d_i} == data_q,
                "WRITE* and data stand before the first data strobe falls")
    `MMCS_GIVEN(LevelStands, vme_iackin_ni || iackin_q || vme_as_ni || !dtack_n || dtack_q ||
                ack_level_q == {vme_a_i[3:1], vme_iack_ni},
                "level and IACK* stand while IACKIN* and AS* are low and nobody has answered")
    `MMCS_GIVEN(AddressStands, told_q || (!dtack_n && !dtack_q) || !moves,
                "address, modifier, LWORD* and IACK* stand from before AS* falls until DTACK*")
    `MMCS_GIVEN(DtackFirst, (dtack_n && !dtack_q) || (~vme_ds_ni & ds_q) == 2'b00,
                "no strobe falls before DTACK* of the cycle before is high")
    `MMCS_GIVEN(ResetLasts, !(vme_sysreset_ni && down_q != 5'd0 && down_q < 5'd31),
                "SYSRESET* lasts 31 clocks at least (the bus says 200 ms)")
    `MMCS_GIVEN(ResetEnds, !(strobed && down_q > 5'd16), "SYSRESET* makes the master let go")
  end

  vme_slave_checker #(
    .Stop(Keeps)
  ) u_slave_rules (
    .clk_i, .rst_ni, .vme_ds_ni, .vme_iack_ni, .vme_write_ni,
    .vme_iackout_no(iackout_n),
    .vme_sysreset_ni,
    .vme_d_oe_o(d_oe),
    .vme_dtack_no(dtack_n),
    .vme_d_o(d)
  );

  vme_claim_checker #(
    .Stop(Keeps)
  ) u_claim_rules (
    .clk_i, .rst_ni, .vme_a_i, .vme_am_i, .vme_as_ni, .vme_ds_ni, .vme_lword_ni, .vme_iack_ni,
    .vme_iackin_ni, .vme_sysreset_ni,
    .vme_iackout_no(iackout_n),
    .vme_irq_no(irq_n),
    .vme_d_oe_o(d_oe),
    .vme_dtack_no(dtack_n)
  );

  // --- what the bus shows, by ourselves -----------------------------------------------------

  logic strobe, ours, mine, old, cycle, quiet;
  logic [1:0] ds_q = '1;
  logic as_q = 1'b1, ours_q = 1'b0, mine_q = 1'b0;   // AS* fell under our address, a clock before
  logic old_q = 1'b1;            // DS0* stood as AS* rose (both in one clock: group `strobe`)
  assign strobed = ~(&vme_ds_ni);
  assign strobe = ~vme_as_ni & ~vme_ds_ni[0];
  assign ours = vme_iack_ni & vme_lword_ni & (vme_a_i[15:11] == 5'b01100) &
                ((vme_am_i == 6'h29) | (vme_am_i == 6'h2D));
  assign moves = !vme_as_ni && (ours != ours_q || ack_level_q != {vme_a_i[3:1], vme_iack_ni});
  assign mine = ~vme_as_ni & (as_q ? ours_q : mine_q);
  assign old = ~vme_ds_ni[0] & (old_q | (vme_as_ni & ~as_q & ~ds_q[0]));
  assign cycle = strobe & mine & ~old;

  logic [6:0] held_q = '0;       // clocks that a strobe of ours has stood since it fell
  logic [6:0] foreign_q = '0;    // clocks that none of ours has been seen
  logic [4:0] rest_q = '0;       // clocks that both data strobes have been high
  logic       rested_q = 1'b0;   // at rest when the present cycle began
  logic       clean_q = 1'b0;    // the strobes have been high since SYSRESET*
  logic [2:0] up_q = '0;         // clocks without SYSRESET*

  assign quiet = &up_q;

  always @(posedge clk_i) begin
    if (rst_ni) begin
      dtack_q <= ~dtack_n;
      data_q <= {vme_write_ni, vme_d_i};
      moved_q <= !vme_as_ni && (moved_q || moves);
      told_q <= !vme_as_ni && (told_q || (!dtack_n && !dtack_q));
      iackin_q <= vme_iackin_ni;
      reset_q <= {reset_q[1:0], ~vme_sysreset_ni};
      ack_level_q <= {vme_a_i[3:1], vme_iack_ni};
      rdata_q <= dut.hp_rdata;
      vector_q <= dut.vector;
      request_q <= dut.hp_req;
      ack_q <= dut.hp_ack;
      if (!dut.hp_req || dut.hp_ack) asked_q <= '0;
      else if (asked_q != '1) asked_q <= asked_q + 1'b1;
      if (vme_sysreset_ni) down_q <= '0;
      else if (down_q != '1) down_q <= down_q + 1'b1;
      if (!vme_sysreset_ni) up_q <= '0;
      else if (!quiet) up_q <= up_q + 1'b1;
      if (!vme_sysreset_ni) clean_q <= 1'b0;
      else if (quiet && !strobed) clean_q <= 1'b1;
      ds_q <= vme_ds_ni;
      {as_q, ours_q, mine_q, old_q} <= {vme_as_ni, ours, mine, old};
      if (!cycle || !clean_q || !quiet || (held_q == '0 && !ds_q[0])) held_q <= '0;
      else if (held_q != '1) held_q <= held_q + 1'b1;
      if (cycle) foreign_q <= '0;
      else if (foreign_q != '1) foreign_q <= foreign_q + 1'b1;
      if (strobed) rest_q <= '0;
      else if (rest_q != '1) rest_q <= rest_q + 1'b1;
      if (!strobed) rested_q <= (&rest_q) & quiet;
      else if (!cycle || !vme_sysreset_ni) rested_q <= 1'b0;
    end
  end

  // Since the strobes were last high for two clocks a strobe of ours has been seen.
  logic strobe_seen_q = 1'b0, high_q = 1'b0;
  always @(posedge clk_i) begin
    if (rst_ni) begin
      high_q <= ~strobed;
      if (cycle) strobe_seen_q <= 1'b1;
      else if (!strobed && high_q) strobe_seen_q <= 1'b0;
    end
  end

  // --- DTACK* -------------------------------------------------------------------------------

  if (!Cut) begin : g_handshake
  `MMCS_PROVE(DtackIsOurs, "4.3.1", dut.slave_dtack && !dtack_q, foreign_q < 7'd31 && strobe_seen_q,
              "DTACK* of a data cycle falls only after a strobe with our address and modifier")
  `MMCS_PROVE(NeverForeign, "4.3.1", foreign_q >= 7'd31 && strobed,
              !(dut.slave_dtack && !dtack_q) && !dut.hp_req,
              "a cycle that is not ours gets no DTACK* and starts nothing")
  `MMCS_PROVE(Answered, "4.3.1", rested_q && held_q >= 7'(Answer), !dtack_n,
              "begun at rest, a cycle of ours has DTACK* within 24 clocks (3 us), IOCHRDY and all")
  `MMCS_PROVE(NoWedge, "4.3.1", held_q >= 7'(Longest), !dtack_n,
              "whatever went on since SYSRESET*, a cycle of ours is answered within 47 clocks")
  `MMCS_PROVE(ComesToRest, "4.3.1", rest_q >= 5'd25, !dut.hp_req && dtack_n && !d_oe,
              "25 clocks after the strobes the slave is at rest, whatever went on before")

  end

  `MMCS_REACH(ReadCard, !dtack_n && d_oe && !vme_a_i[10] && d == 8'h5A && dut.slave_dtack,
              "a card register is read")
  `MMCS_REACH(ReadPccsr, !dtack_n && d_oe && vme_a_i == 15'h3204 && d == 8'h98 && dut.slave_dtack,
              "what was written to PCCSR is read back")

endmodule

`default_nettype wire
