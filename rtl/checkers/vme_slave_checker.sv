// SPDX-License-Identifier: Apache-2.0
// What a VME slave must never do, seen from its pins on every clock. §4.3.1
//
// Needs no knowledge of the slave. Attached by bind.sv in simulation; the proofs use it as it is.
`default_nettype none
`include "checkers/mmcs_rule.svh"

module vme_slave_checker #(
  parameter int ReleaseClks = 2,  // DTACK* rises at the latest this many clocks after the strobes
  parameter bit Stop = 1'b1
) (
  input  wire logic       clk_i,
  input  wire logic       rst_ni,
  input  wire logic [1:0] vme_ds_ni,
  input  wire logic       vme_iack_ni,
  input  wire logic       vme_write_ni,
  input  wire logic       vme_iackout_no,
  input  wire logic       vme_sysreset_ni,
  input  wire logic       vme_d_oe_o,
  input  wire logic       vme_dtack_no,
  input  wire logic [7:0] vme_d_o,
  output logic      [7:0] broken_o   // sticky, one bit per rule in the order below
);

  logic [7:0] bad;
  logic strobed, strobed_q, strobed2_q, dtack_q, oe_q, reset_q;
  logic [7:0] d_q;
  logic [2:0] released_q;   // clocks since both strobes went high with DTACK* still low

  assign strobed = ~(&vme_ds_ni);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      strobed_q  <= 1'b0;
      strobed2_q <= 1'b0;
      dtack_q    <= 1'b0;
      oe_q       <= 1'b0;
      reset_q    <= 1'b0;
      d_q        <= '0;
      released_q <= '0;
      broken_o   <= '0;
    end else begin
      strobed_q  <= strobed;
      strobed2_q <= strobed_q;
      dtack_q    <= ~vme_dtack_no;
      oe_q       <= vme_d_oe_o;
      reset_q    <= ~vme_sysreset_ni;
      d_q        <= vme_d_o;
      if (strobed || vme_dtack_no) released_q <= '0;
      else if (released_q != '1) released_q <= released_q + 1'b1;
      broken_o <= broken_o | bad;
    end
  end

  // One that is withdrawn as the clock rises looks withdrawn before; vme_edge_checker knows better.
  `MMCS_RULE(0, NoDtackAlone, vme_dtack_no || dtack_q || strobed_q || strobed2_q,
             "DTACK* falls only while a data strobe is low")
  `MMCS_RULE(1, NoEarlyRelease, !(vme_dtack_no && dtack_q && strobed && strobed_q && !reset_q),
             "DTACK* does not rise before both data strobes are high")
  `MMCS_RULE(2, PromptRelease, released_q <= 3'(ReleaseClks),
             "DTACK* rises one or two clocks after both data strobes")
  `MMCS_RULE(3, DriversOff, !(vme_d_oe_o && !strobed),
             "the data drivers are off as soon as both data strobes are high")
  `MMCS_RULE(4, NoDriveOnWrite, !(vme_d_oe_o && !oe_q && vme_iack_ni && !vme_write_ni),
             "the slave does not begin to drive data in a write cycle")
  `MMCS_RULE(5, DataStands, !(dtack_q && oe_q && strobed && vme_d_oe_o) || (vme_d_o == d_q),
             "read data stands until the strobes rise")
  `MMCS_RULE(6, OneFate, vme_dtack_no || vme_iackout_no,
             "an acknowledge is answered or passed on, never both")
  `MMCS_RULE(7, DataFirst,
             !(!vme_dtack_no && !dtack_q && strobed && vme_d_oe_o) || (oe_q && vme_d_o == d_q),
             "read data stands a clock before DTACK* falls")

endmodule

`default_nettype wire
