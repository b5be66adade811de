// SPDX-License-Identifier: Apache-2.0
// The slave between clock edges: every step is an instant, and the board's clock rises when it
// likes. The host port behind it answers when it likes. §4.3.1
`default_nettype none
`include "mmcs_formal.svh"

module slave_props (
  input wire logic        board_clk_i,
  input wire logic        reset_any_i,   // become synchronous below
  input wire logic        ack_any_i,
  input wire logic [15:1] vme_a_i,
  input wire logic        ours_any_i,    // AM, LWORD* and IACK* make the cycle ours
  input wire logic        vme_as_ni,
  input wire logic [ 1:0] vme_ds_ni,
  input wire logic        vme_write_ni,
  input wire logic [ 7:0] vme_d_i
);

  (* gclk *) logic clk_i;                // the instants

  `MMCS_RESET(1'b1)

  logic sys_reset_q = 1'b0, ack_q = 1'b0;
  always @(posedge board_clk_i) {sys_reset_q, ack_q} <= {reset_any_i, ack_any_i};

  logic d_oe, dtack, hp_req, hp_write, hp_ack;
  logic [10:1] hp_a;
  logic [7:0] hp_wdata;
  assign hp_ack = hp_req & ack_q;

  vme_slave dut (
    .clk_i(board_clk_i), .rst_ni,
    .sys_reset_i(sys_reset_q),
    .vme_a_i, .vme_am_i(6'h29), .vme_as_ni, .vme_ds_ni, .vme_write_ni, .vme_lword_ni(ours_any_i),
    .vme_iack_ni(1'b1), .vme_d_i,
    .d_oe_o(d_oe),
    .dtack_o(dtack),
    .hp_req_o(hp_req),
    .hp_write_o(hp_write),
    .hp_a_o(hp_a),
    .hp_wdata_o(hp_wdata),
    .hp_ack_i(hp_ack)
  );

  // --- the cycle, seen from the bus -----------------------------------------------------------

  // Wires of these names are joined to the registers when the hierarchy is flattened.
  (* hierconn *) wire \dut.busy_q ;
  logic strobed, ours, mine, old, rises, fresh, good;
  logic clk_q = 1'b1, as_q = 1'b1, rst_q = 1'b0, ours_q = 1'b0, strobed_q = 1'b0;
  logic [1:0] ds_q = '1;
  logic mine_q = 1'b0;                   // AS* fell under our address
  logic old_q = 1'b1;                    // DS0* stood as AS* rose: it is the last cycle's
  logic good_q = 1'b0;                   // DS0* fell in a cycle of ours and still stands
  logic dtack_q = 1'b0, oe_q = 1'b0, req_q = 1'b0, reset_q = 1'b0, done_q = 1'b0;
  logic since_q = 1'b0;                  // the present request began under the present strobe
  logic rest_q = 1'b0;                   // the slave was at rest when this strobe fell
  logic [2:0] waits_q = '0;              // clocks that it has stood since
  logic [1:0] resets_q = '0;             // clocks of SYSRESET*
  logic [10:1] a_q = '0, bus_a_q = '0;   // what that strobe addressed; the pins an instant ago
  logic [7:0] d_q = '0, bus_d_q = '0;
  logic write_q = 1'b0, bus_write_q = 1'b0;
  assign strobed = ~(&vme_ds_ni);
  assign ours = ours_any_i && vme_a_i[15:11] == 5'b01100;
  assign rises = board_clk_i && !clk_q;
  assign mine = !vme_as_ni && (as_q ? ours_q : mine_q);
  assign old = !vme_ds_ni[0] && (old_q || (vme_as_ni && !as_q));
  assign fresh = !vme_ds_ni[0] && !old && mine;
  assign good = !vme_ds_ni[0] && (fresh || good_q);

  always @(posedge clk_i) begin
    clk_q <= board_clk_i;
    rst_q <= rst_ni;
    if (rst_ni) begin
      {as_q, ds_q, ours_q, mine_q, old_q, good_q} <= {vme_as_ni, vme_ds_ni, ours, mine, old, good};
      {bus_a_q, bus_d_q, bus_write_q} <= {vme_a_i[10:1], vme_d_i, ~vme_write_ni};
      strobed_q <= strobed;
      dtack_q   <= dtack;
      oe_q      <= d_oe;
      req_q     <= hp_req;
      reset_q   <= sys_reset_q;
      if (!sys_reset_q) resets_q <= '0;
      else if (rises && resets_q != '1) resets_q <= resets_q + 1'b1;
      done_q    <= good && !sys_reset_q && (done_q || dtack);
      if (as_q && !vme_as_ni) a_q <= bus_a_q;
      if (ds_q[0] && !vme_ds_ni[0]) {d_q, write_q} <= {bus_d_q, bus_write_q};
      since_q <= good && (since_q || (hp_req && !req_q));
      rest_q  <= good && (good_q ? rest_q : !dut.busy_q && !dtack);
      if (!good || vme_as_ni || sys_reset_q || !rest_q) waits_q <= '0;
      else if (rises && good_q && !as_q && waits_q != '1) waits_q <= waits_q + 1'b1;
    end
  end

  // --- what the bus keeps to ------------------------------------------------------------------

  `MMCS_GIVEN(PowerOn, rst_q || (vme_ds_ni[0] && vme_as_ni), "nobody uses the bus in reset")
  `MMCS_GIVEN(SetUp, vme_as_ni || !as_q || {ours, vme_a_i[10:1]} == {ours_q, bus_a_q},
              "address, modifier, LWORD* and IACK* stand 10 ns before AS* falls")
  `MMCS_GIVEN(DataSetUp, vme_ds_ni[0] || !ds_q[0] ||
              {vme_d_i, ~vme_write_ni} == {bus_d_q, bus_write_q},
              "WRITE* and data stand 10 ns before the first data strobe falls")
  `MMCS_GIVEN(Apart, !(vme_as_ni && !as_q && !vme_ds_ni[0] && ds_q[0]),
              "no data strobe falls as AS* rises, high for 30 ns: DS* falls 10 ns before it does")
  `MMCS_GIVEN(AsStands, !(vme_as_ni && !as_q && good_q && !vme_ds_ni[0]) || done_q || dtack,
              "AS* stands until DTACK*, or until the strobe is withdrawn")
  `MMCS_GIVEN(ResetLasts, !reset_q || sys_reset_q || resets_q == 2'd3,
              "SYSRESET* lasts three clocks at least (the bus says 200 ms)")
  `MMCS_GIVEN(Waits, !dtack_q || (vme_ds_ni | ~$past(vme_ds_ni)) == 2'b11,
              "no strobe falls before DTACK* of the cycle before is high")

  // --- properties -----------------------------------------------------------------------------

  `MMCS_PROVE(OwnStrobe, "4.3.1", dtack && !dtack_q, good_q && since_q,
              "DTACK* falls only for the strobe whose request it answers, which still stands")
  `MMCS_PROVE(OwnData, "4.3.1", dtack && !dtack_q,
              {hp_a, hp_write} == {a_q, write_q} && (!write_q || hp_wdata == d_q),
              "what was asked of the host port is what that strobe addressed, data and all")
  `MMCS_PROVE(Stands, "4.3.1", hp_req && req_q,
              {hp_a, hp_wdata, hp_write} == $past({hp_a, hp_wdata, hp_write}),
              "a request does not change while it is under way")
  `MMCS_PROVE(DtackStays, "4.3.1", dtack_q && !dtack && !reset_q, !strobed_q || !strobed,
              "DTACK* does not rise before both data strobes")
  `MMCS_PROVE(DriversOff, "4.3.1", d_oe, strobed && !hp_write,
              "data is driven only in a read and goes with the strobes, at once")
  `MMCS_PROVE(DriveOwn, "4.3.1", d_oe, good || dtack || dtack_q,
              "data is driven only into the cycle that is ours")
  `MMCS_PROVE(DataFirst, "4.3.1", dtack && !dtack_q && !hp_write, oe_q,
              "the drivers are on before DTACK* falls")
  `MMCS_PROVE(QuietReset, "4.3.1", hp_req && !req_q, !reset_q,
              "no strobe becomes a request in SYSRESET*")
  `MMCS_PROVE(Taken, "4.3.1", waits_q >= 3'd4, since_q,
              "a strobe of ours that stands becomes a request within four edges of the clock")

endmodule

`default_nettype wire
