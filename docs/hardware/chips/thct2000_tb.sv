// SPDX-License-Identifier: Apache-2.0
// The encoder counter alone: ten counts upwards, every edge counted (mode 5), latched, read by bytes.
module thct2000_tb;
  logic clk = 0, rst_n = 0, latch = 0, cs_n = 1, rd_n = 1, rs = 0, oe, illegal;
  logic [ 1:0] ab = 0;
  logic [ 7:0] d;
  logic [15:0] count, read;

  thct2000 dut (
      .clk_i(clk), .rst_ni(rst_n), .reset_i(1'b0), .clk_en_i(1'b1), .m_i(3'd5), .a_i(ab[1]),
      .b_i(ab[0]), .latch_i(latch), .other_i(1'b0), .cs_ni(cs_n), .rd_ni(rd_n), .wr_ni(1'b1),
      .rs_i(rs), .d_i(8'h00), .d_o(d), .d_oe_o(oe), .count_o(count), .illegal_o(illegal)
  );

  always #5 clk = !clk;

  task automatic byte_of(input logic low, output logic [7:0] value);
    @(negedge clk) begin cs_n = 0; rd_n = 0; rs = low; end
    @(negedge clk) begin value = d; cs_n = 1; rd_n = 1; end
  endtask

  initial begin
    repeat (2) @(negedge clk);
    rst_n = 1;
    repeat (8) @(negedge clk);
    repeat (10) begin
      ab = {!ab[0], ab[1]};  // A leads B
      repeat (2) @(negedge clk);
    end
    repeat (4) @(negedge clk);  // through the synchroniser
    latch = 1;
    @(negedge clk) latch = 0;
    byte_of(0, read[15:8]);
    byte_of(1, read[7:0]);
    if (!illegal && read == 10) $display("thct2000: ok");
    else $display("thct2000: %0d, illegal %b", $signed(read), illegal);
    $finish;
  end
endmodule
