// SPDX-License-Identifier: Apache-2.0
// The loopback relay: D/A to the joints, or to the A/D inputs. Table 5.1, §5.3.5
//
// It follows its coil after RelayUs. The joints are isolated as soon as the coil says so.
`default_nettype none

module mark1_relay #(
  parameter int SettleClks = 8000
) (
  input  wire logic clk_i,
  input  wire logic rst_ni,
  input  wire logic joint_i,    // the coil, port B bit 1
  output logic      drive_o,    // the D/As reach the joints
  output logic      loop_o      // the D/As reach the A/Ds
);

  localparam int Width = $clog2(SettleClks + 1);
  localparam logic [Width-1:0] Settle = Width'(SettleClks);

  logic joint_d, joint_q;            // the contacts
  logic [Width-1:0] left_d, left_q;  // clocks until they follow the coil

  // A coil that changes its mind starts anew.
  always_comb begin
    joint_d = joint_q;
    left_d  = Settle;
    if (joint_i != joint_q) begin
      if (left_q == Width'(1)) joint_d = joint_i;
      else left_d = left_q - 1'b1;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      joint_q <= 1'b0;
      left_q  <= Settle;
    end else begin
      joint_q <= joint_d;
      left_q  <= left_d;
    end
  end

  assign drive_o = joint_q & joint_i;
  assign loop_o = ~joint_q;

endmodule

`default_nettype wire
