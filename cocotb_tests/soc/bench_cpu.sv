// SPDX-License-Identifier: Apache-2.0
// Stands in for rtl/soc/soc_cpu.sv, under its name: the ports of the core, and a program in hardware.
//
// It writes words below the mailbox and reads them back, as fast as the data port takes them. At a
// ring it notices the doorbell, serves a request of the mailbox by adding one to each of 8 words of
// data, and reports: what the firmware does with firmware/ports/mailbox.h, without a firmware.
`default_nettype none

// verilog_lint: waive module-filename
module soc_cpu (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  output logic             instr_req_o,
  output logic      [31:0] instr_addr_o,
  input  wire logic        instr_rvalid_i,
  input  wire logic [31:0] instr_rdata_i,
  input  wire logic        instr_err_i,
  output logic             data_req_o,
  input  wire logic        data_gnt_i,
  input  wire logic        data_rvalid_i,
  output logic             data_we_o,
  output logic      [ 3:0] data_be_o,
  output logic      [31:0] data_addr_o,
  output logic      [31:0] data_wdata_o,
  input  wire logic [31:0] data_rdata_i,
  input  wire logic        data_err_i,
  input  wire logic        irq_external_i,
  input  wire logic        irq_software_i
);

  localparam logic [31:0] Mailbox = 32'h0001_E000;
  localparam logic [31:0] Posted = Mailbox + 8, Done = Mailbox + 12, Result = Mailbox + 32;
  localparam logic [31:0] Data = Mailbox + 32'h500;
  localparam logic [31:0] Report = 32'h00F0_0000, Doorbell = 32'h00F0_0004;

  typedef enum logic [3:0] {
    StFill,     // a word of the own region is written
    StCheck,    // and read back
    StNotice,
    StPosted,
    StLoad,
    StStore,
    StResult,
    StDone,
    StReport
  } state_e;

  state_e state_q;
  logic wait_q;                    // granted, the answer is to come
  logic [9:0] place_q;             // in the own region
  logic [2:0] n_q;
  logic [31:0] posted_q, word_q, sum_q;
  logic [31:0] rounds_q, wrong_q;  // looked at by the test: own words checked, and bad ones
  logic [31:0] pattern;

  assign pattern = {place_q, rounds_q[21:0]} ^ 32'h5A5A_1234;

  always_comb begin
    data_we_o    = 1'b1;
    data_addr_o  = {18'd1, 2'b00, place_q, 2'b00};
    data_wdata_o = pattern;
    case (state_q)
      StCheck: data_we_o = 1'b0;
      StNotice: data_addr_o = Doorbell;
      StPosted: begin
        data_we_o   = 1'b0;
        data_addr_o = Posted;
      end
      StLoad: begin
        data_we_o   = 1'b0;
        data_addr_o = Data + {27'd0, n_q, 2'b00};
      end
      StStore: begin
        data_addr_o  = Data + {27'd0, n_q, 2'b00};
        data_wdata_o = word_q + 1;
      end
      StResult: begin
        data_addr_o  = Result;
        data_wdata_o = sum_q;
      end
      StDone: begin
        data_addr_o  = Done;
        data_wdata_o = posted_q;
      end
      StReport: begin
        data_addr_o  = Report;
        data_wdata_o = 32'd4;
      end
      default: data_we_o = 1'b1;
    endcase
  end

  assign data_req_o = rst_ni && !wait_q;
  assign data_be_o = data_req_o ? 4'hF : 4'h0;  // of no account without a request
  assign instr_req_o = rst_ni;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q      <= StFill;
      wait_q       <= 1'b0;
      place_q      <= '0;
      n_q          <= '0;
      posted_q     <= '0;
      word_q       <= '0;
      sum_q        <= '0;
      rounds_q     <= '0;
      wrong_q      <= '0;
      instr_addr_o <= '0;
    end else begin
      instr_addr_o <= {20'd0, instr_addr_o[11:2] + 10'd1, 2'b00};
      if (data_req_o && data_gnt_i) wait_q <= 1'b1;
      if (wait_q && data_rvalid_i) begin
        wait_q <= 1'b0;
        if (data_err_i) wrong_q <= wrong_q + 1;
        case (state_q)
          StFill: state_q <= StCheck;
          StCheck: begin
            if (data_rdata_i != pattern) wrong_q <= wrong_q + 1;
            rounds_q <= rounds_q + 1;
            place_q  <= place_q + 10'd37;
            state_q  <= irq_software_i ? StNotice : StFill;
          end
          StNotice: state_q <= StPosted;
          StPosted: begin
            posted_q <= data_rdata_i;
            sum_q    <= '0;
            n_q      <= '0;
            state_q  <= StLoad;
          end
          StLoad: begin
            word_q  <= data_rdata_i;
            sum_q   <= sum_q + data_rdata_i;
            state_q <= StStore;
          end
          StStore: begin
            n_q     <= n_q + 3'd1;
            state_q <= (n_q == 3'd7) ? StResult : StLoad;
          end
          StResult: state_q <= StDone;
          StDone: state_q <= StReport;
          default: state_q <= StFill;
        endcase
      end
    end
  end

  logic unused;
  assign unused = ^{instr_rvalid_i, instr_rdata_i, instr_err_i, irq_external_i};

endmodule

`default_nettype wire
