// SPDX-License-Identifier: Apache-2.0
// A card on the 8-bit PC bus: at 0x300 a register, at 0x301 the wait states that it asks for.
`default_nettype none

module pc_port #(
  parameter logic [9:0] Base = 10'h300
) (
  input  wire logic       clk_i,
  input  wire logic       rst_ni,
  // PC bus
  input  wire logic [9:0] pc_a_i,
  input  wire logic       pc_aen_i,
  input  wire logic       pc_ior_ni,
  input  wire logic       pc_iow_ni,
  input  wire logic [7:0] pc_d_i,
  output logic      [7:0] pc_d_o,
  output logic            pc_d_oe_o,
  output logic            pc_iochrdy_o
);

  logic ours, command, iow_q;
  logic [7:0] port_q, waits_q, age_q;

  assign ours = pc_a_i[9:1] == Base[9:1] && !pc_aen_i;
  assign command = !(pc_ior_ni && pc_iow_ni) && ours;
  assign pc_d_o = pc_a_i[0] ? waits_q : port_q;
  assign pc_d_oe_o = !pc_ior_ni && ours;
  assign pc_iochrdy_o = !(command && age_q < waits_q);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      iow_q   <= 1'b1;
      port_q  <= '0;
      waits_q <= '0;
      age_q   <= '0;
    end else begin
      iow_q <= pc_iow_ni;
      age_q <= command ? age_q + 8'(age_q != '1) : '0;
      if (pc_iow_ni && !iow_q && ours) begin
        if (pc_a_i[0]) waits_q <= pc_d_i;
        else port_q <= pc_d_i;
      end
    end
  end

endmodule

`default_nettype wire
