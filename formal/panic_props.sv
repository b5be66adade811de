// SPDX-License-Identifier: Apache-2.0
// System PANIC and the brakes, for all inputs. §2.3.4, §4.3.5
`default_nettype none
`include "mmcs_formal.svh"

module panic_props (
  input wire logic clk_i,
  input wire logic bus_panic_i,
  input wire logic estop_closed_i,
  input wire logic cable_ok_i,
  input wire logic pc_power_i
);

  logic rst_ni = 1'b0;
  always @(posedge clk_i) rst_ni <= 1'b1;

  logic panic, brake, cable, power;

  panic dut (
    .clk_i, .rst_ni,
    .bus_panic_i, .estop_closed_i, .cable_ok_i, .pc_power_i,
    .panic_o(panic),
    .brake_release_o(brake),
    .cable_ok_o(cable),
    .pc_power_o(power)
  );

  // The inputs as they were one, two and three clocks ago.
  logic [3:1] fault_q = '0, bus_q = '0;
  always @(posedge clk_i) begin
    if (rst_ni) begin
      fault_q <= {fault_q[2:1], ~(estop_closed_i & cable_ok_i & pc_power_i)};
      bus_q   <= {bus_q[2:1], bus_panic_i};
    end
  end

  `MMCS_PROVE(BusPanics, "4.3.5", bus_q[3], panic,
              "PANIC of the PC bus is system PANIC three clocks later")
  `MMCS_PROVE(LoopPanics, "4.3.5", fault_q[3], panic,
              "button open, cable out or no power is system PANIC three clocks later")
  `MMCS_PROVE(BrakesHold, "4.2.1", panic, !brake,
              "the brakes are never released while PANIC stands")
  `MMCS_REACH(Healthy, !panic && brake, "PANIC can go and the brakes be released")

endmodule

`default_nettype wire
