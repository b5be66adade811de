// SPDX-License-Identifier: Apache-2.0
// A serial line at the host port, 8N1: a PC reads and writes registers, byte by byte. §4.2.1
//
// Request: {write, 4'b0, offset[10:8]}, offset[7:0], and for a write the value. Answer: one byte, the
// value read, or 0 after a write. A request that stops short is forgotten after a millisecond: so
// both ends agree again after a disturbance, or after a reset within a byte.
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
  localparam int Width = $clog2(BitClks + BitClks / 2 + 1);
  localparam int ForgetClks = ClkHz / 1000;
  localparam int ForgetWidth = $clog2(ForgetClks + 1);

  `MMCS_REQUIRE(GoodBaud, BitClks >= 8, "Baud must be an eighth of ClkHz at most")

  // --- receiver ---------------------------------------------------------------------------

  logic [1:0] rx_q;
  logic [Width-1:0] rx_timer_q;
  logic [3:0] rx_left_q;     // bits to come, the stop bit among them
  logic [7:0] rx_byte_q;
  logic rx_done;

  assign rx_done = (rx_left_q == 4'd1) & (rx_timer_q == '0) & rx_q[1];

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      rx_q       <= '1;
      rx_timer_q <= '0;
      rx_left_q  <= '0;
      rx_byte_q  <= '0;
    end else begin
      rx_q <= {rx_q[0], rx_i};
      if (rx_left_q == '0) begin
        if (!rx_q[1]) begin
          rx_left_q  <= 4'd9;
          rx_timer_q <= Width'(BitClks + BitClks / 2 - 2);
        end
      end else if (rx_timer_q != '0) begin
        rx_timer_q <= rx_timer_q - 1'b1;
      end else begin
        rx_left_q  <= rx_left_q - 1'b1;
        rx_timer_q <= Width'(BitClks - 1);
        if (rx_left_q != 4'd1) rx_byte_q <= {rx_q[1], rx_byte_q[7:1]};
      end
    end
  end

  // --- request and answer -----------------------------------------------------------------

  typedef enum logic [2:0] {
    StFirst,
    StOffset,
    StValue,
    StAccess,  // the host port works
    StAnswer
  } state_e;

  state_e state_q;
  logic [ForgetWidth-1:0] forget_q;
  logic [9:0] tx_q;          // start bit last out is at the bottom
  logic [3:0] tx_left_q;
  logic [Width-1:0] tx_timer_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q    <= StFirst;
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
            state_q <= StOffset;
          end
        end
        StOffset: begin
          if (rx_done) begin
            hp_a_o[7:1] <= rx_byte_q[7:1];
            state_q <= hp_write_o ? StValue : StAccess;
          end
        end
        StValue: begin
          if (rx_done) begin
            hp_wdata_o <= rx_byte_q;
            state_q <= StAccess;
          end
        end
        StAccess: begin
          if (hp_ack_i) begin
            tx_q       <= {1'b1, hp_write_o ? 8'h00 : hp_rdata_i, 1'b0};
            tx_left_q  <= 4'd10;
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
      end else if (state_q == StOffset || state_q == StValue) begin
        if (forget_q == '0) state_q <= StFirst;
        else forget_q <= forget_q - 1'b1;
      end
      if (tx_left_q != '0) begin
        if (tx_timer_q != '0) begin
          tx_timer_q <= tx_timer_q - 1'b1;
        end else begin
          tx_timer_q <= Width'(BitClks - 1);
          tx_left_q  <= tx_left_q - 1'b1;
          tx_q       <= {1'b1, tx_q[9:1]};
        end
      end
    end
  end

  assign hp_req_o = (state_q == StAccess);
  assign tx_o = tx_q[0];

endmodule

`default_nettype wire
