// SPDX-License-Identifier: MIT OR Apache-2.0
// hwg_accumulator: sums the words of a group.
//
// Function:  sum_o = (first_i ? 0 : sum_o) + word_i, where enable_i is high.
// Format:    signed words of WIDTH bits to a signed sum of SUM_WIDTH bits.
// Latency:   1 clock.
// Overflow:  the generator proves that SUM_WIDTH bits hold every partial sum (hwgen: docs/numerics.md).
// Reset:     none: first_i clears.
// Model:     hwgen: sim/src/model/array.rs, Array
`default_nettype none

module hwg_accumulator #(
  parameter integer WIDTH     = 8,  // bits of a word, 2 or more
  parameter integer SUM_WIDTH = 9   // bits of the sum, WIDTH or more
) (
  input  wire                 clk_i,
  input  wire                 enable_i,
  input  wire                 first_i,
  input  wire [WIDTH-1:0]     word_i,
  output wire [SUM_WIDTH-1:0] sum_o
);
  reg [SUM_WIDTH-1:0] sum_q = {SUM_WIDTH{1'b0}};

  wire [SUM_WIDTH-1:0] word = {{(SUM_WIDTH-WIDTH+1){word_i[WIDTH-1]}}, word_i[WIDTH-2:0]};

  always @(posedge clk_i) begin
    if (enable_i) sum_q <= (first_i ? {SUM_WIDTH{1'b0}} : sum_q) + word;
  end

  assign sum_o = sum_q;
endmodule

`default_nettype wire
