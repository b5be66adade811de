// SPDX-License-Identifier: Apache-2.0
// Measures the VMEbus in nanoseconds, between clocks too, against the limits of its tables. §4.3.1
//
// Simulation only. For each parameter the worst value is kept and printed at the end of the run:
//   MARGIN vme <name> <min|max> limit <ns> worst <ns> seen <n> broken <n> by <master|slave>
// The limits are those at a slave's pins. A slave that breaks one ends the run (Stop); what a
// master breaks is counted, for tests do it on purpose.
`default_nettype none

module vme_timing #(
  parameter int BusTimerNs = 16_000,
  parameter bit Stop = 1'b1
) (
  input  wire logic        rst_ni,
  input  wire logic [15:1] vme_a_i,
  input  wire logic [ 5:0] vme_am_i,
  input  wire logic        vme_as_ni,
  input  wire logic [ 1:0] vme_ds_ni,
  input  wire logic        vme_write_ni,
  input  wire logic        vme_lword_ni,
  input  wire logic        vme_iack_ni,
  input  wire logic        vme_iackout_no,
  input  wire logic        vme_sysreset_ni,
  input  wire logic [15:0] vme_d_i,
  input  wire logic [ 7:1] vme_irq_no,
  input  wire logic        vme_d_oe_o,
  input  wire logic [ 7:0] vme_d_o,
  input  wire logic        vme_dtack_no,
  output logic      [18:0] broken_o   // until reset, one bit per parameter
);

`ifdef SYNTHESIS
  assign broken_o = '0;
`elsif YOSYS
  assign broken_o = '0;
`elsif FORMAL
  assign broken_o = '0;
`else

  // The master's parameters first
  localparam int AddrSetup = 0, AsHigh = 1, WriteSetup = 2, DataSetup = 3, AsToDs = 4, DsSkew = 5,
                 DsHigh = 6, AddrHold = 7, DataHold = 8, StrobeHold = 9, NextStrobe = 10;
  localparam int DsToDtack = 11, Answer = 12, DataToDtack = 13, DataOff = 14, OffToDtack = 15,
                 DtackRise = 16, IackoutRise = 17, IrqRelease = 18;
  localparam int Params = 19;
  localparam int FirstOfSlave = DsToDtack;
  localparam real Never = -1.0;

  real limit[Params];
  real worst[Params];
  int seen[Params];
  int broken[Params];
  logic [8*16-1:0] name[Params];
  logic [Params-1:0] upper;   // the limit is a maximum

  initial begin
    for (int n = 0; n < Params; n++) begin
      limit[n]  = 0.0;
      worst[n]  = 0.0;
      seen[n]   = 0;
      broken[n] = 0;
    end
    limit[AddrSetup]   = 10.0;
    limit[AsHigh]      = 30.0;
    limit[WriteSetup]  = 10.0;
    limit[DataSetup]   = 10.0;
    limit[AsToDs]      = -10.0;
    limit[DsSkew]      = 20.0;
    limit[DsHigh]      = 30.0;
    limit[DsToDtack]   = 30.0;
    limit[Answer]      = real'(BusTimerNs);
    limit[IackoutRise] = 40.0;
    limit[IrqRelease]  = 2000.0;
    name[AddrSetup]   = "addr_setup";
    name[AsHigh]      = "as_high";
    name[WriteSetup]  = "write_setup";
    name[DataSetup]   = "data_setup";
    name[AsToDs]      = "as_to_ds";
    name[DsSkew]      = "ds_skew";
    name[DsHigh]      = "ds_high";
    name[AddrHold]    = "addr_hold";
    name[DataHold]    = "data_hold";
    name[StrobeHold]  = "strobe_hold";
    name[NextStrobe]  = "next_strobe";
    name[DsToDtack]   = "ds_to_dtack";
    name[Answer]      = "answer";
    name[DataToDtack] = "data_to_dtack";
    name[DataOff]     = "data_off";
    name[OffToDtack]  = "off_to_dtack";
    name[DtackRise]   = "dtack_rise";
    name[IackoutRise] = "iackout_rise";
    name[IrqRelease]  = "irq_release";
    upper = '0;
    upper[DsSkew]      = 1'b1;
    upper[Answer]      = 1'b1;
    upper[DataOff]     = 1'b1;
    upper[IackoutRise] = 1'b1;
    upper[IrqRelease]  = 1'b1;
  end

  task automatic measure(input int what, input real ns);
    if (seen[what] == 0 || (upper[what] ? ns > worst[what] : ns < worst[what])) worst[what] = ns;
    seen[what] = seen[what] + 1;
    // half a picosecond: the resolution of time
    if (upper[what] ? ns > limit[what] + 0.0005 : ns < limit[what] - 0.0005) begin
      broken[what] = broken[what] + 1;
      broken_o[what] = 1'b1;
      if (what >= FirstOfSlave && Stop) begin
        $fatal(1, "%m: parameter %0d is %0.3f ns, limit %0.3f ns", what, ns, limit[what]);
      end
    end
  endtask

  logic [22:0] cycle, cycle_q;
  logic [15:0] d_q;
  logic [ 1:0] ds_q;
  logic [ 8:0] read_q;
  logic as_q, write_q, dtack_q, iackout_q, requested_q;
  logic answered_q;    // this data strobe has had its DTACK*
  logic addr_done_q, data_done_q;
  logic was_read_q;
  real now, t_cycle, t_write, t_data, t_as_fall, t_as_rise, t_ds_fall, t_ds_rise, t_read,
       t_dtack_fall, t_dtack_rise;

  // One process, so that lines which move together are taken in a fixed order: what is set up,
  // the strobes, the answers. It compares with what it saw last, so running twice does no harm.
  always @(rst_ni or vme_a_i or vme_am_i or vme_lword_ni or vme_iack_ni or vme_d_i or vme_as_ni or
           vme_ds_ni or vme_write_ni or vme_d_oe_o or vme_d_o or vme_dtack_no or vme_iackout_no or
           vme_irq_no or vme_sysreset_ni) begin
    now = $realtime;
    cycle = {vme_a_i, vme_am_i, vme_lword_ni, vme_iack_ni};
    if (!rst_ni) begin
      broken_o = '0;
      {answered_q, addr_done_q, data_done_q, was_read_q} = 4'b0110;
      t_cycle = Never;
      t_write = Never;
      t_data = Never;
      t_as_fall = Never;
      t_as_rise = Never;
      t_ds_fall = Never;
      t_ds_rise = Never;
      t_read = Never;
      t_dtack_fall = Never;
      t_dtack_rise = Never;
    end else begin
      if (cycle != cycle_q) begin
        if (!addr_done_q) measure(AddrHold, now - t_dtack_fall);
        addr_done_q = 1'b1;
        t_cycle = now;
      end
      if (vme_write_ni != write_q || vme_d_i != d_q) begin
        if (!data_done_q) measure(DataHold, now - t_dtack_fall);
        data_done_q = 1'b1;
        if (vme_write_ni != write_q) t_write = now;
        if (vme_d_i != d_q) t_data = now;
      end
      if (vme_as_ni && !as_q) begin
        if (!addr_done_q) measure(AddrHold, now - t_dtack_fall);
        addr_done_q = 1'b1;
        t_as_rise = now;
      end
      if (!vme_as_ni && as_q) begin
        if (t_cycle != Never) measure(AddrSetup, now - t_cycle);
        if (t_as_rise != Never) measure(AsHigh, now - t_as_rise);
        // a strobe already there belongs to this cycle: AS* came after it
        if (ds_q != 2'b11 && vme_ds_ni != 2'b11 && !answered_q) measure(AsToDs, t_ds_fall - now);
        t_as_fall = now;
      end
      if (vme_ds_ni != ds_q) begin
        if (ds_q == 2'b11) begin
          if (t_write != Never) measure(WriteSetup, now - t_write);
          if (!vme_write_ni && t_data != Never) measure(DataSetup, now - t_data);
          if (!vme_as_ni) measure(AsToDs, now - t_as_fall);
          if (t_ds_rise != Never) measure(DsHigh, now - t_ds_rise);
          if (!dtack_q) measure(NextStrobe, -1.0);
          else if (t_dtack_rise != Never) measure(NextStrobe, now - t_dtack_rise);
          answered_q = 1'b0;
          was_read_q = 1'b0;
          t_ds_fall  = now;
        end else if (vme_ds_ni == 2'b00) begin
          measure(DsSkew, now - t_ds_fall);
        end else if (vme_ds_ni == 2'b11) begin
          if (answered_q) measure(StrobeHold, now - t_dtack_fall);
          t_ds_rise = now;
        end
      end
      if ({vme_d_oe_o, vme_d_o} != read_q) begin
        if (read_q[8] && !vme_d_oe_o) begin
          if (vme_ds_ni == 2'b11) measure(DataOff, now - t_ds_rise);
        end
        t_read = now;
      end
      // Not if the strobes were withdrawn at this very instant: nobody can tell them apart.
      if (!vme_dtack_no && dtack_q && !(vme_ds_ni == 2'b11 && t_ds_rise == now)) begin
        if (vme_ds_ni == 2'b11) begin
          measure(DsToDtack, -1.0);
        end else begin
          measure(DsToDtack, now - t_ds_fall);
          measure(Answer, now - t_ds_fall);
        end
        was_read_q = vme_write_ni || !vme_iack_ni;
        if (was_read_q) measure(DataToDtack, vme_d_oe_o ? now - t_read : -1.0);
        t_dtack_fall = now;
        answered_q   = 1'b1;
        addr_done_q  = 1'b0;
        data_done_q  = 1'b0;
        // what moved before the answer was not held
        if (t_cycle > t_as_fall && !vme_as_ni) begin
          measure(AddrHold, t_cycle - now);
          addr_done_q = 1'b1;
        end
        if (t_write > t_ds_fall || (t_data > t_ds_fall && !vme_write_ni)) begin
          measure(DataHold, (t_write > t_data ? t_write : t_data) - now);
        end
        if (vme_write_ni || t_write > t_ds_fall || t_data > t_ds_fall) data_done_q = 1'b1;
      end
      if (vme_dtack_no && !dtack_q && vme_sysreset_ni) begin
        measure(DtackRise, vme_ds_ni == 2'b11 ? now - t_ds_rise : -1.0);
        if (was_read_q) measure(OffToDtack, vme_d_oe_o ? -1.0 : now - t_read);
      end
      if (vme_dtack_no && !dtack_q) t_dtack_rise = now;
      if (vme_iackout_no && !iackout_q) begin
        measure(IackoutRise, vme_as_ni ? now - t_as_rise : 0.0);
      end
      if ((&vme_irq_no) && requested_q && vme_sysreset_ni) begin
        measure(IrqRelease, vme_ds_ni == 2'b11 ? now - t_ds_rise : 0.0);
      end
    end
    cycle_q     = cycle;
    d_q         = vme_d_i;
    as_q        = vme_as_ni;
    ds_q        = vme_ds_ni;
    write_q     = vme_write_ni;
    read_q      = {vme_d_oe_o, vme_d_o};
    dtack_q     = vme_dtack_no;
    iackout_q   = vme_iackout_no;
    requested_q = !(&vme_irq_no);
  end

  final begin
    for (int n = 0; n < Params; n++) begin
      if (seen[n] != 0) begin
        $display("MARGIN vme %0s %0s limit %0.1f worst %0.1f seen %0d broken %0d by %0s", name[n],
                 upper[n] ? "max" : "min", limit[n], worst[n], seen[n], broken[n],
                 n >= FirstOfSlave ? "slave" : "master");
      end
    end
  end

`endif

endmodule

`default_nettype wire
