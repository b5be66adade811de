// SPDX-License-Identifier: Apache-2.0
// PANIC of the whole machine with two cards. §2.3.4, §4.3.5, §5.3.6
//
// The front on the VMEbus, timers, PPIs, encoder counters, converters and relays are cut out: what
// they do is free. What is left is the PC bus, decoders, heartbeats, wiring and PANIC.
// The heartbeat has its real 50 ms in the proof (400,000 clocks) and 32 clocks in the covers.
`default_nettype none
`include "mmcs_formal.svh"

module panic_system_props #(
  parameter int HeartbeatUs = 50_000
) (
  input wire logic       clk_i,
  input wire logic       estop_closed_i,
  input wire logic       cable_ok_i,
  input wire logic       pc_power_i,
  input wire logic [3:0] axis_enable_i,
  input wire logic       sysreset_ni
);

  localparam int Pulse = 8 * HeartbeatUs;

  logic rst_ni = 1'b0;
  always @(posedge clk_i) rst_ni <= 1'b1;

  logic panic, brake, iow_n, ior_n;
  logic [15:0] pc_a;

  mmcs #(
    .NumCards(2),
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
    .pcx_d_i('0), .pcx_d_oe_i(1'b0), .pcx_wait_i(1'b0), .pcx_irq_i('0)
  );

  // Wires of the inside, joined by the script.
  logic [ 3:0] f_heartbeat, f_enable, f_trigger;   // card 1 axis 2 ... card 0 axis 1
  logic [ 1:0] f_line;
  logic [20:0] f_left0, f_left1, f_left2, f_left3;
  logic        f_power;
  logic [ 5:0] f_sync;   // {button, cable, power} in the synchroniser's two stages

  // --- button, cable and power as they were two clocks ago ------------------------------------

  logic [2:0] safe0_q = '1, safe1_q = '1;
  always @(posedge clk_i) begin
    if (rst_ni) begin
      safe0_q <= {estop_closed_i, cable_ok_i, pc_power_i};
      safe1_q <= safe0_q;
    end
  end

  // --- clocks since the low byte of each D/A was last written --------------------------------

  logic [3:0] write, write_q = '0;
  logic [20:0] since_q[4];
  logic [3:0] late, expired;
  for (genvar n = 0; n < 4; n++) begin : g_axis
    localparam logic [15:0] Address = {2'b00, 4'(n / 2), 5'b11000, 5'(8 + 2 * (n % 2))};
    assign write[n] = !iow_n && pc_a == Address && safe1_q[0];
    always @(posedge clk_i) begin
      if (!rst_ni) begin
        since_q[n] <= 21'h1FFFFF;
      end else begin
        write_q[n] <= write[n];
        if (write[n] && !write_q[n]) since_q[n] <= '0;
        else if (since_q[n] != '1) since_q[n] <= since_q[n] + 1'b1;
      end
    end
    assign late[n] = since_q[n] >= 21'(Pulse);         // 50 ms have passed
    assign expired[n] = since_q[n] >= 21'(Pulse + 3);  // and three clocks
  end

  // Written since power came: the one-shots are held cleared without it.
  logic [3:0] written_q = '0;
  always @(posedge clk_i) begin
    if (rst_ni) begin
      if (!safe1_q[0]) written_q <= '0;
      else written_q <= written_q | (write & ~write_q);
    end
  end

  // --- what should be -------------------------------------------------------------------------

  // The PC bus as it was three clocks ago, the rest a clock ago; of that three clocks at once.
  logic [3:0] enable_q = '0, late_q = '0, beat_q = '0;
  logic [3:0] enable1_q = '0, late1_q = '0, beat1_q = '0;
  logic [3:0] enable2_q = '0, late2_q = '0, beat2_q = '0;
  logic [2:0] safe_q = '0, fresh_q = '0;
  always @(posedge clk_i) begin
    if (rst_ni) begin
      {enable_q, enable2_q, enable1_q} <= {enable2_q, enable1_q, f_enable};
      {late_q, late2_q, late1_q}       <= {late2_q, late1_q, late};
      {beat_q, beat2_q, beat1_q}       <= {beat2_q, beat1_q, f_heartbeat};
      safe_q  <= {safe_q[1:0], &safe1_q};
      fresh_q <= {fresh_q[1:0], 1'b1};
    end
  end

  `MMCS_PROVE(LowMeansGood, "4.3.5", !panic && (&fresh_q),
              (&safe_q) && (enable_q & ~beat_q) == 4'd0,
          "PANIC is low only if all enabled axes beat; button, cable and power are good")
  `MMCS_PROVE(GoodMeansLow, "4.3.5",
              (&safe_q) && (enable_q & ~beat_q) == 4'd0 && (&fresh_q), !panic,
              "and it is low if they are: nothing else panics")
  `MMCS_PROVE(BeatExact, "5.3.6", f_heartbeat != 4'd0, (f_heartbeat & late) == 4'd0,
              "a heartbeat lives 50 ms from the last write of the D/A low byte, not a clock longer")
  `MMCS_PROVE(BeatLives, "5.3.6", safe1_q[0] && written_q == 4'hF && ~late != 4'd0,
              (f_heartbeat | late) == 4'hF,
              "and not a clock shorter, power given")
  `MMCS_PROVE(PanicIn50ms, "5.3.6", (enable_q & expired) != 4'd0 && (&fresh_q), panic,
              "50 ms after an enabled D/A's last low-byte write PANIC is high in three clocks")
  `MMCS_PROVE(BrakesHold, "4.2.1", panic, !brake, "no brake is released while PANIC is high")
  `MMCS_REACH(Released, brake && (&enable_q), "all four axes beat and the brakes are released")
  `MMCS_REACH(RunsOut, panic && safe_q[0] && (&enable_q) && late_q == 4'b0001 && beat_q == 4'b1110,
              "one heartbeat of four runs out")

  // --- steps of the induction -----------------------------------------------------------------

  `MMCS_LEMMA(Trigger, f_trigger == (f_power ? write_q : 4'd0) || !f_power, "-")
  `MMCS_LEMMA(Written, !f_power || (written_q & (f_heartbeat ^ ~late)) == 4'd0, "-")
  `MMCS_LEMMA(Safe, {safe1_q, safe0_q} == f_sync, "-")
  `MMCS_LEMMA(IoSpace, pc_a[15:14] == 2'b00, "-")
  `MMCS_LEMMA(Power, f_power == safe1_q[0], "-")
  `MMCS_LEMMA(Left0, !f_heartbeat[0] || (f_left0 + since_q[0] == 21'(Pulse) && f_left0 != 0), "-")
  `MMCS_LEMMA(Left1, !f_heartbeat[1] || (f_left1 + since_q[1] == 21'(Pulse) && f_left1 != 0), "-")
  `MMCS_LEMMA(Left2, !f_heartbeat[2] || (f_left2 + since_q[2] == 21'(Pulse) && f_left2 != 0), "-")
  `MMCS_LEMMA(Left3, !f_heartbeat[3] || (f_left3 + since_q[3] == 21'(Pulse) && f_left3 != 0), "-")
  `MMCS_LEMMA(Line0, f_line[0] == (|(f_enable[1:0] & ~f_heartbeat[1:0]) & f_power),
              "-")
  `MMCS_LEMMA(Line1, f_line[1] == (|(f_enable[3:2] & ~f_heartbeat[3:2]) & f_power),
              "-")

endmodule

`default_nettype wire
