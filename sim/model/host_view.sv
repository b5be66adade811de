// SPDX-License-Identifier: Apache-2.0
// What a processor beside the machine is doing, for the waveform: docs/simulator/processors.md.

`default_nettype none

module host_view;
  logic [ 2:0] phase /*verilator public_flat_rw*/;
  logic [31:0] pc /*verilator public_flat_rw*/;
endmodule

bind mmcs host_view u_host_view ();

`default_nettype wire
