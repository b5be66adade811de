// SPDX-License-Identifier: Apache-2.0
// From an address of the VME window to one register or none, two cards side by side, and the rules
// of the PC bus between them. §4.3.2, §5.3.1
//
// Cut out: the timers; the cards' converters, one-shots and relays. The switches of both cards are
// free. The table of registers is written down here a second time.
`default_nettype none
`include "mmcs_formal.svh"

module mapping_props (
  input wire logic        clk_i,
  input wire logic        req_i,
  input wire logic        write_i,
  input wire logic [10:1] a_i,
  input wire logic [ 7:0] wdata_i,
  input wire logic        sys_reset_i,
  input wire logic        cable_ok_i,
  input wire logic        pc_power_i,
  input wire logic [ 7:0] pc_d_i,
  input wire logic        pc_wait_i,
  input wire logic [ 3:0] dip0_i,
  input wire logic [ 3:0] dip1_i
);

  `MMCS_RESET(1'b1)

  logic ack, ior_n, iow_n, aen;
  logic [15:0] pc_a;
  logic [7:0] pc_wdata;

  adaptor_core dut (
    .clk_i, .rst_ni,
    .hp_req_i(req_i),
    .hp_write_i(write_i),
    .hp_a_i(a_i),
    .hp_wdata_i(wdata_i),
    .hp_ack_o(ack),
    .sys_reset_i,
    .estop_closed_i(1'b1),
    .cable_ok_i, .pc_power_i,
    .pc_a_o(pc_a),
    .pc_aen_o(aen),
    .pc_d_o(pc_wdata),
    .pc_ior_no(ior_n),
    .pc_iow_no(iow_n),
    .pc_d_i, .pc_wait_i,
    .pc_irq_i('0)
  );

  // What the host does: a request stands until it is answered.
  logic req_q = 1'b0, ack_q = 1'b0;
  logic [18:0] held_q = '0;
  always @(posedge clk_i) begin
    if (rst_ni) begin
      req_q  <= req_i;
      ack_q  <= ack;
      held_q <= {write_i, a_i, wdata_i};
    end
  end
  `MMCS_GIVEN(RequestStands, !req_q || ack_q || (req_i && {write_i, a_i, wdata_i} == held_q),
              "the host holds a request until its answer")
  `MMCS_GIVEN(RequestPauses, !ack_q || !req_i, "and pauses a clock after it")

  // Wires of the inside, joined by the script.
  logic [3:0] f_sel;         // vector, PCCSR, timers, PC bus
  logic       f_strobe, f_link;
  logic [1:0] f_ppi_n, f_adc, f_sw_latch, f_drives;
  logic [3:0] f_enc_n, f_lo, f_hi;

  // --- the adaptor --------------------------------------------------------------------------

  // By the table of §4.3.3: {vector, PCCSR, timers, PC bus}.
  logic [3:0] wanted;
  always_comb begin
    wanted = 4'b0000;
    if (!a_i[10]) wanted = 4'b0001;
    else if (a_i[6]) wanted = 4'b1000;
    else if (a_i[5:3] == 3'b000) wanted = 4'b0010;
    else if (a_i[5:3] == 3'b001) wanted = 4'b0100;
  end

  logic command;
  assign command = ~(ior_n & iow_n);

  `MMCS_PROVE(OneOfFour, "4.3.3", req_i, f_sel == wanted && (f_sel & (f_sel - 4'd1)) == 4'd0,
              "an odd address of the window selects timers, PCCSR, vector, PC bus, or none")
  `MMCS_PROVE(OwnOrBus, "4.3.3", f_strobe, a_i[10] && !command,
              "an access to an own register makes no cycle on the PC bus")
  `MMCS_PROVE(AddressMap, "4.3.2", command,
              pc_a[4:0] == a_i[5:1] && pc_a[13:10] == a_i[9:6] && pc_a[15:14] == 2'b00 && !a_i[10],
              "PC A04-A00 are VME A05-A01, A13-A10 are A09-A06, A15 and A14 are 0")
  `MMCS_PROVE(Direction, "4.3.2", command, (iow_n != ior_n) && (iow_n == !write_i) && !aen,
              "a read makes IOR#, a write IOW#, AEN is 0")
  `MMCS_PROVE(DataOut, "4.3.2", !iow_n, pc_wdata == wdata_i, "IOW# stands with the host's data")

  // --- two cards ----------------------------------------------------------------------------

  for (genvar n = 0; n < 2; n++) begin : g_card
    mark1 u_card (
      .clk_i, .rst_ni,
      .pc_clk_en_i(1'b1),
      .pc_reset_drv_i(1'b0),
      .pc_a_i(pc_a),
      .pc_aen_i(aen),
      .pc_ior_ni(ior_n),
      .pc_iow_ni(iow_n),
      .pc_d_i(pc_wdata),
      .pc_d_oe_o(f_drives[n]),
      .pc_drq_i('0),
      .dip_i(n == 0 ? dip0_i : dip1_i),
      .axis_enable_i(2'b11),
      .power_i(1'b1),
      .enc_a_i('0), .enc_b_i('0), .enc_i_i('0), .adc_v_i('0)
    );
  end

  // The rules of the PC bus, as the simulation has them.
  pcbus_checker #(
    .SideClks(1),
    .CmdClks(4),
    .MaxClks(17),
    .NumCards(2)
  ) u_pcbus_rules (
    .clk_i, .rst_ni,
    .link_ok_i(cable_ok_i && pc_power_i && f_link),
    .pc_a_i(pc_a),
    .pc_d_i(pc_wdata),
    .pc_ior_ni(ior_n),
    .pc_iow_ni(iow_n),
    .pc_aen_i(aen),
    .drivers_i({1'b0, f_drives})
  );

  // Card 0: what a register of table 5.1 selects; {latch, A/D, hi2, hi1, lo2, lo1, enc2, enc1, PPI}
  logic [8:0] selects, table_of;
  logic at_card, at_all;
  assign selects = {f_sw_latch[0], f_adc[0], f_hi[1:0], f_lo[1:0], ~f_enc_n[1:0], ~f_ppi_n[0]};
  assign at_card = command && pc_a[9:5] == 5'b11000 && pc_a[13:10] == dip0_i;
  assign at_all = command && pc_a[9:5] == 5'b11000 && pc_a[4:0] == 5'h12;
  always_comb begin
    table_of = 9'h000;
    if (at_card) begin
      if (pc_a[4:0] <= 5'h03) table_of = 9'h001;
      else if (pc_a[4:0] <= 5'h05) table_of = 9'h002;
      else if (pc_a[4:0] <= 5'h07) table_of = 9'h004;
      else if (pc_a[4:0] == 5'h08 && !iow_n) table_of = 9'h008;
      else if (pc_a[4:0] == 5'h0A && !iow_n) table_of = 9'h010;
      else if (pc_a[4:0] == 5'h09 && !iow_n) table_of = 9'h020;
      else if (pc_a[4:0] == 5'h0B && !iow_n) table_of = 9'h040;
      else if (pc_a[4:0] >= 5'h0C && pc_a[4:0] <= 5'h0E && !ior_n) table_of = 9'h080;
      else if (pc_a[4:0] == 5'h10) table_of = 9'h100;
    end
    if (at_all) table_of = 9'h100;
  end

  `MMCS_PROVE(CardTable, "5.3.1", command, selects == table_of,
              "a register of a card is selected at its address and switches, as table 5.1 says")
  `MMCS_PROVE(OneRegister, "5.3.1", selects != 9'h000, (selects & (selects - 9'd1)) == 9'h000,
              "a command selects one register of a card or none")
  `MMCS_PROVE(OneCard, "5.3.1", f_drives[0] && dip0_i != dip1_i, !f_drives[1],
              "no two cards answer one address unless their switches are equal")
  `MMCS_PROVE(OneSelected, "5.3.1", (selects & 9'h0FF) != 0 && dip0_i != dip1_i,
              f_ppi_n[1] && (&f_enc_n[3:2]) && f_lo[3:2] == 0 && f_hi[3:2] == 0 && !f_adc[1],
              "no two cards are selected by one address unless their switches are equal")
  `MMCS_PROVE(MasterAlone, "4.3.2", !iow_n, f_drives == 2'b00,
              "no card drives the data bus while the adaptor does: never two drivers")
  `MMCS_PROVE(DrivesInRead, "5.3.1", f_drives[0], !ior_n && at_card,
              "a card drives data only in a read of its own address")
  `MMCS_REACH(EqualSwitches, f_drives == 2'b11, "two cards with equal switches do answer together")

endmodule

`default_nettype wire
