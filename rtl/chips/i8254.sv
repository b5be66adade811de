// SPDX-License-Identifier: Apache-2.0
// 8254 programmable interval timer: the bus and three counters. §4.3.4
`default_nettype none

module i8254 #(
  parameter bit NmosRewrite = 1'b1,           // see i8254_counter
  parameter bit SplitCr = 1'b1,
  parameter logic [31:0] PowerUpSeed = 32'd0  // state at power-up; the chip has no reset pin
) (
  input  wire logic       clk_i,
  input  wire logic       rst_ni,
  // Bus
  input  wire logic       cs_ni,
  input  wire logic       rd_ni,
  input  wire logic       wr_ni,
  input  wire logic [1:0] a_i,
  input  wire logic [7:0] d_i,
  output logic      [7:0] d_o,
  output logic            d_oe_o,
  // Counters: edges of CLK that fall into this clock, the rise before the fall
  input  wire logic       clk0_rise_i,
  input  wire logic       clk0_fall_i,
  input  wire logic       clk1_rise_i,
  input  wire logic       clk1_fall_i,
  input  wire logic       clk2_rise_i,
  input  wire logic       clk2_fall_i,
  input  wire logic [2:0] gate_i,
  output logic      [2:0] out_o,
  output logic            out0_rise_o,  // OUT will rise on this clock: for cascades
  output logic            out0_fall_o,
  output logic            out1_rise_o,
  output logic            out1_fall_o,
  output logic            out2_rise_o,
  output logic            out2_fall_o
);

  // --- bus: a write acts when its strobe ends, so does what a read changes --------------------

  logic rd, wr, rd_q, wr_q, wr_end, rd_end;
  logic [1:0] a_d, a_q;
  logic [7:0] d_d, d_q;

  assign rd = !cs_ni && !rd_ni;
  assign wr = !cs_ni && !wr_ni && rd_ni;
  assign wr_end = wr_q && !wr;
  assign rd_end = rd_q && !rd;
  assign a_d = (rd || wr) ? a_i : a_q;
  assign d_d = wr ? d_i : d_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      rd_q <= 1'b0;
      wr_q <= 1'b0;
      a_q  <= '0;
      d_q  <= '0;
    end else begin
      rd_q <= rd;
      wr_q <= wr;
      a_q  <= a_d;
      d_q  <= d_d;
    end
  end

  // --- commands, one bit per counter ----------------------------------------------------------

  logic to_control, read_back;
  logic [2:0] at, chosen, selected;  // by the address, by SC of a control word, by a read-back
  logic [2:0] write, read_end, control, latch_count, latch_status;
  logic [1:0] sc, rw;

  assign sc = d_q[7:6];
  assign rw = d_q[5:4];
  assign at = a_q == 2'd3 ? 3'b000 : 3'b001 << a_q;
  assign chosen = sc == 2'd3 ? 3'b000 : 3'b001 << sc;
  assign selected = d_q[3:1];
  assign to_control = wr_end && a_q == 2'd3;
  assign read_back = to_control && sc == 2'd3;

  assign write = wr_end ? at : 3'b000;
  assign read_end = rd_end ? at : 3'b000;
  assign control = (to_control && rw != 2'd0) ? chosen : 3'b000;
  assign latch_count = (read_back && !d_q[5]) ? selected
                     : (to_control && rw == 2'd0) ? chosen : 3'b000;
  assign latch_status = (read_back && !d_q[4]) ? selected : 3'b000;

  // --- counters -------------------------------------------------------------------------------

  logic [23:0] d;

  // In a cascade one counter's OUT is the next one's CLK: each has nets of its own.
  for (genvar n = 0; n < 3; n++) begin : g_counter
    logic out_rise, out_fall;

    i8254_counter #(
      .NmosRewrite(NmosRewrite),
      .SplitCr(SplitCr),
      // A seed of 0 stays 0 in every counter, any other gives each counter a state of its own.
      .PowerUpSeed(PowerUpSeed << 11 * n | PowerUpSeed >> (32 - 11 * n))
    ) u_counter (
      .clk_i, .rst_ni,
      .clk_rise_i(n == 0 ? clk0_rise_i : n == 1 ? clk1_rise_i : clk2_rise_i),
      .clk_fall_i(n == 0 ? clk0_fall_i : n == 1 ? clk1_fall_i : clk2_fall_i),
      .gate_i(gate_i[n]),
      .out_o(out_o[n]),
      .out_rise_o(out_rise),
      .out_fall_o(out_fall),
      .control_i(control[n]),
      .latch_count_i(latch_count[n]),
      .latch_status_i(latch_status[n]),
      .write_i(write[n]),
      .read_i(rd),
      .read_end_i(read_end[n]),
      .d_i(d_q),
      .d_o(d[8*n+:8])
    );
  end

  assign {out0_rise_o, out0_fall_o} = {g_counter[0].out_rise, g_counter[0].out_fall};
  assign {out1_rise_o, out1_fall_o} = {g_counter[1].out_rise, g_counter[1].out_fall};
  assign {out2_rise_o, out2_fall_o} = {g_counter[2].out_rise, g_counter[2].out_fall};

  // --- reads: address 3 is no register, the idle bus reads 0xFF -------------------------------

  assign d_oe_o = rd;

  assign d_o = (rd && a_i != 2'd3) ? d[8*a_i+:8] : 8'hFF;

endmodule

`default_nettype wire
