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

  logic rst_ni = 1'b0;
  always @(posedge clk_i) rst_ni <= 1'b1;

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

  // A wire of this name is joined to the register when the hierarchy is flattened.
  (* hierconn *) wire [1:0] \dut.state_q ;
  logic strobed, ours, rises, good;
  logic clk_q = 1'b1, rst_q = 1'b0, awake_q = 1'b0, high_q = 1'b1, strobed_q = 1'b0;
  logic good_q = 1'b0;                   // DS0* fell in a cycle of ours and still stands
  logic dtack_q = 1'b0, oe_q = 1'b0, req_q = 1'b0, reset_q = 1'b0, reset_seen_q = 1'b0;
  logic since_q = 1'b0;                  // the present request began under the present strobe
  logic [1:0] falls_q = '0;              // of DS0* in this clock of the board
  logic rest_q = 1'b0;                   // the slave was at rest when this strobe fell
  logic [2:0] waits_q = '0;              // clocks that it has stood since
  logic [10:1] a_q = '0;                 // what that strobe addressed
  logic [7:0] d_q = '0;
  logic write_q = 1'b0;
  assign strobed = ~(&vme_ds_ni);
  assign ours = ours_any_i && vme_a_i[15:11] == 5'b01100;
  assign rises = board_clk_i && !clk_q;
  assign good = !vme_ds_ni[0] && ((high_q && ours) || good_q);

  always @(posedge clk_i) begin
    clk_q <= board_clk_i;
    rst_q <= rst_ni;
    high_q <= vme_ds_ni[0] & rst_ni;
    if (rises && rst_q) awake_q <= 1'b1;
    if (rst_ni) begin
      good_q    <= good;
      strobed_q <= strobed;
      dtack_q   <= dtack;
      oe_q      <= d_oe;
      req_q     <= hp_req;
      reset_q   <= sys_reset_q;
      if (rises) falls_q <= {1'b0, vme_ds_ni[0] < $past(vme_ds_ni[0])};
      else if (vme_ds_ni[0] < $past(vme_ds_ni[0]) && falls_q != '1) falls_q <= falls_q + 1'b1;
      if (good && !good_q) {a_q, d_q, write_q} <= {vme_a_i[10:1], vme_d_i, ~vme_write_ni};
      since_q <= good && (since_q || (hp_req && !req_q));
      rest_q    <= good && (good_q ? rest_q : dut.state_q == 2'd0 && !dtack);
      if (!good || vme_as_ni || sys_reset_q || !rest_q) waits_q <= '0;
      else if (rises && good_q && !$past(vme_as_ni) && waits_q != '1) waits_q <= waits_q + 1'b1;
    end
  end

  // --- what the bus keeps to ------------------------------------------------------------------

  `MMCS_GIVEN(Holds, !good_q || vme_ds_ni[0] || dtack || dtack_q || (ours &&
              {vme_a_i[10:1], vme_d_i, ~vme_write_ni} == {a_q, d_q, write_q}),
              "address, WRITE* and data stand until DTACK*, or until the strobe is withdrawn")
  `MMCS_GIVEN(PowerOn, (awake_q || vme_ds_ni[0] || ours) && (rst_q || vme_ds_ni[0]),
              "until the first clock after power-on nobody else uses the bus")
  `MMCS_GIVEN(Pace, falls_q < 2'd2 || vme_ds_ni[0] || $past(ours) == ours,
              "two strobes and an address pipelined under the second do not fit one clock")
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
  `MMCS_PROVE(Taken, "4.3.1", waits_q >= 3'd4, since_q,
              "a strobe of ours that stands becomes a request within four edges of the clock")

endmodule

`default_nettype wire
