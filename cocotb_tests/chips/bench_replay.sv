// SPDX-License-Identifier: Apache-2.0
// Replays a file of packed pins, one word per clock, and writes down what the outputs were.
// The comparison with the reference model happens afterwards in Python: a hundred thousand
// operations take seconds, in Verilator and Icarus alike.
`default_nettype none

module bench_replay #(
    parameter int InBits = 8,
    parameter int OutBits = 8,
    parameter logic [InBits-1:0] Idle = '0,  // pins while nothing is replayed
    parameter int Depth = 262_144
) (
    input wire clk_i,
    input wire go_i,  // a rising edge starts one replay
    input wire [31:0] id_i,  // files are stim_<id>.hex and resp_<id>.hex in the run's directory
    input wire [31:0] length_i,  // words in the file
    output logic [InBits-1:0] stim_o,
    input wire [OutBits-1:0] resp_i,  // as seen by the clock edge that also sees stim_o
    output logic done_o
);
  logic [InBits-1:0] words[0:Depth-1];
  logic go_q = 1'b0;
  logic busy = 1'b0;
  int at = 0;
  int file = 0;
  string name;

  initial begin
    stim_o = Idle;
    done_o = 1'b0;
  end

  always @(posedge clk_i) begin
    go_q <= go_i;
    if (go_i && !go_q) begin
      name = $sformatf("stim_%0d.hex", id_i);
      $readmemh(name, words, 0, length_i - 1);
      name = $sformatf("resp_%0d.hex", id_i);
      file = $fopen(name, "w");
      stim_o <= words[0];
      at <= 1;
      busy <= 1'b1;
      done_o <= 1'b0;
    end else if (busy) begin
      $fwrite(file, "%h\n", resp_i);
      if (at == length_i) begin
        $fclose(file);
        stim_o <= Idle;
        busy <= 1'b0;
        done_o <= 1'b1;
      end else begin
        stim_o <= words[at];
        at <= at + 1;
      end
    end
  end
endmodule

`default_nettype wire
