// SPDX-License-Identifier: Apache-2.0
// The same as replay.cpp for Icarus: +record=FILE +last=CLOCK.
`timescale 1ns / 1ps
module replay_tb;
  logic clk_i = 0;
`include "signals.svh"
  mmcs #(.NumCards(3)) dut (.*);

  integer file, found, t, at, field, last, other = 0;
  logic [31:0] value;
  logic [9:0] expected = 0;
  string name;

  initial begin
    found = $value$plusargs("record=%s", name) + $value$plusargs("last=%d", last);
    file = $fopen(name, "r");
    found = $fscanf(file, "%d %d %d", at, field, value);
    for (t = at; t < last; t = t + 1) begin
      clk_i = 1;
      #62;
      while (found == 3 && at == t) begin
        case (field)
`include "cases.svh"
          default: expected = value[9:0];
        endcase
        found = $fscanf(file, "%d %d %d", at, field, value);
      end
      clk_i = 0;
      #63;
      if (t >= 0 && {vme_dtack_no, vme_d_oe_o, vme_d_o[7:0]} !== expected) other = other + 1;
    end
    $display("%0d", other);
    $finish;
  end
endmodule
