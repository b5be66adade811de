// SPDX-License-Identifier: Apache-2.0
// The adaptor's PC bus on real pins: every output from a flip-flop, data through a transceiver, ALE
// and CLK as a PC has them. §4.2.1
//
// Commands come three clocks after the adaptor's, so that ALE and the transceiver are ahead of them.
// So a card has three clocks less than CmdNs from command to data.
`default_nettype none

module pcbus_pins (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  // Adaptor
  input  wire logic [15:0] a_i,
  input  wire logic        aen_i,
  input  wire logic [ 7:0] d_i,
  output logic      [ 7:0] d_o,
  input  wire logic        ior_ni,
  input  wire logic        iow_ni,
  input  wire logic        clk_en_i,
  input  wire logic        reset_drv_i,
  input  wire logic [ 3:1] drq_i,
  // Pins
  output logic      [15:0] pc_a,
  output logic             pc_ale,
  output logic             pc_aen,
  inout  wire       [ 7:0] pc_d,        // the FPGA's side of the transceiver
  output logic             pc_d_dir,    // 1: to the bus
  output logic             pc_d_oe_n,
  output logic             pc_ior_n,
  output logic             pc_iow_n,
  output logic             pc_clk,
  output logic             pc_reset_drv,
  output logic      [ 3:1] pc_drq
);

  localparam int Stages = 2;

  logic [Stages-1:0] ior_d, ior_q, iow_d, iow_q;   // the commands, high while low
  logic ior_nd, iow_nd, ale_d;                     // the pins
  logic iow_after_d, iow_after_q;                  // data stand a clock after IOW#
  logic writing, reading, drive;
  logic [15:0] a0_q;
  logic [7:0] d0_q, d_q;

  assign ior_d = {ior_q[0], ~ior_ni};
  assign iow_d = {iow_q[0], ~iow_ni};
  assign {ior_nd, iow_nd} = {~ior_q[1], ~iow_q[1]};
  assign iow_after_d = ~pc_iow_n;
  // Falls a clock before a command and rises when the command is over.
  assign ale_d = ~(ior_q[0] | iow_q[0] | ior_q[1] | iow_q[1]);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      ior_q        <= '0;
      iow_q        <= '0;
      iow_after_q  <= 1'b0;
      pc_ior_n     <= 1'b1;
      pc_iow_n     <= 1'b1;
      pc_ale       <= 1'b0;
      pc_aen       <= 1'b0;
      pc_clk       <= 1'b0;
      pc_reset_drv <= 1'b1;
      pc_drq       <= '0;
      a0_q         <= '0;
      pc_a         <= '0;
      d0_q         <= '0;
      d_q          <= '0;
    end else begin
      ior_q        <= ior_d;
      iow_q        <= iow_d;
      iow_after_q  <= iow_after_d;
      pc_ior_n     <= ior_nd;
      pc_iow_n     <= iow_nd;
      pc_ale       <= ale_d;
      pc_aen       <= aen_i;
      pc_clk       <= clk_en_i;
      pc_reset_drv <= reset_drv_i;
      pc_drq       <= drq_i;
      a0_q         <= a_i;
      pc_a         <= a0_q;
      d0_q         <= d_i;
      d_q          <= d0_q;
    end
  end

  assign writing = ~iow_ni | (|iow_q) | ~pc_iow_n | iow_after_q;
  assign reading = ~pc_ior_n;

  data_turn u_turn (
    .clk_i, .rst_ni,
    .out_i(writing),
    .in_i(reading),
    .gate_i(1'b1),
    .dir_o(pc_d_dir),
    .oe_no(pc_d_oe_n),
    .drive_o(drive)
  );

  assign pc_d = drive ? d_q : 8'hzz;
  assign d_o = pc_d;

endmodule

`default_nettype wire
