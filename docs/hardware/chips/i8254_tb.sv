// SPDX-License-Identifier: Apache-2.0
// The 8254 alone, its strobes as short as may be: counter 0 as a rate generator (mode 2) of five, of
// which OUT is low once in five CLKs, and counter 1 as one of three, of a CLK that comes from a pin.
// A second 8254 behind a bus that has no clock of ours: counter 0 as a rate generator of four.
module i8254_tb;
  logic clk = 0, rst_n = 0, cs_n = 1, wr_n = 1, oe;
  logic [1:0] a = 0;
  logic [7:0] din = 0, dout;
  logic [2:0] out, far_out;
  logic pin_cs_n = 1, pin_rd_n = 1, pin_wr_n = 1, far_oe;
  logic [1:0] pin_a = 0;
  logic [7:0] pin_d = 0, far_d;
  logic [5:0] far_status;
  int low = 0, far_low = 0, pin_rises = 0, out_rises = 0;

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

  // Pins of a bus that has no clock of ours: two flip-flops each.
  logic [2:0] strobes;  // CS#, RD#, WR#
  logic [9:0] bus;      // address and data
  mmcs_sync #(.Width(3), .ResetValue(3'b111)) u_strobes (
      .clk_i(clk), .rst_ni(rst_n), .d_i({pin_cs_n, pin_rd_n, pin_wr_n}), .q_o(strobes)
  );
  mmcs_sync #(.Width(10)) u_bus (
      .clk_i(clk), .rst_ni(rst_n), .d_i({pin_a, pin_d}), .q_o(bus)
  );
  wire far_drives = far_oe && !pin_rd_n && !pin_cs_n;  // a read ends with its pins

  i8254 far (
      .clk_i(clk), .rst_ni(rst_n), .cs_ni(strobes[2]), .rd_ni(strobes[1]), .wr_ni(strobes[0]),
      .a_i(bus[9:8]), .d_i(bus[7:0]), .d_o(far_d), .d_oe_o(far_oe), .clk0_rise_i(1'b1),
      .clk0_fall_i(1'b1), .clk1_rise_i(1'b0), .clk1_fall_i(1'b0), .clk2_rise_i(1'b0),
      .clk2_fall_i(1'b0), .gate_i(3'b111), .out_o(far_out)
  );

  always #5 clk = !clk;
  always #13 clk1_pin = !clk1_pin;
  always @(posedge clk1_pin) pin_rises = pin_rises + 1;
  always @(posedge out[1]) out_rises = out_rises + 1;

  task automatic write(input logic [1:0] where, input logic [7:0] value);
    @(negedge clk) begin cs_n = 0; a = where; din = value; wr_n = 0; end
    @(negedge clk) begin cs_n = 1; wr_n = 1; end
  endtask

  task automatic far_write(input logic [1:0] where, input logic [7:0] value);
    #17 pin_a = where; pin_d = value;
    #3 pin_cs_n = 0; pin_wr_n = 0;
    #23 pin_cs_n = 1; pin_wr_n = 1;
    #13;
  endtask

  initial begin
    repeat (2) @(negedge clk);
    rst_n = 1;
    write(2'd3, 8'h14);  // counter 0, low byte only, mode 2
    write(2'd0, 8'd5);
    write(2'd3, 8'h54);  // counter 1, low byte only, mode 2
    write(2'd1, 8'd3);
    far_write(2'd3, 8'h14);
    far_write(2'd0, 8'd4);
    far_write(2'd3, 8'hE2);  // read-back: status of counter 0
    pin_a = 0; pin_cs_n = 0; pin_rd_n = 0;
    #41 far_status = far_drives ? far_d[5:0] : '0;
    pin_cs_n = 1; pin_rd_n = 1;
    repeat (20) @(negedge clk);
    repeat (50) @(negedge clk) if (!out[0]) low = low + 1;
    repeat (40) @(negedge clk) if (!far_out[0]) far_low = far_low + 1;
    pin_rises = 0;
    out_rises = 0;
    repeat (780) @(negedge clk);  // 300 CLKs of the pin
    if (low == 10 && pin_rises == 300 && out_rises == 100 && far_low == 10 && far_status == 6'h14)
      $display("i8254: ok");
    else
      $display("i8254: %0d of 50 low, %0d OUTs of %0d CLKs; over pins %0d of 40 low, status %h",
               low, out_rises, pin_rises, far_low, far_status);
    $finish;
  end
endmodule
