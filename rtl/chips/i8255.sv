// SPDX-License-Identifier: Apache-2.0
// 8255A programmable peripheral interface: modes 0, 1 and 2, bit set/reset. §5.3.1
//
// Group A is port A with C7-C4 (and C3 in modes 1 and 2), group B is port B with C2-C0. STB# and
// ACK# are sampled by clk_i without synchroniser; put one outside if they need it.
`default_nettype none

module i8255 #(
  parameter bit ControlReadable = 1'b0  // 1: an 82C55A, which returns its mode word
) (
  input  wire logic       clk_i,
  input  wire logic       rst_ni,
  // Bus
  input  wire logic       reset_i,
  input  wire logic       cs_ni,
  input  wire logic       rd_ni,
  input  wire logic       wr_ni,
  input  wire logic [1:0] a_i,
  input  wire logic [7:0] d_i,
  output logic      [7:0] d_o,
  output logic            d_oe_o,
  // Ports
  input  wire logic [7:0] pa_i,
  output logic      [7:0] pa_o,
  output logic      [7:0] pa_oe_o,
  input  wire logic [7:0] pb_i,
  output logic      [7:0] pb_o,
  output logic      [7:0] pb_oe_o,
  input  wire logic [7:0] pc_i,
  output logic      [7:0] pc_o,
  output logic      [7:0] pc_oe_o
);

  localparam logic [1:0] PortA = 2'd0, PortB = 2'd1, PortC = 2'd2;
  localparam logic [6:0] AllInputs = 7'h1B;  // mode word 0x9B, what RESET leaves

  // The bits of `mask` from d, the others as they were.
  function automatic logic [7:0] merge(input logic [7:0] old, input logic [7:0] d,
                                       input logic [7:0] mask);
    merge = (old & ~mask) | (d & mask);
  endfunction

  // --- bus: a write acts when its strobe ends -------------------------------------------------

  logic rd, wr, rd_q, wr_q, rd_end, wr_end;
  logic rd_d, wr_d;
  logic [1:0] a_d, a_q;
  logic [7:0] d_d, d_q;

  assign rd = !cs_ni && !rd_ni;
  assign wr = !cs_ni && !wr_ni && rd_ni;
  assign rd_end = rd_q && !rd;
  assign wr_end = wr_q && !wr;
  assign rd_d = rd && !reset_i;
  assign wr_d = wr && !reset_i;
  assign a_d = (rd || wr) ? a_i : a_q;
  assign d_d = wr ? d_i : d_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      rd_q <= 1'b0;
      wr_q <= 1'b0;
      a_q  <= '0;
      d_q  <= '0;
    end else begin
      rd_q <= rd_d;
      wr_q <= wr_d;
      a_q  <= a_d;
      d_q  <= d_d;
    end
  end

  // --- what the mode word says ----------------------------------------------------------------

  // Strobed input: STB# C4, IBF C5, INTE C4 of port A; STB# C2, IBF C1, INTE C2 of port B.
  // Strobed output: ACK# C6, OBF# C7, INTE C6 of port A; ACK# C2, OBF# C1, INTE C2 of port B.
  // Mode 2 of port A is both.
  logic [6:0] mode_d, mode_q;
  logic a_in, b_in, c_up_in, c_low_in;
  logic a_mode1, a_mode2, a_strobed, a_strobed_in, a_strobed_out;
  logic b_strobed, b_strobed_in, b_strobed_out;
  logic [7:0] inte_bits;  // of port C: set/reset reaches the flag instead of the latch
  logic [7:0] flag_bits;  // IBF, OBF# and INTR: likewise

  assign {a_mode2, a_mode1, a_in, c_up_in, b_strobed, b_in, c_low_in} = mode_q;
  assign a_strobed = a_mode2 || a_mode1;
  assign a_strobed_in = a_mode2 || (a_mode1 && a_in);
  assign a_strobed_out = a_mode2 || (a_mode1 && !a_in);
  assign b_strobed_in = b_strobed && b_in;
  assign b_strobed_out = b_strobed && !b_in;
  assign flag_bits = {a_strobed_out, 1'b0, a_strobed_in, 1'b0, a_strobed, 1'b0, {2{b_strobed}}};
  assign inte_bits = {1'b0, a_strobed_out, 1'b0, a_strobed_in, 1'b0, b_strobed, 2'b00};

  // --- output latches and INTE ----------------------------------------------------------------

  logic [7:0] pa_d, pa_q, pb_d, pb_q, pc_d, pc_q;
  logic [7:0] inte_d, inte_q;  // each flag stands at its bit of port C
  logic [7:0] bit_mask, pc_mask;
  logic [6:0] new_mode;
  logic set_mode, value;

  assign new_mode = d_q[6:0];
  assign value = d_q[0];
  assign set_mode = wr_end && a_q == 2'd3 && d_q[7];
  assign bit_mask = 8'h01 << d_q[3:1];
  // A write to port C reaches the bits of a group in mode 0.
  assign pc_mask = {{5{!a_strobed}}, {3{!b_strobed}}};

  always_comb begin
    mode_d = mode_q;
    pa_d   = pa_q;
    pb_d   = pb_q;
    pc_d   = pc_q;
    inte_d = inte_q;
    if (reset_i || set_mode) begin
      mode_d = reset_i ? AllInputs : new_mode;
      pa_d   = '0;
      pb_d   = '0;
      pc_d   = '0;
      inte_d = '0;
    end else if (wr_end) begin
      case (a_q)
        PortA: pa_d = d_q;
        PortB: pb_d = d_q;
        PortC: pc_d = merge(pc_q, d_q, pc_mask);
        default: begin  // set/reset: INTE, or the latch if no flag drives the line
          if ((inte_bits & bit_mask) != 8'h00) inte_d = merge(inte_q, {8{value}}, bit_mask);
          else pc_d = merge(pc_q, {8{value}}, bit_mask & ~flag_bits);
        end
      endcase
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      mode_q <= AllInputs;
      pa_q   <= '0;
      pb_q   <= '0;
      pc_q   <= '0;
      inte_q <= '0;
    end else begin
      mode_q <= mode_d;
      pa_q   <= pa_d;
      pb_q   <= pb_d;
      pc_q   <= pc_d;
      inte_q <= inte_d;
    end
  end

  // --- handshakes -----------------------------------------------------------------------------

  // Bit set/reset writes all of them, as it does every port C line that is an output.
  // IBF: set by STB# low, reset by the end of a read. Output full (OBF# low): set by the end of a
  // write, reset by ACK# low. The input latch follows the port while STB# is low.
  logic a_ibf_d, a_ibf_q, a_full_d, a_full_q, b_ibf_d, b_ibf_q, b_full_d, b_full_q;
  logic [7:0] pa_in_d, pa_in_q, pb_in_d, pb_in_q;
  logic c7_set, c5_set, c3_set, c1_set, c0_set;   // set/reset of that line, to `value`
  logic [2:0] unused;
  logic a_stb_n, a_ack_n, b_stb_n, b_ack_n;

  assign a_stb_n = pc_i[4];
  assign a_ack_n = pc_i[6];
  assign b_stb_n = pc_i[2];
  assign b_ack_n = pc_i[2];

  assign {c7_set, unused[2], c5_set, unused[1], c3_set, unused[0], c1_set, c0_set} =
         (wr_end && a_q == 2'd3) ? bit_mask : 8'h00;

  always_comb begin
    a_ibf_d  = a_ibf_q;
    a_full_d = a_full_q;
    b_ibf_d  = b_ibf_q;
    b_full_d = b_full_q;
    pa_in_d  = pa_in_q;
    pb_in_d  = pb_in_q;
    if (reset_i || set_mode) begin
      a_ibf_d  = 1'b0;
      a_full_d = 1'b0;
      b_ibf_d  = 1'b0;
      b_full_d = 1'b0;
    end else begin
      if (a_strobed_in && !a_stb_n) a_ibf_d = 1'b1;
      else if (rd_end && a_q == PortA) a_ibf_d = 1'b0;
      else if (c5_set) a_ibf_d = value;
      if (a_strobed_in && !a_stb_n) pa_in_d = pa_i;

      if (a_strobed_out && wr_end && a_q == PortA) a_full_d = 1'b1;
      else if (!a_ack_n) a_full_d = 1'b0;
      else if (c7_set) a_full_d = !value;

      if (b_strobed_in && !b_stb_n) b_ibf_d = 1'b1;
      else if (rd_end && a_q == PortB) b_ibf_d = 1'b0;
      else if (c1_set && b_in) b_ibf_d = value;
      if (b_strobed_in && !b_stb_n) pb_in_d = pb_i;

      if (b_strobed_out && wr_end && a_q == PortB) b_full_d = 1'b1;
      else if (!b_ack_n) b_full_d = 1'b0;
      else if (c1_set && !b_in) b_full_d = !value;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      a_ibf_q  <= 1'b0;
      a_full_q <= 1'b0;
      b_ibf_q  <= 1'b0;
      b_full_q <= 1'b0;
      pa_in_q  <= '0;
      pb_in_q  <= '0;
    end else begin
      a_ibf_q  <= a_ibf_d;
      a_full_q <= a_full_d;
      b_ibf_q  <= b_ibf_d;
      b_full_q <= b_full_d;
      pa_in_q  <= pa_in_d;
      pb_in_q  <= pb_in_d;
    end
  end

  // INTR falls with the strobe that serves it, not with its end. Written by set/reset it stays the
  // other way round until its conditions change or a strobe serves it.
  logic a_reading, a_writing, b_reading, b_writing, a_intr, b_intr;
  logic a_asks, b_asks, a_asks_q, b_asks_q, a_served, b_served;
  logic a_flip_d, a_flip_q, b_flip_d, b_flip_q;

  assign a_reading = (rd && a_i == PortA) || (rd_q && a_q == PortA);
  assign a_writing = (wr && a_i == PortA) || (wr_q && a_q == PortA);
  assign b_reading = (rd && a_i == PortB) || (rd_q && a_q == PortB);
  assign b_writing = (wr && a_i == PortB) || (wr_q && a_q == PortB);
  assign a_asks = (a_strobed_in && inte_q[4] && a_ibf_q && pc_i[4] && !a_reading) ||
                 (a_strobed_out && inte_q[6] && !a_full_q && pc_i[6] && !a_writing);
  assign b_asks = inte_q[2] && pc_i[2] && (b_in ? b_ibf_q && !b_reading : !b_full_q && !b_writing);
  assign a_served = (a_strobed_in && a_reading) || (a_strobed_out && a_writing);
  assign b_served = b_in ? b_reading : b_writing;
  assign a_intr = a_asks ^ (a_flip_q && !a_served);
  assign b_intr = b_asks ^ (b_flip_q && !b_served);

  always_comb begin
    a_flip_d = a_flip_q;
    b_flip_d = b_flip_q;
    if (reset_i || set_mode || a_asks != a_asks_q || a_served) a_flip_d = 1'b0;
    else if (c3_set) a_flip_d = value != a_asks;
    if (reset_i || set_mode || b_asks != b_asks_q || b_served) b_flip_d = 1'b0;
    else if (c0_set) b_flip_d = value != b_asks;
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      {a_asks_q, a_flip_q} <= '0;
      {b_asks_q, b_flip_q} <= '0;
    end else begin
      {a_asks_q, a_flip_q} <= {a_asks, a_flip_d};
      {b_asks_q, b_flip_q} <= {b_asks, b_flip_d};
    end
  end

  // --- pins -----------------------------------------------------------------------------------

  assign pa_o = pa_q;
  assign pa_oe_o = {8{a_mode2 ? !pc_i[6] : !a_in}};  // mode 2: only while ACK# is low
  assign pb_o = pb_q;
  assign pb_oe_o = {8{!b_in}};
  assign pc_o = {
    a_strobed_out ? !a_full_q : pc_q[7],
    pc_q[6],
    a_strobed_in ? a_ibf_q : pc_q[5],
    pc_q[4],
    a_strobed ? a_intr : pc_q[3],
    pc_q[2],
    b_strobed_in ? b_ibf_q : b_strobed_out ? !b_full_q : pc_q[1],
    b_strobed ? b_intr : pc_q[0]
  };
  assign pc_oe_o = {
    a_strobed_out || !c_up_in,
    !a_strobed_out && !c_up_in,
    a_strobed_in || !c_up_in,
    !a_strobed_in && !c_up_in,
    a_strobed || !c_low_in,
    !b_strobed && !c_low_in,
    {2{b_strobed || !c_low_in}}
  };

  // --- reads ----------------------------------------------------------------------------------

  // Port C shows flags, INTE where STB# or ACK# comes in, latches on outputs and pins on inputs.
  logic [7:0] pc_seen;

  assign pc_seen = merge((pc_o & pc_oe_o) | (pc_i & ~pc_oe_o), inte_q, inte_bits);
  assign d_oe_o = rd;

  always_comb begin
    d_o = 8'hFF;
    if (rd) begin
      case (a_i)
        PortA: d_o = a_strobed_in ? pa_in_q : a_in ? pa_i : pa_q;
        PortB: d_o = b_strobed_in ? pb_in_q : b_in ? pb_i : pb_q;
        PortC: d_o = pc_seen;
        default: if (ControlReadable) d_o = {1'b1, mode_q};
      endcase
    end
  end

endmodule

`default_nettype wire
