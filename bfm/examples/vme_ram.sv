// SPDX-License-Identifier: Apache-2.0
// A VME slave: 256 bytes, and an interrupter that a write to the last byte, the vector, sets off.
`default_nettype none

module vme_ram #(
  parameter logic [7:0] Base  = 8'h10,  // A15-A08
  parameter int         Level = 3
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  // VMEbus
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
  output logic      [ 7:1] vme_irq_no
);

  logic [15:0] mem [128];
  logic [ 7:0] vector_q;
  logic [ 2:0] age_q;  // clocks for which a cycle has been there for us to look at
  logic strobed, ours, mine, take, held_q, passed_q, irq_q;

  assign strobed = !(&vme_ds_ni) && !vme_as_ni && (vme_iack_ni || !vme_iackin_ni);
  assign ours = vme_lword_ni && vme_a_i[15:8] == Base &&
                (vme_am_i == 6'h29 || vme_am_i == 6'h2D);
  assign mine = irq_q && vme_a_i[3:1] == 3'(Level);
  assign take = strobed && age_q == 3'd2 && (vme_iack_ni ? ours : mine);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      age_q        <= '0;
      held_q       <= 1'b0;
      passed_q     <= 1'b0;
      irq_q        <= 1'b0;
      vector_q     <= '0;
      vme_d_o      <= '1;
      vme_dtack_no <= 1'b1;
    end else begin
      age_q        <= strobed ? age_q + 3'(age_q != '1) : '0;
      held_q       <= take || (held_q && strobed);
      passed_q     <= strobed && (passed_q || (age_q == 3'd2 && !vme_iack_ni && !mine));
      vme_dtack_no <= !(held_q && strobed && age_q > 3'd4);
      if (take) begin
        vme_d_o <= vme_iack_ni ? mem[vme_a_i[7:1]] : {8'hFF, vector_q};
        if (!vme_iack_ni) irq_q <= 1'b0;
        else if (!vme_write_ni) begin
          if (!vme_ds_ni[0]) mem[vme_a_i[7:1]][7:0] <= vme_d_i[7:0];
          if (!vme_ds_ni[1]) mem[vme_a_i[7:1]][15:8] <= vme_d_i[15:8];
          if (&vme_a_i[7:1]) {irq_q, vector_q} <= {1'b1, vme_d_i[7:0]};
        end
      end
    end
  end

  assign vme_d_oe_o = held_q && strobed && (!vme_iack_ni || vme_write_ni);
  assign vme_iackout_no = !(passed_q && !vme_iackin_ni && !vme_as_ni);

  always_comb begin
    vme_irq_no = '1;
    vme_irq_no[Level] = !irq_q;
  end

endmodule

`default_nettype wire
