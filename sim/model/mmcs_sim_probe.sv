// SPDX-License-Identifier: Apache-2.0
// Looks into one axis of the machine for tests and for the final hash; §5.3.
//
// Exported functions read registers where they are, only when they are called: nothing is evaluated
// clock by clock. One instance per axis, told apart by its scope.

`default_nettype none

`ifdef MMCS_SOC
`define MMCS_MACHINE mmcs_sim_top.u_soc.u_mmcs
`else
`define MMCS_MACHINE mmcs_sim_top.u_mmcs
`endif

module mmcs_sim_probe #(
  parameter int unsigned Card  = 0,
  parameter int unsigned Joint = 0
) ();

  export "DPI-C" function mmcs_encoder_register;
  export "DPI-C" function mmcs_axis_digest;

  // The 16-bit counter, not the latch in front of it.
  function automatic int unsigned mmcs_encoder_register();
    mmcs_encoder_register =
        {16'd0, `MMCS_MACHINE.g_card[Card].u_card.g_axis[Joint].u_axis.u_encoder.count_q};
  endfunction

  // D/A rank 2 and 1, index latch, heartbeat running.
  function automatic int unsigned mmcs_axis_digest();
    mmcs_axis_digest = {
      6'd0,
      `MMCS_MACHINE.g_card[Card].u_card.g_axis[Joint].u_axis.index_latch_q,
      `MMCS_MACHINE.g_card[Card].u_card.g_axis[Joint].u_axis.u_heartbeat.run_q,
      `MMCS_MACHINE.g_card[Card].u_card.g_axis[Joint].u_axis.u_dac.rank2_q,
      `MMCS_MACHINE.g_card[Card].u_card.g_axis[Joint].u_axis.u_dac.rank1_q
    };
  endfunction

endmodule

`undef MMCS_MACHINE
`default_nettype wire
