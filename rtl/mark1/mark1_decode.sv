// SPDX-License-Identifier: Apache-2.0
// Card address decoder: A9-A5 = 11000, A13-A10 = DIP switch, A4-A0 the register. §5.3.1
`default_nettype none

module mark1_decode (
  // PC bus; a switch that is on stands for 0, so dip_i is the card number
  input  wire logic [13:0] pc_a_i,
  input  wire logic        pc_aen_i,
  input  wire logic        pc_ior_ni,
  input  wire logic        pc_iow_ni,
  input  wire logic [ 3:0] dip_i,
  // Chip selects, active only while a command is low
  output logic             ppi_cs_no,
  output logic      [ 1:0] enc_cs_no,
  // Strobes of what has no chip select of its own, high while the command is low
  output logic      [ 1:0] dac_lo_o,
  output logic      [ 1:0] dac_hi_o,
  output logic             adc_read_o,
  output logic             sw_latch_o,  // software latch: this card's, or that of all cards
  output logic             ours_o       // a command for this card, whatever it is for
);

  localparam logic [13:0] CardMask = 14'h03E0;
  localparam logic [13:0] DipMask = 14'h3C00;

  logic command, board, ours;
  logic [4:0] register;

  assign register = pc_a_i[4:0];
  assign command = ~(pc_ior_ni & pc_iow_ni);
  assign board = command && !pc_aen_i &&
                 (pc_a_i & CardMask) == {4'b0000, mmcs_regs_pkg::CARD_SELECT, 5'b00000};
  assign ours = board && (pc_a_i & DipMask) == {dip_i, 10'b0};

  assign ours_o = ours;

  always_comb begin
    ppi_cs_no  = 1'b1;
    enc_cs_no  = 2'b11;
    dac_lo_o   = 2'b00;
    dac_hi_o   = 2'b00;
    adc_read_o = 1'b0;
    sw_latch_o = 1'b0;
    if (board && register == mmcs_regs_pkg::CARD_LATCH_ALL) sw_latch_o = 1'b1;
    if (ours) begin
      case (register)
        mmcs_regs_pkg::CARD_PPI_A, mmcs_regs_pkg::CARD_PPI_B, mmcs_regs_pkg::CARD_PPI_C,
        mmcs_regs_pkg::CARD_PPI_CONTROL: ppi_cs_no = 1'b0;
        mmcs_regs_pkg::CARD_ENC1_MSB, mmcs_regs_pkg::CARD_ENC1_LSB: enc_cs_no[0] = 1'b0;
        mmcs_regs_pkg::CARD_ENC2_MSB, mmcs_regs_pkg::CARD_ENC2_LSB: enc_cs_no[1] = 1'b0;
        mmcs_regs_pkg::CARD_DAC1_LO: dac_lo_o[0] = ~pc_iow_ni;
        mmcs_regs_pkg::CARD_DAC1_HI: dac_hi_o[0] = ~pc_iow_ni;
        mmcs_regs_pkg::CARD_DAC2_LO: dac_lo_o[1] = ~pc_iow_ni;
        mmcs_regs_pkg::CARD_DAC2_HI: dac_hi_o[1] = ~pc_iow_ni;
        mmcs_regs_pkg::CARD_ADC1_LO, mmcs_regs_pkg::CARD_ADC2_LO,
        mmcs_regs_pkg::CARD_ADC_HI: adc_read_o = ~pc_ior_ni;
        mmcs_regs_pkg::CARD_LATCH: sw_latch_o = 1'b1;
        default: ;
      endcase
    end
  end

endmodule

`default_nettype wire
