// SPDX-License-Identifier: Apache-2.0
// The register window of a memory-mapped host: one access at a time becomes a request at the host
// port, or an error that the host's bus knows. §4.2.1
//
// DataWidth 32: register n, at offset 2 n + 1 of the VME window, is the lowest byte of word n; a word
// or that byte alone may be accessed. DataWidth 8: the bytes lie as on VME, at odd offsets.
`default_nettype none
`include "mmcs_assert.svh"
`include "mmcs_require.svh"

module reg_window #(
  parameter int DataWidth = 32,
  parameter int AddrWidth = 16
) (
  input  wire logic                   clk_i,
  input  wire logic                   rst_ni,
  // Access: taken in the clock in which start and ready are 1
  input  wire logic                   start_i,
  output logic                        ready_o,
  input  wire logic                   write_i,
  input  wire logic [AddrWidth-1:0]   a_i,       // in bytes
  input  wire logic [DataWidth/8-1:0] sel_i,     // bytes that the access is about
  input  wire logic [            7:0] wdata_i,
  output logic                        done_o,    // one clock, with what follows
  output logic                        outside_o, // error: beyond the window
  output logic                        width_o,   // error: not a whole register
  output logic      [            7:0] rdata_o,
  // Host port, and the vector register behind it
  output logic                        hp_req_o,
  output logic                        hp_write_o,
  output logic      [           10:1] hp_a_o,
  output logic      [            7:0] hp_wdata_o,
  input  wire logic                   hp_ack_i,
  input  wire logic [            7:0] hp_rdata_i,
  input  wire logic [            7:0] vector_i
);

  localparam int Words = (DataWidth == 32) ? 1 : 0;
  localparam int WindowWidth = (Words != 0) ? 12 : 11;

  `MMCS_REQUIRE(GoodDataWidth, DataWidth == 32 || DataWidth == 8, "DataWidth must be 32 or 8")
  `MMCS_REQUIRE(GoodAddrWidth, AddrWidth > WindowWidth && AddrWidth <= 32,
                "AddrWidth must be more than the window's (12 for words, 11 for bytes), at most 32")

  typedef enum logic [1:0] {
    StIdle,
    StRequest,  // the host port works
    StDone
  } state_e;

  state_e state_q, state_d;
  logic outside, fits, nothing, is_vector;
  logic outside_d, outside_q, width_d, width_q;
  logic hp_write_d;
  logic [10:1] hp_a_d;
  logic [ 7:0] hp_wdata_d, rdata_d;

  assign outside = a_i[AddrWidth-1:WindowWidth] != '0;

  if (Words != 0) begin : g_words
    assign nothing = write_i & (sel_i == '0);  // a write of no byte is legal and does nothing
    assign fits = (a_i[1:0] == 2'b00) & (sel_i == 4'b1111 | sel_i == 4'b0001 | nothing);
  end else begin : g_bytes
    assign nothing = write_i & ~sel_i[0];
    assign fits = a_i[0];
  end

  // There is no acknowledge cycle that would fetch the vector: its register is read.
  assign is_vector = hp_a_o[10] & hp_a_o[6];

  always_comb begin
    state_d    = state_q;
    outside_d  = outside_q;
    width_d    = width_q;
    hp_write_d = hp_write_o;
    hp_a_d     = hp_a_o;
    hp_wdata_d = hp_wdata_o;
    rdata_d    = rdata_o;
    case (state_q)
      StIdle: begin
        if (start_i) begin
          if (outside || !fits || nothing) state_d = StDone;
          else state_d = StRequest;
          outside_d  = outside;
          width_d    = ~outside & ~fits;
          hp_write_d = write_i;
          hp_a_d     = (Words != 0) ? a_i[11:2] : a_i[10:1];
          hp_wdata_d = wdata_i;
          rdata_d    = '1;
        end
      end
      StRequest: begin
        if (hp_ack_i) begin
          state_d = StDone;
          rdata_d = is_vector ? vector_i : hp_rdata_i;
        end
      end
      default: state_d = StIdle;
    endcase
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q    <= StIdle;
      outside_q  <= 1'b0;
      width_q    <= 1'b0;
      hp_write_o <= 1'b0;
      hp_a_o     <= '0;
      hp_wdata_o <= '0;
      rdata_o    <= '1;
    end else begin
      state_q    <= state_d;
      outside_q  <= outside_d;
      width_q    <= width_d;
      hp_write_o <= hp_write_d;
      hp_a_o     <= hp_a_d;
      hp_wdata_o <= hp_wdata_d;
      rdata_o    <= rdata_d;
    end
  end

  assign ready_o = (state_q == StIdle);
  assign hp_req_o = (state_q == StRequest);
  assign done_o = (state_q == StDone);
  assign outside_o = outside_q;
  assign width_o = width_q;

  `MMCS_ASSERT(OneError, !(outside_q && width_q), "an access ends in one error at most")

endmodule

`default_nettype wire
