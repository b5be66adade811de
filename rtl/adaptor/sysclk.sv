// SPDX-License-Identifier: Apache-2.0
// The system clock: 8, 4, 2 or 1 MHz by jumper, as enables of clk_i. §4.3.4
`default_nettype none

module sysclk #(
  parameter int ClkHz = 8_000_000,
  parameter int SysClkMHz = 8
) (
  input  wire logic clk_i,
  input  wire logic rst_ni,
  // Its edges, each in one clock of clk_i; both in every clock when it runs as fast as clk_i.
  output logic rise_o,
  output logic fall_o
);

  localparam int Div = ClkHz / (SysClkMHz * 1_000_000);

  if (Div <= 1) begin : g_same
    assign rise_o = 1'b1;
    assign fall_o = 1'b1;
    logic unused;
    assign unused = clk_i & rst_ni;
  end else begin : g_divide
    localparam int Width = $clog2(Div);
    localparam logic [Width-1:0] Last = Width'(Div - 1);
    localparam logic [Width-1:0] Half = Width'(Div / 2);

    logic [Width-1:0] phase_d, phase_q;

    assign phase_d = (phase_q == Last) ? '0 : phase_q + 1'b1;

    always_ff @(posedge clk_i or negedge rst_ni) begin
      if (!rst_ni) phase_q <= '0;
      else phase_q <= phase_d;
    end

    assign rise_o = (phase_q == '0);
    assign fall_o = (phase_q == Half);
  end

endmodule

`default_nettype wire
