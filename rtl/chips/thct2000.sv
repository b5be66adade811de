// SPDX-License-Identifier: Apache-2.0
// THCT2000: 16-bit encoder counter with direction discriminator, latch and 8-bit bus.
// §5.3.2

`include "mmcs_assert.svh"
`default_nettype none

module thct2000 #(
  parameter int Filter = 0      // further equal samples an input must show, 0 to 3
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  // pins
  input  wire logic        reset_i,    // RESET DRV
  input  wire logic        clk_en_i,   // a tick of the chip's CLK
  input  wire logic [ 2:0] m_i,        // mode
  input  wire logic        a_i,        // encoder, asynchronous
  input  wire logic        b_i,
  input  wire logic        latch_i,    // a rising edge latches the count on the same clock
  // bus
  input  wire logic        cs_ni,
  input  wire logic        rd_ni,
  input  wire logic        wr_ni,
  input  wire logic        rs_i,       // 0 = high byte, 1 = low byte
  input  wire logic [ 7:0] d_i,
  output      logic [ 7:0] d_o,
  output      logic        d_oe_o,
  // debug
  output      logic [15:0] count_o,
  output      logic        illegal_o   // sticky until reset: both inputs changed at once
);
  localparam logic [2:0] ModeHold      = 3'd0;  // counting off
  localparam logic [2:0] ModeX1Low     = 3'd1;  // edges of A while B is 0
  localparam logic [2:0] ModeX1High    = 3'd2;  // edges of A while B is 1
  localparam logic [2:0] ModeX2A       = 3'd3;  // both edges of A
  localparam logic [2:0] ModeX2B       = 3'd4;  // both edges of B
  localparam logic [2:0] ModeX4        = 3'd5;  // all edges
  localparam logic [2:0] ModeInterval  = 3'd6;  // CLK ticks while A is 1
  localparam logic [2:0] ModeFrequency = 3'd7;  // rises of A while B is 1

  // ---- inputs: two flip-flops, the filter, and the previous state --------------------------------
  logic [1:0] in, s1_q, s2_q, now, prev_q;  // {A, B}

  assign in = {a_i, b_i};

  generate
    if (Filter == 0) begin : g_direct
      assign now = s2_q;
    end else begin : g_filter
      // `now` takes over an input that differed for Filter + 1 ticks running, each on its own.
      logic [1:0] kept_q;
      logic [1:0] run_a_q, run_b_q;
      assign now[1] = (s2_q[1] != kept_q[1] && run_a_q == Filter[1:0]) ? s2_q[1] : kept_q[1];
      assign now[0] = (s2_q[0] != kept_q[0] && run_b_q == Filter[1:0]) ? s2_q[0] : kept_q[0];
      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) begin
          kept_q  <= '0;
          run_a_q <= '0;
          run_b_q <= '0;
        end else if (clk_en_i) begin
          kept_q  <= now;
          run_a_q <= s2_q[1] == now[1] ? 2'd0 : run_a_q + 2'd1;
          run_b_q <= s2_q[0] == now[0] ? 2'd0 : run_b_q + 2'd1;
        end
      end
    end
    if (Filter < 0 || Filter > 3) begin : g_bad
      initial $fatal(1, "thct2000: Filter must be 0 to 3");
    end
  endgenerate

  // ---- decode: what a tick does to the count ------------------------------------------------------
  // Functions, so that nothing is decoded while the inputs are still.
  function automatic logic is_step(input logic [2:0] m);  // the modes that count steps of A and B
    is_step = m != ModeHold && m != ModeInterval && m != ModeFrequency;
  endfunction

  function automatic logic is_illegal(input logic [2:0] m, input logic [1:0] to,
                                      input logic [1:0] from);
    is_illegal = is_step(m) && to[1] != from[1] && to[0] != from[0];
  endfunction

  // A leads B counts up.
  function automatic logic [15:0] change(input logic [2:0] m, input logic [1:0] to,
                                         input logic [1:0] from);
    logic edge_a, edge_b, up;  // up is meant for exactly one edge
    begin
      edge_a = to[1] != from[1];
      edge_b = to[0] != from[0];
      up     = edge_a == (to[1] != to[0]);
      change = 16'd0;
      case (m)
        ModeInterval:  change[0] = to[1];
        ModeFrequency: change[0] = edge_a && to == 2'b11;
        ModeX1Low, ModeX1High, ModeX2A, ModeX2B, ModeX4: begin
          if (edge_a != edge_b && (m == ModeX4 || (m == ModeX2B ? edge_b : edge_a)) &&
              !(m == ModeX1Low && to[0]) && !(m == ModeX1High && !to[0])) begin
            change = up ? 16'd1 : 16'hFFFF;
          end
        end
        default: ;  // ModeHold
      endcase
    end
  endfunction

  // The gate of modes 6 and 7 closes: the count goes to the latch.
  function automatic logic gate_closes(input logic [2:0] m, input logic [1:0] to,
                                       input logic [1:0] from);
    gate_closes = (m == ModeInterval && from[1] && !to[1]) ||
                  (m == ModeFrequency && from[0] && !to[0]);
  endfunction

  // ---- bus ----------------------------------------------------------------------------------------
  // A 16-bit value crosses the 8-bit bus as one sample. The byte address read first after a reset
  // becomes the snapshot address: a read of it samples the value, the other byte comes from there.
  // Likewise the byte written first after a reset waits for the other, which stores both.
  logic        rd, wr, rd_q, wr_q;
  logic        rd_seen_q, rd_snap_q, wr_seen_q, wr_first_q;
  logic        rs_q;
  logic [ 7:0] d_q, held_q;
  logic        take;        // this clock begins a read at the snapshot address
  logic [15:0] shown;       // to a read: a fresh sample or what is left of the last
  logic [15:0] snap_q;
  logic [15:0] count_q, latch_q;
  logic        latched_q, latch_in_q, illegal_q;

  assign rd     = !cs_ni && !rd_ni;
  assign wr     = !cs_ni && !wr_ni;
  assign d_oe_o = rd;

  always_comb begin
    take  = 1'b0;
    shown = snap_q;
    if (rd) begin
      take = !rd_q && (!rd_seen_q || rs_i == rd_snap_q);
      if (take) shown = latched_q ? latch_q : count_q;
    end
  end
  assign d_o = !rd ? 8'hFF : rs_i ? shown[7:0] : shown[15:8];

  // ---- registers ----------------------------------------------------------------------------------
  // The latch takes the count as it stood before this clock. A write wins over a count. A latch on
  // the clock of a snapshot belongs to the next one.
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      s1_q       <= '0;
      s2_q       <= '0;
      prev_q     <= '0;
      rd_q       <= 1'b0;
      wr_q       <= 1'b0;
      rs_q       <= 1'b0;
      d_q        <= '0;
      held_q     <= '0;
      snap_q     <= '0;
      rd_seen_q  <= 1'b0;
      rd_snap_q  <= 1'b0;
      wr_seen_q  <= 1'b0;
      wr_first_q <= 1'b0;
      latch_q    <= '0;
      latched_q  <= 1'b0;
      latch_in_q <= 1'b0;
      illegal_q  <= 1'b0;
      count_q    <= '0;
    end else begin
      if (clk_en_i) begin
        s1_q   <= in;
        s2_q   <= s1_q;
        prev_q <= now;
      end
      rd_q       <= rd;
      wr_q       <= wr;
      latch_in_q <= latch_i;
      if (wr) begin
        rs_q <= rs_i;
        d_q  <= d_i;
      end
      if (reset_i) begin
        rd_seen_q <= 1'b0;
        wr_seen_q <= 1'b0;
        held_q    <= '0;
        snap_q    <= '0;
        latch_q   <= '0;
        latched_q <= 1'b0;
        illegal_q <= 1'b0;
        count_q   <= '0;
      end else begin
        if (take) begin
          snap_q    <= shown;
          rd_seen_q <= 1'b1;
          rd_snap_q <= rs_i;
          latched_q <= 1'b0;
        end
        if ((latch_i && !latch_in_q) || (clk_en_i && gate_closes(m_i, now, prev_q))) begin
          latch_q   <= count_q;
          latched_q <= 1'b1;
        end
        if (clk_en_i) begin
          if (is_illegal(m_i, now, prev_q)) illegal_q <= 1'b1;
          count_q <= gate_closes(m_i, now, prev_q) ? 16'd0 : count_q + change(m_i, now, prev_q);
        end
        if (wr_q && !wr) begin
          if (!wr_seen_q || rs_q == wr_first_q) begin
            held_q     <= d_q;
            wr_seen_q  <= 1'b1;
            wr_first_q <= rs_q;
          end else begin
            count_q <= wr_first_q ? {d_q, held_q} : {held_q, d_q};
          end
        end
      end
    end
  end

  assign count_o   = count_q;
  assign illegal_o = illegal_q;
endmodule

`default_nettype wire
