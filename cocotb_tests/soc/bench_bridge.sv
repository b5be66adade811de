// SPDX-License-Identifier: Apache-2.0
// The bridge of the SoC at the host port of a real adaptor core, with counters in between.
`default_nettype none

module bench_bridge #(
  parameter int TimeoutClks = 128
) (
  input  wire logic        cpu_clk_i,
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  input  wire logic        start_i,
  input  wire logic        clock_i,
  input  wire logic        write_i,
  input  wire logic [10:1] a_i,
  input  wire logic [ 7:0] wdata_i,
  output logic             busy_o,
  output logic             done_o,
  output logic      [31:0] rdata_o,
  output logic             err_o,
  input  wire logic [31:0] us_i,
  input  wire logic        deaf_i,        // the adaptor's answers are lost
  input  wire logic [ 7:0] pc_d_i,
  output logic             irq_o,
  output logic      [ 7:0] vector_o,
  // What happened at the host port
  output logic      [15:0] reads_o,
  output logic      [15:0] writes_o,
  output logic      [10:1] last_a_o
);

  logic hp_req, hp_write, hp_ack, ack, deaf_q;
  logic [10:1] hp_a;
  logic [7:0] hp_wdata, hp_rdata;

  soc_bridge #(
    .TimeoutClks(TimeoutClks)
  ) u_bridge (
    .clk_i(cpu_clk_i),
    .rst_ni, .start_i, .clock_i, .write_i, .a_i, .wdata_i, .busy_o, .done_o, .rdata_o, .err_o,
    .far_clk_i(clk_i),
    .far_rst_ni(rst_ni),
    .us_i,
    .hp_req_o(hp_req),
    .hp_write_o(hp_write),
    .hp_a_o(hp_a),
    .hp_wdata_o(hp_wdata),
    .hp_ack_i(ack),
    .hp_rdata_i(hp_rdata)
  );

  // An adaptor that is deaf sees nothing; one that hears again answers what still stands there.
  assign ack = hp_ack & ~deaf_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      reads_o  <= '0;
      writes_o <= '0;
      last_a_o <= '0;
      deaf_q   <= 1'b0;
    end else begin
      deaf_q <= deaf_i;
      if (ack) begin
        last_a_o <= hp_a;
        if (hp_write) writes_o <= writes_o + 1'b1;
        else reads_o <= reads_o + 1'b1;
      end
    end
  end

  /* verilator lint_off PINCONNECTEMPTY */  // no cards: the host's side only
  adaptor_core u_core (
    .clk_i, .rst_ni,
    .hp_req_i(hp_req & ~deaf_q),
    .hp_write_i(hp_write),
    .hp_a_i(hp_a),
    .hp_wdata_i(hp_wdata),
    .hp_ack_o(hp_ack),
    .hp_rdata_o(hp_rdata),
    .irq_req_o(irq_o),
    .vector_o,
    .sys_reset_i(1'b0),
    .sys_reset_o(),
    .estop_closed_i(1'b1),
    .cable_ok_i(1'b1),
    .pc_power_i(1'b1),
    .panic_o(),
    .brake_release_o(),
    .alive_o(),
    .sclock_o(),
    .pc_a_o(),
    .pc_aen_o(),
    .pc_d_o(),
    .pc_d_oe_o(),
    .pc_ior_no(),
    .pc_iow_no(),
    .pc_clk_en_o(),
    .pc_reset_drv_o(),
    .pc_drq_o(),
    .pc_power_o(),
    .pc_d_i,
    .pc_wait_i(1'b0),
    .pc_irq_i('0)
  );
  /* verilator lint_on PINCONNECTEMPTY */

endmodule

`default_nettype wire
