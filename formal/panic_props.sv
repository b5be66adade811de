// SPDX-License-Identifier: Apache-2.0
// System PANIC and the brakes, from the pins, at any time between clocks. §2.3.4, §4.3.5
//
// A step of the proof is an instant, not a clock: the clock is one more input, which runs, jitters
// or stops; pins, reset and PANIC's line move between its edges, for as short as they like.
`default_nettype none
`include "mmcs_formal.svh"

module panic_props (
  (* gclk *) input wire logic clk_i, // the steps
  input wire logic clock_i,          // the design's clock
  input wire logic no_reset_i,
  input wire logic bus_panic_i,
  input wire logic estop_closed_i,
  input wire logic cable_ok_i,
  input wire logic pc_power_i,
  input wire logic pick_i            // some fault of all
);

  localparam int Alive = 3;

  `MMCS_RESET(1'b1)

  logic panic, brake, alive, bad;

  panic #(
    .AliveClks(Alive)
  ) dut (
    .clk_i(clock_i),
    .rst_ni(rst_ni & no_reset_i),
    .bus_panic_i, .estop_closed_i, .cable_ok_i, .pc_power_i,
    .panic_o(panic),
    .brake_release_o(brake),
    .alive_o(alive)
  );

  assign bad = bus_panic_i || !estop_closed_i || !cable_ok_i || !pc_power_i || !no_reset_i;

  // --- clocks ---------------------------------------------------------------------------------

  logic clock_q = 1'b1, brake_q = 1'b0, panic_q = 1'b1, alive_q = 1'b0, tick;
  logic [3:0] good_q = '0;               // clocks since anything was bad, 15 at most
  logic [2:0] after_q = 3'd7;            // clocks since a fault that began in health; 7: none
  logic [2:0] still_q = '0;              // clocks in which alive stood
  assign tick = clock_i && !clock_q;

  always @(posedge clk_i) begin
    clock_q <= clock_i;
    brake_q <= brake;
    panic_q <= panic;
    alive_q <= alive;
    if (bad || !rst_ni) good_q <= '0;
    else if (tick && good_q != 4'd15) good_q <= good_q + 4'd1;
    if (bad && pick_i && rst_ni) after_q <= '0;
    else if (tick && after_q != 3'd7) after_q <= after_q + 3'd1;
    if (!rst_ni || !no_reset_i || alive != alive_q) still_q <= '0;
    else if (tick && still_q != 3'd7) still_q <= still_q + 3'd1;
  end

  `MMCS_PROVE(PinsClose, "4.3.5", bad, !brake,
              "PANIC's line, button, cable, power, reset close the brakes, clock or no clock")
  `MMCS_PROVE(OnlyClockOpens, "4.3.5", brake && !brake_q, tick,
              "brakes are released by an edge of the clock, and by nothing else")
  `MMCS_PROVE(ShortPanics, "4.3.5", after_q == 3'd3, panic,
              "whatever was bad, however short, is system PANIC three clocks later")
  `MMCS_PROVE(NoGap, "4.3.5", brake, good_q >= 4'd7,
              "brakes are released only after seven clocks of health, after a reset too")
  `MMCS_PROVE(PanicGoes, "4.3.5", good_q == 4'd15 && !bad, !panic && brake,
              "after fifteen clocks of health PANIC is low and the brakes are released")
  `MMCS_PROVE(Lives, "4.2.1", no_reset_i && good_q != '0, still_q <= 3'(Alive),
              "the sign of life changes as long as the clock runs")
  `MMCS_REACH(Healthy, brake && alive, "PANIC can go and the brakes be released")
  `MMCS_REACH(Pulse, panic && !panic_q && good_q == 4'd2, "a fault shorter than a clock panics")

endmodule

`default_nettype wire
