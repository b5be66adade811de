// SPDX-License-Identifier: Apache-2.0
// A card of one's own with a joint: a pulse-width modulator drives it, a counter follows its encoder.
//
//   address    write                                 read
//   Base       duty, of 256; 128 is no voltage       counts, bits 7 to 0
//   Base + 1   bit 0: run                            counts, bits 15 to 8 of the last read of Base
`default_nettype none

module pwm_card #(
  parameter int Slot = 14,  // the machine says it
  // PC address: bits 13-10 the slot, 9-5 those of all cards, 4-0 the register
  parameter logic [13:0] Base = {4'(Slot), 5'h18, 5'd0}
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  input  wire logic [15:0] pc_a_i,
  input  wire logic        pc_aen_i,
  input  wire logic        pc_ior_ni,
  input  wire logic        pc_iow_ni,
  input  wire logic [ 7:0] pc_d_i,
  output logic      [ 7:0] pc_d_o,
  output logic             pc_d_oe_o,
  input  wire logic        enc_a_i, enc_b_i, enc_i_i,
  output logic      [15:0] drive_v_o   // of the amplifier, 32768 = 10 V
);

  logic selected, writing, writing_q, write, out, reading_low;
  logic [7:0] duty_q, phase_q, high_q, d_q;
  logic run_q, register_q;

  assign selected = !pc_aen_i && pc_a_i[13:1] == Base[13:1];

  // A write takes effect at the end of IOW#, with the data and the address of the clock before.
  assign writing = selected && !pc_iow_ni;
  assign write = writing_q && !writing;
  assign out = phase_q < duty_q;
  assign reading_low = selected && !pc_ior_ni && !pc_a_i[0];

  // The amplifier's voltage is taken every 50 us: it comes through a low-pass, of 0.5 ms.
  logic signed [15:0] level;
  logic signed [27:0] sum_q;
  assign level = !run_q ? 16'sd0 : out ? 16'sd32767 : -16'sd32767;
  assign drive_v_o = sum_q[27:12];

  // The wires of the encoder come at any time: two flip-flops. Then a change of one is a count.
  logic [1:0] first_q, pair_q, before_q;
  logic [15:0] count_q;
  logic moved;
  assign moved = ^(pair_q ^ before_q);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      {writing_q, register_q, run_q} <= '0;
      {d_q, duty_q, phase_q, high_q} <= '0;
      {first_q, pair_q, before_q, count_q, sum_q} <= '0;
    end else begin
      writing_q <= writing;
      register_q <= pc_a_i[0];
      d_q <= pc_d_i;
      if (write && !register_q) duty_q <= d_q;
      if (write && register_q) run_q <= d_q[0];
      if (run_q) phase_q <= phase_q + 8'd1;
      sum_q <= sum_q + 28'(level) - 28'(signed'(drive_v_o));
      first_q <= {enc_a_i, enc_b_i};
      pair_q <= first_q;
      before_q <= pair_q;
      if (moved) count_q <= pair_q[1] ^ before_q[0] ? count_q + 16'd1 : count_q - 16'd1;
      if (reading_low) high_q <= count_q[15:8];
    end
  end

  assign pc_d_oe_o = selected && !pc_ior_ni;
  assign pc_d_o = pc_a_i[0] ? high_q : count_q[7:0];

endmodule

`default_nettype wire
