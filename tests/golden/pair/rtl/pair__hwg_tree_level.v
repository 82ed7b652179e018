// SPDX-License-Identifier: MIT OR Apache-2.0
// pair__hwg_tree_level: one registered level of an adder tree.
//
// Function:  sums neighbours in pairs; an odd last word passes through.
// Format:    signed words of WIDTH bits to signed words of SUM_WIDTH bits.
// Latency:   1 clock.
// Overflow:  the generator proves that SUM_WIDTH bits hold every sum (hwgen: docs/numerics.md).
// Reset:     none.
// Model:     hwgen: sim/src/model/array.rs, Array
`default_nettype none

module pair__hwg_tree_level #(
  parameter integer INPUTS    = 4,  // words, 2 or more
  parameter integer WIDTH     = 8,  // bits of a word, 2 or more
  parameter integer SUM_WIDTH = 9   // bits of a sum, WIDTH or more
) (
  input  wire                                clk_i,
  input  wire [INPUTS*WIDTH-1:0]             words_i,
  output wire [(INPUTS+1)/2*SUM_WIDTH-1:0]   sums_o
);
  localparam integer PAIRS = INPUTS / 2;
  localparam integer SUMS  = (INPUTS + 1) / 2;
  localparam integer SIGNS = SUM_WIDTH - WIDTH + 1;  // copies of the sign bit, itself included

  reg [SUMS*SUM_WIDTH-1:0] sum_q = {SUMS*SUM_WIDTH{1'b0}};

  integer i;
  always @(posedge clk_i) begin
    for (i = 0; i < PAIRS; i = i + 1)
      sum_q[i*SUM_WIDTH +: SUM_WIDTH] <=
        {{SIGNS{words_i[2*i*WIDTH+WIDTH-1]}}, words_i[2*i*WIDTH +: WIDTH-1]} +
        {{SIGNS{words_i[(2*i+1)*WIDTH+WIDTH-1]}}, words_i[(2*i+1)*WIDTH +: WIDTH-1]};
    if (SUMS > PAIRS)
      sum_q[(SUMS-1)*SUM_WIDTH +: SUM_WIDTH] <=
        {{SIGNS{words_i[(INPUTS-1)*WIDTH+WIDTH-1]}}, words_i[(INPUTS-1)*WIDTH +: WIDTH-1]};
  end

  assign sums_o = sum_q;
endmodule

`default_nettype wire
