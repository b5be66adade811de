// SPDX-License-Identifier: Apache-2.0
// The machine with one card behind each of its host fronts. §4.2.1
//
// HostPort 0: VME. 1: front_i chooses 1 AXI4-Lite, 2 Wishbone classic, 3 pipelined, 4 APB; of 8 bits
// 5 Wishbone classic, 6 APB.
`default_nettype none

module bench_hosts #(
  parameter bit HostPort = 1'b1,
  parameter int HeartbeatUs = 400
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  input  wire logic [ 2:0] front_i,
  input  wire logic [15:1] vme_a_i,
  input  wire logic [ 5:0] vme_am_i,
  input  wire logic        vme_as_ni,
  input  wire logic [ 1:0] vme_ds_ni,
  input  wire logic        vme_write_ni,
  input  wire logic        vme_lword_ni,
  input  wire logic [15:0] vme_d_i,
  output logic      [15:0] vme_d_o,
  output logic             vme_d_oe_o,
  output logic             vme_dtack_no,
  input  wire logic        vme_iack_ni,
  input  wire logic        vme_iackin_ni,
  output logic             vme_iackout_no,
  output logic      [ 7:1] vme_irq_no,
  input  wire logic        vme_sysreset_ni,
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
  input  wire logic        wbp_cyc_i,
  input  wire logic        wbp_stb_i,
  input  wire logic        wbp_we_i,
  input  wire logic [15:0] wbp_adr_i,
  input  wire logic [ 3:0] wbp_sel_i,
  input  wire logic [31:0] wbp_dat_i,
  output logic      [31:0] wbp_dat_o,
  output logic             wbp_ack_o,
  output logic             wbp_err_o,
  output logic             wbp_stall_o,
  input  wire logic        wb8_cyc_i,
  input  wire logic        wb8_stb_i,
  input  wire logic        wb8_we_i,
  input  wire logic [15:0] wb8_adr_i,
  input  wire logic [ 0:0] wb8_sel_i,
  input  wire logic [ 7:0] wb8_dat_i,
  output logic      [ 7:0] wb8_dat_o,
  output logic             wb8_ack_o,
  output logic             wb8_err_o,
  output logic             wb8_stall_o,
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
  input  wire logic        apb8_psel,
  input  wire logic        apb8_penable,
  input  wire logic        apb8_pwrite,
  input  wire logic [15:0] apb8_paddr,
  input  wire logic [ 2:0] apb8_pprot,
  input  wire logic [ 0:0] apb8_pstrb,
  input  wire logic [ 7:0] apb8_pwdata,
  output logic      [ 7:0] apb8_prdata,
  output logic             apb8_pready,
  output logic             apb8_pslverr,
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
  logic [7:0] hp_rdata;
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
    .hp_ack_i(hp_ack & front_i == 1), .hp_rdata_i(hp_rdata)
  );

  adaptor_wb #() u_wb (
    .clk_i, .rst_ni,
    .wb_cyc_i(wb_cyc_i), .wb_stb_i(wb_stb_i), .wb_we_i(wb_we_i),
    .wb_adr_i(wb_adr_i), .wb_sel_i(wb_sel_i), .wb_dat_i(wb_dat_i), .wb_dat_o(wb_dat_o),
    .wb_ack_o(wb_ack_o), .wb_err_o(wb_err_o), .wb_stall_o(wb_stall_o),
    .hp_req_o(req[2]), .hp_write_o(write[2]), .hp_a_o(a[2]), .hp_wdata_o(wdata[2]),
    .hp_ack_i(hp_ack & front_i == 2), .hp_rdata_i(hp_rdata)
  );

  adaptor_wb #(.Pipelined(1'b1)) u_wbp (
    .clk_i, .rst_ni,
    .wb_cyc_i(wbp_cyc_i), .wb_stb_i(wbp_stb_i), .wb_we_i(wbp_we_i),
    .wb_adr_i(wbp_adr_i), .wb_sel_i(wbp_sel_i), .wb_dat_i(wbp_dat_i), .wb_dat_o(wbp_dat_o),
    .wb_ack_o(wbp_ack_o), .wb_err_o(wbp_err_o), .wb_stall_o(wbp_stall_o),
    .hp_req_o(req[3]), .hp_write_o(write[3]), .hp_a_o(a[3]), .hp_wdata_o(wdata[3]),
    .hp_ack_i(hp_ack & front_i == 3), .hp_rdata_i(hp_rdata)
  );

  adaptor_apb #(.DataWidth(32)) u_apb (
    .clk_i, .rst_ni,
    .apb_psel(apb_psel), .apb_penable(apb_penable), .apb_pwrite(apb_pwrite), .apb_paddr(apb_paddr),
    .apb_pprot(apb_pprot), .apb_pstrb(apb_pstrb), .apb_pwdata(apb_pwdata),
    .apb_prdata(apb_prdata), .apb_pready(apb_pready), .apb_pslverr(apb_pslverr),
    .hp_req_o(req[4]), .hp_write_o(write[4]), .hp_a_o(a[4]), .hp_wdata_o(wdata[4]),
    .hp_ack_i(hp_ack & front_i == 4), .hp_rdata_i(hp_rdata)
  );

  adaptor_wb #(.DataWidth(8)) u_wb8 (
    .clk_i, .rst_ni,
    .wb_cyc_i(wb8_cyc_i), .wb_stb_i(wb8_stb_i), .wb_we_i(wb8_we_i),
    .wb_adr_i(wb8_adr_i), .wb_sel_i(wb8_sel_i), .wb_dat_i(wb8_dat_i), .wb_dat_o(wb8_dat_o),
    .wb_ack_o(wb8_ack_o), .wb_err_o(wb8_err_o), .wb_stall_o(wb8_stall_o),
    .hp_req_o(req[5]), .hp_write_o(write[5]), .hp_a_o(a[5]), .hp_wdata_o(wdata[5]),
    .hp_ack_i(hp_ack & front_i == 5), .hp_rdata_i(hp_rdata)
  );

  adaptor_apb #(.DataWidth(8)) u_apb8 (
    .clk_i, .rst_ni,
    .apb_psel(apb8_psel), .apb_penable(apb8_penable), .apb_pwrite(apb8_pwrite),
    .apb_paddr(apb8_paddr),
    .apb_pprot(apb8_pprot), .apb_pstrb(apb8_pstrb), .apb_pwdata(apb8_pwdata),
    .apb_prdata(apb8_prdata), .apb_pready(apb8_pready), .apb_pslverr(apb8_pslverr),
    .hp_req_o(req[6]), .hp_write_o(write[6]), .hp_a_o(a[6]), .hp_wdata_o(wdata[6]),
    .hp_ack_i(hp_ack & front_i == 6), .hp_rdata_i(hp_rdata)
  );

  /* verilator lint_off PINCONNECTEMPTY */
  mmcs #(
    .NumCards(1),
    .HeartbeatUs(HeartbeatUs),
    .RelayUs(20),
    .HostPort(HostPort)
  ) u_mmcs (
    .clk_i, .rst_ni,
    .vme_a_i, .vme_am_i, .vme_as_ni, .vme_ds_ni, .vme_write_ni, .vme_lword_ni, .vme_d_i, .vme_d_o,
    .vme_d_oe_o, .vme_dtack_no, .vme_iack_ni, .vme_iackin_ni, .vme_iackout_no, .vme_irq_no,
    .vme_sysreset_ni, .estop_closed_i, .cable_ok_i, .pc_power_i,
    .brake_release_o(),
    .panic_o(),
    .sclock_o,
    .led_irq_o(irq_o),
    .enc_a_i, .enc_b_i, .enc_i_i, .axis_enable_i,
    .dip_i(4'h0),
    .adc_v_i(32'h0),
    .drive_v_o,
    .card_leds_o(),
    .pcx_a_o(), .pcx_d_o(), .pcx_ior_no(), .pcx_iow_no(), .pcx_aen_o(), .pcx_clk_en_o(),
    .pcx_reset_drv_o(), .pcx_drq_o(),
    .pcx_d_i(8'h0),
    .pcx_d_oe_i(1'b0),
    .pcx_wait_i(1'b0),
    .pcx_irq_i(5'h0),
    .hp_req_i(|req),
    .hp_write_i(write[front_i]),
    .hp_a_i(a[front_i]),
    .hp_wdata_i(wdata[front_i]),
    .hp_ack_o(hp_ack),
    .hp_rdata_o(hp_rdata)
  );
  /* verilator lint_on PINCONNECTEMPTY */

endmodule

`default_nettype wire
