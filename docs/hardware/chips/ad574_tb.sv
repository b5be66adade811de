// SPDX-License-Identifier: Apache-2.0
// The A/D alone: start a conversion of 5 V on the range of +-10 V, wait, read twelve bits.
module ad574_tb;
  logic clk = 0, rst_n = 0, ce = 0, rc_n = 1, sts, oe;
  logic [11:0] db;

  ad574 #(.ConvClks(20)) dut (
      .clk_i(clk), .rst_ni(rst_n), .ce_i(ce), .cs_ni(1'b0), .rc_ni(rc_n), .a0_i(1'b0),
      .mode12_i(1'b1), .sts_o(sts), .db_o(db), .db_oe_o(oe), .span10_i(1'b0), .vin_i(16'sd16384)
  );

  always #5 clk = !clk;

  initial begin
    repeat (2) @(negedge clk);
    rst_n = 1;
    @(negedge clk) begin rc_n = 0; ce = 1; end
    @(negedge clk) ce = 0;
    wait (sts);
    wait (!sts);
    @(negedge clk) begin rc_n = 1; ce = 1; end
    repeat (2) @(negedge clk);
    if (oe && db == 12'hC00) $display("ad574: ok");
    else $display("ad574: %h, driving %b", db, oe);
    $finish;
  end
endmodule
