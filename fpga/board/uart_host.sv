// SPDX-License-Identifier: Apache-2.0
// A serial line at the host port, 8N1: a PC reads and writes registers, byte by byte. §4.2.1
//
// Request: {write, 4'b0, offset[10:8]}, offset[7:0], the value (0 for a read), check. Answer: the
// value read, or 0 after a write, and a check. A check is the CRC-8 of all bytes since the request
// began but itself: polynomial 0x07, from 0xFF. A request whose check is wrong is not answered; one
// that stops short is forgotten after a millisecond: so both ends agree again after a disturbance.
`default_nettype none
`include "mmcs_require.svh"

module uart_host #(
  parameter int ClkHz = 24_000_000,
  parameter int Baud = 1_000_000
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  input  wire logic        rx_i,
  output logic             tx_o,
  // Host port
  output logic             hp_req_o,
  output logic             hp_write_o,
  output logic      [10:1] hp_a_o,
  output logic      [ 7:0] hp_wdata_o,
  input  wire logic        hp_ack_i,
  input  wire logic [ 7:0] hp_rdata_i
);

  localparam int BitClks = ClkHz / Baud;
  localparam int Width = $clog2(BitClks + 1);
  localparam int ForgetClks = ClkHz / 1000;
  localparam int ForgetWidth = $clog2(ForgetClks + 1);

  `MMCS_REQUIRE(GoodBaud, BitClks >= 8, "Baud must be an eighth of ClkHz at most")

  // --- receiver ---------------------------------------------------------------------------

  logic rx;
  logic [Width-1:0] rx_timer_q;
  logic [3:0] rx_left_q;     // bits to come, start and stop bit among them
  logic [7:0] rx_byte_q;
  logic rx_done;

  sync #(.ResetValue(1'b1)) u_rx (.clk_i, .rst_ni, .d_i(rx_i), .q_o(rx));

  assign rx_done = (rx_left_q == 4'd1) & (rx_timer_q == '0) & rx;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      rx_timer_q <= '0;
      rx_left_q  <= '0;
      rx_byte_q  <= '0;
    end else begin
      if (rx_left_q == '0) begin
        if (!rx) begin
          rx_left_q  <= 4'd10;
          rx_timer_q <= Width'(BitClks / 2 - 2);
        end
      end else if (rx_timer_q != '0) begin
        rx_timer_q <= rx_timer_q - 1'b1;
      end else begin
        // Each bit in its middle; what has gone by the middle of a start bit was none.
        rx_left_q  <= (rx_left_q == 4'd10 && rx) ? '0 : rx_left_q - 1'b1;
        rx_timer_q <= Width'(BitClks - 1);
        if (rx_left_q != 4'd1) rx_byte_q <= {rx, rx_byte_q[7:1]};
      end
    end
  end

  // --- request and answer -----------------------------------------------------------------

  typedef enum logic [2:0] {
    StFirst,
    StOffset,
    StValue,
    StCheck,
    StAccess,  // the host port works
    StAnswer
  } state_e;

  state_e state_q;
  logic [ForgetWidth-1:0] forget_q;
  logic [7:0] check_q, answer;
  logic [19:0] tx_q;         // two bytes with start and stop bits, the first at the bottom
  logic [4:0] tx_left_q;
  logic [Width-1:0] tx_timer_q;

  function automatic logic [7:0] crc(input logic [7:0] sum, input logic [7:0] data);
    crc = sum ^ data;
    for (int n = 0; n < 8; n++) crc = {crc[6:0], 1'b0} ^ (crc[7] ? 8'h07 : 8'h00);
  endfunction

  assign answer = hp_write_o ? 8'h00 : hp_rdata_i;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q    <= StFirst;
      check_q    <= '0;
      forget_q   <= '0;
      hp_write_o <= 1'b0;
      hp_a_o     <= '0;
      hp_wdata_o <= '0;
      tx_q       <= '1;
      tx_left_q  <= '0;
      tx_timer_q <= '0;
    end else begin
      case (state_q)
        StFirst: begin
          if (rx_done) begin
            {hp_write_o, hp_a_o[10:8]} <= {rx_byte_q[7], rx_byte_q[2:0]};
            check_q <= crc(8'hFF, rx_byte_q);
            state_q <= StOffset;
          end
        end
        StOffset: begin
          if (rx_done) begin
            hp_a_o[7:1] <= rx_byte_q[7:1];
            check_q <= crc(check_q, rx_byte_q);
            state_q <= StValue;
          end
        end
        StValue: begin
          if (rx_done) begin
            hp_wdata_o <= rx_byte_q;
            check_q <= crc(check_q, rx_byte_q);
            state_q <= StCheck;
          end
        end
        StCheck: begin
          if (rx_done) state_q <= (rx_byte_q == check_q) ? StAccess : StFirst;
        end
        StAccess: begin
          if (hp_ack_i) begin
            tx_q       <= {1'b1, crc(check_q, answer), 1'b0, 1'b1, answer, 1'b0};
            tx_left_q  <= 5'd20;
            tx_timer_q <= Width'(BitClks - 1);
            state_q    <= StAnswer;
          end
        end
        default: begin
          if (tx_left_q == '0) state_q <= StFirst;
        end
      endcase
      if (rx_done || state_q == StFirst) begin
        forget_q <= ForgetWidth'(ForgetClks);
      end else if (state_q == StOffset || state_q == StValue || state_q == StCheck) begin
        if (forget_q == '0) state_q <= StFirst;
        else forget_q <= forget_q - 1'b1;
      end
      if (tx_left_q != '0) begin
        if (tx_timer_q != '0) begin
          tx_timer_q <= tx_timer_q - 1'b1;
        end else begin
          tx_timer_q <= Width'(BitClks - 1);
          tx_left_q  <= tx_left_q - 1'b1;
          tx_q       <= {1'b1, tx_q[19:1]};
        end
      end
    end
  end

  assign hp_req_o = (state_q == StAccess);
  assign tx_o = tx_q[0];

endmodule

`default_nettype wire
