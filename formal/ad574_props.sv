// SPDX-License-Identifier: Apache-2.0
// The A/D converter, for all inputs. §5.3.4
`default_nettype none
`include "mmcs_formal.svh"

module ad574_props #(
  parameter int ConvClks = 200
) (
  input wire logic               clk_i,
  input wire logic               no_reset_i,
  input wire logic               ce_i,
  input wire logic               cs_ni,
  input wire logic               rc_ni,
  input wire logic               a0_i,
  input wire logic               mode12_i,
  input wire logic               span10_i,
  input wire logic signed [15:0] vin_i
);

  `MMCS_RESET(no_reset_i)

  logic sts, oe;
  logic [11:0] db;
  ad574 #(
    .ConvClks(ConvClks)
  ) dut (
    .clk_i, .rst_ni, .ce_i, .cs_ni, .rc_ni, .a0_i, .mode12_i,
    .sts_o(sts),
    .db_o(db),
    .db_oe_o(oe),
    .span10_i, .vin_i
  );

  // The model: the clocks since the start, the input at the start, and the code that it lies
  // nearest to: code c stands for (c - 2048) steps of 16 (span 20 V) or 8 units of 10 V / 32768.
  logic convert, convert_q, busy_q, short_q;
  int age_q, length;
  logic [11:0] sampled_q, code_q;
  int step, nearest;
  assign convert = ce_i && !cs_ni && !rc_ni;
  assign length  = short_q ? (ConvClks * 16 + 24) / 25 : ConvClks;
  assign step    = span10_i ? 8 : 16;
  assign nearest = (int'(vin_i) + 2048 * step + step / 2) / step;

  function automatic logic [11:0] clamp(input int v, input int raw);
    clamp = raw < 0 ? 12'h000 : v > 4095 ? 12'hFFF : v[11:0];
  endfunction

  always @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      {convert_q, busy_q, short_q, sampled_q, code_q} <= '0;
      age_q <= 0;
    end else begin
      convert_q <= convert;
      if (busy_q) begin
        age_q <= age_q + 1;
        if (age_q == length) begin
          busy_q <= 1'b0;
          code_q <= short_q ? {sampled_q[11:4], 4'h0} : sampled_q;
        end
      end else if (convert && !convert_q) begin
        busy_q    <= 1'b1;
        age_q     <= 1;
        short_q   <= a0_i;
        sampled_q <= clamp(nearest, int'(vin_i) + 2048 * step + step / 2);
      end
    end
  end

  (* hierconn *) wire [$clog2(ConvClks + 1)-1:0] \dut.left_q ;
  (* hierconn *) wire [11:0] \dut.next_q , \dut.code_q ;
  (* hierconn *) wire \dut.start_q ;

  `MMCS_PROVE(Busy, "5.3.4", busy_q, sts, "a conversion takes 200 clocks, 25 us, or 128 of 8 bits")
  `MMCS_PROVE(Done, "5.3.4", !busy_q, !sts, "after that it is over, and nothing else starts one")
  `MMCS_PROVE(Code, "5.3.4", ce_i && !cs_ni && rc_ni && !busy_q && mode12_i, oe && db == code_q,
              "what is read is the code nearest to the voltage at the start")
  `MMCS_PROVE(Bytes, "5.3.4", ce_i && !cs_ni && rc_ni && !busy_q && !mode12_i,
              oe && db[11:4] == (a0_i ? {code_q[3:0], 4'h0} : code_q[11:4]),
              "by bytes it is the high eight bits, or the low four and zeros")
  `MMCS_PROVE(Quiet, "5.3.4", busy_q, !oe, "while it converts the part drives nothing")
  `MMCS_PROVE(Stable, "5.3.4", $past(oe) && oe && code_q != 12'h000 &&
              {mode12_i, a0_i} == $past({mode12_i, a0_i}) && $past(rst_ni), db == $past(db),
              "data that is read does not change")
  `MMCS_REACH(Top, code_q == 12'hFFF && oe, "the greatest code can be read")

  `MMCS_LEMMA(Edges, dut.start_q == convert_q, "both see the same starts")
  `MMCS_LEMMA(Left, !busy_q || (dut.left_q == length + 1 - age_q && age_q >= 1 && age_q <= length),
              "what is left is the length without the age")
  `MMCS_LEMMA(Codes, dut.code_q == code_q && (!busy_q || dut.next_q ==
              (short_q ? {sampled_q[11:4], 4'h0} : sampled_q)), "both hold the same codes")

endmodule

`default_nettype wire
