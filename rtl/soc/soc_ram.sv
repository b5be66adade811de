// SPDX-License-Identifier: Apache-2.0
// The memory of the SoC: one port reads instructions, the other reads and writes data, both with
// the answer one clock later. What it holds at power-on is the file InitFile, if one is given.
`default_nettype none

module soc_ram #(
  parameter int Words = 32_768,     // a power of two
  parameter InitFile = "",          // $readmemh
  localparam int Width = $clog2(Words)
) (
  input  wire logic             clk_i,
  input  wire logic             fetch_i,
  input  wire logic [Width-1:0] fetch_a_i,
  output logic      [     31:0] fetch_d_o,
  input  wire logic             req_i,
  input  wire logic             write_i,
  input  wire logic [      3:0] be_i,
  input  wire logic [Width-1:0] a_i,
  input  wire logic [     31:0] wdata_i,
  output logic      [     31:0] rdata_o
);

  // A word that is fetched in the clock in which it is written may be the old or the new one.
  (* no_rw_check *) logic [31:0] memory[Words];

  if (InitFile != "") begin : g_init
    initial $readmemh(InitFile, memory);
  end

  always_ff @(posedge clk_i) begin
    if (fetch_i) fetch_d_o <= memory[fetch_a_i];
  end

  always_ff @(posedge clk_i) begin
    if (req_i) begin
      if (write_i) begin
        for (int n = 0; n < 4; n++) if (be_i[n]) memory[a_i][8*n+:8] <= wdata_i[8*n+:8];
      end else begin
        rdata_o <= memory[a_i];
      end
    end
  end

endmodule

`default_nettype wire
