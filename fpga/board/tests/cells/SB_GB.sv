// SPDX-License-Identifier: Apache-2.0
// The global buffer of an iCE40.
/* verilator lint_off UNUSEDSIGNAL */
/* verilator lint_off UNUSEDPARAM */
`default_nettype none

module SB_GB (
  input  wire logic USER_SIGNAL_TO_GLOBAL_BUFFER,
  output logic      GLOBAL_BUFFER_OUTPUT
);
  assign GLOBAL_BUFFER_OUTPUT = USER_SIGNAL_TO_GLOBAL_BUFFER;
endmodule

`default_nettype wire
