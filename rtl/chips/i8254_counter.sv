// SPDX-License-Identifier: Apache-2.0
// One counter of the 8254: six modes, binary and BCD, latches, status, null count.
// §4.3.4

`include "mmcs_assert.svh"
`default_nettype none

// Order within one clk_i: first the rise of CLK, then its fall, then the bus. So a CLK that comes
// with the end of a write does not see what was written, and a latch command takes the count and
// the status as that CLK leaves them.
module i8254_counter #(
  parameter bit          NmosRewrite = 1'b1,
  parameter logic [31:0] PowerUpSeed = 32'd0   // 0: all zero; else any state, counting or not
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  // pins
  input  wire logic        clk_rise_i,
  input  wire logic        clk_fall_i,
  input  wire logic        gate_i,
  output      logic        out_o,
  output      logic        out_rise_o,      // OUT will rise on this clock
  output      logic        out_fall_o,
  // bus: each for one clock
  input  wire logic        control_i,       // control word in d_i, RW not 00
  input  wire logic        latch_count_i,
  input  wire logic        latch_status_i,
  input  wire logic        write_i,         // a byte of the count in d_i
  input  wire logic        read_i,          // d_o is looked at; it is 0xFF otherwise
  input  wire logic        read_end_i,      // a read of d_o has ended
  input  wire logic [ 7:0] d_i,
  output      logic [ 7:0] d_o
);
  localparam logic [5:0] SeedCw = PowerUpSeed == 32'd0 ? 6'd0 : {1'b1, PowerUpSeed[4:0]};

  // ---- state --------------------------------------------------------------------------------------
  logic [ 1:0] rw_q;         // 01 low byte, 10 high byte, 11 low then high
  logic [ 2:0] m_q;          // mode as written
  logic        bcd_q;
  logic [15:0] written_q;    // count as written; takes part from the next CLK rise on
  logic [15:0] cr_q;         // count register
  logic [15:0] ce_q;         // counting element
  logic [15:0] ol_q;         // output latch
  logic [ 7:0] low_q;        // first byte of a two-byte write
  logic [ 7:0] status_q;     // status latch
  logic        half_write_q, half_read_q;
  logic        count_latched_q, status_latched_q;
  logic        armed_q;      // a whole count was written since the control word
  logic        fresh_q;      // a count waits for a CLK rise
  logic        ready_q;      // a count waits to be loaded
  logic        loaded_q;     // CE was loaded since the control word
  logic        stop_q;       // mode 0: first byte of a rewrite seen
  logic        odd_q;        // mode 3: parity of N as loaded
  logic        strobe_q;     // modes 4, 5: the one strobe of this load is still to come
  logic        gate_q, level_q;        // GATE a clock ago; GATE at the last CLK rise
  logic        edge_q, trigger_q;      // GATE rose; GATE rise seen by the last CLK rise
  logic        out_q;

  // ---- mode ---------------------------------------------------------------------------------------
  logic m0, m1, m2, m3, m4, m5, periodic;
  assign m0       = m_q == 3'd0;
  assign m1       = m_q == 3'd1;
  assign m2       = m_q[1:0] == 2'd2;
  assign m3       = m_q[1:0] == 2'd3;
  assign m4       = m_q == 3'd4;
  assign m5       = m_q == 3'd5;
  assign periodic = m_q[1];

  // ---- what this clock does -----------------------------------------------------------------------
  // A digit above 9, which the data sheet leaves open, counts down like any other.
  function automatic logic [15:0] bcd_minus_1(input logic [15:0] v);
    begin
      if ((v & 16'h000F) != 16'd0) bcd_minus_1 = v - 16'h0001;
      else if ((v & 16'h00F0) != 16'd0) bcd_minus_1 = (v - 16'h0010) | 16'h0009;
      else if ((v & 16'h0F00) != 16'd0) bcd_minus_1 = (v - 16'h0100) | 16'h0099;
      else if ((v & 16'hF000) != 16'd0) bcd_minus_1 = (v - 16'h1000) | 16'h0999;
      else bcd_minus_1 = 16'h9999;
    end
  endfunction

  // N = 1 is illegal in modes 2 and 3: taken as 2 and as 0.
  function automatic logic [15:0] first(input logic two, input logic three,
                                        input logic [15:0] v);
    begin
      first = v;
      if (two && v == 16'd1) first = 16'd2;
      if (three) first = v == 16'd1 ? 16'd0 : v & 16'hFFFE;
    end
  endfunction

  logic        gate_edge;                  // GATE rises
  logic        trigger, ready;             // what the fall will act on
  logic [15:0] cr, ce;
  logic        begin_load, load, count;    // the fall: begins a count, loads CE, counts
  logic        zero;                       // it counted to 0
  logic        out;
  logic        to_m0;
  assign to_m0     = d_i[3:1] == 3'd0;
  assign gate_edge = gate_i && !gate_q && armed_q;

  always_comb begin
    trigger    = trigger_q;
    ready      = ready_q;
    cr         = cr_q;
    begin_load = 1'b0;
    load       = 1'b0;
    count      = 1'b0;
    zero       = 1'b0;
    ce         = ce_q;
    out        = out_q;
    if (clk_rise_i) begin
      trigger = edge_q || gate_edge;
      if (fresh_q) begin
        ready = 1'b1;
        cr    = written_q;
      end
    end
    if (clk_fall_i) begin
      begin_load = periodic ? trigger || (ready && !loaded_q)
                 : (m0 || m4) ? ready : trigger;
      // Mode 3 holds one more CLK at zero in the high half of an odd N.
      load  = begin_load ||
              (periodic && loaded_q && (clk_rise_i ? gate_i : level_q) &&
               ce_q == (m2 ? 16'd1 : (odd_q && out_q) ? 16'd0 : 16'd2));
      count = loaded_q && !load && (m1 || m5 || (clk_rise_i ? gate_i : level_q)) && !stop_q;
      if (load) begin
        ce = first(m2, m3, cr);
      end else if (count) begin
        if (bcd_q) ce = m3 ? bcd_minus_1(bcd_minus_1(ce_q)) : bcd_minus_1(ce_q);
        else ce = ce_q - (m3 ? 16'd2 : 16'd1);
        zero = ce == 16'd0;
      end
      case (m_q)
        3'd0:       if (zero && !fresh_q && !half_write_q) out = 1'b1;
        3'd1:       if (load) out = 1'b0;
                    else if (zero) out = 1'b1;
        3'd2, 3'd6: if (load) out = 1'b1;
                    else if (count && ce == 16'd1) out = 1'b0;
        3'd3, 3'd7: if (load) out = begin_load || !out_q;
        default:    out = !(strobe_q && zero);
      endcase
    end
    if (!gate_i && periodic) out = 1'b1;
    if (control_i) out = !to_m0;
    else if (write_i && m0) out = 1'b0;
  end
  assign out_o      = out_q;
  assign out_rise_o = out && !out_q;
  assign out_fall_o = !out && out_q;

  // ---- registers: CLK and GATE --------------------------------------------------------------------
  logic full_write;  // the byte completes a count
  assign full_write = write_i && (rw_q != 2'b11 || half_write_q);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      gate_q    <= 1'b1;
      level_q   <= 1'b0;
      edge_q    <= 1'b0;
      trigger_q <= 1'b0;
      cr_q      <= '0;
      out_q     <= PowerUpSeed[5];
      odd_q     <= 1'b0;
      strobe_q  <= 1'b0;
      armed_q   <= 1'b0;
      fresh_q   <= 1'b0;
      ready_q   <= 1'b0;
      loaded_q  <= PowerUpSeed[6];
      stop_q    <= 1'b0;
    end else begin
      out_q  <= out;
      gate_q <= gate_i;
      if (gate_edge) edge_q <= 1'b1;
      if (clk_rise_i) begin
        level_q   <= gate_i;
        trigger_q <= trigger;
        edge_q    <= 1'b0;
        if (fresh_q) begin
          cr_q    <= written_q;
          fresh_q <= 1'b0;
          ready_q <= 1'b1;
        end
      end
      if (clk_fall_i) begin
        trigger_q <= 1'b0;
        if (load) begin
          ready_q  <= 1'b0;
          loaded_q <= 1'b1;
          stop_q   <= stop_q && half_write_q;  // a first byte stops this count too
          odd_q    <= cr[0] && cr != 16'd1;
          strobe_q <= 1'b1;
        end else if (zero) begin
          strobe_q <= 1'b0;
        end
      end
      if (control_i) begin
        edge_q    <= 1'b0;
        trigger_q <= 1'b0;
        armed_q   <= 1'b0;
        fresh_q   <= 1'b0;
        ready_q   <= 1'b0;
        loaded_q  <= 1'b0;
        stop_q    <= 1'b0;
        odd_q     <= 1'b0;
      end else if (full_write) begin
        armed_q <= 1'b1;
        fresh_q <= 1'b1;
      end else if (write_i && m0 && NmosRewrite) begin
        stop_q <= 1'b1;
      end
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) ce_q <= PowerUpSeed[31:16];
    else ce_q <= ce;
  end

  // ---- registers: bus -----------------------------------------------------------------------------
  logic null_count;
  assign null_count = !(loaded_q || load) || (fresh_q && !clk_rise_i) || (ready && !load);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      {rw_q, m_q, bcd_q} <= SeedCw;
      written_q          <= '0;
      low_q              <= '0;
      ol_q               <= '0;
      status_q           <= '0;
      half_write_q       <= 1'b0;
      half_read_q        <= 1'b0;
      count_latched_q    <= 1'b0;
      status_latched_q   <= 1'b0;
    end else if (control_i) begin
      {rw_q, m_q, bcd_q} <= d_i[5:0];
      written_q          <= '0;
      half_write_q       <= 1'b0;
      half_read_q        <= 1'b0;
      count_latched_q    <= 1'b0;
      status_latched_q   <= 1'b0;
    end else if (write_i) begin
      case (rw_q)
        2'b10:   written_q <= {d_i, 8'h00};
        2'b11: begin
          half_write_q <= !half_write_q;
          if (half_write_q) written_q <= {d_i, low_q};
          else low_q <= d_i;
        end
        default: written_q <= {8'h00, d_i};
      endcase
    end else if (latch_count_i || latch_status_i) begin
      if (latch_count_i && !count_latched_q) begin
        ol_q            <= ce;
        count_latched_q <= 1'b1;
      end
      if (latch_status_i && !status_latched_q) begin
        status_q         <= {out, null_count, rw_q, m_q, bcd_q};
        status_latched_q <= 1'b1;
      end
    end else if (read_end_i) begin
      if (status_latched_q) begin
        status_latched_q <= 1'b0;
      end else if (rw_q == 2'b11) begin
        half_read_q <= !half_read_q;
        if (half_read_q) count_latched_q <= 1'b0;
      end else begin
        count_latched_q <= 1'b0;
      end
    end
  end

  logic        high_byte;
  logic [15:0] readable;
  assign high_byte = rw_q == 2'b10 || (rw_q == 2'b11 && half_read_q);
  assign readable  = count_latched_q ? ol_q : ce_q;
  assign d_o       = !read_i ? 8'hFF
                   : status_latched_q ? status_q : high_byte ? readable[15:8] : readable[7:0];

  `MMCS_ASSERT(a_armed, !(fresh_q || ready_q) || armed_q, "a count can wait only once written")
  `MMCS_ASSERT(a_trigger, !(edge_q || trigger_q) || armed_q, "no trigger before a count")
  `MMCS_ASSERT(a_even, !(m3 && loaded_q && armed_q && !bcd_q) || !ce_q[0], "mode 3 counts evens")
endmodule

`default_nettype wire
