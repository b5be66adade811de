// SPDX-License-Identifier: Apache-2.0
// The processor side of the SoC: core, memory, bridge to the adaptor, window for a computer above.
//
// Memory map (docs/hardware/soc.md): memory from 0; register n of the adaptor's window at RegBase + 4 n;
// ControlBase + 0 report (write), + 4 doorbell (write: noticed), + 8 microseconds (read). Anything
// else, and a register access of other than a word or the lowest byte, is a bus error.
//
// cpu_clk_i may be clk_i, a multiple of it, or any other clock. The window belongs to clk_i.
`default_nettype none

module soc_host #(
  parameter int ClkHz = 8_000_000,
  parameter int RamWords = 32_768,
  parameter InitFile = "",
  parameter int TimeoutClks = 128
) (
  input  wire logic        clk_i,
  input  wire logic        cpu_clk_i,
  input  wire logic        rst_ni,
  // Window: memory, one word at a time, while the processor runs or not. a is held until ack.
  input  wire logic        run_i,          // 0: the processor is in reset
  input  wire logic        box_req_i,
  input  wire logic        box_write_i,
  input  wire logic [31:2] box_a_i,
  input  wire logic [31:0] box_wdata_i,
  output logic             box_ack_o,      // one clock, with rdata; req goes, or it is a new one
  output logic      [31:0] box_rdata_o,
  input  wire logic        ring_i,         // one clock: interrupts the processor
  output logic             report_valid_o, // the processor waits until its report is taken
  output logic      [ 7:0] report_o,
  input  wire logic        report_take_i,  // one clock
  // Adaptor
  input  wire logic        irq_i,
  output logic             hp_req_o,
  output logic             hp_write_o,
  output logic      [10:1] hp_a_o,
  output logic      [ 7:0] hp_wdata_o,
  input  wire logic        hp_ack_i,
  input  wire logic [ 7:0] hp_rdata_i
);

  localparam int RamWidth = $clog2(RamWords);
  localparam logic [31:12] RegPage = 20'h00E00;
  localparam logic [31:4] ControlPage = 28'h00F0000;
  localparam int ClkMHz = ClkHz / 1_000_000;
  localparam int PreWidth = $clog2(ClkMHz + 1);

  // --- resets and lines into the processor's clock ----------------------------------------

  logic [1:0] run_q, irq_q;
  logic [2:0] ring_q;
  logic ring_far_d, ring_far_q;      // flips with each ring
  logic rst_first_q, cpu_rst_n, core_rst_nd, core_rst_nq, doorbell_d, doorbell_q;
  logic slow_d, slow_q;
  logic doorbell_off;

  assign ring_far_d = ring_far_q ^ ring_i;
  // never released into the answer of an access from before
  assign core_rst_nd = run_q[1] && (core_rst_nq || !slow_q);
  assign doorbell_d = (ring_q[2] != ring_q[1]) || (doorbell_q && !doorbell_off);

  always_ff @(posedge cpu_clk_i or negedge rst_ni) begin
    if (!rst_ni) {cpu_rst_n, rst_first_q} <= '0;
    else {cpu_rst_n, rst_first_q} <= {rst_first_q, 1'b1};
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) ring_far_q <= 1'b0;
    else ring_far_q <= ring_far_d;
  end

  always_ff @(posedge cpu_clk_i or negedge cpu_rst_n) begin
    if (!cpu_rst_n) begin
      run_q       <= '0;
      irq_q       <= '0;
      ring_q      <= '0;
      core_rst_nq <= 1'b0;
      doorbell_q  <= 1'b0;
    end else begin
      run_q       <= {run_q[0], run_i};
      irq_q       <= {irq_q[0], irq_i};
      ring_q      <= {ring_q[1:0], ring_far_q};
      core_rst_nq <= core_rst_nd;
      doorbell_q  <= doorbell_d;
    end
  end

  // --- processor --------------------------------------------------------------------------

  logic instr_req, instr_rvalid_q, instr_err_d, instr_err_q;
  logic [31:0] instr_addr, instr_rdata;
  logic data_req, data_gnt, data_rvalid, data_we, data_err;
  logic [3:0] data_be;
  logic [31:0] data_addr, data_wdata, data_rdata;

  soc_cpu u_cpu (
    .clk_i(cpu_clk_i),
    .rst_ni(core_rst_nq),
    .instr_req_o(instr_req),
    .instr_addr_o(instr_addr),
    .instr_rvalid_i(instr_rvalid_q),
    .instr_rdata_i(instr_rdata),
    .instr_err_i(instr_err_q),
    .data_req_o(data_req),
    .data_gnt_i(data_gnt),
    .data_rvalid_i(data_rvalid),
    .data_we_o(data_we),
    .data_be_o(data_be),
    .data_addr_o(data_addr),
    .data_wdata_o(data_wdata),
    .data_rdata_i(data_rdata),
    .data_err_i(data_err),
    .irq_external_i(irq_q[1]),
    .irq_software_i(doorbell_q)
  );

  // --- memory -----------------------------------------------------------------------------

  logic in_ram, ram_req, box_far_req, box_use, box_used_q;
  logic [31:0] ram_rdata, box_wdata_d, box_wdata_q;
  logic [RamWidth-1:0] box_a_d, box_a_q;
  logic box_write_d, box_write_q;

  assign in_ram = (data_addr[31:RamWidth+2] == '0);
  // The window takes the clocks that the processor leaves.
  assign box_use = box_far_req && !box_used_q && !data_req;

  soc_ram #(
    .Words(RamWords),
    .InitFile(InitFile)
  ) u_ram (
    .clk_i(cpu_clk_i),
    .fetch_i(instr_req),
    .fetch_a_i(instr_addr[RamWidth+1:2]),
    .fetch_d_o(instr_rdata),
    .req_i(ram_req | box_use),
    .write_i(box_use ? box_write_q : data_we),
    .be_i(box_use ? 4'hF : data_be),
    .a_i(box_use ? box_a_q : data_addr[RamWidth+1:2]),
    .wdata_i(box_use ? box_wdata_q : data_wdata),
    .rdata_o(ram_rdata)
  );

  assign instr_err_d = (instr_addr[31:RamWidth+2] != '0);

  always_ff @(posedge cpu_clk_i or negedge core_rst_nq) begin
    if (!core_rst_nq) begin
      instr_rvalid_q <= 1'b0;
      instr_err_q    <= 1'b0;
    end else begin
      instr_rvalid_q <= instr_req;
      instr_err_q    <= instr_err_d;
    end
  end

  // --- what the data port reaches ---------------------------------------------------------

  typedef enum logic [1:0] {
    PcNone,
    PcBridge,
    PcReport
  } place_e;

  place_e place;                     // who must answer, later
  logic good;                        // memory, or a register that answers at once
  logic whole, is_reg, is_control, accepted;
  logic quick_d, quick_q, quick_err_d, quick_err_q;  // an answer in this clock
  logic bridge_done, bridge_err, bridge_busy;
  logic report_done, report_busy, report_far_req;
  logic [31:0] bridge_rdata;

  assign whole = (data_be == 4'hF) || (data_be == 4'h1);
  assign is_reg = (data_addr[31:12] == RegPage) && whole;
  assign is_control = (data_addr[31:4] == ControlPage) && (data_be == 4'hF);

  always_comb begin
    place = PcNone;
    good = in_ram;
    doorbell_off = 1'b0;
    if (is_reg) place = PcBridge;
    if (is_control) begin
      case (data_addr[3:2])
        2'd0: if (data_we) place = PcReport;
        2'd1: good = data_we;
        2'd2: if (!data_we) place = PcBridge;
        default: good = 1'b0;
      endcase
      doorbell_off = data_req && data_gnt && data_we && (data_addr[3:2] == 2'd1);
    end
  end

  assign data_gnt = data_req && !slow_q;
  assign accepted = data_gnt;
  assign ram_req = accepted && in_ram;
  assign quick_d = accepted && (place == PcNone);
  assign quick_err_d = quick_d && !good;
  assign slow_d = (accepted && (place != PcNone)) || (slow_q && !bridge_done && !report_done);

  always_ff @(posedge cpu_clk_i or negedge cpu_rst_n) begin
    if (!cpu_rst_n) begin
      slow_q      <= 1'b0;
      quick_q     <= 1'b0;
      quick_err_q <= 1'b0;
    end else begin
      slow_q      <= slow_d;
      quick_q     <= quick_d;
      quick_err_q <= quick_err_d;
    end
  end

  assign data_rvalid = quick_q || bridge_done || report_done;
  assign data_err = quick_q ? quick_err_q : (bridge_done && bridge_err);
  assign data_rdata = quick_q ? ram_rdata : bridge_rdata;

  // --- registers and clock: through the bridge --------------------------------------------

  logic [PreWidth-1:0] pre_d, pre_q;
  logic [31:0] us_d, us_q;
  logic us_ends;

  assign us_ends = (pre_q == PreWidth'(ClkMHz - 1));
  assign pre_d = us_ends ? '0 : pre_q + 1'b1;
  assign us_d = us_q + 32'(us_ends);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      pre_q <= '0;
      us_q  <= '0;
    end else begin
      pre_q <= pre_d;
      us_q  <= us_d;
    end
  end

  soc_bridge #(
    .TimeoutClks(TimeoutClks)
  ) u_bridge (
    .clk_i(cpu_clk_i),
    .rst_ni(cpu_rst_n),
    .start_i(accepted && (place == PcBridge)),
    .clock_i(is_control),
    .write_i(data_we),
    .a_i(data_addr[11:2]),
    .wdata_i(data_wdata[7:0]),
    .busy_o(bridge_busy),
    .done_o(bridge_done),
    .rdata_o(bridge_rdata),
    .err_o(bridge_err),
    .far_clk_i(clk_i),
    .far_rst_ni(rst_ni),
    .us_i(us_q),
    .hp_req_o, .hp_write_o, .hp_a_o, .hp_wdata_o, .hp_ack_i, .hp_rdata_i
  );

  // --- reports ----------------------------------------------------------------------------

  logic report_start;
  logic [7:0] report_d;
  assign report_start = accepted && (place == PcReport);
  assign report_d = report_start ? data_wdata[7:0] : report_o;

  always_ff @(posedge cpu_clk_i or negedge cpu_rst_n) begin
    if (!cpu_rst_n) report_o <= '0;
    else report_o <= report_d;
  end

  soc_cross u_report (
    .clk_i(cpu_clk_i),
    .rst_ni(cpu_rst_n),
    .start_i(report_start),
    .busy_o(report_busy),
    .done_o(report_done),
    .far_clk_i(clk_i),
    .far_rst_ni(rst_ni),
    .far_req_o(report_far_req),
    .far_finish_i(report_far_req && report_take_i)
  );

  assign report_valid_o = report_far_req;

  // --- window -----------------------------------------------------------------------------

  logic box_start, box_busy, box_done;

  // not in the clock of its ack: the request there is still the old one
  assign box_start = box_req_i && !box_busy && !box_ack_o;
  assign {box_write_d, box_a_d, box_wdata_d} =
      box_start ? {box_write_i, box_a_i[RamWidth+1:2], box_wdata_i} :
                  {box_write_q, box_a_q, box_wdata_q};

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      box_write_q <= 1'b0;
      box_a_q     <= '0;
      box_wdata_q <= '0;
      box_ack_o   <= 1'b0;
    end else begin
      box_write_q <= box_write_d;
      box_a_q     <= box_a_d;
      box_wdata_q <= box_wdata_d;
      box_ack_o   <= box_done;
    end
  end

  soc_cross u_box (
    .clk_i, .rst_ni,
    .start_i(box_start),
    .busy_o(box_busy),
    .done_o(box_done),
    .far_clk_i(cpu_clk_i),
    .far_rst_ni(cpu_rst_n),
    .far_req_o(box_far_req),
    .far_finish_i(box_used_q)
  );

  logic [31:0] box_rdata_d;
  assign box_rdata_d = box_used_q ? ram_rdata : box_rdata_o;

  always_ff @(posedge cpu_clk_i or negedge cpu_rst_n) begin
    if (!cpu_rst_n) begin
      box_used_q  <= 1'b0;
      box_rdata_o <= '0;
    end else begin
      box_used_q  <= box_use;
      box_rdata_o <= box_rdata_d;
    end
  end

  logic unused;
  assign unused = ^{bridge_busy, report_busy, box_a_i[31:RamWidth+2], instr_addr[1:0],
                    data_addr[1:0]};

endmodule

`default_nettype wire
