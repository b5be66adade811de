// SPDX-License-Identifier: Apache-2.0
// A card of one's own: a pulse-width modulator and a counter of its pulses.
//
//   address    write                                 read
//   Base       duty, of 256                          pulses so far
//   Base + 1   bit 0: run                            bit 0: the output
`default_nettype none

module pwm_card #(
  // PC address: bits 13-10 the slot, 9-5 those of all cards, 4-0 the register
  parameter logic [13:0] Base = {4'd14, 5'h18, 5'd0}
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  input  wire logic        pc_reset_drv_i,
  input  wire logic [15:0] pc_a_i,
  input  wire logic        pc_aen_i,
  input  wire logic        pc_ior_ni,
  input  wire logic        pc_iow_ni,
  input  wire logic [ 7:0] pc_d_i,
  output logic      [ 7:0] pc_d_o,
  output logic             pc_d_oe_o
);

  logic selected, writing, writing_q, write, out;
  logic [7:0] duty_q, phase_q, pulses_q, d_q;
  logic run_q, register_q;

  assign selected = !pc_aen_i && pc_a_i[13:1] == Base[13:1];

  // A write takes effect at the end of IOW#, with the data and the address of the clock before.
  assign writing = selected && !pc_iow_ni;
  assign write = writing_q && !writing;
  assign out = run_q && phase_q < duty_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      writing_q <= 1'b0;
      register_q <= 1'b0;
      d_q <= '0;
      run_q <= 1'b0;
      duty_q <= '0;
      phase_q <= '0;
      pulses_q <= '0;
    end else begin
      writing_q <= writing;
      register_q <= pc_a_i[0];
      d_q <= pc_d_i;
      if (run_q) phase_q <= phase_q + 8'd1;
      if (run_q && phase_q == 8'hFF) pulses_q <= pulses_q + 8'd1;
      if (write && !register_q) duty_q <= d_q;
      if (write && register_q) run_q <= d_q[0];
      if (pc_reset_drv_i) run_q <= 1'b0;
    end
  end

  assign pc_d_oe_o = selected && !pc_ior_ni;
  assign pc_d_o = pc_a_i[0] ? {7'd0, out} : pulses_q;

endmodule

`default_nettype wire
