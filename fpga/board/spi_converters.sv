// SPDX-License-Identifier: Apache-2.0
// Real converters for the two axes of a card: an MCP3208 reads, a DAC8568 writes, again and again.
//
// One SCLK for both, 32 clocks a slot, one joint a slot; both converters have their own select and
// data lines. Data out change at the falling edge of SCLK for the A/D, at the rising one for the D/A,
// which takes them at the falling one. A value is at most two slots old, and as long on its way out.
`default_nettype none
`include "mmcs_require.svh"

module spi_converters #(
  parameter int ClkHz = 24_000_000,
  parameter int SclkHz = 1_000_000
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  output logic             sclk_o,
  output logic             adc_cs_no,
  output logic             adc_din_o,   // to the converter
  input  wire logic        adc_dout_i,
  output logic             dac_sync_no,
  output logic             dac_din_o,
  input  wire logic [31:0] drive_v_i,   // two axes, signed, 32768 = 10 V
  output logic      [31:0] adc_v_o
);

  localparam int Half = ClkHz / SclkHz / 2;
  localparam int Width = $clog2(Half + 1);
  // Static reference on; then write and update of channel A or B.
  localparam logic [31:0] Reference = 32'h0800_0001;
  localparam logic [3:0] WriteUpdate = 4'h3;
  localparam int AdcClks = 24;

  `MMCS_REQUIRE(GoodSclk, Half >= 2, "SclkHz must be a quarter of ClkHz at most")

  logic [Width-1:0] half_q;
  logic [5:0] bit_q;         // 0 to 31; 32 and 33: both selects high
  logic high_q, joint_q, ready_q;
  logic [31:0] dac_q;
  logic [23:0] adc_out_q;
  logic [11:0] adc_in_q;
  logic [15:0] drive;
  logic tick, active;

  assign tick = (half_q == '0);
  assign active = ~bit_q[5];
  assign drive = joint_q ? drive_v_i[31:16] : drive_v_i[15:0];

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      half_q    <= '0;
      bit_q     <= 6'd32;
      high_q    <= 1'b0;
      joint_q   <= 1'b0;
      ready_q   <= 1'b0;
      dac_q     <= '0;
      adc_out_q <= '0;
      adc_in_q  <= '0;
      adc_v_o   <= '0;
    end else begin
      half_q <= tick ? Width'(Half - 1) : half_q - 1'b1;
      if (tick) begin
        high_q <= ~high_q;
        if (!high_q) begin
          // SCLK rises: the A/D's bit is taken, the D/A's next bit put out
          if (active && bit_q < 6'(AdcClks)) adc_in_q <= {adc_in_q[10:0], adc_dout_i};
          if (active && bit_q != '0) dac_q <= {dac_q[30:0], 1'b0};
        end else begin
          // SCLK falls
          adc_out_q <= {adc_out_q[22:0], 1'b0};
          bit_q     <= (bit_q == 6'd33) ? '0 : bit_q + 1'b1;
          if (bit_q == 6'd32) begin
            // offset binary from either side of a level shifter
            if (ready_q && joint_q) adc_v_o[31:16] <= {~adc_in_q[11], adc_in_q[10:0], 4'h0};
            else if (ready_q) adc_v_o[15:0] <= {~adc_in_q[11], adc_in_q[10:0], 4'h0};
            joint_q <= ready_q & ~joint_q;
          end
          if (bit_q == 6'd33) begin
            // single-ended channel 0 or 1
            adc_out_q <= {5'b0, 2'b11, 2'b00, joint_q, 14'b0};
            dac_q     <= ready_q ? {4'h0, WriteUpdate, 3'b0, joint_q, ~drive[15], drive[14:0], 4'h0}
                                 : Reference;
            ready_q   <= 1'b1;
          end
        end
      end
    end
  end

  assign sclk_o = high_q & active;
  assign adc_cs_no = ~(active & (bit_q < 6'(AdcClks)));
  assign adc_din_o = adc_out_q[23];
  // SYNC stays until after the last falling edge of SCLK.
  assign dac_sync_no = ~(active | (bit_q == 6'd32 & ~high_q));
  assign dac_din_o = dac_q[31];

endmodule

`default_nettype wire
