// SPDX-License-Identifier: Apache-2.0
// THCT2000: 16-bit encoder counter with direction discriminator, latch and 8-bit bus. §5.3.2
//
// A 16-bit value crosses the 8-bit bus as one sample. A read samples all of it; the other byte, if
// it is read next, comes from that sample. A byte written is stored at once; the other byte, if it
// is written next, stores both again, so that no count in between tears them. Every other access,
// a mode set and RESET end such a pair; a latch does not.
`default_nettype none
`include "mmcs_require.svh"

module thct2000 #(
  parameter int Filter = 0,                 // further equal samples an input must show, 0 to 3
  parameter logic [15:0] PowerUp = 16'h0000  // the count before the first RESET
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  // Pins
  input  wire logic        reset_i,    // RESET DRV
  input  wire logic        clk_en_i,   // a tick of the chip's CLK
  input  wire logic [ 2:0] m_i,        // mode
  input  wire logic        a_i,        // encoder, asynchronous
  input  wire logic        b_i,
  input  wire logic        latch_i,    // one clock for each event: latches the count
  input  wire logic        other_i,    // the board is accessed, but not this chip
  // Bus
  input  wire logic        cs_ni,
  input  wire logic        rd_ni,
  input  wire logic        wr_ni,
  input  wire logic        rs_i,       // 0 = high byte, 1 = low byte
  input  wire logic [ 7:0] d_i,
  output logic      [ 7:0] d_o,
  output logic             d_oe_o,
  // Debugging
  output logic      [15:0] count_o,
  output logic             illegal_o   // both inputs changed at once since the last reset
);

  `MMCS_REQUIRE(ReqFilter, Filter >= 0 && Filter <= 3, "thct2000: Filter must be 0 to 3")

  localparam logic [2:0] ModeHold = 3'd0;       // counting off
  localparam logic [2:0] ModeX1Low = 3'd1;      // edges of A while B is 0
  localparam logic [2:0] ModeX1High = 3'd2;     // edges of A while B is 1
  localparam logic [2:0] ModeX2A = 3'd3;        // both edges of A
  localparam logic [2:0] ModeX2B = 3'd4;        // both edges of B
  localparam logic [2:0] ModeX4 = 3'd5;         // all edges
  localparam logic [2:0] ModeInterval = 3'd6;   // CLK ticks while A is 1
  localparam logic [2:0] ModeFrequency = 3'd7;  // rises of A while B is 1

  // --- inputs: two flip-flops, the filter, and the tick before --------------------------------

  logic [1:0] in, now, prev_d, prev_q;  // {A, B}
  logic a, b, a_prev, b_prev;

  mmcs_sync_en #(.Width(2)) u_pins (.clk_i, .rst_ni, .en_i(clk_en_i), .d_i({a_i, b_i}), .q_o(in));

  assign prev_d = clk_en_i ? now : prev_q;
  assign {a, b} = now;
  assign {a_prev, b_prev} = prev_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) prev_q <= '0;
    else prev_q <= prev_d;
  end

  if (Filter == 0) begin : g_direct
    assign now = in;
  end else begin : g_filter
    // `now` takes over an input that differed for Filter + 1 ticks running, each on its own.
    logic [1:0] kept_d, kept_q;
    logic [3:0] run_d, run_q;   // ticks that each has differed

    always_comb begin
      kept_d = kept_q;
      run_d  = run_q;
      for (int n = 0; n < 2; n++) begin
        now[n] = (in[n] != kept_q[n] && run_q[2*n+:2] == 2'(Filter)) ? in[n] : kept_q[n];
        if (clk_en_i) begin
          kept_d[n]     = now[n];
          run_d[2*n+:2] = in[n] == now[n] ? 2'd0 : run_q[2*n+:2] + 2'd1;
        end
      end
    end

    always_ff @(posedge clk_i or negedge rst_ni) begin
      if (!rst_ni) begin
        kept_q <= '0;
        run_q  <= '0;
      end else begin
        kept_q <= kept_d;
        run_q  <= run_d;
      end
    end
  end

  // --- what a tick does to the count ----------------------------------------------------------

  logic a_edge, b_edge, up;     // up is meant for exactly one edge: A leads B
  logic by_steps, counted;      // the mode counts steps of A and B; this one
  logic illegal, gate_closes;   // both at once; the gate of modes 6 and 7
  logic [15:0] change;

  assign a_edge = a != a_prev;
  assign b_edge = b != b_prev;
  assign up = a_edge == (a != b);
  assign by_steps = m_i != ModeHold && m_i != ModeInterval && m_i != ModeFrequency;
  assign illegal = by_steps && a_edge && b_edge;

  always_comb begin
    case (m_i)
      ModeX1Low: counted = a_edge && !b_edge && !b;
      ModeX1High: counted = a_edge && !b_edge && b;
      ModeX2A: counted = a_edge && !b_edge;
      ModeX2B: counted = b_edge && !a_edge;
      ModeX4: counted = a_edge != b_edge;
      ModeInterval: counted = a;
      ModeFrequency: counted = a_edge && a && b;
      default: counted = 1'b0;  // ModeHold
    endcase
  end

  assign change = !counted ? 16'd0 : (by_steps && !up) ? 16'hFFFF : 16'd1;
  assign gate_closes = (m_i == ModeInterval && a_prev && !a) ||
                       (m_i == ModeFrequency && b_prev && !b);

  // --- bus ------------------------------------------------------------------------------------

  logic rd, wr, rd_q, wr_q;
  logic pair_d, pair_q;             // the last access was the first byte of a pair
  logic pair_wr_d, pair_wr_q;       // a write
  logic pair_rs_d, pair_rs_q;       // its address
  logic rs_d, rs_q;                 // the write under way
  logic [2:0] m_q;
  logic [7:0] d_d, d_q, held_d, held_q;
  logic wr_end;                     // a write ends
  logic sample;                     // this clock begins a read that is no second byte
  logic wr_second;                  // it is the second byte of a pair
  logic [15:0] shown, snap_d, snap_q;
  logic [15:0] count_d, count_q, latch_d, latch_q;
  logic latched_d, latched_q, illegal_d, illegal_q;

  assign rd = !cs_ni && !rd_ni;
  assign wr = !cs_ni && !wr_ni;
  assign sample = rd && !rd_q && !(pair_q && !pair_wr_q && rs_i != pair_rs_q);
  assign shown = !sample ? snap_q : latched_q ? latch_q : count_q;
  assign wr_end = wr_q && !wr;
  assign wr_second = pair_q && pair_wr_q && rs_q != pair_rs_q;

  assign d_oe_o = rd;
  assign d_o = !rd ? 8'hFF : rs_i ? shown[7:0] : shown[15:8];

  assign rs_d = wr ? rs_i : rs_q;
  assign d_d = wr ? d_i : d_q;

  // --- count, latch and snapshot --------------------------------------------------------------

  // A write wins over a count, in the bytes that it stores.
  logic [15:0] ticked, written;
  logic [7:0] high, low;   // the byte that is not written now

  assign ticked = !clk_en_i ? count_q : gate_closes ? 16'd0 : count_q + change;
  assign high = wr_second ? held_q : ticked[15:8];
  assign low = wr_second ? held_q : ticked[7:0];
  assign written = rs_q ? {high, d_q} : {d_q, low};

  // The latch takes the count as it stood before this clock. One on the clock of a sample belongs to
  // the next sample.
  always_comb begin
    count_d   = wr_end ? written : ticked;
    illegal_d = illegal_q || (clk_en_i && illegal);
    held_d    = wr_end ? d_q : held_q;
    snap_d    = snap_q;
    latch_d   = latch_q;
    latched_d = latched_q;
    pair_d    = pair_q;
    pair_wr_d = pair_wr_q;
    pair_rs_d = pair_rs_q;
    if (rd && !rd_q) begin
      pair_d    = sample;
      pair_wr_d = 1'b0;
      pair_rs_d = rs_i;
    end
    if (sample) begin
      snap_d    = shown;
      latched_d = 1'b0;
    end
    if (latch_i || (clk_en_i && gate_closes)) begin
      latch_d   = count_q;
      latched_d = 1'b1;
    end
    if (wr_end) begin
      pair_d    = !wr_second;
      pair_wr_d = 1'b1;
      pair_rs_d = rs_q;
    end
    if (other_i || m_i != m_q) pair_d = 1'b0;
    if (reset_i) begin
      count_d   = '0;
      illegal_d = 1'b0;
      held_d    = '0;
      snap_d    = '0;
      latch_d   = '0;
      latched_d = 1'b0;
      pair_d    = 1'b0;
      pair_wr_d = pair_wr_q;
      pair_rs_d = pair_rs_q;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      rd_q      <= 1'b0;
      wr_q      <= 1'b0;
      m_q       <= '0;
      rs_q      <= 1'b0;
      d_q       <= '0;
      count_q   <= PowerUp;
      illegal_q <= 1'b0;
      held_q    <= '0;
      snap_q    <= '0;
      latch_q   <= '0;
      latched_q <= 1'b0;
      pair_q    <= 1'b0;
      pair_wr_q <= 1'b0;
      pair_rs_q <= 1'b0;
    end else begin
      rd_q      <= rd;
      wr_q      <= wr;
      m_q       <= m_i;
      rs_q      <= rs_d;
      d_q       <= d_d;
      count_q   <= count_d;
      illegal_q <= illegal_d;
      held_q    <= held_d;
      snap_q    <= snap_d;
      latch_q   <= latch_d;
      latched_q <= latched_d;
      pair_q    <= pair_d;
      pair_wr_q <= pair_wr_d;
      pair_rs_q <= pair_rs_d;
    end
  end

  assign count_o = count_q;
  assign illegal_o = illegal_q;

endmodule

`default_nettype wire
