// SPDX-License-Identifier: Apache-2.0
// The 8255: its latches, its mode word, what drives its pins. §5.3.1
`default_nettype none
`include "mmcs_formal.svh"

module i8255_props (
  input wire logic       clk_i,
  input wire logic       no_reset_i,
  input wire logic       reset_i,
  input wire logic       cs_ni,
  input wire logic       rd_ni,
  input wire logic       wr_ni,
  input wire logic [1:0] a_i,
  input wire logic [7:0] d_i,
  input wire logic [7:0] pa_i,
  input wire logic [7:0] pb_i,
  input wire logic [7:0] pc_i
);

  `MMCS_RESET(no_reset_i)

  logic [7:0] d, pa, pa_oe, pb, pb_oe, pc, pc_oe;
  logic oe;
  i8255 dut (
    .clk_i, .rst_ni, .reset_i, .cs_ni, .rd_ni, .wr_ni, .a_i, .d_i, .d_o(d), .d_oe_o(oe), .pa_i,
    .pa_o(pa), .pa_oe_o(pa_oe), .pb_i, .pb_o(pb), .pb_oe_o(pb_oe), .pc_i, .pc_o(pc),
    .pc_oe_o(pc_oe)
  );

  // --- the model: a write acts when its strobe ends, unless RESET came ------------------------

  logic [1:0] strobe, strobe_q, at_q;  // 1 read, 2 write
  logic [7:0] data_q;
  logic acts;
  assign strobe = cs_ni || reset_i ? 2'd0 : !rd_ni ? 2'd1 : !wr_ni ? 2'd2 : 2'd0;
  assign acts   = strobe_q == 2'd2 && (cs_ni || !rd_ni || wr_ni) && !reset_i;

  // What group A and B do: 0 plain, 1 strobed, 2 both ways. Bits of port C that are plain: a write
  // to port C reaches these. Bits that hold an interrupt enable, or IBF, OBF# or INTR, instead of a
  // latch.
  logic [6:0] mode_q;
  logic [1:0] mode_a;
  logic [7:0] enables, plain, flags;
  assign mode_a = mode_q[6] ? 2'd2 : {1'b0, mode_q[5]};
  assign plain  = {{5{mode_a == 2'd0}}, {3{!mode_q[2]}}};
  always_comb begin
    enables = 8'h00;
    enables[6] = mode_a == 2'd2 || (mode_a == 2'd1 && !mode_q[4]);
    enables[4] = mode_a == 2'd2 || (mode_a == 2'd1 && mode_q[4]);
    enables[2] = mode_q[2];
    flags = {enables[6], 1'b0, enables[4], 1'b0, mode_a != 2'd0, 1'b0, {2{mode_q[2]}}};
  end

  logic sets_mode, sets_bit;
  logic [7:0] one;  // the bit that is set or reset
  logic [7:0] a_q, b_q, c_q, enable_q;
  assign sets_mode = acts && at_q == 2'd3 && data_q[7];
  assign sets_bit  = acts && at_q == 2'd3 && !data_q[7];
  assign one       = 8'd1 << data_q[3:1];

  always @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      {strobe_q, at_q, data_q, a_q, b_q, c_q, enable_q} <= '0;
      mode_q <= 7'h1B;
    end else begin
      strobe_q <= strobe;
      if (!cs_ni && !(rd_ni && wr_ni)) at_q <= a_i;
      if (!cs_ni && rd_ni && !wr_ni) data_q <= d_i;
      if (reset_i || sets_mode) begin
        {a_q, b_q, c_q, enable_q} <= '0;
        mode_q <= reset_i ? 7'h1B : data_q[6:0];
      end else if (sets_bit && (enables & one) != 8'h00) begin
        enable_q <= data_q[0] ? enable_q | one : enable_q & ~one;
      end else if (sets_bit && (flags & one) != 8'h00) begin
        // what the handshakes make of it is not modelled: SetsFlag
      end else if (sets_bit) begin
        c_q <= data_q[0] ? c_q | one : c_q & ~one;
      end else if (acts) begin
        case (at_q)
          2'd0:    a_q <= data_q;
          2'd1:    b_q <= data_q;
          default: c_q <= (data_q & plain) | (c_q & ~plain);
        endcase
      end
    end
  end

  // --- properties -----------------------------------------------------------------------------

  logic simple;  // both groups in mode 0, as on the card
  logic [7:0] c_out;
  assign simple = mode_a == 2'd0 && !mode_q[2];
  assign c_out  = {{4{!mode_q[3]}}, {4{!mode_q[0]}}};

  `MMCS_PROVE(PortA, "5.3.1", mode_a != 2'd2 && !mode_q[4], pa == a_q && pa_oe == 8'hFF,
              "port A as an output drives what was last written to it")
  `MMCS_PROVE(PortB, "5.3.1", !mode_q[1], pb == b_q && pb_oe == 8'hFF,
              "port B as an output drives what was last written to it")
  `MMCS_PROVE(PortC, "5.3.1", simple, pc == c_q && pc_oe == c_out,
              "port C drives what was last written to it, in the halves that are outputs")
  `MMCS_PROVE(InputA, "5.3.1", mode_a != 2'd2 && mode_q[4], pa_oe == 8'h00,
              "port A as an input drives nothing")
  `MMCS_PROVE(InputB, "5.3.1", mode_q[1], pb_oe == 8'h00, "port B as an input drives nothing")
  `MMCS_PROVE(BothWays, "5.3.1", mode_a == 2'd2, pa == a_q && pa_oe == {8{!pc_i[6]}},
              "in mode 2 port A drives only while it is acknowledged")
  `MMCS_PROVE(Clears, "5.3.1", $past(sets_mode || reset_i) && $past(rst_ni),
              {pa, pb, a_q, b_q, c_q, enable_q} == '0 && (!simple || pc == 8'h00),
              "setting the mode, or RESET, clears every output latch")
  `MMCS_PROVE(AllInputs, "5.3.1", $past(reset_i) && $past(rst_ni),
              {pa_oe, pb_oe, pc_oe} == '0, "RESET makes all ports inputs")
  `MMCS_PROVE(OneBit, "5.3.1", $past(sets_bit) && $past(rst_ni) && simple && pc != $past(pc),
              pc == ($past(data_q[0]) ? $past(pc | one) : $past(pc & ~one)) &&
              {pa, pb} == $past({pa, pb}),
              "bit set and reset touches the one bit that it names")
  `MMCS_PROVE(SetsFlag, "5.3.1", $past(sets_bit && (flags & one & 8'hA2) != 8'h00 && (&pc_i)) &&
              $past(rst_ni), ((pc & $past(one)) != 8'h00) == $past(data_q[0]),
              "set and reset writes IBF and OBF# too, while nobody shakes hands")
  `MMCS_PROVE(Stays, "5.3.1", !$past(acts) && !$past(reset_i) && $past(rst_ni) && simple,
              {pa, pb, pc, pa_oe, pb_oe, pc_oe} == $past({pa, pb, pc, pa_oe, pb_oe, pc_oe}),
              "in mode 0 nothing but a write changes a port")
  `MMCS_PROVE(ReadBack, "5.3.1", !cs_ni && !rd_ni && simple, oe && d ==
              (a_i == 2'd0 ? (mode_q[4] ? pa_i : a_q) : a_i == 2'd1 ? (mode_q[1] ? pb_i : b_q) :
               a_i == 2'd2 ? (c_out & c_q) | (~c_out & pc_i) : 8'hFF),
              "a read shows the latches of outputs and the pins of inputs")

  // --- steps on the way -----------------------------------------------------------------------

  // Wires of these names are joined to the registers when the hierarchy is flattened.
  (* hierconn *) wire \dut.rd_q , \dut.wr_q ;
  (* hierconn *) wire [1:0] \dut.a_q ;
  (* hierconn *) wire [6:0] \dut.mode_q ;
  (* hierconn *) wire [7:0] \dut.d_q , \dut.pa_q , \dut.pb_q , \dut.pc_q , \dut.inte_q ;

  `MMCS_LEMMA(Bus, {dut.wr_q, dut.rd_q} == strobe_q &&
              (strobe_q == 2'd0 || dut.a_q == at_q) && (strobe_q != 2'd2 || dut.d_q == data_q),
              "both see the same strobes")
  `MMCS_LEMMA(Latches, dut.mode_q == mode_q && {dut.pa_q, dut.pb_q, dut.pc_q, dut.inte_q} ==
              {a_q, b_q, c_q, enable_q}, "both hold the same latches")

endmodule

`default_nettype wire
