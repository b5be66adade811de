// SPDX-License-Identifier: Apache-2.0
// The block RAM of an ECP5 as Yosys uses it, from Yosys' mapping to it: no output register, no
// reset, always selected; a read of what is written at once gives the old word. Yosys has no model
// of it. Words of 1, 2, 4, 9 and 18 bits lie in rows of 9, whose ninth the short ones leave out.
/* verilator lint_off UNUSEDSIGNAL */
/* verilator lint_off UNUSEDPARAM */
/* verilator lint_off MULTIDRIVEN */
`default_nettype none

module DP16KD #(
  parameter int DATA_WIDTH_A = 18, DATA_WIDTH_B = 18,
  parameter CLKAMUX = "CLKA", CLKBMUX = "CLKB", CSDECODE_A = "0b000", CSDECODE_B = "0b000",
  parameter REGMODE_A = "NOREG", REGMODE_B = "NOREG", WRITEMODE_A = "NORMAL",
  parameter WRITEMODE_B = "NORMAL", RESETMODE = "SYNC", ASYNC_RESET_RELEASE = "SYNC", GSR = "AUTO",
  parameter logic [319:0] INITVAL_00 = 0, INITVAL_01 = 0, INITVAL_02 = 0, INITVAL_03 = 0,
  INITVAL_04 = 0, INITVAL_05 = 0, INITVAL_06 = 0, INITVAL_07 = 0, INITVAL_08 = 0, INITVAL_09 =
  0, INITVAL_0A = 0, INITVAL_0B = 0, INITVAL_0C = 0, INITVAL_0D = 0, INITVAL_0E = 0, INITVAL_0F
  = 0, INITVAL_10 = 0, INITVAL_11 = 0, INITVAL_12 = 0, INITVAL_13 = 0, INITVAL_14 = 0,
  INITVAL_15 = 0, INITVAL_16 = 0, INITVAL_17 = 0, INITVAL_18 = 0, INITVAL_19 = 0, INITVAL_1A =
  0, INITVAL_1B = 0, INITVAL_1C = 0, INITVAL_1D = 0, INITVAL_1E = 0, INITVAL_1F = 0, INITVAL_20
  = 0, INITVAL_21 = 0, INITVAL_22 = 0, INITVAL_23 = 0, INITVAL_24 = 0, INITVAL_25 = 0,
  INITVAL_26 = 0, INITVAL_27 = 0, INITVAL_28 = 0, INITVAL_29 = 0, INITVAL_2A = 0, INITVAL_2B =
  0, INITVAL_2C = 0, INITVAL_2D = 0, INITVAL_2E = 0, INITVAL_2F = 0, INITVAL_30 = 0, INITVAL_31
  = 0, INITVAL_32 = 0, INITVAL_33 = 0, INITVAL_34 = 0, INITVAL_35 = 0, INITVAL_36 = 0,
  INITVAL_37 = 0, INITVAL_38 = 0, INITVAL_39 = 0, INITVAL_3A = 0, INITVAL_3B = 0, INITVAL_3C =
  0, INITVAL_3D = 0, INITVAL_3E = 0, INITVAL_3F = 0
) (
  input  wire logic DIA17, DIA16, DIA15, DIA14, DIA13, DIA12, DIA11, DIA10, DIA9, DIA8, DIA7,
  DIA6, DIA5, DIA4, DIA3, DIA2, DIA1, DIA0,
  input  wire logic ADA13, ADA12, ADA11, ADA10, ADA9, ADA8, ADA7, ADA6, ADA5, ADA4, ADA3, ADA2,
  ADA1, ADA0,
  input  wire logic CEA, OCEA, CLKA, WEA, RSTA, CSA2, CSA1, CSA0,
  output logic      DOA17, DOA16, DOA15, DOA14, DOA13, DOA12, DOA11, DOA10, DOA9, DOA8, DOA7,
  DOA6, DOA5, DOA4, DOA3, DOA2, DOA1, DOA0,
  input  wire logic DIB17, DIB16, DIB15, DIB14, DIB13, DIB12, DIB11, DIB10, DIB9, DIB8, DIB7,
  DIB6, DIB5, DIB4, DIB3, DIB2, DIB1, DIB0,
  input  wire logic ADB13, ADB12, ADB11, ADB10, ADB9, ADB8, ADB7, ADB6, ADB5, ADB4, ADB3, ADB2,
  ADB1, ADB0,
  input  wire logic CEB, OCEB, CLKB, WEB, RSTB, CSB2, CSB1, CSB0,
  output logic      DOB17, DOB16, DOB15, DOB14, DOB13, DOB12, DOB11, DOB10, DOB9, DOB8, DOB7,
  DOB6, DOB5, DOB4, DOB3, DOB2, DOB1, DOB0
);
  localparam logic [64*320-1:0] Init = {
    INITVAL_3F, INITVAL_3E, INITVAL_3D, INITVAL_3C, INITVAL_3B, INITVAL_3A, INITVAL_39,
    INITVAL_38, INITVAL_37, INITVAL_36, INITVAL_35, INITVAL_34, INITVAL_33, INITVAL_32,
    INITVAL_31, INITVAL_30, INITVAL_2F, INITVAL_2E, INITVAL_2D, INITVAL_2C, INITVAL_2B,
    INITVAL_2A, INITVAL_29, INITVAL_28, INITVAL_27, INITVAL_26, INITVAL_25, INITVAL_24,
    INITVAL_23, INITVAL_22, INITVAL_21, INITVAL_20, INITVAL_1F, INITVAL_1E, INITVAL_1D,
    INITVAL_1C, INITVAL_1B, INITVAL_1A, INITVAL_19, INITVAL_18, INITVAL_17, INITVAL_16,
    INITVAL_15, INITVAL_14, INITVAL_13, INITVAL_12, INITVAL_11, INITVAL_10, INITVAL_0F,
    INITVAL_0E, INITVAL_0D, INITVAL_0C, INITVAL_0B, INITVAL_0A, INITVAL_09, INITVAL_08,
    INITVAL_07, INITVAL_06, INITVAL_05, INITVAL_04, INITVAL_03, INITVAL_02, INITVAL_01,
    INITVAL_00
  };

  logic [8:0] memory[2048];

  // A row pair is 20 bits of INITVAL, two of them unused.
  initial begin
    for (int n = 0; n < 2048; n++) memory[n] = Init[20*(n/2)+9*(n%2)+:9];
    if (REGMODE_A != "NOREG" || REGMODE_B != "NOREG" || CLKAMUX == "INV" || CLKBMUX == "INV")
      $fatal(1, "DP16KD: a mode that the model does not have");
  end

  function automatic logic [17:0] read(input logic [13:0] a, input int width);
    case (width)
      18: read = {memory[{a[13:4], 1'b1}], memory[{a[13:4], 1'b0}]};
      9: read = 18'(memory[a[13:3]]);
      4: read = 18'(memory[a[13:3]][{1'b0, a[2], 2'b00}+:4]);
      2: read = 18'(memory[a[13:3]][{1'b0, a[2:1], 1'b0}+:2]);
      default: read = 18'(memory[a[13:3]][{1'b0, a[2:0]}]);
    endcase
  endfunction

  // Port A is 0, port B is 1.
  localparam int Widths[2] = '{DATA_WIDTH_A, DATA_WIDTH_B};
  localparam bit ReadsOld[2] = '{WRITEMODE_A != "NORMAL", WRITEMODE_B != "NORMAL"};
  logic [13:0] a[2];
  logic [17:0] in[2], out[2];
  logic [1:0] clk, enable, write;

  assign clk = {CLKB, CLKA};
  assign enable = {CEB, CEA};
  assign write = {WEB, WEA};
  assign a[0] = {ADA13, ADA12, ADA11, ADA10, ADA9, ADA8, ADA7, ADA6, ADA5, ADA4, ADA3, ADA2, ADA1,
  ADA0};
  assign a[1] = {ADB13, ADB12, ADB11, ADB10, ADB9, ADB8, ADB7, ADB6, ADB5, ADB4, ADB3, ADB2, ADB1,
  ADB0};
  assign in[0] = {DIA17, DIA16, DIA15, DIA14, DIA13, DIA12, DIA11, DIA10, DIA9, DIA8, DIA7, DIA6,
  DIA5, DIA4, DIA3, DIA2, DIA1, DIA0};
  assign in[1] = {DIB17, DIB16, DIB15, DIB14, DIB13, DIB12, DIB11, DIB10, DIB9, DIB8, DIB7, DIB6,
  DIB5, DIB4, DIB3, DIB2, DIB1, DIB0};
  assign {DOA17, DOA16, DOA15, DOA14, DOA13, DOA12, DOA11, DOA10, DOA9, DOA8, DOA7, DOA6, DOA5,
  DOA4, DOA3, DOA2, DOA1, DOA0} = out[0];
  assign {DOB17, DOB16, DOB15, DOB14, DOB13, DOB12, DOB11, DOB10, DOB9, DOB8, DOB7, DOB6, DOB5,
  DOB4, DOB3, DOB2, DOB1, DOB0} = out[1];

  for (genvar p = 0; p < 2; p++) begin : g_port
    always @(posedge clk[p]) begin
      if (enable[p]) begin
        if (!write[p] || ReadsOld[p]) out[p] <= read(a[p], Widths[p]);
        if (write[p]) begin
          if (Widths[p] == 18) begin
            if (a[p][0]) memory[{a[p][13:4], 1'b0}] <= in[p][8:0];
            if (a[p][1]) memory[{a[p][13:4], 1'b1}] <= in[p][17:9];
          end else if (Widths[p] == 9) begin
            memory[a[p][13:3]] <= in[p][8:0];
          end else begin
            for (int n = 0; n < Widths[p]; n++)
              memory[a[p][13:3]][(4'(a[p][2:0])&4'(-Widths[p]))+4'(n)] <= in[p][n];
          end
        end
      end
    end
  end
endmodule

`default_nettype wire
