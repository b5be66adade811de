// SPDX-License-Identifier: Apache-2.0
// Direction and output enable of a 74xx245, 74xx645 or ABT245 between the FPGA and a bus, such that
// no two drivers meet on either side: DIR changes only while OE# is high, a clock on each side.
//
// Out: OE# high, a clock later DIR and the FPGA's own drivers, another clock later OE# low; back the
// same way. `gate_i` = 0 takes outgoing data off the bus at once, without a clock.
`default_nettype none

module data_turn (
  input  wire logic clk_i,
  input  wire logic rst_ni,
  input  wire logic out_i,      // data are to go out to the bus
  input  wire logic in_i,       // data are to come in
  input  wire logic gate_i,     // asynchronous: outgoing data may be on the bus
  output logic      dir_o,      // 1: FPGA to bus (A to B)
  output logic      oe_no,
  output logic      drive_o     // the FPGA drives its side
);

  logic out_q, turned_d, turned_q;   // the direction; it stands for a clock or more

  assign turned_d = (out_q == out_i);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      out_q    <= 1'b0;
      turned_q <= 1'b0;
    end else begin
      out_q    <= out_i;
      turned_q <= turned_d;
    end
  end

  assign dir_o = out_q;
  assign drive_o = out_q;
  assign oe_no = ~(turned_q & (out_q ? (out_i & gate_i) : (in_i & ~out_i)));

endmodule

`default_nettype wire
