// SPDX-License-Identifier: Apache-2.0
// The loopback relay: D/A to the joints, or to the A/D inputs. Table 5.1, §5.3.5
//
// It follows its coil after RelayUs. The joints are isolated as soon as the coil says so.
`default_nettype none

module relay #(
  parameter int SettleClks = 8000,
  parameter bit Gate = 1'b0,            // see rtl/mmcs.sv
  parameter bit Skip = 1'b0
) (
  input  wire logic         clk_i,
  input  wire logic         rst_ni,
  input  wire logic         joint_i,    // port B bit 1
  output logic              drive_o,    // the D/As reach the joints
  output logic              loop_o,     // the D/As reach the A/Ds
  // Skipping and gating
  input  wire logic         clk_free_i,
  output logic              due_o,      // this clock moves the contacts
  input  wire logic  [15:0] extra_i,
  output logic       [15:0] horizon_o
);

  localparam int Width = ($clog2(SettleClks + 1) < 17) ? 17 : $clog2(SettleClks + 1);
  localparam logic [Width-1:0] Settle = Width'(SettleClks);

  logic clk_free;
  assign clk_free = Gate ? clk_free_i : clk_i;

  logic joint_q, moving;
  logic [Width-1:0] left_q;   // clocks until the contacts follow; restarts when the coil changes
  logic [Width-1:0] step;

  if (Skip) begin : g_skip
    assign step = Width'(extra_i) + 1'b1;
    always_comb begin
      horizon_o = 16'hFFFF;
      if (joint_i != joint_q) begin
        if (left_q < Width'(17'h10000)) horizon_o = 16'(left_q);
      end else if (left_q != Settle) begin
        horizon_o = 16'd1;
      end
    end
  end else begin : g_step
    assign step = Width'(1);
    assign horizon_o = 16'd1;
    logic unused;
    assign unused = ^extra_i;
  end

  assign moving = joint_i != joint_q;
  assign due_o = moving && left_q == step;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) joint_q <= 1'b0;
    else if (due_o) joint_q <= joint_i;
  end

  always_ff @(posedge clk_free or negedge rst_ni) begin
    if (!rst_ni) left_q <= Settle;
    else if (moving && !due_o) left_q <= left_q - step;
    else if (left_q != Settle) left_q <= Settle;
  end

  assign drive_o = joint_q & joint_i;
  assign loop_o = ~joint_q;

endmodule

`default_nettype wire
