// SPDX-License-Identifier: Apache-2.0
// 8255A programmable peripheral interface: modes 0, 1 and 2, bit set/reset.
// §5.3.1

`default_nettype none

// Group A is port A with C7..C4 (and C3 in modes 1 and 2), group B is port B with C2..C0.
// STB# and ACK# are sampled by clk_i without synchroniser; put one outside if they need it.
module i8255 #(
  parameter bit ControlReadable = 1'b0  // 1: an 82C55A, which returns its mode word
) (
  input  wire logic       clk_i,
  input  wire logic       rst_ni,
  // bus
  input  wire logic       reset_i,
  input  wire logic       cs_ni,
  input  wire logic       rd_ni,
  input  wire logic       wr_ni,
  input  wire logic [1:0] a_i,
  input  wire logic [7:0] d_i,
  output      logic [7:0] d_o,
  output      logic       d_oe_o,
  // ports
  input  wire logic [7:0] pa_i,
  output      logic [7:0] pa_o,
  output      logic [7:0] pa_oe_o,
  input  wire logic [7:0] pb_i,
  output      logic [7:0] pb_o,
  output      logic [7:0] pb_oe_o,
  input  wire logic [7:0] pc_i,
  output      logic [7:0] pc_o,
  output      logic [7:0] pc_oe_o
);
  localparam logic [6:0] AllInputs = 7'h1B;  // mode word 0x9B, what RESET leaves

  // ---- bus: a write acts when its strobe ends -----------------------------------------------------
  logic       rd, wr, rd_q, wr_q;
  logic [1:0] a_q;
  logic [7:0] d_q;
  assign rd = !cs_ni && !rd_ni;
  assign wr = !cs_ni && !wr_ni && rd_ni;

  // ---- what the mode word says --------------------------------------------------------------------
  // Strobed input: STB# C4, IBF C5, INTE C4 of port A; STB# C2, IBF C1, INTE C2 of port B.
  // Strobed output: ACK# C6, OBF# C7, INTE C6 of port A; ACK# C2, OBF# C1, INTE C2 of port B.
  // Handshakes are rare: functions and guards keep them off the path of a chip in mode 0.
  logic [6:0] mode_q;
  logic       a_shakes, b_shakes, shakes;
  logic       a_in, b_in, c_up_in, c_low_in;
  logic [6:4] a_mode;
  assign a_mode   = mode_q[6:4];
  assign a_in     = mode_q[4];
  assign b_in     = mode_q[1];
  assign a_shakes = mode_q[6] || mode_q[5];
  assign b_shakes = mode_q[2];
  assign shakes   = a_shakes || b_shakes;

  function automatic logic a_takes(input logic [6:4] group);
    a_takes = group[6] || (group[5] && group[4]);
  endfunction

  function automatic logic a_gives(input logic [6:4] group);
    a_gives = group[6] || (group[5] && !group[4]);
  endfunction

  // Bits of port C that are INTE flags: set/reset reaches the flag instead of the latch.
  function automatic logic [7:0] c_inte(input logic [6:4] group, input logic b);
    c_inte = {1'b0, a_gives(group), 1'b0, a_takes(group), 1'b0, b, 2'b00};
  endfunction

  // The bits of `mask` from d, the others as they were.
  function automatic logic [7:0] merge(input logic [7:0] old, input logic [7:0] d,
                                       input logic [7:0] mask);
    merge = (old & ~mask) | (d & mask);
  endfunction

  // ---- registers ----------------------------------------------------------------------------------
  // IBF: set by STB# low, reset by the end of a read. Output full (OBF# low): set by the end of a
  // write, reset by ACK# low. The input latch follows the port while STB# is low.
  logic [7:0] pa_q, pb_q, pc_q, inte_q;  // inte_q: each flag stands at its bit of port C
  logic       a_ibf_q, a_full_q, b_ibf_q, b_full_q;
  logic [7:0] pa_in_q, pb_in_q;
  logic       wr_end, rd_end, set_mode;
  logic [7:0] bit_mask;
  assign wr_end   = wr_q && !wr;
  assign rd_end   = rd_q && !rd;
  assign set_mode = wr_end && a_q == 2'd3 && d_q[7];
  assign bit_mask = 8'h01 << d_q[3:1];

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      rd_q     <= 1'b0;
      wr_q     <= 1'b0;
      a_q      <= '0;
      d_q      <= '0;
      mode_q   <= AllInputs;
      pa_q     <= '0;
      pb_q     <= '0;
      pc_q     <= '0;
      inte_q   <= '0;
      a_ibf_q  <= 1'b0;
      a_full_q <= 1'b0;
      b_ibf_q  <= 1'b0;
      b_full_q <= 1'b0;
      pa_in_q  <= '0;
      pb_in_q  <= '0;
    end else begin
      rd_q <= rd && !reset_i;
      wr_q <= wr && !reset_i;
      if (rd || wr) a_q <= a_i;
      if (wr) d_q <= d_i;
      if (reset_i || set_mode) begin
        // Mode setting clears every output latch and every handshake flag.
        mode_q   <= reset_i ? AllInputs : d_q[6:0];
        pa_q     <= '0;
        pb_q     <= '0;
        pc_q     <= '0;
        inte_q   <= '0;
        a_ibf_q  <= 1'b0;
        a_full_q <= 1'b0;
        b_ibf_q  <= 1'b0;
        b_full_q <= 1'b0;
      end else begin
        if (wr_end) begin
          case (a_q)
            2'd0: pa_q <= d_q;
            2'd1: pb_q <= d_q;
            // A write to port C reaches the bits of a group in mode 0.
            2'd2: pc_q <= merge(pc_q, d_q, {{5{!a_shakes}}, {3{!b_shakes}}});
            default: begin
              if ((c_inte(a_mode, b_shakes) & bit_mask) != 8'h00) begin
                inte_q <= merge(inte_q, {8{d_q[0]}}, bit_mask);
              end else begin
                pc_q <= merge(pc_q, {8{d_q[0]}}, bit_mask);
              end
            end
          endcase
        end
        if (shakes) begin
          if (a_takes(a_mode) && !pc_i[4]) begin
            a_ibf_q <= 1'b1;
            pa_in_q <= pa_i;
          end else if (rd_end && a_q == 2'd0) begin
            a_ibf_q <= 1'b0;
          end
          if (a_gives(a_mode) && wr_end && a_q == 2'd0) a_full_q <= 1'b1;
          else if (!pc_i[6]) a_full_q <= 1'b0;
          if (b_shakes && b_in && !pc_i[2]) begin
            b_ibf_q <= 1'b1;
            pb_in_q <= pb_i;
          end else if (rd_end && a_q == 2'd1) begin
            b_ibf_q <= 1'b0;
          end
          if (b_shakes && !b_in && wr_end && a_q == 2'd1) b_full_q <= 1'b1;
          else if (!pc_i[2]) b_full_q <= 1'b0;
        end
      end
    end
  end

  // ---- pins ---------------------------------------------------------------------------------------
  assign pa_o    = pa_q;
  assign pb_o    = pb_q;
  assign pa_oe_o = {8{mode_q[6] ? !pc_i[6] : !a_in}};  // mode 2: only while ACK# is low
  assign pb_oe_o = {8{!b_in}};

  // INTR falls with the strobe that serves it, not with its end.
  logic a_reading, a_writing, b_reading, b_writing, a_intr, b_intr;
  always_comb begin
    a_reading = 1'b0;
    a_writing = 1'b0;
    b_reading = 1'b0;
    b_writing = 1'b0;
    if (shakes) begin
      a_reading = (rd && a_i == 2'd0) || (rd_q && a_q == 2'd0);
      a_writing = (wr && a_i == 2'd0) || (wr_q && a_q == 2'd0);
      b_reading = (rd && a_i == 2'd1) || (rd_q && a_q == 2'd1);
      b_writing = (wr && a_i == 2'd1) || (wr_q && a_q == 2'd1);
    end
  end
  assign a_intr = (a_takes(a_mode) && inte_q[4] && a_ibf_q && pc_i[4] && !a_reading) ||
                  (a_gives(a_mode) && inte_q[6] && !a_full_q && pc_i[6] && !a_writing);
  assign b_intr = inte_q[2] && pc_i[2] && (b_in ? b_ibf_q && !b_reading : !b_full_q && !b_writing);

  assign c_up_in  = mode_q[3];
  assign c_low_in = mode_q[0];
  assign pc_o = !shakes ? pc_q
              : {a_gives(a_mode) ? !a_full_q : pc_q[7], pc_q[6],
                 a_takes(a_mode) ? a_ibf_q : pc_q[5], pc_q[4],
                 a_shakes ? a_intr : pc_q[3], pc_q[2],
                 !b_shakes ? pc_q[1:0] : {b_in ? b_ibf_q : !b_full_q, b_intr}};
  assign pc_oe_o = !shakes ? {{4{!c_up_in}}, {4{!c_low_in}}}
                 : {a_gives(a_mode) || !c_up_in, !a_gives(a_mode) && !c_up_in,
                    a_takes(a_mode) || !c_up_in, !a_takes(a_mode) && !c_up_in,
                    a_shakes || !c_low_in, !b_shakes && !c_low_in,
                    {2{b_shakes || !c_low_in}}};

  // ---- reads --------------------------------------------------------------------------------------
  // Port C shows flags, INTE where STB# or ACK# comes in, latches on outputs and pins on inputs.
  logic [7:0] inte_bits;
  logic       a_strobed;
  assign inte_bits = c_inte(a_mode, b_shakes);
  assign a_strobed = a_takes(a_mode);
  assign d_oe_o    = rd;
  always_comb begin
    d_o = 8'hFF;
    if (rd) begin
      case (a_i)
        2'd0:    d_o = a_strobed ? pa_in_q : a_in ? pa_i : pa_q;
        2'd1:    d_o = (b_shakes && b_in) ? pb_in_q : b_in ? pb_i : pb_q;
        2'd2:    d_o = merge((pc_o & pc_oe_o) | (pc_i & ~pc_oe_o), inte_q, inte_bits);
        default: d_o = ControlReadable ? {1'b1, mode_q} : 8'hFF;
      endcase
    end
  end
endmodule

`default_nettype wire
