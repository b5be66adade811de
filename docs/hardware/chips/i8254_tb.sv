// SPDX-License-Identifier: Apache-2.0
// The 8254 alone, its strobes as short as may be: counter 0 as a rate generator (mode 2) of five, of
// which OUT is low once in five CLKs, and counter 1 as one of three, of a CLK that comes from a pin.
module i8254_tb;
  logic clk = 0, rst_n = 0, cs_n = 1, wr_n = 1, oe;
  logic [1:0] a = 0;
  logic [7:0] din = 0, dout;
  logic [2:0] out;
  int low = 0, pin_rises = 0, out_rises = 0;

  // From a CLK pin: two flip-flops synchronise, the third remembers what CLK was.
  logic clk1_pin = 0, clk1_rise, clk1_fall;
  (* ASYNC_REG = "TRUE" *) logic [2:0] clk1_q;
  always_ff @(posedge clk or negedge rst_n)
    if (!rst_n) clk1_q <= '0;
    else clk1_q <= {clk1_q[1:0], clk1_pin};
  assign clk1_rise = clk1_q[2:1] == 2'b01;
  assign clk1_fall = clk1_q[2:1] == 2'b10;

  i8254 dut (  // CLK0 is the system clock, CLK1 a pin, CLK2 stands
      .clk_i(clk), .rst_ni(rst_n), .cs_ni(cs_n), .rd_ni(1'b1), .wr_ni(wr_n), .a_i(a), .d_i(din),
      .d_o(dout), .d_oe_o(oe), .clk0_rise_i(1'b1), .clk0_fall_i(1'b1), .clk1_rise_i(clk1_rise),
      .clk1_fall_i(clk1_fall), .clk2_rise_i(1'b0), .clk2_fall_i(1'b0), .gate_i(3'b111), .out_o(out)
  );

  always #5 clk = !clk;
  always #13 clk1_pin = !clk1_pin;
  always @(posedge clk1_pin) pin_rises = pin_rises + 1;
  always @(posedge out[1]) out_rises = out_rises + 1;

  task automatic write(input logic [1:0] where, input logic [7:0] value);
    @(negedge clk) begin cs_n = 0; a = where; din = value; wr_n = 0; end
    @(negedge clk) begin cs_n = 1; wr_n = 1; end
  endtask

  initial begin
    repeat (2) @(negedge clk);
    rst_n = 1;
    write(2'd3, 8'h14);  // counter 0, low byte only, mode 2
    write(2'd0, 8'd5);
    write(2'd3, 8'h54);  // counter 1, low byte only, mode 2
    write(2'd1, 8'd3);
    repeat (20) @(negedge clk);
    repeat (50) @(negedge clk) if (!out[0]) low = low + 1;
    pin_rises = 0;
    out_rises = 0;
    repeat (780) @(negedge clk);  // 300 CLKs of the pin
    if (low == 10 && pin_rises == 300 && out_rises == 100) $display("i8254: ok");
    else $display("i8254: %0d of 50 low, %0d OUTs of %0d CLKs", low, out_rises, pin_rises);
    $finish;
  end
endmodule
