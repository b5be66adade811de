// SPDX-License-Identifier: Apache-2.0
// The 8254 alone: counter 0 as a rate generator (mode 2) of five; OUT is low once in five CLKs.
module i8254_tb;
  logic clk = 0, rst_n = 0, cs_n = 1, wr_n = 1, oe;
  logic [1:0] a = 0;
  logic [7:0] din = 0, dout;
  logic [2:0] out;
  int low = 0;

  i8254 dut (  // CLK0 is the system clock, CLK1 and CLK2 stand
      .clk_i(clk), .rst_ni(rst_n), .cs_ni(cs_n), .rd_ni(1'b1), .wr_ni(wr_n), .a_i(a), .d_i(din),
      .d_o(dout), .d_oe_o(oe), .clk0_rise_i(1'b1), .clk0_fall_i(1'b1), .clk1_rise_i(1'b0),
      .clk1_fall_i(1'b0), .clk2_rise_i(1'b0), .clk2_fall_i(1'b0), .gate_i(3'b111), .out_o(out)
  );

  always #5 clk = !clk;

  task automatic write(input logic [1:0] where, input logic [7:0] value);
    @(negedge clk) begin cs_n = 0; a = where; din = value; wr_n = 0; end
    repeat (3) @(negedge clk);
    wr_n = 1;
    @(negedge clk) cs_n = 1;
    repeat (2) @(negedge clk);
  endtask

  initial begin
    repeat (2) @(negedge clk);
    rst_n = 1;
    write(2'd3, 8'h14);  // counter 0, low byte only, mode 2
    write(2'd0, 8'd5);
    repeat (20) @(negedge clk);
    repeat (50) @(negedge clk) if (!out[0]) low = low + 1;
    if (low == 10) $display("i8254: ok");
    else $display("i8254: low in %0d of 50 clocks", low);
    $finish;
  end
endmodule
