// SPDX-License-Identifier: Apache-2.0
// The heartbeat's one-shot alone: a pulse, and one that a second trigger makes longer.
module oneshot_tb;
  logic clk = 0, rst_n = 0, trig = 0, q;
  int   high = 0;

  oneshot #(.PulseClks(10)) dut (
      .clk_i(clk), .rst_ni(rst_n), .trig_i(trig), .clr_ni(1'b1), .q_o(q)
  );

  always #5 clk = !clk;
  always @(posedge clk) if (q) high = high + 1;

  initial begin
    repeat (2) @(negedge clk);
    rst_n = 1;
    @(negedge clk) trig = 1;
    @(negedge clk) trig = 0;
    repeat (5) @(negedge clk);
    trig = 1;
    repeat (20) @(negedge clk);
    if (high == 16 && !q) $display("oneshot: ok");
    else $display("oneshot: high for %0d clocks", high);
    $finish;
  end
endmodule
