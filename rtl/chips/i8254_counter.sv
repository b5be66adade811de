// SPDX-License-Identifier: Apache-2.0
// One counter of the 8254: six modes, binary and BCD, latches, status, null count. §4.3.4
//
// Order within one clk_i: first the rise of CLK, then its fall, then the bus. So a CLK that comes
// with the end of a write does not see what was written, and a latch command takes the count and
// the status as that CLK leaves them.
`default_nettype none
`include "mmcs_assert.svh"

module i8254_counter #(
  // Mode 0, first byte of a new two-byte count. 1: it stops the count, as on the 8254. 0: only while
  // the count has not rolled over, as on the 82C54.
  parameter bit NmosRewrite = 1'b1,
  // 1: CR_L takes the first of two bytes at once, as the sheet says: a trigger or reload before the
  // second loads the mix. 0: both bytes are taken with the second.
  parameter bit SplitCr = 1'b1,
  parameter logic [31:0] PowerUpSeed = 32'd0   // 0: all zero; else any state, counting or not
) (
  input  wire logic       clk_i,
  input  wire logic       rst_ni,
  // Pins
  input  wire logic       clk_rise_i,
  input  wire logic       clk_fall_i,
  input  wire logic       gate_i,
  output logic            out_o,
  output logic            out_rise_o,      // OUT will rise on this clock
  output logic            out_fall_o,
  // Bus: each for one clock
  input  wire logic       control_i,       // control word in d_i, RW not 00
  input  wire logic       latch_count_i,
  input  wire logic       latch_status_i,
  input  wire logic       write_i,         // a byte of the count in d_i
  input  wire logic       read_i,          // d_o is looked at; it is 0xFF otherwise
  input  wire logic       read_end_i,      // a read of d_o has ended
  input  wire logic [7:0] d_i,
  output logic      [7:0] d_o
);

  localparam logic [5:0] SeedControl = PowerUpSeed == 32'd0 ? 6'd0 : {1'b1, PowerUpSeed[4:0]};

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

  // --- state ----------------------------------------------------------------------------------

  logic [1:0] rw_d, rw_q;                // 01 low byte, 10 high byte, 11 low then high
  logic [2:0] m_d, m_q;                  // mode as written
  logic bcd_d, bcd_q;
  logic [15:0] written_d, written_q;     // count as written; takes part from the next CLK rise on
  logic [15:0] cr_d, cr_q;               // count register
  logic [15:0] ce_d, ce_q;               // counting element
  logic [15:0] ol_d, ol_q;               // output latch
  logic [7:0] low_d, low_q;              // first byte of a two-byte write
  logic [7:0] status_d, status_q;        // status latch
  logic half_write_d, half_write_q, half_read_d, half_read_q;
  logic count_latched_d, count_latched_q, status_latched_d, status_latched_q;
  logic armed_d, armed_q;                // a whole count was written since the control word
  logic fresh_d, fresh_q;                // a count waits for a CLK rise
  logic ready_d, ready_q;                // a count waits to be loaded
  logic loaded_d, loaded_q;              // CE was loaded since the control word
  logic stop_d, stop_q;                  // mode 0: first byte of a rewrite seen
  logic odd_d, odd_q;                    // mode 3: parity of N as loaded
  logic strobe_d, strobe_q;              // modes 4, 5: the one strobe of this load is yet to come
  logic rolled_d, rolled_q;              // CE has counted below 0 since it was loaded
  logic gate_q, level_d, level_q;        // GATE a clock ago; GATE at the last CLK rise
  logic edge_d, edge_q;                  // GATE rose
  logic trigger_d, trigger_q;            // its rise was seen by the last CLK rise
  logic out_d, out_q;

  logic m0, m1, m2, m3, m4, m5, periodic;

  assign m0 = m_q == 3'd0;
  assign m1 = m_q == 3'd1;
  assign m2 = m_q[1:0] == 2'd2;
  assign m3 = m_q[1:0] == 2'd3;
  assign m4 = m_q == 3'd4;
  assign m5 = m_q == 3'd5;
  assign periodic = m_q[1];

  // --- what this clock does -------------------------------------------------------------------

  logic whole;                    // the byte that is written completes a count
  logic to_m0;                    // the control word says mode 0
  logic restart, load, count;     // the fall of CLK: begins a count, loads CE, counts
  logic zero;                     // it counted to 0
  logic [15:0] last;              // the count of a period after which CE is loaded again

  assign whole = write_i && (rw_q != 2'b11 || half_write_q);
  assign to_m0 = d_i[3:1] == 3'd0;
  // Mode 3 holds one more CLK at zero in the high half of an odd N.
  assign last = m2 ? 16'd1 : (odd_q && out_q) ? 16'd0 : 16'd2;

  always_comb begin
    cr_d      = cr_q;
    ce_d      = ce_q;
    armed_d   = armed_q;
    fresh_d   = fresh_q;
    ready_d   = ready_q;
    loaded_d  = loaded_q;
    stop_d    = stop_q;
    odd_d     = odd_q;
    strobe_d  = strobe_q;
    rolled_d  = rolled_q;
    level_d   = level_q;
    edge_d    = edge_q || (gate_i && !gate_q && armed_q);
    trigger_d = trigger_q;
    out_d     = out_q;
    restart   = 1'b0;
    load      = 1'b0;
    count     = 1'b0;
    zero      = 1'b0;

    if (clk_rise_i) begin
      level_d   = gate_i;
      trigger_d = edge_d;
      edge_d    = 1'b0;
      cr_d      = written_q;
      if (fresh_q) begin
        fresh_d = 1'b0;
        ready_d = 1'b1;
      end
    end

    if (clk_fall_i) begin
      if (periodic) restart = trigger_d || (ready_d && !loaded_q);
      else restart = (m0 || m4) ? ready_d : trigger_d;
      load  = restart || (periodic && loaded_q && level_d && ce_q == last);
      count = !load && loaded_q && !stop_q && (level_d || m1 || m5);
      if (load) begin
        ce_d     = first(m2, m3, cr_d);
        ready_d  = 1'b0;
        loaded_d = 1'b1;
        stop_d   = stop_q && half_write_q;  // a first byte stops this count too
        odd_d    = (cr_d & 16'd1) != 16'd0 && cr_d != 16'd1;
        strobe_d = 1'b1;
        rolled_d = 1'b0;
      end else if (count) begin
        if (ce_q == 16'd0) rolled_d = 1'b1;
        if (bcd_q) ce_d = m3 ? bcd_minus_1(bcd_minus_1(ce_q)) : bcd_minus_1(ce_q);
        else ce_d = ce_q - (m3 ? 16'd2 : 16'd1);
        zero = ce_d == 16'd0;
        if (zero) strobe_d = 1'b0;
      end
      trigger_d = 1'b0;
      case (m_q)
        3'd0:       if (zero && !fresh_q && !half_write_q) out_d = 1'b1;
        3'd1:       if (load) out_d = 1'b0;
                    else if (zero) out_d = 1'b1;
        3'd2, 3'd6: if (load) out_d = 1'b1;
                    else if (count && ce_d == 16'd1) out_d = 1'b0;
        3'd3, 3'd7: if (load) out_d = restart || !out_q;
        default:    out_d = !(strobe_q && zero);
      endcase
    end
    if (!gate_i && periodic) out_d = 1'b1;

    if (control_i) begin
      edge_d    = 1'b0;
      trigger_d = 1'b0;
      armed_d   = 1'b0;
      fresh_d   = 1'b0;
      ready_d   = 1'b0;
      loaded_d  = 1'b0;
      stop_d    = 1'b0;
      odd_d     = 1'b0;
      out_d     = !to_m0;
    end else if (write_i) begin
      if (whole) armed_d = 1'b1;
      if (whole) fresh_d = 1'b1;
      else if (m0 && (NmosRewrite || !rolled_d)) stop_d = 1'b1;
      if (m0) out_d = 1'b0;
    end
  end

  assign out_o = out_q;
  assign out_rise_o = out_d && !out_q;
  assign out_fall_o = !out_d && out_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      cr_q      <= '0;
      ce_q      <= PowerUpSeed[31:16];
      armed_q   <= 1'b0;
      fresh_q   <= 1'b0;
      ready_q   <= 1'b0;
      loaded_q  <= PowerUpSeed[6];
      stop_q    <= 1'b0;
      odd_q     <= 1'b0;
      strobe_q  <= 1'b0;
      rolled_q  <= 1'b0;
      gate_q    <= 1'b1;
      level_q   <= 1'b0;
      edge_q    <= 1'b0;
      trigger_q <= 1'b0;
      out_q     <= PowerUpSeed[5];
    end else begin
      cr_q      <= cr_d;
      ce_q      <= ce_d;
      armed_q   <= armed_d;
      fresh_q   <= fresh_d;
      ready_q   <= ready_d;
      loaded_q  <= loaded_d;
      stop_q    <= stop_d;
      odd_q     <= odd_d;
      strobe_q  <= strobe_d;
      rolled_q  <= rolled_d;
      gate_q    <= gate_i;
      level_q   <= level_d;
      edge_q    <= edge_d;
      trigger_q <= trigger_d;
      out_q     <= out_d;
    end
  end

  // --- bus: formats, latches, bytes -----------------------------------------------------------

  logic null_count;
  logic [5:0] control;
  logic [7:0] written_high;

  assign control = d_i[5:0];
  assign written_high = written_q[15:8];
  assign null_count = !loaded_d || fresh_d || ready_d;

  always_comb begin
    {rw_d, m_d, bcd_d} = {rw_q, m_q, bcd_q};
    written_d        = written_q;
    low_d            = low_q;
    ol_d             = ol_q;
    status_d         = status_q;
    half_write_d     = half_write_q;
    half_read_d      = half_read_q;
    count_latched_d  = count_latched_q;
    status_latched_d = status_latched_q;
    if (control_i) begin
      {rw_d, m_d, bcd_d} = control;
      written_d        = '0;
      half_write_d     = 1'b0;
      half_read_d      = 1'b0;
      count_latched_d  = 1'b0;
      status_latched_d = 1'b0;
    end else if (write_i) begin
      case (rw_q)
        2'b10: written_d = {d_i, 8'h00};
        2'b11: begin
          half_write_d = !half_write_q;
          if (half_write_q) begin
            written_d = {d_i, low_q};
          end else begin
            low_d = d_i;
            if (SplitCr) written_d = {written_high, d_i};
          end
        end
        default: written_d = {8'h00, d_i};
      endcase
    end else if (latch_count_i || latch_status_i) begin
      if (latch_count_i && !count_latched_q) begin
        ol_d            = ce_d;
        count_latched_d = 1'b1;
      end
      if (latch_status_i && !status_latched_q) begin
        status_d         = {out_d, null_count, rw_q, m_q, bcd_q};
        status_latched_d = 1'b1;
      end
    end else if (read_end_i) begin
      if (status_latched_q) begin
        status_latched_d = 1'b0;
      end else if (rw_q == 2'b11) begin
        half_read_d = !half_read_q;
        if (half_read_q) count_latched_d = 1'b0;
      end else begin
        count_latched_d = 1'b0;
      end
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      {rw_q, m_q, bcd_q} <= SeedControl;
      written_q        <= '0;
      low_q            <= '0;
      ol_q             <= '0;
      status_q         <= '0;
      half_write_q     <= 1'b0;
      half_read_q      <= 1'b0;
      count_latched_q  <= 1'b0;
      status_latched_q <= 1'b0;
    end else begin
      {rw_q, m_q, bcd_q} <= {rw_d, m_d, bcd_d};
      written_q        <= written_d;
      low_q            <= low_d;
      ol_q             <= ol_d;
      status_q         <= status_d;
      half_write_q     <= half_write_d;
      half_read_q      <= half_read_d;
      count_latched_q  <= count_latched_d;
      status_latched_q <= status_latched_d;
    end
  end

  logic high_byte;
  logic [15:0] readable;

  assign high_byte = rw_q == 2'b10 || (rw_q == 2'b11 && half_read_q);
  assign readable = count_latched_q ? ol_q : ce_q;
  assign d_o = !read_i ? 8'hFF
             : status_latched_q ? status_q : high_byte ? readable[15:8] : readable[7:0];

  `MMCS_ASSERT(WaitingWasWritten, !(fresh_q || ready_q) || armed_q,
               "a count can wait only once it was written")
  `MMCS_ASSERT(TriggerAfterCount, !(edge_q || trigger_q) || armed_q,
               "there is no trigger before a count")
  `MMCS_ASSERT(Mode3CountsEven, !(m3 && loaded_q && armed_q && !bcd_q) || !ce_q[0],
               "mode 3 counts even numbers")

endmodule

`default_nettype wire
