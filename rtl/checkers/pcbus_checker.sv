// SPDX-License-Identifier: Apache-2.0
// The rules of the PC I/O bus, seen from the bus on every clock. §4.3.2
//
// Attached by bind.sv in simulation; the proofs use it as it is.
`default_nettype none
`include "checkers/mmcs_rule.svh"

module pcbus_checker #(
  parameter int SideClks = 1,   // address set-up and data hold
  parameter int CmdClks = 4,    // shortest command
  parameter int MaxClks = 0,    // longest command, IOCHRDY and all; 0: no limit
  parameter int NumCards = 3,
  parameter bit Stop = 1'b1
) (
  input  wire logic                clk_i,
  input  wire logic                rst_ni,
  input  wire logic                link_ok_i,     // a pulled cable may cut a command short
  input  wire logic [        15:0] pc_a_i,
  input  wire logic [         7:0] pc_d_i,        // what the master drives
  input  wire logic                pc_ior_ni,
  input  wire logic                pc_iow_ni,
  input  wire logic                pc_aen_i,
  // Who drives the data lines in a read: one bit per card, expansion on top
  input  wire logic [  NumCards:0] drivers_i,
  output logic                     conflict_o,    // sticky: two cards have answered one read
  output logic      [        11:0] broken_o       // sticky, one bit per rule in the order below
);

  localparam int Width = 12;

  logic [11:0] bad;
  logic command, command_q, iow_q;
  logic [15:0] a_q;
  logic [ 7:0] d_q;
  logic [Width-1:0] stable_q;   // clocks that the address has stood still
  logic [Width-1:0] low_q;      // clocks that the command has been low
  logic [Width-1:0] high_q;     // clocks since it went high
  logic link_q, cut_q;

  assign command = ~(pc_ior_ni & pc_iow_ni);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      command_q  <= 1'b0;
      iow_q      <= 1'b0;
      a_q        <= '0;
      d_q        <= '0;
      stable_q   <= '0;
      low_q      <= '0;
      high_q     <= '1;
      link_q     <= 1'b0;
      cut_q      <= 1'b0;
      conflict_o <= 1'b0;
      broken_o   <= '0;
    end else begin
      command_q <= command;
      link_q    <= link_ok_i;
      if (!link_ok_i) cut_q <= 1'b1;
      else if (!command) cut_q <= 1'b0;
      iow_q <= ~pc_iow_ni;
      a_q   <= pc_a_i;
      d_q   <= pc_d_i;
      if (pc_a_i != a_q) stable_q <= Width'(1);
      else if (stable_q != '1) stable_q <= stable_q + 1'b1;
      if (!command) low_q <= '0;
      else if (low_q != '1) low_q <= low_q + 1'b1;
      if (command) high_q <= '0;
      else if (high_q != '1) high_q <= high_q + 1'b1;
      if (!pc_ior_ni && |(drivers_i & (drivers_i - 1'b1))) begin
`ifndef FORMAL
        if (!conflict_o) $display("%m: two cards answer address 0x%04x", pc_a_i);
`endif
        conflict_o <= 1'b1;
      end
      broken_o <= broken_o | bad;
    end
  end

  logic whole;   // nobody pulled the cable
  assign whole = link_ok_i && link_q && !cut_q;

  `MMCS_RULE(0, OneCommand, pc_ior_ni || pc_iow_ni, "IOR# and IOW# are never low together")
  `MMCS_RULE(1, NoDma, !pc_aen_i, "AEN is 0: nobody but the adaptor owns the bus")
  `MMCS_RULE(2, AddressFirst,
             !(command && !command_q && whole) ||
             (pc_a_i == a_q && stable_q >= Width'(SideClks)),
             "the address stands a full clock before the command")
  `MMCS_RULE(3, AddressHolds, !(command && command_q) || pc_a_i == a_q,
             "the address stands through the command")
  `MMCS_RULE(4, AddressAfter, !(!command && command_q && whole) || pc_a_i == a_q,
             "the address stands past the end of the command")
  `MMCS_RULE(5, DataHolds, !(iow_q && pc_iow_ni && whole) || pc_d_i == d_q,
             "write data stands past the end of IOW#")
  `MMCS_RULE(6, LongEnough, !(!command && command_q && whole) || low_q >= Width'(CmdClks),
             "a command is low for CmdNs at least")
  `MMCS_RULE(7, Recovery,
             !(command && !command_q && whole) || high_q >= Width'(2 * SideClks),
             "two commands are apart by hold and set-up")
  `MMCS_RULE(8, DataStands, !(iow_q && !pc_iow_ni && whole) || pc_d_i == d_q,
             "write data stands through IOW#")
  `MMCS_RULE(9, ShortEnough, MaxClks == 0 || low_q <= Width'(MaxClks),
             "IOCHRDY stretches a command up to its limit, no further")
  `MMCS_RULE(10, DriveInRead, !(pc_ior_ni && |drivers_i[NumCards-1:0]),
             "a card drives data only while IOR# is low")
  `MMCS_RULE(11, IoSpace, pc_a_i[15:14] == 2'b00, "A15 and A14 are 0")

endmodule

`default_nettype wire
