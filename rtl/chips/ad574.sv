// SPDX-License-Identifier: Apache-2.0
// AD574A: 12-bit successive approximation A/D converter, bipolar, offset binary. §5.3.4
//
// The input is taken at the start: the part has no sample-and-hold, the model one without droop.
// Starts during a conversion, its last clock included, are ignored, not remembered.
`default_nettype none
`include "mmcs_assert.svh"
`include "mmcs_require.svh"

module ad574 #(
  parameter int          ConvClks = 200,   // 12 bits: 25 us at 8 MHz; 8 bits take 16/25 of it
  parameter logic [11:0] PowerUp  = 12'h0  // what a read gives before the first conversion
) (
  input  wire logic               clk_i,
  input  wire logic               rst_ni,
  // Pins
  input  wire logic               ce_i,
  input  wire logic               cs_ni,
  input  wire logic               rc_ni,     // 0 convert, 1 read
  input  wire logic               a0_i,      // convert: 1 = 8 bits; read by bytes: 1 = low byte
  input  wire logic               mode12_i,  // 12/8#: 1 = all bits at once
  output logic                    sts_o,     // 1 while converting
  output logic             [11:0] db_o,
  output logic                    db_oe_o,
  // Analog
  input  wire logic               span10_i,  // 1: +-5 V, 0: +-10 V
  input  wire logic signed [15:0] vin_i      // 32768 = 10 V
);

  `MMCS_REQUIRE(ReqConv, ConvClks >= 1, "ad574: ConvClks must be at least 1")

  localparam int Conv8Clks = (ConvClks * 16 + 24) / 25;
  localparam int Width = $clog2(ConvClks + 1);

  // --- what the input is worth: to the nearest code, clamped at the ends ---------------------

  logic signed [17:0] vin, level;  // level: in LSB, with the half that rounds
  logic [11:0] sample;

  assign vin = {{2{vin_i[15]}}, vin_i};
  assign level = span10_i ? (vin + 18'sd16388) >>> 3 : (vin + 18'sd32776) >>> 4;
  assign sample = level < 18'sd0 ? 12'h000 : level > 18'sd4095 ? 12'hFFF : level[11:0];

  // --- conversion ---------------------------------------------------------------------------

  logic start, start_q;
  logic busy_d, busy_q;
  logic [Width-1:0] left_d, left_q;  // clocks until the conversion ends, valid while busy_q
  logic [11:0] next_d, next_q;       // what the conversion under way will give
  logic [11:0] code_d, code_q;

  assign start = ce_i && !cs_ni && !rc_ni;

  always_comb begin
    busy_d = busy_q;
    left_d = left_q;
    next_d = next_q;
    code_d = code_q;
    if (busy_q) begin
      left_d = left_q - 1'b1;
      if (left_q <= Width'(1)) begin
        busy_d = 1'b0;
        code_d = next_q;
      end
    end else if (start && !start_q) begin
      busy_d = 1'b1;
      left_d = a0_i ? Width'(Conv8Clks) : Width'(ConvClks);
      next_d = a0_i ? sample & 12'hFF0 : sample;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      start_q <= 1'b0;
      busy_q  <= 1'b0;
      left_q  <= '0;
      next_q  <= '0;
      code_q  <= PowerUp;
    end else begin
      start_q <= start;
      busy_q  <= busy_d;
      left_q  <= left_d;
      next_q  <= next_d;
      code_q  <= code_d;
    end
  end

  assign sts_o = busy_q;

  // --- reads --------------------------------------------------------------------------------

  // By bytes, the byte stands in DB11-DB4: the high eight bits, or the low four and four zeros.
  assign db_oe_o = ce_i && !cs_ni && rc_ni && !busy_q;
  assign db_o = !db_oe_o ? 12'hFFF
              : mode12_i ? code_q
              : a0_i ? {code_q[3:0], 8'h00} : {code_q[11:4], 4'h0};

  `MMCS_ASSERT(ConversionHasClocks, !busy_q || left_q != '0,
               "a conversion under way has a clock left")

endmodule

`default_nettype wire
