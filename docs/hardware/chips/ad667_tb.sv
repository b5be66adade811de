// SPDX-License-Identifier: Apache-2.0
// The D/A alone: a byte, then a nibble into the first rank, then all twelve bits at once.
module ad667_tb;
  logic clk = 0, rst_n = 0, cs_n = 1;
  logic [ 3:0] a_n = 4'b1111;
  logic [11:0] d = 0, code;

  ad667 dut (.clk_i(clk), .rst_ni(rst_n), .cs_ni(cs_n), .a_ni(a_n), .d_i(d), .code_o(code));

  always #5 clk = !clk;

  task automatic write(input logic [3:0] select_n, input logic [11:0] value);
    @(negedge clk) begin cs_n = 0; a_n = select_n; d = value; end
    @(negedge clk) begin cs_n = 1; a_n = 4'b1111; end
  endtask

  initial begin
    repeat (2) @(negedge clk);
    rst_n = 1;
    write(4'b1100, 12'h0A5);  // low byte
    write(4'b1011, 12'h700);  // high nibble
    if (code != 12'h800) $display("ad667: moved too soon to %h", code);
    write(4'b0111, 12'h000);  // second rank
    if (code == 12'h7A5) $display("ad667: ok");
    else $display("ad667: %h", code);
    $finish;
  end
endmodule
