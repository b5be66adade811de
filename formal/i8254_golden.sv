// SPDX-License-Identifier: Apache-2.0
// One counter of the 8254 as its data sheet tells it, one event after the other. §4.3.4
`default_nettype none

// In one clock of clk_i: GATE, the rise of CLK, the fall of CLK, one event of the bus.
module i8254_golden #(
  parameter bit NmosRewrite = 1'b1,
  parameter bit SplitCr = 1'b1
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  input  wire logic        rise_i,
  input  wire logic        fall_i,
  input  wire logic        gate_i,
  input  wire logic        control_i,
  input  wire logic        latch_count_i,
  input  wire logic        latch_status_i,
  input  wire logic        write_i,
  input  wire logic        read_end_i,
  input  wire logic [ 7:0] d_i,
  output logic      [ 7:0] d_o,     // what a read shows
  output logic             out,
  // state, for the proof
  output logic      [ 5:0] control,      // RW, mode, BCD
  output logic      [15:0] written,      // the count register as the bus has left it
  output logic      [15:0] cr,           // of that, what a rise of CLK has seen
  output logic      [15:0] ce,           // counting element
  output logic      [15:0] latched,      // count latch
  output logic      [ 7:0] status,       // status latch
  output logic      [ 7:0] low_byte,     // first byte of two
  output logic      [ 7:0] flags,        // {high_next_w, high_next_r, count_held, status_held,
                                         //  counts, null_count, stopped, odd}
  output logic      [ 8:0] events        // {rolled, unseen, waits, programmed, gate, level, rose,
                                         //  trigger, strobe}
);

  logic high_next_w, high_next_r, count_held, status_held, counts, null_count, stopped, odd;
  logic rolled, unseen, waits, programmed, gate, level, rose, trigger, strobe;
  assign flags  = {high_next_w, high_next_r, count_held, status_held, counts, null_count, stopped,
                   odd};
  assign events = {rolled, unseen, waits, programmed, gate, level, rose, trigger, strobe};

  logic [1:0] rw;
  logic [2:0] mode;
  logic bcd;
  assign {rw, mode, bcd} = control;

  // One less: four decades or sixteen bits.
  function automatic logic [15:0] less(input logic [15:0] v, input logic decades);
    logic borrow;
    begin
      less = v - 16'd1;
      if (decades) begin
        borrow = 1'b1;
        for (int i = 0; i < 4; i++) begin
          less[4*i+:4] = !borrow ? v[4*i+:4] : v[4*i+:4] == 4'd0 ? 4'd9 : v[4*i+:4] - 4'd1;
          borrow = borrow && v[4*i+:4] == 4'd0;
        end
      end
    end
  endfunction

  logic fills, starts, ends, steps, reaches_zero;

  always @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      control = 6'd0;
      {written, cr, ce, latched, status, low_byte} = '0;
      {high_next_w, high_next_r, count_held, status_held, counts, stopped, odd} = '0;
      {rolled, unseen, waits, programmed, level, rose, trigger, strobe} = '0;
      {fills, starts, ends, steps, reaches_zero} = '0;
      null_count = 1'b1;
      gate = 1'b1;
      out = 1'b0;
    end else begin
      // GATE: its rise is remembered until CLK rises; it means nothing before the first count.
      if (gate_i && !gate && programmed) rose = 1'b1;
      gate = gate_i;

      // CLK rises: GATE, a trigger and a new count are seen.
      if (rise_i) begin
        level = gate_i;
        trigger = rose;
        rose = 1'b0;
        cr = written;
        if (unseen) begin
          waits = 1'b1;
          unseen = 1'b0;
        end
      end

      // CLK falls: the counting element is loaded or counts, and OUT moves.
      if (fall_i) begin
        case (mode)
          3'd0, 3'd4: starts = waits;
          3'd1, 3'd5: starts = trigger;
          default:    starts = trigger || (waits && !counts);
        endcase
        steps = counts && !starts && (level || mode == 3'd1 || mode == 3'd5) && !stopped;
        case (mode)  // the last CLK of a period or half period
          3'd2, 3'd6: ends = steps && ce == 16'd1;
          3'd3, 3'd7: ends = steps && ce == (odd && out ? 16'd0 : 16'd2);
          default:    ends = 1'b0;
        endcase
        fills = starts || ends;
        if (fills) begin
          ce = cr;
          odd = cr[0] && cr != 16'd1;
          if ((mode == 3'd2 || mode == 3'd6) && cr == 16'd1) ce = 16'd2;
          if (mode == 3'd3 || mode == 3'd7) ce = cr == 16'd1 ? 16'd0 : {cr[15:1], 1'b0};
          waits = 1'b0;
          counts = 1'b1;
          null_count = unseen;
          rolled = 1'b0;
          if (!high_next_w) stopped = 1'b0;
        end else if (steps) begin
          if (ce == 16'd0) rolled = 1'b1;
          ce = less(ce, bcd);
          if (mode == 3'd3 || mode == 3'd7) ce = less(ce, bcd);
        end
        reaches_zero = steps && !fills && ce == 16'd0;
        case (mode)
          3'd0:       if (reaches_zero && !unseen && !high_next_w) out = 1'b1;
          3'd1:       out = starts ? 1'b0 : reaches_zero ? 1'b1 : out;
          3'd2, 3'd6: out = fills ? 1'b1 : steps && ce == 16'd1 ? 1'b0 : out;
          3'd3, 3'd7: out = starts ? 1'b1 : ends ? !out : out;
          default:    out = !(reaches_zero && strobe);
        endcase
        if (fills) strobe = 1'b1;
        else if (reaches_zero) strobe = 1'b0;
        trigger = 1'b0;
      end

      // GATE low holds OUT high in modes 2 and 3.
      if (!gate_i && (mode[1:0] == 2'd2 || mode[1:0] == 2'd3)) out = 1'b1;

      // The bus.
      if (control_i) begin
        control = d_i[5:0];
        out = d_i[3:1] != 3'd0;
        {high_next_w, high_next_r, count_held, status_held, counts, stopped, odd} = '0;
        {unseen, waits, programmed, rose, trigger} = '0;
        null_count = 1'b1;
        written = '0;
      end else if (write_i) begin
        if (mode == 3'd0) out = 1'b0;
        if (rw == 2'b11 && !high_next_w) begin
          low_byte = d_i;
          if (SplitCr) written[7:0] = d_i;
          high_next_w = 1'b1;
          if (mode == 3'd0 && (NmosRewrite || !rolled)) stopped = 1'b1;
        end else begin
          written = rw == 2'b11 ? {d_i, low_byte} : rw == 2'b10 ? {d_i, 8'h00} : {8'h00, d_i};
          high_next_w = 1'b0;
          {programmed, unseen, null_count} = 3'b111;
        end
      end else if (read_end_i) begin
        if (status_held) begin
          status_held = 1'b0;
        end else begin
          if (rw != 2'b11 || high_next_r) count_held = 1'b0;
          high_next_r = rw == 2'b11 && !high_next_r;
        end
      end else begin
        if (latch_count_i && !count_held) {count_held, latched} = {1'b1, ce};
        if (latch_status_i && !status_held) begin
          {status_held, status} = {1'b1, out, null_count, control};
        end
      end
    end
  end

  logic [15:0] shown;
  assign shown = count_held ? latched : ce;
  assign d_o = status_held ? status
             : rw == 2'b10 || (rw == 2'b11 && high_next_r) ? shown[15:8] : shown[7:0];

endmodule

`default_nettype wire
