// SPDX-License-Identifier: Apache-2.0
// A third-party PC card: eight outputs, eight inputs, an interrupt, slow registers. §4.2.2
//
// An example of what fits the expansion connector; any I/O card of the period would do. At Base:
//   +0 outputs, read back   +1 inputs   +2 wait states of the registers (0-15 CLK)   +3 identity
// The interrupt line follows input bit 7 while bit 7 of +2 is 1.
`default_nettype none

module dio_card #(
  parameter logic [9:0] Base = 10'h2A0,
  parameter logic [7:0] Identity = 8'hD1
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  // PC bus
  input  wire logic        clk_en_i,      // one per period of CLK
  input  wire logic        reset_drv_i,
  input  wire logic [15:0] a_i,
  input  wire logic        aen_i,
  input  wire logic        ior_ni,
  input  wire logic        iow_ni,
  input  wire logic [ 7:0] d_i,
  output logic      [ 7:0] d_o,
  output logic             d_oe_o,
  output logic             wait_o,        // 1: IOCHRDY pulled low
  output logic             irq_o,
  // The outside
  output logic      [ 7:0] out_o,
  input  wire logic [ 7:0] in_i
);

  logic [7:0] control_q;
  logic [3:0] waited_q;
  logic hit, command;

  assign hit = ~aen_i & (a_i[9:2] == Base[9:2]);
  assign command = hit & ~(ior_ni & iow_ni);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      out_o     <= '0;
      control_q <= '0;
      waited_q  <= '0;
    end else begin
      if (!command) waited_q <= '0;
      else if (clk_en_i && waited_q != '1) waited_q <= waited_q + 1'b1;
      if (reset_drv_i) begin
        out_o     <= '0;
        control_q <= '0;
      end else if (hit && !iow_ni) begin
        if (a_i[1:0] == 2'd0) out_o <= d_i;
        if (a_i[1:0] == 2'd2) control_q <= d_i;
      end
    end
  end

  assign wait_o = command && (waited_q < control_q[3:0]);
  assign irq_o = control_q[7] & in_i[7];
  assign d_oe_o = hit & ~ior_ni;

  always_comb begin
    case (a_i[1:0])
      2'd0: d_o = out_o;
      2'd1: d_o = in_i;
      2'd2: d_o = control_q;
      default: d_o = Identity;
    endcase
    if (!d_oe_o) d_o = 8'hFF;
  end

  logic unused;
  assign unused = ^a_i[15:10];

endmodule

`default_nettype wire
