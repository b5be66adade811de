// SPDX-License-Identifier: Apache-2.0
// A host front at the adaptor's core: its bus's rules, and never wedged. §4.2.1
//
// The timers are cut out: what they do is free. So are the cards, the cable, the power and the
// button: read data, IOCHRDY, PANIC.
`default_nettype none
`include "mmcs_formal.svh"

module fronts_props #(
  parameter int Front = 1,      // 1 AXI4-Lite, 2 Wishbone classic, 3 pipelined, 4 APB
  parameter int Slowest = 19,   // clocks of a request at the host port
  parameter int Longest = 44    // clocks from an access to its answer, one other before it
) (
  input wire logic        clk_i,
  input wire logic [15:0] a_i,
  input wire logic [15:0] b_i,
  input wire logic [31:0] data_i,
  input wire logic [ 3:0] sel_i,
  input wire logic        write_i,
  input wire logic        want_i,     // of the master: write address, strobe, select
  input wire logic        also_i,     // write data, cycle, enable
  input wire logic        other_i,    // read address
  input wire logic        take_i,     // ready for the answer
  input wire logic        take2_i,
  input wire logic        sys_reset_i,
  input wire logic        estop_closed_i,
  input wire logic        cable_ok_i,
  input wire logic        pc_power_i,
  input wire logic [ 7:0] pc_d_i,
  input wire logic        pc_wait_i,
  input wire logic [ 7:3] pc_irq_i
);

  `MMCS_RESET(1'b1)

  // --- host port ---------------------------------------------------------------------------

  logic hp_req, hp_write, req_q = 1'b0, ack_q = 1'b0, write_q = 1'b0;
  logic [10:1] hp_a, a_q = '0;
  logic [7:0] hp_wdata, wdata_q = '0, asked_q = '0;
  logic hp_ack;
  logic [7:0] hp_rdata, vector;

  adaptor_core u_core (
    .clk_i, .rst_ni,
    .hp_req_i(hp_req),
    .hp_write_i(hp_write),
    .hp_a_i(hp_a),
    .hp_wdata_i(hp_wdata),
    .hp_ack_o(hp_ack),
    .hp_rdata_o(hp_rdata),
    .vector_o(vector),
    .sys_reset_i,
    .estop_closed_i, .cable_ok_i, .pc_power_i,
    .pc_d_i, .pc_wait_i, .pc_irq_i
  );

  always @(posedge clk_i) begin
    if (rst_ni) begin
      req_q   <= hp_req;
      ack_q   <= hp_ack;
      a_q     <= hp_a;
      write_q <= hp_write;
      wdata_q <= hp_wdata;
      asked_q <= (hp_req && !hp_ack) ? asked_q + 8'd1 : 8'd0;
    end
  end

  `MMCS_PROVE(CoreAnswers, "4.2.1", hp_req, asked_q < 8'(Slowest),
              "The core answers a request within 19 clocks, whatever IOCHRDY and the link do.")
  `MMCS_PROVE(AnswersAsked, "4.2.1", hp_ack, hp_req, "The core answers what it is asked.")
  `MMCS_PROVE(RequestHeld, "4.2.1", req_q && !ack_q,
              hp_req && hp_a == a_q && hp_write == write_q && hp_wdata == wdata_q,
              "A request at the host port stands unchanged until it is answered.")
  `MMCS_PROVE(RequestEnds, "4.2.1", ack_q, !hp_req,
              "After an answer the request goes for a clock at least.")

  // --- buses -------------------------------------------------------------------------------

  logic [7:0] waited_q = '0;
  if (Front == 1) begin : g_axil
    logic awready, wready, arready, bvalid, rvalid;
    logic [1:0] bresp, rresp;
    logic [31:0] rdata;
    logic aw_q = 1'b0, w_q = 1'b0, ar_q = 1'b0, bvalid_q = 1'b0, rvalid_q = 1'b0;
    logic b_taken_q = 1'b0, r_taken_q = 1'b0;
    logic [15:0] awaddr_q = '0, araddr_q = '0;
    logic [31:0] wdata_in_q = '0, rdata_was_q = '0;
    logic [3:0] wstrb_q = '0;
    logic [1:0] bresp_q = '0, rresp_q = '0;
    logic [7:0] read_waited_q = '0;
    logic [1:0] writes_q = '0, reads_q = '0;   // accepted and not yet answered

    adaptor_axil dut (
      .clk_i, .rst_ni,
      .s_axil_awaddr(a_i), .s_axil_awprot(3'b0), .s_axil_awvalid(want_i), .s_axil_awready(awready),
      .s_axil_wdata(data_i), .s_axil_wstrb(sel_i), .s_axil_wvalid(also_i), .s_axil_wready(wready),
      .s_axil_bresp(bresp), .s_axil_bvalid(bvalid), .s_axil_bready(take_i),
      .s_axil_araddr(b_i), .s_axil_arprot(3'b0), .s_axil_arvalid(other_i), .s_axil_arready(arready),
      .s_axil_rdata(rdata), .s_axil_rresp(rresp), .s_axil_rvalid(rvalid), .s_axil_rready(take2_i),
      .hp_req_o(hp_req), .hp_write_o(hp_write), .hp_a_o(hp_a), .hp_wdata_o(hp_wdata),
      .hp_ack_i(hp_ack), .hp_rdata_i(hp_rdata), .vector_i(vector)
    );

    always @(posedge clk_i) begin
      if (rst_ni) begin
        {aw_q, w_q, ar_q} <= {want_i & ~awready, also_i & ~wready, other_i & ~arready};
        {awaddr_q, araddr_q, wdata_in_q, wstrb_q} <= {a_i, b_i, data_i, sel_i};
        {bvalid_q, rvalid_q} <= {bvalid & ~take_i, rvalid & ~take2_i};
        {bresp_q, rresp_q, rdata_was_q} <= {bresp, rresp, rdata};
        writes_q <= writes_q + 2'(want_i & awready) - 2'(bvalid & take_i);
        reads_q <= reads_q + 2'(other_i & arready) - 2'(rvalid & take2_i);
        waited_q <= (want_i & also_i & ~awready & take_i & take2_i) ? waited_q + 8'd1 : 8'd0;
        read_waited_q <= (other_i & ~arready & take_i & take2_i) ? read_waited_q + 8'd1 : 8'd0;
      end
    end

    `MMCS_GIVEN(MasterHolds, (!aw_q || (want_i && a_i == awaddr_q)) &&
                (!w_q || (also_i && data_i == wdata_in_q && sel_i == wstrb_q)) &&
                (!ar_q || (other_i && b_i == araddr_q)),
                "AXI: what a master has offered stands until it is taken")
    `MMCS_PROVE(ResponseHeld, "4.2.1", bvalid_q, bvalid && bresp == bresp_q,
                "AXI4-Lite: a write's response stands unchanged until it is taken.")
    `MMCS_PROVE(DataHeld, "4.2.1", rvalid_q, rvalid && rresp == rresp_q && rdata == rdata_was_q,
                "AXI4-Lite: read data stand unchanged until they are taken.")
    `MMCS_PROVE(WriteAnswersOnce, "4.2.1", bvalid, writes_q == 2'd1,
                "AXI4-Lite: a response belongs to one accepted write.")
    `MMCS_PROVE(ReadAnswersOnce, "4.2.1", rvalid, reads_q == 2'd1,
                "AXI4-Lite: read data belong to one accepted read.")
    `MMCS_PROVE(BothTogether, "4.2.1", want_i && awready, also_i && wready,
                "AXI4-Lite: address and data of a write are taken together.")
    `MMCS_PROVE(NeverWedged, "4.2.1", 1'b1, waited_q < Longest && read_waited_q < Longest,
                "AXI4-Lite: while its answers are taken, a front takes what is offered in time.")
    `MMCS_REACH(Refuses, bvalid && bresp != 0, "an error response")
  end else if (Front == 4) begin : g_apb
    logic pready, pslverr;
    logic [31:0] prdata;
    logic held_q = 1'b0, set_q = 1'b0, pwrite_q = 1'b0;
    logic [15:0] paddr_q = '0;
    logic [31:0] pwdata_q = '0;
    logic [3:0] pstrb_q = '0;

    adaptor_apb dut (
      .clk_i, .rst_ni,
      .apb_psel(want_i), .apb_penable(also_i), .apb_pwrite(write_i), .apb_paddr(a_i),
      .apb_pprot(3'b0), .apb_pstrb(sel_i), .apb_pwdata(data_i),
      .apb_prdata(prdata), .apb_pready(pready), .apb_pslverr(pslverr),
      .hp_req_o(hp_req), .hp_write_o(hp_write), .hp_a_o(hp_a), .hp_wdata_o(hp_wdata),
      .hp_ack_i(hp_ack), .hp_rdata_i(hp_rdata), .vector_i(vector)
    );

    always @(posedge clk_i) begin
      if (rst_ni) begin
        set_q  <= want_i & ~also_i;
        held_q <= want_i & also_i & ~pready;
        {paddr_q, pwdata_q, pstrb_q, pwrite_q} <= {a_i, data_i, sel_i, write_i};
        waited_q <= (want_i & also_i & ~pready) ? waited_q + 8'd1 : 8'd0;
      end
    end

    `MMCS_GIVEN(MasterHolds, (!(set_q || held_q) || (want_i && also_i && a_i == paddr_q &&
                data_i == pwdata_q && sel_i == pstrb_q && write_i == pwrite_q)) &&
                (set_q || held_q || !also_i),
                "APB: a setup clock, then enable and all else stand until PREADY")
    `MMCS_PROVE(ReadyInAccess, "4.2.1", pready, want_i && also_i,
                "APB: PREADY comes in an access, not before.")
    `MMCS_PROVE(NeverWedged, "4.2.1", 1'b1, waited_q < Longest,
                "APB: every access is answered in time.")
    `MMCS_REACH(Refuses, pready && pslverr, "an access that is refused")
    `MMCS_REACH(Reads, pready && !pslverr && prdata == 32'h5A, "a read")
  end else begin : g_wb
    logic ack, err, stall, answer;
    logic [31:0] rdata;
    logic held_q = 1'b0, we_q = 1'b0;
    logic [15:0] adr_q = '0;
    logic [31:0] dat_q = '0;
    logic [3:0] seld_q = '0;
    logic [1:0] due_q = '0;   // accepted in this cycle and not yet answered
    logic accept;
    assign answer = ack | err;
    assign accept = also_i & want_i & ~stall & (Front == 3);

    adaptor_wb #(
      .Pipelined(Front == 3)
    ) dut (
      .clk_i, .rst_ni,
      .wb_cyc_i(also_i), .wb_stb_i(want_i), .wb_we_i(write_i), .wb_adr_i(a_i), .wb_sel_i(sel_i),
      .wb_dat_i(data_i), .wb_dat_o(rdata), .wb_ack_o(ack), .wb_err_o(err), .wb_stall_o(stall),
      .hp_req_o(hp_req), .hp_write_o(hp_write), .hp_a_o(hp_a), .hp_wdata_o(hp_wdata),
      .hp_ack_i(hp_ack), .hp_rdata_i(hp_rdata), .vector_i(vector)
    );

    always @(posedge clk_i) begin
      if (rst_ni) begin
        held_q <= also_i & want_i & (Front == 3 ? stall : ~answer);
        {adr_q, dat_q, seld_q, we_q} <= {a_i, data_i, sel_i, write_i};
        if (!also_i || Front == 2) due_q <= '0;
        else due_q <= due_q + 2'(accept) - 2'(answer);
        waited_q <= (also_i & (want_i | due_q != '0) & ~answer & ~accept) ? waited_q + 8'd1 : 8'd0;
      end
    end

    `MMCS_GIVEN(MasterHolds, !(held_q && also_i && want_i) || (a_i == adr_q && data_i == dat_q &&
                sel_i == seld_q && write_i == we_q),
                "Wishbone: what a strobe is about stands as long as it does")
    if (Front == 3) begin : g_pipelined
      `MMCS_PROVE(PipelinedAnswers, "4.2.1", answer, also_i && due_q == 2'd1,
                  "Wishbone pipelined: an answer comes in the cycle of its access, and once.")
    end else begin : g_classic
      `MMCS_PROVE(ClassicAnswers, "4.2.1", answer, also_i && want_i && held_q,
                  "Wishbone classic: the answer comes under a strobe that stood before, and once.")
    end
    `MMCS_PROVE(NeverWedged, "4.2.1", 1'b1, waited_q < Longest,
                "Wishbone: every access is answered in time, after others given up, too.")
    `MMCS_REACH(Refuses, err, "an access that is refused")
    `MMCS_REACH(GivesUp, hp_ack && !also_i, "an access given up is finished at the host port")
  end

endmodule

`default_nettype wire
