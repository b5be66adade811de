// SPDX-License-Identifier: Apache-2.0
// The adaptor from the pins of the VMEbus to those of the PC bus and back: what is written is read,
// PANIC and SCLOCK interrupt, the vector comes, resets pass. §2.3.4, §4.3.2-4.3.8
//
// The timers are cut out: SCLOCK and what they read are free. The master is one that keeps the
// rules: it waits for DTACK*, or IACKOUT*.
`default_nettype none
`include "mmcs_formal.svh"

module adaptor_props #(
  parameter int ClkHz = 8_000_000
) (
  input wire logic        clk_i,
  // What the master does next
  input wire logic        start_i,
  input wire logic        iack_i,
  input wire logic [10:1] a_i,
  input wire logic        write_i,
  input wire logic [ 7:0] d_i,
  input wire logic        supervisor_i,
  input wire logic        sysreset_ni,
  // What is wrong, and the PC bus
  input wire logic        estop_closed_i,
  input wire logic        cable_ok_i,
  input wire logic        pc_power_i,
  input wire logic [ 7:0] pc_d_i,
  input wire logic        pc_wait_i,
  input wire logic [ 7:3] pc_irq_i
);

  localparam int ResetClks = 50 * (ClkHz / 1_000_000);
  localparam int ResetLeast = 31 * (ClkHz / 8_000_000);
  localparam int Width = $clog2(ResetClks + 1);

  `MMCS_RESET(1'b1)

  // --- the master ---------------------------------------------------------------------------

  typedef enum logic [1:0] {
    StIdle,
    StAddress,   // address, data
    StStrobe,    // AS* and DS0*, until it is answered or passed on
    StRelease    // waits for the end of DTACK*
  } state_e;

  logic [1:0] state_q = StIdle;
  logic iack_q = 1'b0, write_q = 1'b0, super_q = 1'b0;
  logic [10:1] a_q = '0;
  logic [7:0] d_q = '0;
  logic dtack_n, iackout_n, d_oe;
  logic [7:0] d;
  logic [7:1] irq_n;

  always @(posedge clk_i) begin
    if (rst_ni) begin
      case (state_q)
        StIdle: if (start_i && dtack_n && sysreset_ni) begin
          state_q <= StAddress;
          {iack_q, write_q} <= {iack_i, write_i && !iack_i};
          {super_q, a_q, d_q} <= {supervisor_i, a_i, d_i};
        end
        StAddress: state_q <= StStrobe;
        StStrobe: if (!dtack_n || !iackout_n) state_q <= StRelease;
        default: if (dtack_n && iackout_n) state_q <= StIdle;
      endcase
      if (!sysreset_ni) state_q <= StIdle;
    end
  end

  logic as_n, ds_n;
  logic strobe_q = 1'b0;         // a clock later the chain's driver has seen them
  assign as_n = state_q != StStrobe;
  assign ds_n = as_n;
  always @(posedge clk_i) strobe_q <= rst_ni && !as_n;

  logic panic, sclock, led_irq, reset_drv, power, ior_n, iow_n, pc_d_oe, clk_en;
  logic [15:0] pc_a;
  logic [7:0] pc_wdata;
  logic [3:1] drq;

  adaptor_vme #(
    .ClkHz(ClkHz)
  ) dut (
    .clk_i, .rst_ni,
    .vme_a_i({5'b01100, a_q}),
    .vme_am_i(super_q ? 6'h2D : 6'h29),
    .vme_as_ni(as_n),
    .vme_ds_ni({1'b1, ds_n}),
    .vme_write_ni(~write_q),
    .vme_lword_ni(1'b1),
    .vme_d_i(d_q),
    .vme_d_o(d),
    .vme_d_oe_o(d_oe),
    .vme_dtack_no(dtack_n),
    .vme_iack_ni(~iack_q),
    .vme_iackin_ni(~(iack_q & ~as_n & strobe_q)),
    .vme_iackout_no(iackout_n),
    .vme_irq_no(irq_n),
    .vme_sysreset_ni(sysreset_ni),
    .estop_closed_i, .cable_ok_i, .pc_power_i,
    .panic_o(panic),
    .sclock_o(sclock),
    .led_irq_o(led_irq),
    .pc_a_o(pc_a),
    .pc_d_o(pc_wdata),
    .pc_d_oe_o(pc_d_oe),
    .pc_ior_no(ior_n),
    .pc_iow_no(iow_n),
    .pc_clk_en_o(clk_en),
    .pc_reset_drv_o(reset_drv),
    .pc_drq_o(drq),
    .pc_power_o(power),
    .pc_d_i, .pc_wait_i, .pc_irq_i
  );

  // --- what was written, as the bus showed it -------------------------------------------------

  logic answered, to_pccsr, to_none, to_vector, to_pc;
  assign answered = state_q == StStrobe && !dtack_n;   // DTACK* has come
  assign to_pc = !a_q[10];
  assign to_vector = a_q[10] && a_q[6];
  assign to_pccsr = a_q[10] && !a_q[6] && a_q[5:3] == 3'b001;
  assign to_none = a_q[10] && !a_q[6] && a_q[5:4] != 2'b00;

  logic [7:0] csr_q = '0, vector_q = 8'h0F;
  logic known_q = 1'b1;
  logic changes;                 // a write of PCCSR or a reset is under way
  logic [5:0] down_q = '0;       // clocks of SYSRESET*
  logic [2:0] up_q = '0;         // and clocks without
  assign changes = (state_q == StStrobe && write_q && !iack_q && to_pccsr) || !(&up_q);
  always @(posedge clk_i) begin
    if (rst_ni) begin
      if (sysreset_ni) down_q <= '0;
      else if (down_q != '1) down_q <= down_q + 1'b1;
      if (!sysreset_ni) up_q <= '0;
      else if (up_q != '1) up_q <= up_q + 1'b1;
      if (!sysreset_ni) csr_q <= '0;
      else if (answered && write_q && to_pccsr) csr_q <= d_q;
      if (answered && write_q && to_vector) vector_q <= d_q;
      // A write that SYSRESET* breaks off may have been made or not.
      if (write_q && !iack_q && to_vector) known_q <= answered || (known_q && state_q != StStrobe);
    end
  end

  `MMCS_GIVEN(ResetLasts, !(sysreset_ni && down_q != 6'd0 && down_q < 6'(ResetLeast)),
              "SYSRESET* lasts 4 us at least (the bus says 200 ms)")

  // --- edges of PANIC and SCLOCK, with three clocks for those who look -------------------------

  // must: it rose, and bit 7 was set before and since. may: it rose not before bit 7 was set.
  logic [1:0] line, must_q = '0, may_q = '0;
  logic [4:0] line0_q = '1, line1_q = '1;   // SCLOCK, PANIC in the last clocks
  logic [5:0] steady_q = '0;                // bit 7 was set, and none was writing
  logic [3:0] clear_q = '0;
  logic [1:0] rose, recent, may;
  assign may = recent | (&clear_q ? 2'b00 : may_q);
  assign line = {panic, sclock};
  assign rose = {line1_q[4:3] == 2'b01 && &line1_q[3:0], line0_q[4:3] == 2'b01 && &line0_q[3:0]};
  assign recent = {|(line1_q[3:0] & ~line1_q[4:1]) || (panic && !line1_q[0]),
                   |(line0_q[3:0] & ~line0_q[4:1]) || (sclock && !line0_q[0])};
  always @(posedge clk_i) begin
    if (rst_ni) begin
      line0_q  <= {line0_q[3:0], sclock};
      line1_q  <= {line1_q[3:0], panic};
      steady_q <= {steady_q[4:0], csr_q[7] && !changes};
      clear_q  <= {clear_q[2:0], !csr_q[7] && !changes};
      must_q   <= (csr_q[7] && !changes) ? must_q | (&steady_q ? rose : 2'b00) : 2'b00;
      may_q    <= may;
    end
  end

  logic [3:0] quiet_q = '0, asks_q = '0;
  logic quiet;
  assign quiet = !changes && (may & csr_q[6:5]) == 2'b00;
  always @(posedge clk_i) begin
    if (rst_ni) begin
      asks_q <= {asks_q[2:0], !changes && |(must_q & csr_q[6:5])};
      quiet_q <= {quiet_q[2:0], quiet};
    end
  end

  // --- the PC bus in a cycle --------------------------------------------------------------------

  logic [7:0] seen_q = '0;
  logic whole_q = 1'b0;          // read data stood, nothing was wrong, nobody waited
  logic [3:0] fine_q = '0;
  logic fine;
  assign fine = cable_ok_i && pc_power_i && !pc_wait_i;
  always @(posedge clk_i) begin
    if (rst_ni) begin
      fine_q <= {fine_q[2:0], fine};
      if (!ior_n) begin
        seen_q  <= pc_d_i;
      end
      if (state_q == StAddress) whole_q <= &fine_q && fine;
      else if (!fine) whole_q <= 1'b0;
    end
  end

  // --- resets and power -------------------------------------------------------------------------

  logic [3:0] down4_q = '0, cable_q = '1;   // the last clocks
  logic [1:0] power_q = '1;
  logic [3:0] good_q = '0;                        // clocks that all was good, up to 15
  logic [2:0] bad_q = '0;                         // and that something was not, up to 5
  logic good;
  logic [Width-1:0] since_q = Width'(ResetClks);                     // clocks since power was off
  assign good = estop_closed_i && cable_ok_i && pc_power_i && !pc_irq_i[7];
  always @(posedge clk_i) begin
    if (rst_ni) begin
      down4_q <= {down4_q[2:0], !sysreset_ni};
      cable_q <= {cable_q[2:0], cable_ok_i};
      power_q <= {power_q[0], pc_power_i};
      good_q  <= !good ? '0 : good_q + 4'(good_q != 4'd15);
      bad_q   <= good ? '0 : bad_q + 3'(bad_q != 3'd5);
      if (!power) since_q <= '0;
      else if (since_q != Width'(ResetClks)) since_q <= since_q + 1'b1;
    end
  end
  (* hierconn *) wire [Width-1:0] \dut.u_core.power_timer_q ;
  `MMCS_LEMMA(PowerTimer, dut.u_core.power_timer_q == Width'(ResetClks) - since_q,
              "RESET DRV after power counts its clocks")

  // --- properties -------------------------------------------------------------------------------

  logic reads;
  assign reads = answered && !write_q && !iack_q;

  `MMCS_PROVE(ReadsBack, "4.3.3", reads && to_pccsr && &up_q,
              d_oe && d[7] == csr_q[7] && d[4:0] == csr_q[4:0],
              "PCCSR reads bits 7 and 4-0 as written")
  `MMCS_PROVE(LatchRead, "4.3.6", reads && to_pccsr && !changes, (must_q & ~d[6:5]) == 2'b00,
              "an edge of SCLOCK or PANIC with bit 7 set reads as bit 5 or 6 until it is cleared")
  `MMCS_PROVE(NothingElseRead, "4.3.6", reads && to_pccsr && !changes, (d[6:5] & ~may) == 2'b00,
              "nothing else sets them; with bit 7 clear they are clear")
  `MMCS_PROVE(Interrupts, "4.3.6", &asks_q && csr_q[7] && !changes, irq_n == 7'b1101111 && led_irq,
              "a latch whose enable is set pulls IRQ5*")
  `MMCS_PROVE(NothingElseInterrupts, "4.3.6", &quiet_q && quiet, irq_n == 7'b1111111 && !led_irq,
              "nothing else does")
  `MMCS_PROVE(Vector, "4.3.6", answered && iack_q && known_q,
              d_oe && d == vector_q && a_q[3:1] == 3'd5,
              "an acknowledge of level 5 reads the vector as it was written")
  `MMCS_PROVE(CardRead, "4.3.2", reads && to_pc && whole_q, d_oe && d == seen_q,
              "a read of the PC bus gives what stood there as IOR# rose")

  `MMCS_PROVE(CardWritten, "4.3.2", !iow_n && state_q == StStrobe, write_q && to_pc &&
              pc_wdata == d_q && pc_a == {2'b00, a_q[9:6], csr_q[4:0], a_q[5:1]},
              "a write of the window is a write of the PC bus, A09-A05 from PCCSR")
  `MMCS_PROVE(Panics, "4.3.5", bad_q == 3'd5 && !good, panic,
              "PANIC of the bus, an open button, a cable out or no power is system PANIC")
  `MMCS_PROVE(ResetPassed, "4.3.8", &down4_q && &cable_q, reset_drv,
              "SYSRESET* is passed to the PC bus as RESET DRV")
  `MMCS_PROVE(ResetAfterPower, "4.3.8", since_q < Width'(ResetClks), reset_drv,
              "RESET DRV stands for 50 us after the cards' power has come back")
  `MMCS_PROVE(NothingElseResets, "4.3.8", &up_q && power && since_q == Width'(ResetClks),
              !reset_drv,
              "nothing else resets the cards")
  `MMCS_PROVE(NoLink, "4.3.5", cable_q[1:0] == '0 || power_q == '0,
              ior_n && iow_n && !pc_d_oe && drq == '0,
              "with the cable out or no power at the cards: no command, no data, no DRQ")
  `MMCS_PROVE(NoCable, "4.3.5", cable_q[1:0] == '0,
              !clk_en && (!reset_drv || since_q < Width'(ResetClks)),
              "with the cable out no CLK and no RESET DRV, but that after power")
  `MMCS_PROVE(NoRegister, "4.3.3", reads && to_none, d_oe && d == 8'hFF,
              "an address of the adaptor without a register reads 0xFF")
  `MMCS_PROVE(NothingElsePanics, "4.3.5", good_q == 4'd15 && good, !panic, "nothing else is")
  `MMCS_REACH(Acknowledged, answered && iack_q && d == 8'h5A, "a written vector is acknowledged")

endmodule

`default_nettype wire
