// SPDX-License-Identifier: Apache-2.0
// The machine with one card behind each of its host fronts but VME. §4.2.1
//
// front_i chooses 1 AXI4-Lite, 2 Wishbone classic, 3 pipelined, 4 APB; of 8 bits 5 Wishbone
// classic, 6 APB. The fronts of one bus share its pins.
`default_nettype none

module bench_hosts #(
  parameter int HeartbeatUs = 400
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  input  wire logic [ 2:0] front_i,
  input  wire logic [15:0] s_axil_awaddr,
  input  wire logic [ 2:0] s_axil_awprot,
  input  wire logic        s_axil_awvalid,
  output logic             s_axil_awready,
  input  wire logic [31:0] s_axil_wdata,
  input  wire logic [ 3:0] s_axil_wstrb,
  input  wire logic        s_axil_wvalid,
  output logic             s_axil_wready,
  output logic      [ 1:0] s_axil_bresp,
  output logic             s_axil_bvalid,
  input  wire logic        s_axil_bready,
  input  wire logic [15:0] s_axil_araddr,
  input  wire logic [ 2:0] s_axil_arprot,
  input  wire logic        s_axil_arvalid,
  output logic             s_axil_arready,
  output logic      [31:0] s_axil_rdata,
  output logic      [ 1:0] s_axil_rresp,
  output logic             s_axil_rvalid,
  input  wire logic        s_axil_rready,
  input  wire logic        wb_cyc_i,
  input  wire logic        wb_stb_i,
  input  wire logic        wb_we_i,
  input  wire logic [15:0] wb_adr_i,
  input  wire logic [ 3:0] wb_sel_i,
  input  wire logic [31:0] wb_dat_i,
  output logic      [31:0] wb_dat_o,
  output logic             wb_ack_o,
  output logic             wb_err_o,
  output logic             wb_stall_o,
  input  wire logic        apb_psel,
  input  wire logic        apb_penable,
  input  wire logic        apb_pwrite,
  input  wire logic [15:0] apb_paddr,
  input  wire logic [ 2:0] apb_pprot,
  input  wire logic [ 3:0] apb_pstrb,
  input  wire logic [31:0] apb_pwdata,
  output logic      [31:0] apb_prdata,
  output logic             apb_pready,
  output logic             apb_pslverr,
  // The machine
  input  wire logic        estop_closed_i,
  input  wire logic        cable_ok_i,
  input  wire logic        pc_power_i,
  output logic             sclock_o,
  output logic             irq_o,
  input  wire logic [ 1:0] enc_a_i,
  input  wire logic [ 1:0] enc_b_i,
  input  wire logic [ 1:0] enc_i_i,
  input  wire logic [ 1:0] axis_enable_i,
  output logic      [31:0] drive_v_o
);

  logic hp_ack;
  logic [7:0] hp_rdata, vector;
  logic [6:1] req, write;
  logic [6:1][10:1] a;
  logic [6:1][7:0] wdata;

  adaptor_axil u_axil (
    .clk_i, .rst_ni,
    .s_axil_awaddr, .s_axil_awprot, .s_axil_awvalid, .s_axil_awready,
    .s_axil_wdata, .s_axil_wstrb, .s_axil_wvalid, .s_axil_wready,
    .s_axil_bresp, .s_axil_bvalid, .s_axil_bready,
    .s_axil_araddr, .s_axil_arprot, .s_axil_arvalid, .s_axil_arready,
    .s_axil_rdata, .s_axil_rresp, .s_axil_rvalid, .s_axil_rready,
    .hp_req_o(req[1]), .hp_write_o(write[1]), .hp_a_o(a[1]), .hp_wdata_o(wdata[1]),
    .hp_ack_i(hp_ack & front_i == 1), .hp_rdata_i(hp_rdata),
    .vector_i(vector)
  );

  // Whose answer the shared pins are
  logic [6:2] ack, err, stall;
  logic [6:2][31:0] dat;
  assign {wb_dat_o, apb_prdata} = {2{dat[front_i]}};
  assign {wb_ack_o, apb_pready} = {2{ack[front_i]}};
  assign {wb_err_o, apb_pslverr} = {2{err[front_i]}};
  assign wb_stall_o = stall[front_i];
  assign {stall[6], stall[4], dat[6][31:8], dat[5][31:8]} = '0;

  adaptor_wb u_wb (
    .clk_i, .rst_ni, .wb_cyc_i(wb_cyc_i & front_i == 2), .wb_stb_i, .wb_we_i, .wb_adr_i,
    .wb_sel_i, .wb_dat_i, .wb_dat_o(dat[2]), .wb_ack_o(ack[2]), .wb_err_o(err[2]),
    .wb_stall_o(stall[2]), .hp_req_o(req[2]), .hp_write_o(write[2]), .hp_a_o(a[2]),
    .hp_wdata_o(wdata[2]), .hp_ack_i(hp_ack & front_i == 2), .hp_rdata_i(hp_rdata),
    .vector_i(vector)
  );

  adaptor_wb #(.Pipelined(1'b1)) u_wbp (
    .clk_i, .rst_ni, .wb_cyc_i(wb_cyc_i & front_i == 3), .wb_stb_i, .wb_we_i, .wb_adr_i,
    .wb_sel_i, .wb_dat_i, .wb_dat_o(dat[3]), .wb_ack_o(ack[3]), .wb_err_o(err[3]),
    .wb_stall_o(stall[3]), .hp_req_o(req[3]), .hp_write_o(write[3]), .hp_a_o(a[3]),
    .hp_wdata_o(wdata[3]), .hp_ack_i(hp_ack & front_i == 3), .hp_rdata_i(hp_rdata),
    .vector_i(vector)
  );

  adaptor_apb #(.DataWidth(32)) u_apb (
    .clk_i, .rst_ni, .apb_psel(apb_psel & front_i == 4), .apb_penable, .apb_pwrite, .apb_paddr,
    .apb_pprot, .apb_pstrb, .apb_pwdata, .apb_prdata(dat[4]),
    .apb_pready(ack[4]), .apb_pslverr(err[4]), .hp_req_o(req[4]), .hp_write_o(write[4]),
    .hp_a_o(a[4]), .hp_wdata_o(wdata[4]), .hp_ack_i(hp_ack & front_i == 4), .hp_rdata_i(hp_rdata),
    .vector_i(vector)
  );

  adaptor_wb #(.DataWidth(8)) u_wb8 (
    .clk_i, .rst_ni, .wb_cyc_i(wb_cyc_i & front_i == 5), .wb_stb_i, .wb_we_i, .wb_adr_i,
    .wb_sel_i(wb_sel_i[0]), .wb_dat_i(wb_dat_i[7:0]), .wb_dat_o(dat[5][7:0]),
    .wb_ack_o(ack[5]), .wb_err_o(err[5]), .wb_stall_o(stall[5]), .hp_req_o(req[5]),
    .hp_write_o(write[5]), .hp_a_o(a[5]), .hp_wdata_o(wdata[5]),
    .hp_ack_i(hp_ack & front_i == 5), .hp_rdata_i(hp_rdata),
    .vector_i(vector)
  );

  adaptor_apb #(.DataWidth(8)) u_apb8 (
    .clk_i, .rst_ni, .apb_psel(apb_psel & front_i == 6), .apb_penable, .apb_pwrite, .apb_paddr,
    .apb_pprot, .apb_pstrb(apb_pstrb[0]), .apb_pwdata(apb_pwdata[7:0]), .apb_prdata(dat[6][7:0]),
    .apb_pready(ack[6]), .apb_pslverr(err[6]), .hp_req_o(req[6]), .hp_write_o(write[6]),
    .hp_a_o(a[6]), .hp_wdata_o(wdata[6]), .hp_ack_i(hp_ack & front_i == 6), .hp_rdata_i(hp_rdata),
    .vector_i(vector)
  );

  /* verilator lint_off PINCONNECTEMPTY */
  mmcs_core #(
    .NumCards(1),
    .HeartbeatUs(HeartbeatUs),
    .RelayUs(20)
  ) u_mmcs (
    .clk_i, .rst_ni,
    .hp_req_i(|req),
    .hp_write_i(write[front_i]),
    .hp_a_i(a[front_i]),
    .hp_wdata_i(wdata[front_i]),
    .hp_ack_o(hp_ack),
    .hp_rdata_o(hp_rdata),
    .irq_req_o(irq_o),
    .vector_o(vector),
    .sysreset_ni(1'b1),
    .estop_closed_i, .cable_ok_i, .pc_power_i,
    .brake_release_o(),
    .alive_o(),
    .panic_o(),
    .sclock_o,
    .enc_a_i, .enc_b_i, .enc_i_i, .axis_enable_i,
    .dip_i(4'h0),
    .adc_v_i(32'h0),
    .drive_v_o,
    .card_leds_o(),
    .pcx_a_o(), .pcx_d_o(), .pcx_d_oe_o(), .pcx_ior_no(), .pcx_iow_no(),
    .pcx_aen_o(), .pcx_clk_en_o(), .pcx_reset_drv_o(), .pcx_drq_o(),
    .pcx_d_i(8'h0),
    .pcx_d_oe_i(1'b0),
    .pcx_wait_i(1'b0),
    .pcx_irq_i(5'h0)
  );
  /* verilator lint_on PINCONNECTEMPTY */

endmodule

`default_nettype wire
