// SPDX-License-Identifier: Apache-2.0
// The rules of DTACK*, IACKOUT* and the data drivers at every edge of an asynchronous line, not on
// clock edges. §4.3.1, §4.3.6
//
// Simulation only. Lines that move at one instant may be seen one after the other, so an instant is
// judged when the next one comes.
`default_nettype none

module vme_edge_checker #(
  parameter logic [4:0] BaseA15A11 = 5'b01100,
  parameter int IrqLevel = 5,
  parameter int AckLevel = 5,
  parameter bit Stop = 1'b1
) (
  input  wire logic        rst_ni,
  input  wire logic [15:1] vme_a_i,
  input  wire logic [ 5:0] vme_am_i,
  input  wire logic        vme_as_ni,
  input  wire logic [ 1:0] vme_ds_ni,
  input  wire logic        vme_lword_ni,
  input  wire logic        vme_iack_ni,
  input  wire logic        vme_iackin_ni,
  input  wire logic        vme_sysreset_ni,
  input  wire logic        vme_iackout_no,
  input  wire logic        vme_d_oe_o,
  input  wire logic        vme_dtack_no,
  output logic      [ 6:0] broken_o   // until reset, one bit per rule in the order below
);

`ifdef SYNTHESIS
  assign broken_o = '0;
`elsif YOSYS
  assign broken_o = '0;
`elsif FORMAL
  assign broken_o = '0;
`else

  localparam int DtackStrobed = 0, DtackOurs = 1, DtackStays = 2, DriversOff = 3, DriveOurs = 4,
                 PassInside = 5, OneFate = 6;

  task automatic rule(input int what, input logic holds, input logic [8*60-1:0] text);
    if (!holds) begin
      broken_o[what] = 1'b1;
      if (Stop) $fatal(1, "%m: %0s", text);
    end
  endtask

  // The instant that is over, and the one before.
  logic [1:0] ds_q, ds1_q;
  logic as_q, iackin_q, iackout_q, dtack_q, dtack1_q, oe_q, oe1_q, reset_q, ours_q;
  logic good_q;       // DS0* fell in a cycle of ours or in an acknowledge, and still stands
  logic passed_q, answered_q, quiet_q;
  logic ours, data_cycle, asks;
  realtime then;

  logic unused;
  assign unused = ^vme_a_i[10:4];

  assign data_cycle = vme_iack_ni && vme_lword_ni && vme_a_i[15:11] == BaseA15A11 &&
                      (vme_am_i == 6'h29 || vme_am_i == 6'h2D);
  assign asks = !vme_iack_ni && vme_a_i[3:1] == 3'(AckLevel) && IrqLevel == AckLevel;
  assign ours = data_cycle || asks;

  // Judges the instant that is over: ds_q to oe_q, against the one before it.
  task automatic judge;
    if (ds_q[0]) good_q = 1'b0;
    else if (ds1_q[0]) good_q = ours_q;
    if (iackin_q) {passed_q, answered_q} = 2'b00;
    if (!iackout_q) passed_q = 1'b1;
    if (!reset_q) quiet_q = 1'b0;
    else if (ds_q == 2'b11) quiet_q = 1'b1;
    if (dtack1_q && !dtack_q) begin
      rule(DtackStrobed, ds_q != 2'b11 || ds1_q != 2'b11, "DTACK* falls only with a strobe low");
      rule(DtackOurs, good_q || ds1_q != ds_q, "DTACK* falls only for a strobe that fell for us");
      if (!iackin_q) answered_q = 1'b1;
    end
    if (!dtack1_q && dtack_q && quiet_q) begin
      rule(DtackStays, ds_q == 2'b11 || ds1_q == 2'b11, "DTACK* rises only after both strobes");
    end
    rule(DriversOff, !oe_q || ds_q != 2'b11, "data is driven only while a strobe is low");
    rule(DriveOurs, !oe_q || oe1_q || good_q, "data is driven only into a cycle that is ours");
    rule(PassInside, iackout_q || !(as_q || iackin_q), "IACKOUT* is inside AS* and IACKIN*");
    rule(OneFate, !(passed_q && answered_q) && (iackout_q || dtack_q),
         "an acknowledge is passed on or answered, never both");
    {ds1_q, dtack1_q, oe1_q} = {ds_q, dtack_q, oe_q};
  endtask

  always @(rst_ni or vme_a_i or vme_am_i or vme_lword_ni or vme_iack_ni or vme_as_ni or
           vme_ds_ni or vme_iackin_ni or vme_sysreset_ni or vme_iackout_no or vme_d_oe_o or
           vme_dtack_no) begin
    if (!rst_ni) begin
      broken_o = '0;
      {ds1_q, dtack1_q, oe1_q} = 4'b1110;
      {good_q, passed_q, answered_q, quiet_q} = 4'b0001;
      then = $realtime;
    end else if ($realtime != then) begin
      judge();
      then = $realtime;
    end
    {ds_q, as_q, iackin_q, reset_q} = {vme_ds_ni, vme_as_ni, vme_iackin_ni, vme_sysreset_ni};
    {iackout_q, dtack_q, oe_q, ours_q} = {vme_iackout_no, vme_dtack_no, vme_d_oe_o, ours};
  end

`endif

endmodule

`default_nettype wire
