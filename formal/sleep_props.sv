// SPDX-License-Identifier: Apache-2.0
// A card that sleeps to save simulation time misses nothing. §5.3
`default_nettype none
`include "mmcs_formal.svh"

module sleep_props (
  input wire logic        clk_i,
  input wire logic [15:1] vme_a_i,
  input wire logic [ 5:0] vme_am_i,
  input wire logic        vme_as_ni,
  input wire logic [ 1:0] vme_ds_ni,
  input wire logic        vme_write_ni,
  input wire logic        vme_lword_ni,
  input wire logic [15:0] vme_d_i,
  input wire logic        vme_iack_ni,
  input wire logic        vme_iackin_ni,
  input wire logic        vme_sysreset_ni,
  input wire logic        cable_ok_i,
  input wire logic        pc_power_i,
  input wire logic [ 1:0] enc_a_i,
  input wire logic [ 1:0] enc_b_i,
  input wire logic [ 1:0] enc_i_i,
  input wire logic [ 1:0] axis_enable_i,
  input wire logic [31:0] adc_v_i,
  input wire logic        card_absent_i,
  input wire logic        sclock_open_i,
  input wire logic        panic_open_i,
  input wire logic [23:0] dac_stuck1_i,
  input wire logic [23:0] dac_stuck0_i,
  input wire logic [ 1:0] adc_stuck_i
);

  logic rst_ni = 1'b0;
  always @(posedge clk_i) rst_ni <= 1'b1;

  logic [31:0] drive_v;
  logic [10:0] leds;
  mmcs #(.NumCards(1)) dut (
    .clk_i, .rst_ni, .vme_a_i, .vme_am_i, .vme_as_ni, .vme_ds_ni, .vme_write_ni, .vme_lword_ni,
    .vme_d_i, .vme_d_o(), .vme_d_oe_o(), .vme_dtack_no(), .vme_iack_ni, .vme_iackin_ni,
    .vme_iackout_no(), .vme_irq_no(), .vme_sysreset_ni, .estop_closed_i(1'b1), .cable_ok_i,
    .pc_power_i, .brake_release_o(), .panic_o(), .sclock_o(), .led_irq_o(), .enc_a_i, .enc_b_i,
    .enc_i_i, .axis_enable_i, .adc_v_i, .drive_v_o(drive_v), .card_leds_o(leds),
    .pcx_a_o(), .pcx_d_o(), .pcx_ior_no(), .pcx_iow_no(), .pcx_aen_o(), .pcx_clk_en_o(),
    .pcx_reset_drv_o(), .pcx_drq_o(), .pcx_d_i(8'hFF), .pcx_d_oe_i(1'b0), .pcx_wait_i(1'b0),
    .pcx_irq_i(5'd0), .card_absent_i, .dip_xor_i(4'h0), .sclock_open_i, .panic_open_i,
    .dac_stuck1_i, .dac_stuck0_i, .adc_stuck_i, .irq_lost_i(1'b0), .clk_adaptor_i(1'b0),
    .clk_cards_i(1'b0), .adaptor_awake_o(), .cards_awake_o(), .skip_extra_i(16'd0),
    .skip_horizon_o()
  );

  // Wires of these names are joined to those of the design when the hierarchy is flattened.
  (* hierconn *) wire [2:0] \dut.settle_q ;
  (* hierconn *) wire \dut.pc_power , \dut.g_card[0].u_card.asleep ;
  (* hierconn *) wire \dut.absent_q , \dut.panic_open_q ;
  (* hierconn *) wire [1:0] \dut.axis_enable_q , \dut.enc_a_q , \dut.enc_b_q , \dut.enc_i_q ;
  (* hierconn *) wire [23:0] \dut.dac_stuck1_q , \dut.dac_stuck0_q ;
  (* hierconn *) wire [7:0] \dut.g_card[0].u_card.pa , \dut.g_card[0].u_card.pb ;
  (* hierconn *) wire \dut.g_card[0].u_card.shakes , \dut.g_card[0].u_card.relay_drive ;
  (* hierconn *) wire \dut.g_card[0].u_card.panic_q , \dut.g_card[0].u_card.reset ;
  (* hierconn *) wire [1:0] \dut.g_card[0].u_card.heartbeat ;
  (* hierconn *) wire [5:0] \dut.g_card[0].u_card.timers , \dut.g_card[0].u_card.timers_q ;
  (* hierconn *) wire [10:0] \dut.g_card[0].u_card.leds_q ;
  (* hierconn *) wire \dut.g_card[0].u_card.u_ppi.rd_q , \dut.g_card[0].u_card.u_ppi.wr_q ;
  (* hierconn *) wire [2:0] \dut.g_card[0].u_card.g_axis[0].u_axis.index_sync_q ;
  (* hierconn *) wire \dut.g_card[0].u_card.g_axis[0].u_axis.armed_index_q ;
  (* hierconn *) wire \dut.g_card[0].u_card.g_axis[0].u_axis.index_latch_q ;
  (* hierconn *) wire [15:0] \dut.g_card[0].u_card.g_axis[0].u_axis.drive_q ;
  (* hierconn *) wire [11:0] \dut.g_card[0].u_card.g_axis[0].u_axis.dac_chip ;
  (* hierconn *) wire [11:0] \dut.g_card[0].u_card.g_axis[0].u_axis.adc_q ;
  (* hierconn *) wire [11:0] \dut.g_card[0].u_card.g_axis[0].u_axis.u_adc.code_q ;
  (* hierconn *) wire \dut.g_card[0].u_card.g_axis[0].u_axis.u_adc.busy_q ;
  (* hierconn *) wire [1:0] \dut.g_card[0].u_card.g_axis[0].u_axis.u_encoder.s1_q ;
  (* hierconn *) wire [1:0] \dut.g_card[0].u_card.g_axis[0].u_axis.u_encoder.s2_q ;
  (* hierconn *) wire [1:0] \dut.g_card[0].u_card.g_axis[0].u_axis.u_encoder.prev_q ;
  (* hierconn *) wire \dut.g_card[0].u_card.g_axis[0].u_axis.u_encoder.rd_q ;
  (* hierconn *) wire \dut.g_card[0].u_card.g_axis[0].u_axis.u_encoder.wr_q ;
  (* hierconn *) wire \dut.g_card[0].u_card.g_axis[0].u_axis.u_encoder.latch_in_q ;

  logic [7:0] pa, pb;
  logic [2:0] t;
  logic asleep, power, settled, busy;
  assign pa      = \dut.g_card[0].u_card.pa ;
  assign pb      = \dut.g_card[0].u_card.pb ;
  assign t       = dut.settle_q;
  assign asleep  = \dut.g_card[0].u_card.asleep ;
  assign power   = dut.pc_power;
  assign settled = \dut.g_card[0].u_card.timers == \dut.g_card[0].u_card.timers_q ;
  assign busy    = \dut.g_card[0].u_card.g_axis[0].u_axis.u_adc.busy_q ;

  // What joint 1 sees when the card is awake: the joint, or port A; and when its pins last moved.
  logic [2:0] now, last;  // A, B, index
  assign now  = pb[0] ? {enc_a_i[0], enc_b_i[0], enc_i_i[0]} : {pa[5], pa[6], pa[7]};
  assign last = pb[0] ? {dut.enc_a_q[0], dut.enc_b_q[0], dut.enc_i_q[0]}
                      : {pa[5], pa[6], pa[7]};

  // What the outputs are when the card is awake.
  logic [11:0] code;
  logic [15:0] volts;
  logic panic;
  logic [10:0] lights, last_lights;
  assign code  = (\dut.g_card[0].u_card.g_axis[0].u_axis.dac_chip | dut.dac_stuck1_q[11:0]) &
                 ~dut.dac_stuck0_q[11:0];
  assign volts = \dut.g_card[0].u_card.relay_drive && power && dut.axis_enable_q[0] &&
                 !dut.absent_q ? {~code[11], code[10:0], 4'h0} : 16'd0;
  assign panic = |(dut.axis_enable_q & ~\dut.g_card[0].u_card.heartbeat ) && power &&
                 !dut.absent_q && !dut.panic_open_q;
  assign lights = {1'b1, pa[4], pa[3], \dut.g_card[0].u_card.heartbeat , enc_i_i[1], enc_b_i[1],
                   enc_a_i[1], enc_i_i[0], enc_b_i[0], enc_a_i[0]} & {11{!dut.absent_q}};
  assign last_lights = {1'b1, pa[4], pa[3], \dut.g_card[0].u_card.heartbeat , dut.enc_i_q[1],
                        dut.enc_b_q[1], dut.enc_a_q[1], dut.enc_i_q[0], dut.enc_b_q[0],
                        dut.enc_a_q[0]} & {11{!dut.absent_q}};

  (* hierconn *) wire \dut.g_card[0].u_card.u_latch.sclock_q , \dut.sclock_open_q ;
  (* hierconn *) wire \dut.g_card[0].u_card.u_latch.sw_latch_q ;
  (* hierconn *) wire [3:1] \dut.drq_q ;

  // Short names.
  logic sclock_q, sw_q;
  assign sclock_q = \dut.g_card[0].u_card.u_latch.sclock_q ;
  assign sw_q = \dut.g_card[0].u_card.u_latch.sw_latch_q ;
  logic [1:0] enc_s1_q, enc_s2_q, enc_prev_q;
  logic [2:0] index_sync_q;
  logic armed_index_q, index_latch_q, enc_rd_q, enc_wr_q, enc_latch_in_q, ppi_rd_q, ppi_wr_q;
  logic reset, panic_q;
  logic [11:0] adc_q, code_q;
  logic [15:0] drive_q;
  logic [10:0] leds_q;
  assign enc_s1_q = \dut.g_card[0].u_card.g_axis[0].u_axis.u_encoder.s1_q ;
  assign enc_s2_q = \dut.g_card[0].u_card.g_axis[0].u_axis.u_encoder.s2_q ;
  assign enc_prev_q = \dut.g_card[0].u_card.g_axis[0].u_axis.u_encoder.prev_q ;
  assign index_sync_q = \dut.g_card[0].u_card.g_axis[0].u_axis.index_sync_q ;
  assign armed_index_q = \dut.g_card[0].u_card.g_axis[0].u_axis.armed_index_q ;
  assign index_latch_q = \dut.g_card[0].u_card.g_axis[0].u_axis.index_latch_q ;
  assign enc_rd_q = \dut.g_card[0].u_card.g_axis[0].u_axis.u_encoder.rd_q ;
  assign enc_wr_q = \dut.g_card[0].u_card.g_axis[0].u_axis.u_encoder.wr_q ;
  assign enc_latch_in_q = \dut.g_card[0].u_card.g_axis[0].u_axis.u_encoder.latch_in_q ;
  assign ppi_rd_q = \dut.g_card[0].u_card.u_ppi.rd_q ;
  assign ppi_wr_q = \dut.g_card[0].u_card.u_ppi.wr_q ;
  assign reset = \dut.g_card[0].u_card.reset ;
  assign adc_q = \dut.g_card[0].u_card.g_axis[0].u_axis.adc_q ;
  assign code_q = \dut.g_card[0].u_card.g_axis[0].u_axis.u_adc.code_q ;
  assign panic_q = \dut.g_card[0].u_card.panic_q ;
  assign drive_q = \dut.g_card[0].u_card.g_axis[0].u_axis.drive_q ;
  assign leds_q = \dut.g_card[0].u_card.leds_q ;

  `MMCS_PROVE(Encoder, "5.3.2", asleep,
              {enc_s1_q, enc_s2_q, enc_prev_q} == {3{now[2:1]}},
              "no edge of A or B is on its way into the counter of a card that sleeps")
  `MMCS_PROVE(Index, "5.3.2", asleep, index_sync_q == {3{now[0]}} &&
              armed_index_q == (now[0] && pb[4]) && (!index_latch_q || pb[4]),
              "nor an index, nor an index latch that is to be cleared")
  `MMCS_PROVE(NoAccess, "5.3.1", asleep,
              {enc_rd_q, enc_wr_q, enc_latch_in_q, ppi_rd_q, ppi_wr_q, reset} == 6'd0 &&
              pa[2:0] != 3'd6,
              "no access, latch or reset is under way, and the counter counts no time")
  `MMCS_PROVE(Drive, "5.3.3", asleep, drive_v[15:0] == volts, "the D/A stands as if awake")
  `MMCS_PROVE(Result, "5.3.4", asleep && !busy, adc_q == code_q,
              "the result of the last conversion has been taken")
  `MMCS_PROVE(Panics, "5.3.6", asleep, panic_q == panic, "PANIC stands as if awake")
  `MMCS_PROVE(Lights, "5.3.1", asleep, leds == lights, "the lights stand as if awake")

  `MMCS_LEMMA(Idle, t == 3'd7 || !power || {enc_rd_q, enc_wr_q, ppi_rd_q, ppi_wr_q} == 4'd0,
              "the bus comes to rest first")
  `MMCS_LEMMA(Sclock, t == 3'd7 || !power ||
              (sclock_q == (dut.drq_q[3] && !dut.sclock_open_q) && !sw_q), "and the latch signals")
  `MMCS_LEMMA(Latch, t > 3'd1 || !power || !enc_latch_in_q, "and last the latch of the counter")
  `MMCS_LEMMA(First, t > 3'd5 || !power || (enc_s1_q == last[2:1] &&
              index_sync_q[0] == last[0]), "then the first flip-flops")
  `MMCS_LEMMA(Second, t > 3'd4 || !power || (enc_s2_q == last[2:1] &&
              index_sync_q[1] == last[0]), "then the second")
  `MMCS_LEMMA(Third, t > 3'd3 || !power || (enc_prev_q == last[2:1] &&
              index_sync_q[2] == last[0]), "then the third")
  `MMCS_LEMMA(Fourth, t > 3'd2 || !power || (armed_index_q == (last[0] && pb[4]) &&
              (!index_latch_q || pb[4])), "then the index latch")
  `MMCS_LEMMA(Outputs, t > 3'd5 || !power || !settled ||
              (drive_q == volts && panic_q == panic && (busy || adc_q == code_q) &&
               leds_q == last_lights), "and the outputs, but for a timer")

endmodule

`default_nettype wire
