// SPDX-License-Identifier: Apache-2.0
// The one-shot, for all triggers, clears and resets. §5.3.6
`default_nettype none
`include "mmcs_formal.svh"

module oneshot_props #(
  parameter int PulseClks = 400_000
) (
  input wire logic clk_i,
  input wire logic reset_i,
  input wire logic trig_i,
  input wire logic clr_ni
);

  `MMCS_RESET(~reset_i)

  logic q;
  oneshot #(
    .PulseClks(PulseClks)
  ) dut (
    .clk_i, .rst_ni, .trig_i, .clr_ni,
    .q_o(q)
  );

  // The model: the clocks since the last trigger, while none of them was cleared.
  logic last_q, alive_q, ended_q;
  int age_q;
  always @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      last_q  <= 1'b0;
      alive_q <= 1'b0;
      ended_q <= 1'b0;
      age_q   <= 0;
    end else begin
      last_q  <= trig_i;
      ended_q <= alive_q && age_q == PulseClks - 1 && clr_ni;
      if (!clr_ni) alive_q <= 1'b0;
      else if (trig_i && !last_q) alive_q <= 1'b1;
      else if (age_q == PulseClks - 1) alive_q <= 1'b0;
      age_q <= trig_i && !last_q ? 0 : age_q + 1;
    end
  end

  // A wire of this name is joined to the register of the design when the hierarchy is flattened.
  (* hierconn *) wire [$clog2(PulseClks + 1)-1:0] \dut.left_q ;
  (* hierconn *) wire \dut.trig_q ;

  `MMCS_PROVE(Lasts, "5.3.6", alive_q, q,
              "the heartbeat stands for 400,000 clocks after the last write that triggers it")
  `MMCS_PROVE(Ends, "5.3.6", !alive_q, !q,
              "without a trigger in the last 400,000 clocks, or cleared since, it is gone")
  `MMCS_REACH(RunsOut, ended_q && !q, "a pulse ends by itself")
  `MMCS_REACH(Extended, ended_q && q, "a trigger on the last clock of a pulse extends it")

  `MMCS_LEMMA(Edges, dut.trig_q == last_q, "both see the same edges")
  `MMCS_LEMMA(Age, !alive_q || (age_q >= 0 && age_q < PulseClks &&
                                dut.left_q == PulseClks - age_q),
              "what is left is the pulse without its age")

endmodule

`default_nettype wire
