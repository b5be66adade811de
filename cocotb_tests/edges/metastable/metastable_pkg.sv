// SPDX-License-Identifier: Apache-2.0
// How long before a clock edge an input of sync.sv may be taken either way, set by the bench.
`timescale 1ps/1ps
`default_nettype none

package metastable_pkg;
  int window;   // ps
endpackage

`default_nettype wire
