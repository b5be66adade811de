// SPDX-License-Identifier: Apache-2.0
// The chips under replayed pins, one word a clock; what the outputs were is written down. The
// comparison with the reference models happens afterwards in Python: a hundred thousand operations
// take seconds, in Verilator and Icarus alike.
`default_nettype none

module bench_chips #(
  parameter int Depth = 262_144
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  input  wire logic        go_i,       // a rising edge starts one replay
  input  wire logic [31:0] id_i,       // files are stim_<id>.hex and resp_<id>.hex
  input  wire logic [31:0] length_i,   // words in the file
  input  wire logic [ 1:0] chip_i,     // analog, i8254, i8255, thct2000
  input  wire logic [ 1:0] variant_i,  // of the chip
  output logic             done_o
);

  localparam int InBits = 41;
  localparam int OutBits = 57;

  logic [InBits-1:0] words[0:Depth-1];
  logic [InBits-1:0] stim;
  logic [3:0][OutBits-1:0] resp;   // as seen by the clock edge that also sees stim
  logic [3:0] clk;                 // only the chip that is replayed is clocked
  logic go_q = 1'b0;
  logic busy = 1'b0;
  int at = 0;
  int file = 0;
  string name;

  initial done_o = 1'b0;
  assign clk = 4'(clk_i) << chip_i;

  always @(posedge clk_i) begin
    go_q <= go_i;
    if (go_i && !go_q) begin
      name = $sformatf("stim_%0d.hex", id_i);
      $readmemh(name, words, 0, length_i - 1);
      name = $sformatf("resp_%0d.hex", id_i);
      file = $fopen(name, "w");
      stim <= words[0];
      at <= 1;
      busy <= 1'b1;
      done_o <= 1'b0;
    end else if (busy) begin
      $fwrite(file, "%h\n", resp[chip_i]);
      if (at == length_i) begin
        $fclose(file);
        busy <= 1'b0;
        done_o <= 1'b1;
      end else begin
        stim <= words[at];
        at <= at + 1;
      end
    end
  end

  // --- A/D, D/A and one-shot, side by side ----------------------------------------------------

  logic ce, ad_cs_n, rc_n, ad_a0, mode12, span10, da_cs_n, trig, clr_n;
  logic [3:0] da_a_n;
  logic [11:0] da_d;
  logic [15:0] vin;

  assign {clr_n, trig, da_d, da_a_n, da_cs_n, vin, span10, mode12, ad_a0, rc_n, ad_cs_n, ce} =
      busy && chip_i == 2'd0 ? stim : {2'b10, 12'h000, 4'hF, 1'b1, 16'h0000, 6'b010110};

  ad667 u_da (
    .clk_i(clk[0]), .rst_ni, .cs_ni(da_cs_n), .a_ni(da_a_n), .d_i(da_d), .code_o(resp[0][25:14])
  );

  ad574 #(.ConvClks(201)) u_ad (
    .clk_i(clk[0]), .rst_ni,
    .ce_i(ce), .cs_ni(ad_cs_n), .rc_ni(rc_n), .a0_i(ad_a0), .mode12_i(mode12), .span10_i(span10),
    .vin_i(vin),
    .sts_o(resp[0][13]), .db_o(resp[0][11:0]), .db_oe_o(resp[0][12])
  );

  oneshot #(.PulseClks(20)) u_shot (
    .clk_i(clk[0]), .rst_ni, .trig_i(trig), .clr_ni(clr_n), .q_o(resp[0][26])
  );

  assign resp[0][OutBits-1:27] = '0;

  // --- the 8254: NMOS and CHMOS part; bit 1 of the variant: CLK1 = OUT0 and CLK2 = OUT1 --------

  logic [7:0] pit_d;
  logic [1:0] pit_a;
  logic pit_cs_n, pit_rd_n, pit_wr_n, cascade;
  logic [2:0] rise, fall, gate;
  logic [1:0][17:0] pit;

  assign {gate, fall, rise, pit_wr_n, pit_rd_n, pit_cs_n, pit_a, pit_d} =
      busy && chip_i == 2'd1 ? stim[21:0] : 22'h381C00;
  assign cascade = variant_i[1];
  assign resp[1] = OutBits'(pit[variant_i[0]]);

  for (genvar v = 0; v < 2; v++) begin : g_i8254
    logic rise0, fall0, rise1, fall1, rise2, fall2;

    i8254 #(
      .NmosRewrite(v == 0),
      .SplitCr(v == 0)
    ) u_part (
      .clk_i(clk[1]), .rst_ni,
      .cs_ni(pit_cs_n), .rd_ni(pit_rd_n), .wr_ni(pit_wr_n), .a_i(pit_a), .d_i(pit_d),
      .d_o(pit[v][7:0]), .d_oe_o(pit[v][8]),
      .clk0_rise_i(rise[0]), .clk0_fall_i(fall[0]),
      .clk1_rise_i(cascade ? rise0 : rise[1]), .clk1_fall_i(cascade ? fall0 : fall[1]),
      .clk2_rise_i(cascade ? rise1 : rise[2]), .clk2_fall_i(cascade ? fall1 : fall[2]),
      .gate_i(gate),
      .out_o(pit[v][11:9]),
      .out0_rise_o(rise0), .out0_fall_o(fall0),
      .out1_rise_o(rise1), .out1_fall_o(fall1),
      .out2_rise_o(rise2), .out2_fall_o(fall2)
    );

    assign pit[v][17:12] = {fall2, fall1, fall0, rise2, rise1, rise0};
  end

  // --- the 8255A: control word write-only, and readable ---------------------------------------

  logic ppi_reset, ppi_cs_n, ppi_rd_n, ppi_wr_n;
  logic [1:0] ppi_a;
  logic [7:0] ppi_d, pa, pb, pc;
  logic [1:0][OutBits-1:0] ppi;

  assign {pc, pb, pa, ppi_d, ppi_a, ppi_wr_n, ppi_rd_n, ppi_cs_n, ppi_reset} =
      busy && chip_i == 2'd2 ? stim[37:0] : 38'hE;
  assign resp[2] = ppi[variant_i[0]];

  for (genvar v = 0; v < 2; v++) begin : g_i8255
    i8255 #(
      .ControlReadable(v == 1)
    ) u_part (
      .clk_i(clk[2]), .rst_ni,
      .reset_i(ppi_reset),
      .cs_ni(ppi_cs_n), .rd_ni(ppi_rd_n), .wr_ni(ppi_wr_n), .a_i(ppi_a), .d_i(ppi_d),
      .d_o(ppi[v][7:0]), .d_oe_o(ppi[v][8]),
      .pa_i(pa), .pa_o(ppi[v][16:9]), .pa_oe_o(ppi[v][24:17]),
      .pb_i(pb), .pb_o(ppi[v][32:25]), .pb_oe_o(ppi[v][40:33]),
      .pc_i(pc), .pc_o(ppi[v][48:41]), .pc_oe_o(ppi[v][56:49])
    );
  end

  // --- the encoder chip: plain, and with Filter = 2 -------------------------------------------

  logic enc_reset, clk_en, a, b, latch, other, enc_cs_n, enc_rd_n, enc_wr_n, rs;
  logic [2:0] m;
  logic [7:0] enc_d;
  logic [1:0][25:0] enc;

  assign {other, enc_d, rs, enc_wr_n, enc_rd_n, enc_cs_n, latch, b, a, m, clk_en, enc_reset} =
      busy && chip_i == 2'd3 ? stim[20:0] : 21'h000702;
  assign resp[3] = OutBits'(enc[variant_i[0]]);

  for (genvar v = 0; v < 2; v++) begin : g_thct2000
    thct2000 #(
      .Filter(2 * v)
    ) u_part (
      .clk_i(clk[3]), .rst_ni,
      .reset_i(enc_reset), .clk_en_i(clk_en), .m_i(m), .a_i(a), .b_i(b),
      .latch_i(latch), .other_i(other),
      .cs_ni(enc_cs_n), .rd_ni(enc_rd_n), .wr_ni(enc_wr_n), .rs_i(rs), .d_i(enc_d),
      .d_o(enc[v][7:0]), .d_oe_o(enc[v][8]), .count_o(enc[v][24:9]), .illegal_o(enc[v][25])
    );
  end

endmodule

`default_nettype wire
