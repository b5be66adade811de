// SPDX-License-Identifier: Apache-2.0
// The interrupter in its daisy chain: every step is an instant, and the board's clock rises when it
// likes. So gaps and phases of every length are meant. §4.3.6
`default_nettype none
`include "mmcs_formal.svh"

module interrupter_props #(
  parameter int IrqLevel = 5,
  parameter int AckLevel = 5
) (
  input wire logic       board_clk_i,
  input wire logic       reset_any_i,   // become synchronous below
  input wire logic       req_any_i,
  input wire logic [3:1] vme_a_i,
  input wire logic       vme_as_ni,
  input wire logic [1:0] vme_ds_ni,
  input wire logic       vme_iack_ni,
  input wire logic       vme_iackin_ni
);

  (* gclk *) logic clk_i;               // the instants

  `MMCS_RESET(1'b1)

  logic sys_reset_q = 1'b0, req_q = 1'b0;
  always @(posedge board_clk_i) {sys_reset_q, req_q} <= {reset_any_i, req_any_i};

  logic iackout_n, d_oe, dtack;
  logic [7:1] irq_n;

  vme_interrupter #(
    .IrqLevel(IrqLevel),
    .AckLevel(AckLevel)
  ) dut (
    .clk_i(board_clk_i), .rst_ni,
    .sys_reset_i(sys_reset_q),
    .irq_req_i(req_q),
    .vme_a_i, .vme_as_ni, .vme_ds_ni, .vme_iack_ni, .vme_iackin_ni,
    .vme_iackout_no(iackout_n),
    .vme_irq_no(irq_n),
    .d_oe_o(d_oe),
    .dtack_o(dtack)
  );

  // --- the acknowledge, seen from the bus -----------------------------------------------------

  logic strobed, level, low, rises, clk_q = 1'b1;
  logic iackin_q = 1'b1, low_q = 1'b0, dtack_q = 1'b0, oe_q = 1'b0, high_q = 1'b1;
  logic level_q = 1'b0, strobed_q = 1'b0, reset_q = 1'b0, as_q = 1'b1, rst_q = 1'b0;
  logic req0_q = 1'b0;                  // our request an instant ago
  logic asked, asked_q = 1'b0;          // we asked when IACKIN* fell
  logic passed_q = 1'b0, answered_q = 1'b0;   // since it fell
  logic ack, ack_q = 1'b0, iack_q = 1'b0;     // AS* fell with IACK* low
  logic old, old_q = 1'b1;              // DS0* stood as AS* rose: it is the last cycle's
  logic good, good_q = 1'b0;            // DS0* fell in an acknowledge and still stands
  logic after_q = 1'b0;                 // it fell under an AS* that stood
  logic quiet_q = 1'b0;                 // no SYSRESET* and no answer still standing since then
  logic told_q = 1'b0;                  // DTACK* was given in this address cycle
  logic [2:0] edges_q = '0;             // clocks of the board that IACKIN* and AS* have been low
  logic [2:0] waits_q = '0;             // that DS0* has been low as well
  logic spoilt_q = 1'b0;                // the strobe was withdrawn: IACKIN* is answered once
  assign strobed = ~(&vme_ds_ni);
  assign level = !vme_iack_ni && vme_a_i == 3'(AckLevel);
  assign low = !vme_iackin_ni && !vme_as_ni && (iackin_q || low_q);   // since IACKIN* fell
  assign rises = board_clk_i && !clk_q;
  assign asked = !vme_iackin_ni && (iackin_q ? req0_q : asked_q);
  assign ack = !vme_as_ni && (as_q ? iack_q : ack_q);
  assign old = !vme_ds_ni[0] && (old_q || (vme_as_ni && !as_q));
  assign good = !vme_ds_ni[0] && !old && ack;

  always @(posedge clk_i) begin
    clk_q <= board_clk_i;
    rst_q <= rst_ni;
    high_q <= vme_ds_ni[0] & rst_ni;
    if (rst_ni) begin
      iackin_q   <= vme_iackin_ni;
      low_q      <= low;
      dtack_q    <= dtack;
      oe_q       <= d_oe;
      strobed_q  <= strobed;
      reset_q    <= sys_reset_q;
      level_q    <= level;
      {as_q, iack_q, ack_q, old_q} <= {vme_as_ni, !vme_iack_ni, ack, old};
      told_q <= !vme_as_ni && (told_q || dtack);
      asked_q    <= asked;
      req0_q     <= req_q;
      good_q     <= good;
      passed_q   <= !vme_iackin_ni && (passed_q || !iackout_n);
      answered_q <= !vme_iackin_ni && (answered_q || (dtack && !dtack_q));
      if (!low || sys_reset_q || dtack) edges_q <= '0;
      else if (rises && low_q && !vme_iackin_ni && !iackin_q && edges_q != '1) begin
        edges_q <= edges_q + 1'b1;
      end
      after_q <= !vme_iackin_ni && (iackin_q ? !(as_q || vme_as_ni) : after_q);
      quiet_q <= !vme_iackin_ni && !sys_reset_q && (iackin_q ? !dtack : quiet_q);
      spoilt_q <= !vme_iackin_ni && (spoilt_q || (vme_ds_ni[0] && !high_q));
      if (!low || !good || !after_q || !quiet_q || spoilt_q) waits_q <= '0;
      else if (rises && low_q && good_q && !iackin_q && waits_q != '1) waits_q <= waits_q + 1'b1;
    end
  end

  // --- what the bus keeps to ------------------------------------------------------------------

  `MMCS_GIVEN(AddressStands, vme_as_ni || $past(vme_as_ni) || dtack || dtack_q ||
              {vme_a_i, vme_iack_ni} == {$past(vme_a_i), $past(vme_iack_ni)},
              "level and IACK* stand while AS* is low and nobody has answered")
  `MMCS_GIVEN(PowerOn, rst_q || (vme_ds_ni[0] && vme_iackin_ni && vme_as_ni),
              "nobody uses the bus in reset")
  `MMCS_GIVEN(SetUp, vme_as_ni || !as_q ||
              {vme_a_i, vme_iack_ni} == {$past(vme_a_i), $past(vme_iack_ni)},
              "address, modifier, LWORD* and IACK* stand 10 ns before AS* falls")
  `MMCS_GIVEN(Apart, !(vme_as_ni && !as_q && !vme_ds_ni[0] && high_q),
              "no data strobe falls as AS* rises, high for 30 ns: DS* falls 10 ns before it does")
  `MMCS_GIVEN(ChainOnce, vme_iackin_ni || !iackin_q || !told_q,
              "the driver of the chain drives once under an AS* that was answered")
  `MMCS_GIVEN(Waits, !dtack_q || (vme_ds_ni | ~$past(vme_ds_ni)) == 2'b11,
              "no strobe falls before DTACK* of the cycle before is high")

  // --- properties -----------------------------------------------------------------------------

  `MMCS_PROVE(NeverBoth, "4.3.6", !iackout_n, !dtack && !answered_q && !d_oe,
              "an acknowledge that is passed on is not answered")
  `MMCS_PROVE(NeverBoth2, "4.3.6", dtack && !dtack_q, !passed_q && iackout_n,
              "an acknowledge that is answered has not been passed on")
  `MMCS_PROVE(PassInside, "4.3.6", !iackout_n, !vme_iackin_ni && !vme_as_ni,
              "IACKOUT* is low only while IACKIN* and AS* are: it needs no clock to rise")
  `MMCS_PROVE(OnlyAsked, "4.3.6", dtack && !dtack_q, IrqLevel == AckLevel && asked_q && level_q,
              "DTACK* is given only in an acknowledge of our level whose IACKIN* found us asking")
  `MMCS_PROVE(OnlyStrobed, "4.3.6", dtack && !dtack_q, good_q && !$past(vme_as_ni || vme_iackin_ni),
              "DTACK* falls only for a strobe that fell in this acknowledge and still stands")
  `MMCS_PROVE(DtackStays, "4.3.6", dtack_q && !dtack && !reset_q, !strobed_q || !strobed,
              "DTACK* does not rise before both data strobes")
  `MMCS_PROVE(DriversOff, "4.3.6", d_oe, strobed, "the vector goes with the data strobes, at once")
  `MMCS_PROVE(DataFirst, "4.3.6", dtack && !dtack_q, oe_q && (d_oe || !strobed),
              "the vector stands before DTACK* falls")
  `MMCS_PROVE(NeverNeither, "4.3.6",
              low && after_q && edges_q >= 3'd4 && !dtack && !answered_q &&
              !(asked && level && IrqLevel == AckLevel), !iackout_n,
              "an acknowledge that is not ours is passed on within four edges of the clock")
  `MMCS_PROVE(OwnKept, "4.3.6", asked && level && after_q && quiet_q && low &&
              IrqLevel == AckLevel, iackout_n,
              "an acknowledge that is ours is not passed on")
  `MMCS_PROVE(OwnAnswered, "4.3.6", waits_q >= 3'd4 && low && good && asked && level &&
              IrqLevel == AckLevel, dtack,
              "an acknowledge that is ours is answered within four edges of clock after its strobe")

endmodule

`default_nettype wire
