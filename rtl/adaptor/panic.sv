// SPDX-License-Identifier: Apache-2.0
// System PANIC and the brakes, fail-safe: whatever is missing asserts it. §2.3.4, §4.3.5
//
// The pins themselves close the brakes, clock or no clock; only registers release them. That the
// clock runs is shown outside: alive_o feeds a charge pump that gates the brakes' supply.
`default_nettype none

module panic #(
  parameter int AliveClks = 4000       // clocks between two edges of alive_o
) (
  input  wire logic clk_i,
  input  wire logic rst_ni,
  // What can go wrong
  input  wire logic bus_panic_i,       // the jumpered line of the PC bus; all four asynchronous
  input  wire logic estop_closed_i,
  input  wire logic cable_ok_i,
  input  wire logic pc_power_i,
  // Result
  output logic      panic_o,
  output logic      brake_release_o,
  output logic      alive_o,
  output logic      cable_ok_o,        // synchronised
  output logic      pc_power_o         // synchronised
);

  // --- PANIC ------------------------------------------------------------------------------

  // PANIC goes when all has been good for so many clocks: what power that returns lets a card say
  // has come through its flip-flop and the synchroniser by then, so that there is no gap.
  localparam int Hold = 4;

  logic bad, tripped;
  logic trip_d, trip_q;      // set by the pins, however short; cleared when it has become PANIC
  logic [Hold-1:0] hold_d, hold_q;  // clocks that all was good
  logic panic_d, panic_q;

  assign bad = ~(rst_ni & estop_closed_i & cable_ok_i & pc_power_i) | bus_panic_i;

  assign trip_d = trip_q & ~(tripped & panic_q);

  always_ff @(posedge clk_i or posedge bad) begin
    if (bad) trip_q <= 1'b1;
    else trip_q <= trip_d;
  end

  mmcs_sync #(
    .ResetValue(1'b1)
  ) u_trip (
    .clk_i, .rst_ni,
    .d_i(trip_q),
    .q_o(tripped)
  );

  mmcs_sync #(
    .Width(2),
    .ResetValue(2'b11)
  ) u_link (
    .clk_i, .rst_ni,
    .d_i({cable_ok_i, pc_power_i}),
    .q_o({cable_ok_o, pc_power_o})
  );

  assign hold_d = tripped ? '0 : {hold_q[Hold-2:0], 1'b1};
  assign panic_d = tripped | ~hold_q[Hold-1];

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      hold_q  <= '0;
      panic_q <= 1'b1;
    end else begin
      hold_q  <= hold_d;
      panic_q <= panic_d;
    end
  end

  assign panic_o = panic_q;
  // The pins themselves, and after them one of the two without a break to the end of PANIC.
  assign brake_release_o = ~(bad | trip_q | panic_q);

  // --- sign of life -----------------------------------------------------------------------

  localparam int Width = $clog2(AliveClks);
  localparam logic [Width-1:0] Last = Width'(AliveClks - 1);

  logic [Width-1:0] left_d, left_q;  // clocks until alive_o changes
  logic alive_d, alive_q;

  assign left_d = (left_q == '0) ? Last : left_q - 1'b1;
  assign alive_d = alive_q ^ (left_q == '0);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      left_q  <= Last;
      alive_q <= 1'b0;
    end else begin
      left_q  <= left_d;
      alive_q <= alive_d;
    end
  end

  assign alive_o = alive_q;

endmodule

`default_nettype wire
