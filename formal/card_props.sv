// SPDX-License-Identifier: Apache-2.0
// A card from its pins to its pins: what each bit of port B, each switch, the latch and the
// heartbeat do at the joints, on the PC bus and on PANIC. Table 5.1, §5.3.2-5.3.6, §5.4.1
//
// Times are the real ones, at 8 and 16 MHz; counter-examples and covers have short ones.
//
// Told, not mended: a latch in the very clock in which a conversion ends hides that sample; reads
// go on giving the one before it (`known`).
`default_nettype none
`include "mmcs_formal.svh"

module card_props #(
  parameter int ClkHz = 8_000_000,
  parameter int HeartbeatUs = 50_000,
  parameter int RelayUs = 1_000,
  parameter int AdcConvNs = 25_000,
  parameter bit Steps = 1'b1        // the steps of the induction are proved too
) (
  input wire logic        clk_i,
  input wire logic        clk_en_i,
  input wire logic        reset_drv_i,
  input wire logic        power_i,
  input wire logic [15:0] a_i,
  input wire logic        aen_i,
  input wire logic        ior_ni,
  input wire logic        iow_ni,
  input wire logic [ 7:0] d_i,
  input wire logic [ 3:1] drq_i,
  input wire logic [ 3:0] dip_i,
  input wire logic [ 1:0] axis_enable_i,
  input wire logic [ 1:0] enc_a_i,
  input wire logic [ 1:0] enc_b_i,
  input wire logic [ 1:0] enc_i_i,
  input wire logic [31:0] adc_v_i
);

  localparam int ClkMHz = ClkHz / 1_000_000;
  localparam int Beat = HeartbeatUs * ClkMHz;
  localparam int Settle = RelayUs * ClkMHz;
  localparam int Conv = (AdcConvNs * ClkMHz + 999) / 1000;
  localparam int BeatWidth = $clog2(Beat + 1);
  localparam int SettleWidth = $clog2(Settle + 1);
  localparam int ConvWidth = $clog2(Conv + 1);

  // Three clocks of reset: the switches' flip-flops have none and follow the pins.
  logic [2:0] reset_q = '0;
  logic rst_ni;
  always @(posedge clk_i) reset_q <= {reset_q[1:0], 1'b1};
  assign rst_ni = reset_q[2];

  logic [7:0] d;
  logic d_oe;
  logic [7:3] irq;
  logic [31:0] drive_v;
  logic [10:0] leds;

  mark1 #(
    .ClkHz(ClkHz),
    .HeartbeatUs(HeartbeatUs),
    .RelayUs(RelayUs),
    .AdcConvNs(AdcConvNs)
  ) dut (
    .clk_i, .rst_ni,
    .pc_clk_en_i(clk_en_i),
    .pc_reset_drv_i(reset_drv_i),
    .pc_a_i(a_i),
    .pc_aen_i(aen_i),
    .pc_ior_ni(ior_ni),
    .pc_iow_ni(iow_ni),
    .pc_d_i(d_i),
    .pc_d_o(d),
    .pc_d_oe_o(d_oe),
    .pc_drq_i(drq_i),
    .pc_irq_o(irq),
    .dip_i, .axis_enable_i, .power_i, .enc_a_i, .enc_b_i, .enc_i_i, .adc_v_i,
    .drive_v_o(drive_v),
    .leds_o(leds)
  );

  // --- the bus, and what a command is for ---------------------------------------------------

  logic rst_n;   // without power all is in reset
  assign rst_n = rst_ni & power_i;

  logic iow_was, command, command_was;
  logic [7:0] d_was;
  logic [20:0] address, address_was;
  assign command = ~(ior_ni & iow_ni);
  assign address = {a_i, aen_i, dip_i};
  always @(posedge clk_i) begin
    iow_was     <= rst_ni && !iow_ni;
    command_was <= rst_ni && command;
    d_was       <= d_i;
    address_was <= address;
  end

  `MMCS_GIVEN(OneCommand, ior_ni || iow_ni, "IOR# and IOW# are never low together")
  `MMCS_GIVEN(AddressFirst, !(command || command_was) || address == address_was,
              "the address stands a clock before a command, through it and a clock after it")
  `MMCS_GIVEN(DataHolds, !iow_was || !iow_ni || d_i == d_was,
              "write data stands a clock past the end of IOW#")

  logic board, ours;
  assign board = command && power_i && !aen_i && a_i[9:5] == 5'b11000;
  assign ours = board && a_i[13:10] == dip_i;

  // Writes: those of the D/A act while IOW# is low, those of the PPI when it ends.
  logic [1:0] low_byte, high_byte;
  logic ppi_write, ppi_write_was, ppi_ends;
  for (genvar j = 0; j < 2; j++) begin : g_write
    assign low_byte[j] = ours && !iow_ni && a_i[4:0] == 5'(8 + 2 * j);
    assign high_byte[j] = ours && !iow_ni && a_i[4:0] == 5'(9 + 2 * j);
  end
  assign ppi_write = ours && !iow_ni && a_i[4:2] == 3'd0;
  assign ppi_ends = ppi_write_was && !ppi_write;

  // --- port B and the mode word as they were written ----------------------------------------

  logic [6:0] mode_q;
  logic [7:0] port_b_q, b;
  always @(posedge clk_i or negedge rst_n) begin
    if (!rst_n) begin
      ppi_write_was <= 1'b0;
      mode_q        <= 7'h1B;
      port_b_q      <= '0;
    end else begin
      ppi_write_was <= ppi_write && !reset_drv_i;
      if (reset_drv_i || (ppi_ends && a_i[1:0] == 2'd3 && d_i[7])) begin
        mode_q   <= reset_drv_i ? 7'h1B : d_i[6:0];
        port_b_q <= '0;
      end else if (ppi_ends && a_i[1:0] == 2'd1) begin
        port_b_q <= d_i;
      end
    end
  end
  assign b = mode_q[1] ? 8'h00 : port_b_q;   // while it is an input the board sees 0

  // --- the latch signal ---------------------------------------------------------------------

  logic sclock_was, pressed_was, pressed, latched, latched_was;
  assign pressed = (ours && a_i[4:0] == 5'h10) || (board && a_i[4:0] == 5'h12);
  assign latched = (drq_i[3] && !sclock_was && b[2]) || (pressed && !pressed_was);
  always @(posedge clk_i or negedge rst_n) begin
    if (!rst_n) {sclock_was, pressed_was, latched_was} <= 3'b100;
    else {sclock_was, pressed_was, latched_was} <= {drq_i[3], pressed, latched};
  end

  // --- switches, relay ----------------------------------------------------------------------

  logic [1:0] switch_q, enabled;   // a switch passes two flip-flops
  always @(posedge clk_i) {enabled, switch_q} <= {switch_q, axis_enable_i};

  // Clocks that B1 has stood before this one, up to the time of the relay.
  logic b1_was, settled;
  logic [SettleWidth-1:0] stood, stood_q;
  assign stood = b[1] == b1_was ? stood_q : '0;
  assign settled = stood == SettleWidth'(Settle);
  always @(posedge clk_i or negedge rst_n) begin
    if (!rst_n) begin
      b1_was  <= 1'b0;
      stood_q <= '0;
    end else begin
      b1_was  <= b[1];
      stood_q <= settled ? stood : stood + 1'b1;
    end
  end

  // --- the D/As: what was written, and what of it has reached the output ---------------------

  logic [11:0] written[2], written_q[2], output_q[2];
  logic [15:0] volts[2], drive[2];
  logic to_outputs;
  assign to_outputs = latched && b[3];
  for (genvar j = 0; j < 2; j++) begin : g_dac
    assign written[j] = low_byte[j] ? {written_q[j][11:8], d_i}
                      : high_byte[j] ? {d_i[3:0], written_q[j][7:0]} : written_q[j];
    always @(posedge clk_i or negedge rst_n) begin
      if (!rst_n) begin
        {written_q[j], output_q[j]} <= {12'h800, 12'h800};
      end else begin
        written_q[j] <= written[j];
        if (to_outputs || (high_byte[j] && !b[3])) output_q[j] <= written[j];
      end
    end
    assign volts[j] = (16'(output_q[j]) - 16'd2048) << 4;   // 32768 for 10 V
    assign drive[j] = drive_v[16*j+:16];
  end

  // --- the A/Ds: the code nearest to what B1 connects them to --------------------------------

  logic converting_q;
  logic [ConvWidth-1:0] converted_q;      // clocks of the conversion under way, without the first
  logic [11:0] nearest[2], next_q[2], code_q[2];
  logic ended_q;                          // it ended in the clock before
  logic known_next_q, known_q, known;     // the relay stood when it was begun
  // A latch in the very clock in which the last conversion has ended: nobody saw its code.
  assign known = known_q && !(ended_q && latched);
  for (genvar j = 0; j < 2; j++) begin : g_adc
    logic [16:0] level;
    assign level = 17'(adc_v_i[16*j+:16] ^ 16'h8000) + 17'd8;   // from 0 on, and half a step
    assign nearest[j] = !b[1] ? output_q[j] : level[16] ? 12'hFFF : level[15:4];
    always @(posedge clk_i or negedge rst_n) begin
      if (!rst_n) begin
        {code_q[j], next_q[j]} <= '0;
      end else begin
        if (!converting_q && latched && !latched_was) next_q[j] <= nearest[j];
        if (converting_q && converted_q == ConvWidth'(Conv - 1)) code_q[j] <= next_q[j];
      end
    end
  end
  always @(posedge clk_i or negedge rst_n) begin
    if (!rst_n) begin
      converting_q <= 1'b0;
      converted_q  <= '0;
      ended_q      <= 1'b0;
      known_next_q <= 1'b0;
      known_q      <= 1'b1;
    end else if (converting_q) begin
      converting_q <= converted_q != ConvWidth'(Conv - 1);
      converted_q  <= converted_q + 1'b1;
      ended_q      <= converted_q == ConvWidth'(Conv - 1);
      if (converted_q == ConvWidth'(Conv - 1)) known_q <= known_next_q;
    end else begin
      converting_q <= latched && !latched_was;
      converted_q  <= '0;
      ended_q      <= 1'b0;
      known_next_q <= settled;
      known_q      <= known;
    end
  end

  // --- heartbeats: clocks since the low byte was written --------------------------------------

  logic [BeatWidth-1:0] since_q[2];
  logic [1:0] low_was, beats;
  for (genvar j = 0; j < 2; j++) begin : g_beat
    always @(posedge clk_i or negedge rst_n) begin
      if (!rst_n) begin
        low_was[j] <= 1'b0;
        since_q[j] <= BeatWidth'(Beat);
      end else begin
        low_was[j] <= low_byte[j];
        if (low_byte[j] && !low_was[j]) since_q[j] <= '0;
        else if (!beats[j]) since_q[j] <= since_q[j];
        else since_q[j] <= since_q[j] + 1'b1;
      end
    end
    assign beats[j] = since_q[j] < BeatWidth'(Beat);
  end

  // --- properties -----------------------------------------------------------------------------

  logic dead, reads, reads_c;
  logic [1:0] grounded, driven;
  logic [7:0] low_code;
  assign dead = |(enabled & ~beats);
  logic [2:0] dead_q = '0, alive_q = '0;   // in the last clocks
  always @(posedge clk_i) begin
    dead_q  <= {dead_q[1:0], rst_n && dead};
    alive_q <= {alive_q[1:0], !rst_n || !dead};
  end
  assign grounded = {drive[1] == 16'h0000, drive[0] == 16'h0000};
  assign driven = {drive[1] == volts[1], drive[0] == volts[0]};
  assign low_code = a_i[0] ? code_q[1][7:0] : code_q[0][7:0];
  assign reads = ours && !ior_ni;
  // Port C as Table 5.1 wants it: an input, mode 0 everywhere.
  assign reads_c = reads && a_i[4:0] == 5'h02 && {mode_q[6:5], mode_q[3:2], mode_q[0]} == 5'b00101;

  `MMCS_PROVE(DeadPanics, "5.3.6", dead && &dead_q && power_i, irq == 5'b10000,
              "an enabled axis whose D/A was not written in time asserts PANIC")
  `MMCS_PROVE(NothingElsePanics, "5.4.1", (!dead && &alive_q) || !power_i, irq == 5'b00000,
              "nothing else does; the heartbeat of an axis that is switched off is ignored")
  `MMCS_PROVE(BeatsShown, "5.3.6", reads_c, {d[2], d[0]} == beats && leds[7:6] == beats,
              "port C bits 0 and 2 and the lights show both heartbeats")
  `MMCS_PROVE(SwitchedOff, "5.4.1", enabled != 2'b11, (grounded | enabled) == 2'b11,
              "the drive of an axis that is switched off is at ground")
  `MMCS_PROVE(Isolated, "5.3.5", !b[1], grounded == 2'b11,
              "B1 = 0: no joint gets a voltage, at once")
  `MMCS_PROVE(Driven, "Table 5.1", b[1] && settled, (driven | ~enabled) == 2'b11,
              "B1 = 1 for the time of the relay: each joint that is switched on gets its D/A")
  `MMCS_PROVE(NothingElse, "5.3.3", grounded != 2'b11, (driven | grounded) == 2'b11,
              "and at no time anything but its D/A: by B3 as the high byte or the latch left it")
  `MMCS_PROVE(Converted, "5.3.4", reads && known && a_i[4:1] == 4'h6, d == low_code,
              "an A/D reads the sample of the last latch: by B1 its joint's, or that of its D/A")
  `MMCS_PROVE(ConvertedHigh, "5.3.4", reads && known && a_i[4:0] == 5'h0E,
              d == {code_q[1][11:8], code_q[0][11:8]}, "its high four bits too")
  `MMCS_PROVE(DoneShown, "Table 5.1", reads_c, d[4] == !converting_q,
              "port C bit 4 is low while the A/Ds convert: begun by SCLOCK only with B2 = 1")
  `MMCS_PROVE(Dark, "5.3.1", !power_i, drive_v == '0 && leds == '0 && !irq,
              "a card without power drives no joint, no interrupt and no light")
  `MMCS_PROVE(Drives, "5.3.1", 1'b1, d_oe == (reads && (a_i[4:3] == 2'b00 ||
              a_i[4:0] == 5'h0C || a_i[4:0] == 5'h0D || a_i[4:0] == 5'h0E)),
              "the card drives the bus in a read of a register that can be read, given power, only")

  `MMCS_REACH(LoopedBack, reads && a_i[4:0] == 5'h0C && known_q && d == 8'hA5 && !b[1],
              "a D/A is read back through its A/D")
  `MMCS_REACH(AllBeat, enabled == 2'b11 && beats == 2'b11 && drive[0] == 16'h5A50 && !irq[7],
              "both axes beat and are driven")

  // --- steps of the induction -------------------------------------------------------------------

  // Wires of these names are joined to those of the design when the hierarchy is flattened.
  (* hierconn *) wire [6:0] \dut.u_ppi.mode_q ;
  (* hierconn *) wire [7:0] \dut.u_ppi.pb_q , \dut.u_ppi.d_q ;
  (* hierconn *) wire [1:0] \dut.u_ppi.a_q ;
  (* hierconn *) wire \dut.u_ppi.wr_q ;
  (* hierconn *) wire \dut.u_latch.sclock_q , \dut.u_latch.sw_latch_q , \dut.u_relay.joint_q ;
  (* hierconn *) wire [SettleWidth-1:0] \dut.u_relay.left_q ;
  (* hierconn *) wire [1:0] \dut.u_axis_enable.first_q , \dut.u_axis_enable.second_q ;
  (* hierconn *) wire [11:0] \dut.g_axis[0].u_axis.u_dac.rank1_q ;
  (* hierconn *) wire [11:0] \dut.g_axis[0].u_axis.u_dac.rank2_q ;
  (* hierconn *) wire [11:0] \dut.g_axis[0].u_axis.u_adc.code_q ;
  (* hierconn *) wire [11:0] \dut.g_axis[0].u_axis.u_adc.next_q ;
  (* hierconn *) wire [11:0] \dut.g_axis[0].u_axis.adc_code_q ;
  (* hierconn *) wire [ConvWidth-1:0] \dut.g_axis[0].u_axis.u_adc.left_q ;
  (* hierconn *) wire [BeatWidth-1:0] \dut.g_axis[0].u_axis.u_heartbeat.left_q ;
  (* hierconn *) wire \dut.g_axis[0].u_axis.u_adc.start_q , \dut.g_axis[0].u_axis.u_adc.busy_q ;
  (* hierconn *) wire \dut.g_axis[0].u_axis.u_heartbeat.trig_q ;
  (* hierconn *) wire \dut.g_axis[0].u_axis.u_heartbeat.run_q ;
  (* hierconn *) wire [11:0] \dut.g_axis[1].u_axis.u_dac.rank1_q ;
  (* hierconn *) wire [11:0] \dut.g_axis[1].u_axis.u_dac.rank2_q ;
  (* hierconn *) wire [11:0] \dut.g_axis[1].u_axis.u_adc.code_q ;
  (* hierconn *) wire [11:0] \dut.g_axis[1].u_axis.u_adc.next_q ;
  (* hierconn *) wire [11:0] \dut.g_axis[1].u_axis.adc_code_q ;
  (* hierconn *) wire [ConvWidth-1:0] \dut.g_axis[1].u_axis.u_adc.left_q ;
  (* hierconn *) wire [BeatWidth-1:0] \dut.g_axis[1].u_axis.u_heartbeat.left_q ;
  (* hierconn *) wire \dut.g_axis[1].u_axis.u_adc.start_q , \dut.g_axis[1].u_axis.u_adc.busy_q ;
  (* hierconn *) wire \dut.g_axis[1].u_axis.u_heartbeat.trig_q ;
  (* hierconn *) wire \dut.g_axis[1].u_axis.u_heartbeat.run_q ;

  `define AXIS(n) dut.g_axis[n].u_axis
  `define AXIS_LEMMAS(n) \
    `MMCS_LEMMA(Dac``n, `AXIS(n).u_dac.rank1_q == written_q[n] && \
                `AXIS(n).u_dac.rank2_q == output_q[n], "the D/A holds what was written") \
    `MMCS_LEMMA(Adc``n, `AXIS(n).u_adc.start_q == latched_was && \
                `AXIS(n).u_adc.busy_q == converting_q && (!converting_q || \
                `AXIS(n).u_adc.left_q == ConvWidth'(Conv) - converted_q), "the A/D converts") \
    `MMCS_LEMMA(Code``n, (!converting_q || !known_next_q || `AXIS(n).u_adc.next_q == next_q[n]) && \
                (!known_q || `AXIS(n).u_adc.code_q == code_q[n]) && \
                (ended_q || !known_q || `AXIS(n).adc_code_q == code_q[n]), "and shows its code") \
    `MMCS_LEMMA(Beat``n, `AXIS(n).u_heartbeat.trig_q == low_was[n] && \
                `AXIS(n).u_heartbeat.run_q == beats[n] && (!beats[n] || \
                `AXIS(n).u_heartbeat.left_q == BeatWidth'(Beat) - since_q[n]), "the one-shot")

  if (Steps) begin : g_steps
    `MMCS_LEMMA(Ppi, dut.u_ppi.mode_q == mode_q && dut.u_ppi.pb_q == port_b_q &&
                dut.u_ppi.wr_q == ppi_write_was &&
                (!ppi_write_was || (dut.u_ppi.a_q == address_was[6:5] && dut.u_ppi.d_q == d_was)),
                "the PPI holds what was written")
    `MMCS_LEMMA(Latch, dut.u_latch.sclock_q == sclock_was && dut.u_latch.sw_latch_q == pressed_was,
                "SCLOCK and the software latch a clock ago")
    `MMCS_LEMMA(Relay, dut.u_relay.joint_q == b[1] ?
                (stood == '0 || dut.u_relay.left_q == SettleWidth'(Settle)) :
                (dut.u_relay.left_q == SettleWidth'(Settle) - stood && !settled),
                "a relay that is to move counts the clocks")
    `MMCS_LEMMA(Switches, dut.u_axis_enable.first_q == switch_q &&
                dut.u_axis_enable.second_q == enabled,
                "switches pass two flip-flops")
    `AXIS_LEMMAS(0)
    `AXIS_LEMMAS(1)
  end

endmodule

`default_nettype wire
