// SPDX-License-Identifier: Apache-2.0
// Drives two instances of a chip, one clock by clock, the other in steps of up to its horizon,
// and writes down both at the end of each step. "Advance by k equals k single clocks."
`default_nettype none

module bench_lockstep #(
    parameter int InBits = 8,
    parameter int OutBits = 8,
    parameter int EdgeBits = 1,
    parameter logic [InBits-1:0] Idle = '0,
    parameter int Depth = 65_536
) (
    input wire clk_i,
    input wire go_i,
    input wire [31:0] id_i,
    input wire [31:0] length_i,  // segments in the file: {cap[15:0], clocks[31:0], pins}
    output logic [InBits-1:0] stim_o,
    output logic [15:0] extra_o,
    output wire fast_clk_o,  // clk_i, but only the last edge of each step
    input wire [15:0] horizon_i,
    input wire [OutBits-1:0] slow_i,
    input wire [OutBits-1:0] fast_i,
    input wire [EdgeBits-1:0] slow_edge_i,  // outputs that tell what this very clock edge does
    input wire [EdgeBits-1:0] fast_edge_i,
    output logic done_o
);
  logic [InBits+47:0] segments[0:Depth-1];
  logic [InBits+47:0] segment;
  logic [31:0] left = 0;  // clocks of this segment after the present step
  logic [31:0] step = 1;  // clocks of the present step
  logic [31:0] todo = 1;  // of which not yet given
  logic [15:0] cap = 1;
  logic [EdgeBits-1:0] early, slow_last, fast_last;
  logic go_q = 1'b0;
  logic busy = 1'b0;
  logic fast_en = 1'b1;
  int at = 0;
  int file = 0;
  string name;

  assign fast_clk_o = clk_i & fast_en;

  initial begin
    stim_o = Idle;
    extra_o = 16'd0;
    done_o = 1'b0;
  end

  // Edge outputs as the clock edge sees them.
  always @(posedge clk_i) begin
    if (fast_en) begin
      slow_last <= slow_edge_i;
      fast_last <= fast_edge_i;
    end
    // Nothing may happen before the last clock of a step.
    if (todo == step) early <= fast_en ? '0 : slow_edge_i;
    else if (!fast_en) early <= early | slow_edge_i;
    if (busy && horizon_i == 16'd0) $error("horizon is 0");
  end

  // All decisions fall on the other edge, so that the gated clock cannot race.
  always @(negedge clk_i) begin
    go_q <= go_i;
    if (go_i && !go_q) begin
      name = $sformatf("stim_%0d.hex", id_i);
      $readmemh(name, segments, 0, length_i - 1);
      name = $sformatf("resp_%0d.hex", id_i);
      file = $fopen(name, "w");
      busy <= 1'b1;
      done_o <= 1'b0;
      at <= 1;
      start(segments[0]);
    end else if (busy) begin
      if (todo != 1) begin
        todo <= todo - 1;
        fast_en <= todo == 2;
        extra_o <= todo == 2 ? step[15:0] - 16'd1 : 16'd0;
      end else begin
        $fwrite(file, "%h %h %h %h %h %h\n", step, slow_i, fast_i, early, slow_last, fast_last);
        if (left != 0) begin
          go_on();
        end else if (at == length_i) begin
          $fclose(file);
          stim_o <= Idle;
          busy <= 1'b0;
          done_o <= 1'b1;
          fast_en <= 1'b1;
          extra_o <= 16'd0;
        end else begin
          at <= at + 1;
          start(segments[at]);
        end
      end
    end
  end

  // The pins change: a step of one clock.
  task automatic start(input logic [InBits+47:0] value);
    segment = value;
    stim_o <= segment[InBits-1:0];
    cap <= segment[InBits+47-:16];
    left <= segment[InBits+31-:32] - 1;
    step <= 1;
    todo <= 1;
    fast_en <= 1'b1;
    extra_o <= 16'd0;
  endtask

  // The pins stay: as far as the horizon, the cap and the segment allow.
  task automatic go_on();
    logic [31:0] k;
    k = {16'd0, horizon_i};
    if (k > {16'd0, cap}) k = {16'd0, cap};
    if (k > left) k = left;
    if (k == 0) k = 1;
    step <= k;
    todo <= k;
    left <= left - k;
    fast_en <= k == 1;
    extra_o <= 16'd0;
  endtask
endmodule

`default_nettype wire
