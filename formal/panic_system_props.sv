// SPDX-License-Identifier: Apache-2.0
// PANIC of the whole machine with two cards. §2.3.4, §4.3.5, §5.3.6
//
// The front on the VMEbus, timers, PPIs, encoder counters, converters and relays are cut out: what
// they do is free. What is left is the PC bus, decoders, heartbeats, wiring and PANIC.
// The heartbeat has its real 50 ms in the proof (400,000 clocks) and 32 clocks in the covers.
`default_nettype none
`include "mmcs_formal.svh"

module panic_system_props #(
  parameter int ClkHz = 8_000_000,
  parameter int HeartbeatUs = 50_000
) (
  input wire logic       clk_i,
  input wire logic       estop_closed_i,
  input wire logic       cable_ok_i,
  input wire logic       pc_power_i,
  input wire logic [3:0] axis_enable_i,
  input wire logic [7:3] line_i,          // of somebody else's card
  input wire logic       sysreset_ni
);

  localparam int Pulse = ClkHz / 1_000_000 * HeartbeatUs;
  localparam int Width = $clog2(Pulse + 1);

  `MMCS_RESET(1'b1)

  logic panic, brake, iow_n, ior_n;
  logic [15:0] pc_a;

  mmcs #(
    .NumCards(2),
    .ClkHz(ClkHz),
    .HeartbeatUs(HeartbeatUs)
  ) dut (
    .clk_i, .rst_ni,
    .vme_a_i('0), .vme_am_i('0), .vme_as_ni(1'b1), .vme_ds_ni(2'b11), .vme_write_ni(1'b1),
    .vme_lword_ni(1'b1), .vme_d_i('0), .vme_iack_ni(1'b1), .vme_iackin_ni(1'b1),
    .vme_sysreset_ni(sysreset_ni),
    .estop_closed_i, .cable_ok_i, .pc_power_i,
    .brake_release_o(brake),
    .panic_o(panic),
    .enc_a_i('0), .enc_b_i('0), .enc_i_i('0),
    .axis_enable_i, .dip_i(8'h10), .adc_v_i('0),
    .pcx_a_o(pc_a),
    .pcx_iow_no(iow_n),
    .pcx_ior_no(ior_n),
    .pcx_d_i('0), .pcx_d_oe_i(1'b0), .pcx_wait_i(1'b0), .pcx_irq_i(line_i)
  );

  // Wires of the inside, joined by the script.
  logic [ 3:0] f_heartbeat, f_enable, f_trigger;   // card 1 axis 2 ... card 0 axis 1
  logic [ 1:0] f_line;
  logic [Width-1:0] f_left0, f_left1, f_left2, f_left3;
  logic        f_power;
  logic [ 1:0] f_power_first;               // {cable, power}

  // --- power as it was one, two and three clocks ago ------------------------------------------

  logic power0_q = 1'b1, power1_q = 1'b1, power2_q = 1'b0;
  always @(posedge clk_i) begin
    if (rst_ni) {power2_q, power1_q, power0_q} <= {power1_q, power0_q, pc_power_i};
  end

  // --- clocks since the low byte of each D/A was last written --------------------------------

  logic [3:0] write, write_q = '0;
  logic [20:0] since_q[4];
  logic [3:0] late, expired;
  for (genvar n = 0; n < 4; n++) begin : g_axis
    localparam logic [15:0] Address = {2'b00, 4'(n / 2), 5'b11000, 5'(8 + 2 * (n % 2))};
    assign write[n] = !iow_n && pc_a == Address && power1_q;
    always @(posedge clk_i) begin
      if (!rst_ni) begin
        since_q[n] <= 21'h1FFFFF;
      end else begin
        write_q[n] <= write[n];
        if (write[n] && !write_q[n]) since_q[n] <= '0;
        else if (since_q[n] != '1) since_q[n] <= since_q[n] + 1'b1;
      end
    end
    assign late[n] = since_q[n] >= 21'(Pulse);   // 50 ms have passed
  end

  // Written since power came: the one-shots are held cleared without it.
  logic [3:0] written_q = '0;
  always @(posedge clk_i) begin
    if (rst_ni) begin
      if (!power1_q) written_q <= '0;
      else written_q <= written_q | (write & ~write_q);
    end
  end

  // --- what should be -------------------------------------------------------------------------

  // So many clocks ago: all pins were good; an enabled axis did not beat, by its heartbeat and by
  // what was written to it. Before the beginning nothing was good.
  logic [7:1] pins_q = '0;
  logic [5:1] dead_q = '1;
  logic [4:1] silent_q = '1;
  logic [3:0] good_q = '0;               // clocks that all was good
  logic pins, dead;
  assign pins = estop_closed_i && cable_ok_i && pc_power_i && !line_i[7];
  assign dead = (f_enable & ~f_heartbeat) != 4'd0;
  always @(posedge clk_i) begin
    if (rst_ni) begin
      pins_q   <= {pins_q[6:1], pins};
      dead_q   <= {dead_q[4:1], dead};
      silent_q <= {silent_q[3:1], (f_enable & late) != 4'd0};
      if (dead || !pins) good_q <= '0;
      else if (good_q != 4'd15) good_q <= good_q + 4'd1;
    end
  end

  `MMCS_PROVE(PinsClose, "4.3.5", !pins, !brake,
              "button, cable, power and PANIC's line close the brakes by themselves")
  `MMCS_PROVE(LowMeansGood, "4.3.5", !panic, (&pins_q[7:3]) && dead_q[5:4] == '0,
              "PANIC is low only if the pins have been good and all enabled axes have beaten")
  `MMCS_PROVE(GoodMeansLow, "4.3.5", good_q == 4'd15 && pins, !panic && brake,
              "and it is low if they are for fifteen clocks: nothing else panics")
  `MMCS_PROVE(BeatExact, "5.3.6", f_heartbeat != 4'd0, (f_heartbeat & late) == 4'd0,
              "a heartbeat lives 50 ms from the last write of the D/A low byte, not a clock longer")
  `MMCS_PROVE(BeatLives, "5.3.6", power1_q && written_q == 4'hF && ~late != 4'd0,
              (f_heartbeat | late) == 4'hF,
              "and not a clock shorter, power given")
  `MMCS_PROVE(BrakesIn50ms, "5.3.6", silent_q[1], !brake,
              "50 ms after an enabled D/A's last low-byte write the brakes close in a clock")
  `MMCS_PROVE(PanicIn50ms, "5.3.6", silent_q[4], panic, "and PANIC is high in four")
  `MMCS_REACH(Released, brake && (&f_enable), "all four axes beat and the brakes are released")
  `MMCS_REACH(RunsOut,
              panic && pins_q[3] && (&f_enable) && late == 4'b0001 && f_heartbeat == 4'b1110,
              "one heartbeat of four runs out")

  // --- steps of the induction -----------------------------------------------------------------

  `MMCS_LEMMA(Trigger, f_trigger == (f_power ? write_q : 4'd0) || !f_power, "-")
  `MMCS_LEMMA(Written, !f_power || (written_q & (f_heartbeat ^ ~late)) == 4'd0, "-")
  `MMCS_LEMMA(Power0, f_power_first[0] == power0_q && f_power == power1_q, "-")
  `MMCS_LEMMA(IoSpace, pc_a[15:14] == 2'b00, "-")
  `MMCS_LEMMA(Left0, !f_heartbeat[0] || (f_left0 + since_q[0] == 21'(Pulse) && f_left0 != 0), "-")
  `MMCS_LEMMA(Left1, !f_heartbeat[1] || (f_left1 + since_q[1] == 21'(Pulse) && f_left1 != 0), "-")
  `MMCS_LEMMA(Left2, !f_heartbeat[2] || (f_left2 + since_q[2] == 21'(Pulse) && f_left2 != 0), "-")
  `MMCS_LEMMA(Left3, !f_heartbeat[3] || (f_left3 + since_q[3] == 21'(Pulse) && f_left3 != 0), "-")
  `MMCS_LEMMA(Line, (f_line != 2'd0) == (dead_q[1] && f_power && power2_q), "-")

endmodule

`default_nettype wire
