// SPDX-License-Identifier: Apache-2.0
// Measures the PC I/O bus in nanoseconds against the limits of bus and chips. §4.3.2
//
// Simulation only. Prints like vme_timing, and ends the run at a broken limit (Stop): the master
// is ours. Limits are those of the 8255A where the bus itself has none.
`default_nettype none

module pcbus_timing #(
  parameter int CmdNs = 500,
  parameter int SetupNs = 125,
  parameter int LongestNs = 0,   // a command with all its wait states; 0: no limit
  parameter bit Stop = 1'b1
) (
  input  wire logic        rst_ni,
  input  wire logic        link_ok_i,
  input  wire logic [15:0] pc_a_i,
  input  wire logic [ 7:0] pc_d_i,      // what the master drives
  input  wire logic [ 7:0] pc_rdata_i,  // what the bus holds in a read
  input  wire logic        pc_ior_ni,
  input  wire logic        pc_iow_ni,
  input  wire logic        driven_i,    // a card drives pc_rdata_i
  output logic      [ 7:0] broken_o     // until reset, one bit per parameter
);

`ifdef SYNTHESIS
  assign broken_o = '0;
`elsif YOSYS
  assign broken_o = '0;
`elsif FORMAL
  assign broken_o = '0;
`else

  localparam int AddrSetup = 0, Command = 1, Longest = 2, AddrHold = 3, DataSetup = 4, DataHold = 5,
                 ReadSetup = 6, Recovery = 7;
  localparam int Params = 8;
  localparam real Never = -1.0;

  real limit[Params];
  real worst[Params];
  int seen[Params];
  int broken[Params];
  logic [8*16-1:0] name[Params];

  initial begin
    for (int n = 0; n < Params; n++) begin
      worst[n]  = 0.0;
      seen[n]   = 0;
      broken[n] = 0;
    end
    limit[AddrSetup] = real'(SetupNs);      // a full clock of an 8 MHz bus
    limit[Command]   = real'(CmdNs);
    limit[Longest]   = real'(LongestNs);
    limit[AddrHold]  = 20.0;                // 8255A tWA
    limit[DataSetup] = 100.0;               // 8255A tDW
    limit[DataHold]  = 30.0;                // 8255A tWD
    limit[ReadSetup] = 75.0;                // 8088 with its bus buffers
    limit[Recovery]  = 2.0 * real'(SetupNs);
    name[AddrSetup] = "addr_setup";
    name[Command]   = "command";
    name[Longest]   = "command_waits";
    name[AddrHold]  = "addr_hold";
    name[DataSetup] = "data_setup";
    name[DataHold]  = "data_hold";
    name[ReadSetup] = "read_setup";
    name[Recovery]  = "recovery";
  end

  task automatic measure(input int what, input real ns);
    if (seen[what] == 0 || (what == Longest ? ns > worst[what] : ns < worst[what])) begin
      worst[what] = ns;
    end
    seen[what] = seen[what] + 1;
    if (what == Longest ? LongestNs != 0 && ns > limit[what] + 0.0005 : ns < limit[what] - 0.0005)
    begin
      broken[what] = broken[what] + 1;
      broken_o[what] = 1'b1;
      if (Stop) begin
        $fatal(1, "%m: parameter %0d is %0.3f ns, limit %0.3f ns", what, ns, limit[what]);
      end
    end
  endtask

  logic command, command_q, write_q, cut_q;
  logic addr_done_q, data_done_q;
  logic [15:0] a_q;
  logic [ 7:0] d_q;
  logic [ 8:0] read_q;
  real now, t_a, t_d, t_read, t_fall, t_rise;

  // Compares with what it saw last, so running twice does no harm.
  always @(rst_ni or link_ok_i or pc_a_i or pc_d_i or pc_rdata_i or pc_ior_ni or pc_iow_ni or
           driven_i) begin
    now = $realtime;
    command = ~(pc_ior_ni & pc_iow_ni);
    if (!rst_ni) begin
      broken_o = '0;
      {addr_done_q, data_done_q, write_q, cut_q} = 4'b1101;
      t_a = Never;
      t_d = Never;
      t_read = Never;
      t_fall = Never;
      t_rise = Never;
    end else begin
      if (!link_ok_i) cut_q = 1'b1;   // this command and what follows at once are not whole
      if (pc_a_i != a_q) begin
        if (!addr_done_q && !cut_q) measure(AddrHold, now - t_rise);
        addr_done_q = 1'b1;
        t_a = now;
      end
      if (pc_d_i != d_q) begin
        if (!data_done_q && !cut_q) measure(DataHold, now - t_rise);
        data_done_q = 1'b1;
        t_d = now;
      end
      if (command && !command_q) begin
        if (link_ok_i) cut_q = 1'b0;
        if (!cut_q && t_a != Never) measure(AddrSetup, now - t_a);
        if (!cut_q && t_rise != Never) measure(Recovery, now - t_rise);
        write_q = !pc_iow_ni;
        t_fall  = now;
      end
      if (!command && command_q) begin
        if (!cut_q) begin
          measure(Command, now - t_fall);
          measure(Longest, now - t_fall);
          if (write_q && t_d != Never) measure(DataSetup, now - t_d);
          // in an 8 MHz machine the cards let go in this very instant
          if (!write_q && read_q[8]) measure(ReadSetup, now - (t_read > t_fall ? t_read : t_fall));
        end
        addr_done_q = 1'b0;
        data_done_q = !write_q;
        t_rise = now;
      end
      if ({driven_i, pc_rdata_i} != read_q) begin
        t_read = now;
      end
    end
    a_q       = pc_a_i;
    d_q       = pc_d_i;
    command_q = command;
    read_q    = {driven_i, pc_rdata_i};
  end

  final begin
    for (int n = 0; n < Params; n++) begin
      if (seen[n] != 0) begin
        $display("MARGIN pc %0s %0s limit %0.1f worst %0.1f seen %0d broken %0d by %0s", name[n],
                 n == Longest ? "max" : "min", limit[n], worst[n], seen[n], broken[n],
                 n == ReadSetup ? "card" : "adaptor");
      end
    end
  end

`endif

endmodule

`default_nettype wire
