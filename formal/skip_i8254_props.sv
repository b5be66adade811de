// SPDX-License-Identifier: Apache-2.0
// Skipping in a counter of the 8254. §4.3.4
`default_nettype none
`include "mmcs_formal.svh"

`define STATE(x) {x.rw_q, x.m_q, x.bcd_q, x.written_q, x.cr_q, x.ce_q, x.ol_q, x.low_q, \
                  x.status_q, x.half_write_q, x.half_read_q, x.count_latched_q, \
                  x.status_latched_q, x.armed_q, x.fresh_q, x.ready_q, x.loaded_q, x.stop_q, \
                  x.odd_q, x.m_q[2:1] == 2'b10 && x.loaded_q && x.strobe_q, x.gate_q, \
                  x.level_q, x.edge_q, x.trigger_q, x.out_q}

module skip_i8254_props (
  input wire logic        clk_i,
  input wire logic        no_reset_i,
  input wire logic        try_i,
  input wire logic [15:0] extra_i,
  input wire logic        rise_i,
  input wire logic        fall_i,
  input wire logic        gate_i,
  input wire logic        control_i,
  input wire logic        latch_count_i,
  input wire logic        latch_status_i,
  input wire logic        write_i,
  input wire logic        read_i,
  input wire logic        read_end_i,
  input wire logic [ 7:0] d_i
);

  logic rst_ni, started = 1'b0;
  always @(posedge clk_i) started <= 1'b1;
  assign rst_ni = started & no_reset_i;

  logic [15:0] horizon_a, horizon_b, extra_a, extra_b;
  logic [1:0] phase;
  logic jumps, out_a, out_b, up_a, up_b, down_a, down_b;
  logic [7:0] d_a, d_b;

  skip_phase frame (
    .clk_i, .rst_ni, .try_i, .extra_i,
    .horizon_i(horizon_a),
    .extra_a_o(extra_a),
    .extra_b_o(extra_b),
    .phase_o(phase)
  );

  // Pulses of CLK come on every clock of a jump. A single edge is that of OUT of another counter,
  // whose horizon puts it on the last clock: copy B sees it there.
  logic rise_b, fall_b;
  assign jumps = phase == 2'd0 && extra_b != extra_a;
  assign {rise_b, fall_b} = jumps ? {2{rise_i & fall_i}} : {rise_i, fall_i};

  i8254_counter #(.Skip(1'b1)) a (
    .clk_i, .rst_ni, .clk_rise_i(rise_i), .clk_fall_i(fall_i), .gate_i, .out_o(out_a),
    .out_rise_o(up_a), .out_fall_o(down_a), .control_i, .latch_count_i, .latch_status_i, .write_i,
    .read_i, .read_end_i, .d_i, .d_o(d_a), .clk_free_i(1'b0), .awake_o(), .extra_i(extra_a),
    .horizon_o(horizon_a)
  );
  i8254_counter #(.Skip(1'b1)) b (
    .clk_i, .rst_ni, .clk_rise_i(rise_b), .clk_fall_i(fall_b), .gate_i, .out_o(out_b),
    .out_rise_o(up_b), .out_fall_o(down_b), .control_i, .latch_count_i, .latch_status_i, .write_i,
    .read_i, .read_end_i, .d_i, .d_o(d_b), .clk_free_i(1'b0), .awake_o(), .extra_i(extra_b),
    .horizon_o(horizon_b)
  );

  // Wires of these names are joined to the registers when the hierarchy is flattened. The strobe is
  // looked at in modes 4 and 5 once a count is loaded.
  (* hierconn *) wire [1:0] \a.rw_q , \b.rw_q ;
  (* hierconn *) wire [2:0] \a.m_q , \b.m_q ;
  (* hierconn *) wire [7:0] \a.low_q , \a.status_q , \b.low_q , \b.status_q ;
  (* hierconn *) wire [15:0] \a.written_q , \a.cr_q , \a.ce_q , \a.ol_q ;
  (* hierconn *) wire [15:0] \b.written_q , \b.cr_q , \b.ce_q , \b.ol_q ;
  (* hierconn *) wire \a.bcd_q , \a.half_write_q , \a.half_read_q , \a.count_latched_q ;
  (* hierconn *) wire \b.bcd_q , \b.half_write_q , \b.half_read_q , \b.count_latched_q ;
  (* hierconn *) wire \a.status_latched_q , \a.armed_q , \a.fresh_q , \a.ready_q , \a.loaded_q ;
  (* hierconn *) wire \b.status_latched_q , \b.armed_q , \b.fresh_q , \b.ready_q , \b.loaded_q ;
  (* hierconn *) wire \a.stop_q , \a.odd_q , \a.strobe_q , \a.gate_q , \a.level_q , \a.edge_q ;
  (* hierconn *) wire \b.stop_q , \b.odd_q , \b.strobe_q , \b.gate_q , \b.level_q , \b.edge_q ;
  (* hierconn *) wire \a.trigger_q , \a.out_q , \b.trigger_q , \b.out_q ;
  logic [101:0] state_a, state_b;
  assign state_a = `STATE(a);
  assign state_b = `STATE(b);

  logic [16:0] pins;
  assign pins = {rise_i, fall_i, gate_i, control_i, latch_count_i, latch_status_i, write_i, read_i,
                 read_end_i, d_i};

  `MMCS_GIVEN(Still, phase != 2'd1 || pins == $past(pins), "the inputs stay during a jump")
  `MMCS_PROVE(JumpIsSteps, "4.3.4", phase == 2'd2, state_b == $past(state_a),
              "k clocks at once end where k single clocks end")
  `MMCS_PROVE(EdgesOfOut, "4.3.4", phase == 2'd1 && $past(up_a || down_a),
              {up_b, down_b} == $past({up_a, down_a}),
              "an edge of OUT that a jump announces is that of its last clock")
  `MMCS_PROVE(NoOtherEdge, "4.3.4", phase == 2'd1 && !$past(up_a || down_a), !up_b && !down_b,
              "the last clock of a jump has no edge of OUT that was not announced")
  `MMCS_PROVE(Quiet, "4.3.4", phase == 2'd1,
              !$past(up_b || down_b) && out_b == $past(out_b) && (read_i || d_b == $past(d_b)),
              "OUT stays until the last clock of a jump")
  `MMCS_PROVE(Advances, "4.3.4", 1'b1, horizon_a != '0, "one clock can always be taken")
  `MMCS_REACH(OneEdge, phase == 2'd2 && $past(rise_i != fall_i), "a jump can end in a single edge")

  `MMCS_LEMMA(Alike, phase != 2'd0 || state_a == state_b, "before the jump the copies are alike")
  `MMCS_LEMMA(Armed, (!a.loaded_q || a.armed_q) && (!b.loaded_q || b.armed_q),
              "only a count that was written is loaded")
  `MMCS_LEMMA(Idle, a.loaded_q || a.out_q == (a.m_q != 3'd0),
              "before a count is loaded OUT stands where the control word put it")
  `MMCS_LEMMA(Stop, !a.stop_q || a.m_q == 3'd0, "only mode 0 is stopped by half a count")
  `MMCS_LEMMA(Even, (a.m_q[1:0] != 2'd3 || !a.loaded_q || !a.ce_q[0]) &&
                    (b.m_q[1:0] != 2'd3 || !b.loaded_q || !b.ce_q[0]), "mode 3 counts evens")

endmodule

`default_nettype wire
