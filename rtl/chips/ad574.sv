// SPDX-License-Identifier: Apache-2.0
// AD574A: 12-bit successive approximation A/D converter, bipolar, offset binary.
// §5.3.4

`include "mmcs_assert.svh"
`default_nettype none

module ad574 #(
  parameter bit          Skip     = 1'b0,
  parameter bit          Gate     = 1'b0,  // see rtl/mmcs.sv
  parameter int          ConvClks = 200  // 12-bit conversion: 25 us at 8 MHz; 8-bit takes 16/25
) (
  input  wire logic               clk_i,
  input  wire logic               rst_ni,
  // pins
  input  wire logic               ce_i,
  input  wire logic               cs_ni,
  input  wire logic               rc_ni,     // 0 convert, 1 read
  input  wire logic               a0_i,      // convert: 1 = 8 bits; read by bytes: 1 = low byte
  input  wire logic               mode12_i,  // 12/8#: 1 = all bits at once
  output      logic               sts_o,     // 1 while converting
  output      logic [11:0]        db_o,
  output      logic               db_oe_o,
  // analog
  input  wire logic               span10_i,  // 1: +-5 V, 0: +-10 V
  input  wire logic signed [15:0] vin_i,     // 32768 = 10 V
  // fault
  input  wire logic               hold_i,    // converts, but keeps the old code
  // skipping and gating
  input  wire logic               clk_free_i,
  output      logic               due_o,     // this clock ends the conversion
  input  wire logic [15:0]        extra_i,
  output      logic [15:0]        horizon_o
);
  localparam int Conv8Clks = (ConvClks * 16 + 24) / 25;
  localparam int Width = $clog2(ConvClks + 1) < 18 ? 18 : $clog2(ConvClks + 1);

  // Round to nearest: the code changes half an LSB below each nominal value, and the ends clamp.
  function automatic logic [11:0] convert(input logic signed [15:0] v, input logic span10);
    logic signed [17:0] level;  // sixteenths (span 20 V) or eighths (span 10 V) of an LSB
    begin
      level = {{2{v[15]}}, v};
      if (span10) level = (level + 18'sd16388) >>> 3;
      else level = (level + 18'sd32776) >>> 4;
      if (level < 0) convert = 12'h000;
      else if (level > 18'sd4095) convert = 12'hFFF;
      else convert = level[11:0];
    end
  endfunction

  logic             clk_free;
  logic             start, start_q, busy_q;
  logic [Width-1:0] left_q;  // clocks until the conversion ends, valid while busy_q
  logic [Width-1:0] n;       // clocks this edge stands for
  logic [11:0]      next_q;  // what the conversion under way will give
  logic [11:0]      code_q;

  assign n     = Skip ? {{(Width - 16) {1'b0}}, extra_i} + 1'b1 : {{(Width - 1) {1'b0}}, 1'b1};
  assign start = ce_i && !cs_ni && !rc_ni;
  assign sts_o = busy_q;
  assign due_o = busy_q && left_q <= n;
  assign clk_free = Gate ? clk_free_i : clk_i;

  // The input is taken at the start: the part has no sample-and-hold, the model one without droop.
  // Starts during a conversion, its last clock included, are ignored, not remembered.
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      start_q <= 1'b0;
      busy_q  <= 1'b0;
      next_q  <= '0;
      code_q  <= '0;
    end else if (busy_q || start || start_q) begin
      start_q <= start;
      if (busy_q) begin
        if (due_o) begin
          busy_q <= 1'b0;
          if (!hold_i) code_q <= next_q;
        end
      end else if (start && !start_q) begin
        busy_q <= 1'b1;
        next_q <= convert(vin_i, span10_i) & (a0_i ? 12'hFF0 : 12'hFFF);
      end
    end
  end

  always_ff @(posedge clk_free or negedge rst_ni) begin
    if (!rst_ni) left_q <= '0;
    else if (busy_q) left_q <= left_q - n;
    else if (start && !start_q) left_q <= a0_i ? Conv8Clks[Width-1:0] : ConvClks[Width-1:0];
  end

  // Read by bytes, the byte stands in DB11..DB4: high eight bits, or the low four and four zeros.
  assign db_oe_o = ce_i && !cs_ni && rc_ni && !busy_q;
  assign db_o = !db_oe_o ? 12'hFFF
              : mode12_i ? code_q
              : a0_i ? {code_q[3:0], 8'h00} : {code_q[11:4], 4'h0};

  generate
    if (Skip) begin : g_skip
      logic [15:0] low;
      logic near;  // the end is close enough for horizon_o to say
      assign low  = left_q[15:0];
      assign near = left_q[Width-1:16] == '0;
      always_comb begin
        horizon_o = 16'hFFFF;
        if (start != start_q) horizon_o = 16'd1;
        else if (busy_q && near) horizon_o = low;
      end
    end else begin : g_step
      assign horizon_o = 16'd1;
    end
    if (ConvClks == 0) begin : g_bad
      initial $fatal(1, "ad574: ConvClks must be at least 1");
    end
  endgenerate

  `MMCS_ASSERT(a_left, !busy_q || left_q != '0, "a conversion under way has a clock left")
endmodule

`default_nettype wire
