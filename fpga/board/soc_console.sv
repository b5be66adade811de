// SPDX-License-Identifier: Apache-2.0
// The window to the memory of the SoC as registers at a host port, for uart_host: the console.
//
// Offset: 0x001, 0x003 word address, low and high byte; 0x005-0x00B data, lowest byte first; 0x00D
// write: bit 0 reads the word into data, bit 1 writes it, bit 2 rings the processor; read: the last
// report of the processor (firmware/ports/mailbox.h). The address goes on by one after each access.
// Reports are taken at once: the processor needs no console.
`default_nettype none

module soc_console (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  // Host port
  input  wire logic        hp_req_i,
  input  wire logic        hp_write_i,
  input  wire logic [10:1] hp_a_i,
  input  wire logic [ 7:0] hp_wdata_i,
  output logic             hp_ack_o,
  output logic      [ 7:0] hp_rdata_o,
  // Window of mmcs_soc
  output logic             box_req_o,
  output logic             box_write_o,
  output logic      [31:2] box_a_o,
  output logic      [31:0] box_wdata_o,
  input  wire logic        box_ack_i,
  input  wire logic [31:0] box_rdata_i,
  output logic             ring_o,
  input  wire logic        report_valid_i,
  input  wire logic [ 7:0] report_i,
  output logic             report_take_o
);

  typedef enum logic [1:0] {
    StIdle,
    StWindow,  // an access to the memory
    StAnswer
  } state_e;

  state_e state_d, state_q;
  logic [15:0] a_d, a_q;
  logic [3:0][7:0] data_d, data_q;
  logic write_d, write_q, ring_d, ring_q, take_d, take_q;
  logic [7:0] report_d, report_q;
  logic [2:0] register;

  assign register = hp_a_i[3:1];

  always_comb begin
    state_d = state_q;
    a_d     = a_q;
    data_d  = data_q;
    write_d = write_q;
    ring_d  = 1'b0;
    case (state_q)
      StIdle: begin
        if (hp_req_i) begin
          state_d = StAnswer;
          if (hp_write_i) begin
            case (register)
              3'd0: a_d[7:0] = hp_wdata_i;
              3'd1: a_d[15:8] = hp_wdata_i;
              3'd2, 3'd3, 3'd4, 3'd5: data_d[2'(register - 3'd2)] = hp_wdata_i;
              3'd6: begin
                write_d = hp_wdata_i[1];
                ring_d  = hp_wdata_i[2];
                if (hp_wdata_i[1:0] != '0) state_d = StWindow;
              end
              default: ;
            endcase
          end
        end
      end
      StWindow: begin
        if (box_ack_i) begin
          state_d = StAnswer;
          a_d     = a_q + 1'b1;
          if (!write_q) data_d = box_rdata_i;
        end
      end
      default: state_d = StIdle;
    endcase
  end

  assign take_d = report_valid_i & ~take_q;
  assign report_d = report_valid_i ? report_i : report_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q  <= StIdle;
      a_q      <= '0;
      data_q   <= '0;
      write_q  <= 1'b0;
      ring_q   <= 1'b0;
      take_q   <= 1'b0;
      report_q <= '0;
    end else begin
      state_q  <= state_d;
      a_q      <= a_d;
      data_q   <= data_d;
      write_q  <= write_d;
      ring_q   <= ring_d;
      take_q   <= take_d;
      report_q <= report_d;
    end
  end

  always_comb begin
    case (register)
      3'd0: hp_rdata_o = a_q[7:0];
      3'd1: hp_rdata_o = a_q[15:8];
      3'd2, 3'd3, 3'd4, 3'd5: hp_rdata_o = data_q[2'(register - 3'd2)];
      3'd6: hp_rdata_o = report_q;
      default: hp_rdata_o = 8'hFF;
    endcase
  end

  assign hp_ack_o = (state_q == StAnswer);
  assign box_req_o = (state_q == StWindow);
  assign box_write_o = write_q;
  assign box_a_o = {14'd0, a_q};
  assign box_wdata_o = data_q;
  assign ring_o = ring_q;
  assign report_take_o = take_q;

  logic unused;
  assign unused = ^hp_a_i[10:4];

endmodule

`default_nettype wire
