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
  logic [Width-1:0] rx_timer_d, rx_timer_q;
  logic [3:0] rx_left_d, rx_left_q;   // bits to come, start and stop bit among them
  logic [7:0] rx_byte_d, rx_byte_q;
  logic rx_done;

  sync #(.ResetValue(1'b1)) u_rx (.clk_i, .rst_ni, .en_i(1'b1), .d_i(rx_i), .q_o(rx));

  assign rx_done = (rx_left_q == 4'd1) & (rx_timer_q == '0) & rx;

  always_comb begin
    rx_timer_d = rx_timer_q - 1'b1;
    rx_left_d  = rx_left_q;
    rx_byte_d  = rx_byte_q;
    if (rx_left_q == '0) begin
      rx_timer_d = Width'(BitClks / 2 - 2);
      if (!rx) rx_left_d = 4'd10;
    end else if (rx_timer_q == '0) begin
      // Each bit in its middle; what has gone by the middle of a start bit was none.
      rx_timer_d = Width'(BitClks - 1);
      rx_left_d  = (rx_left_q == 4'd10 && rx) ? '0 : rx_left_q - 1'b1;
      if (rx_left_q != 4'd1) rx_byte_d = {rx, rx_byte_q[7:1]};
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      rx_timer_q <= '0;
      rx_left_q  <= '0;
      rx_byte_q  <= '0;
    end else begin
      rx_timer_q <= rx_timer_d;
      rx_left_q  <= rx_left_d;
      rx_byte_q  <= rx_byte_d;
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

  state_e state_d, state_q;
  logic write_d, write_q;
  logic [10:1] a_d, a_q;
  logic [7:0] wdata_d, wdata_q, check_d, check_q, answer;
  logic [ForgetWidth-1:0] forget_d, forget_q;
  logic [19:0] tx_d, tx_q;   // two bytes with start and stop bits, the first at the bottom
  logic [4:0] tx_left_d, tx_left_q;
  logic [Width-1:0] tx_timer_d, tx_timer_q;

  function automatic logic [7:0] crc(input logic [7:0] sum, input logic [7:0] data);
    crc = sum ^ data;
    for (int n = 0; n < 8; n++) crc = {crc[6:0], 1'b0} ^ (crc[7] ? 8'h07 : 8'h00);
  endfunction

  assign answer = write_q ? 8'h00 : hp_rdata_i;

  always_comb begin
    state_d  = state_q;
    write_d  = write_q;
    a_d      = a_q;
    wdata_d  = wdata_q;
    check_d  = check_q;
    forget_d = forget_q;
    case (state_q)
      StFirst: begin
        if (rx_done) begin
          {write_d, a_d[10:8]} = {rx_byte_q[7], rx_byte_q[2:0]};
          check_d = crc(8'hFF, rx_byte_q);
          state_d = StOffset;
        end
      end
      StOffset: begin
        if (rx_done) begin
          a_d[7:1] = rx_byte_q[7:1];
          check_d  = crc(check_q, rx_byte_q);
          state_d  = StValue;
        end
      end
      StValue: begin
        if (rx_done) begin
          wdata_d = rx_byte_q;
          check_d = crc(check_q, rx_byte_q);
          state_d = StCheck;
        end
      end
      StCheck: if (rx_done) state_d = (rx_byte_q == check_q) ? StAccess : StFirst;
      StAccess: if (hp_ack_i) state_d = StAnswer;
      default: if (tx_left_q == '0) state_d = StFirst;
    endcase
    if (rx_done || state_q == StFirst) begin
      forget_d = ForgetWidth'(ForgetClks);
    end else if (state_q == StOffset || state_q == StValue || state_q == StCheck) begin
      if (forget_q == '0) state_d = StFirst;
      else forget_d = forget_q - 1'b1;
    end
  end

  always_comb begin
    tx_d       = tx_q;
    tx_left_d  = tx_left_q;
    tx_timer_d = Width'(BitClks - 1);
    if (state_q == StAccess && hp_ack_i) begin
      tx_d      = {1'b1, crc(check_q, answer), 1'b0, 1'b1, answer, 1'b0};
      tx_left_d = 5'd20;
    end else if (tx_left_q != '0 && tx_timer_q != '0) begin
      tx_timer_d = tx_timer_q - 1'b1;
    end else if (tx_left_q != '0) begin
      tx_d      = {1'b1, tx_q[19:1]};
      tx_left_d = tx_left_q - 1'b1;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q    <= StFirst;
      write_q    <= 1'b0;
      a_q        <= '0;
      wdata_q    <= '0;
      check_q    <= '0;
      forget_q   <= '0;
      tx_q       <= '1;
      tx_left_q  <= '0;
      tx_timer_q <= '0;
    end else begin
      state_q    <= state_d;
      write_q    <= write_d;
      a_q        <= a_d;
      wdata_q    <= wdata_d;
      check_q    <= check_d;
      forget_q   <= forget_d;
      tx_q       <= tx_d;
      tx_left_q  <= tx_left_d;
      tx_timer_q <= tx_timer_d;
    end
  end

  assign hp_req_o = (state_q == StAccess);
  assign hp_write_o = write_q;
  assign hp_a_o = a_q;
  assign hp_wdata_o = wdata_q;
  assign tx_o = tx_q[0];

endmodule

`default_nettype wire
