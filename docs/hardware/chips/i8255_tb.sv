// SPDX-License-Identifier: Apache-2.0
// The 8255 alone: ports A and B out, C in; a write shows on the pins, a read shows the pins of C.
module i8255_tb;
  logic clk = 0, rst_n = 0, cs_n = 1, rd_n = 1, wr_n = 1, oe;
  logic [1:0] a = 0;
  logic [7:0] din = 0, dout, pa, pa_oe, pb, pb_oe, pc, pc_oe, seen;

  i8255 dut (
      .clk_i(clk), .rst_ni(rst_n), .reset_i(1'b0), .cs_ni(cs_n), .rd_ni(rd_n), .wr_ni(wr_n),
      .a_i(a), .d_i(din), .d_o(dout), .d_oe_o(oe), .pa_i(8'h00), .pa_o(pa), .pa_oe_o(pa_oe),
      .pb_i(8'h00), .pb_o(pb), .pb_oe_o(pb_oe), .pc_i(8'h3C), .pc_o(pc), .pc_oe_o(pc_oe)
  );

  always #5 clk = !clk;

  task automatic write(input logic [1:0] where, input logic [7:0] value);
    @(negedge clk) begin cs_n = 0; a = where; din = value; wr_n = 0; end
    @(negedge clk) begin cs_n = 1; wr_n = 1; end
  endtask

  initial begin
    repeat (2) @(negedge clk);
    rst_n = 1;
    write(2'd3, 8'h89);
    write(2'd0, 8'h5A);
    @(negedge clk) begin cs_n = 0; a = 2'd2; rd_n = 0; end
    @(negedge clk) seen = dout;
    if (pa == 8'h5A && pa_oe == 8'hFF && pc_oe == 8'h00 && seen == 8'h3C) $display("i8255: ok");
    else $display("i8255: A %h driven %h, C read %h", pa, pa_oe, seen);
    $finish;
  end
endmodule
