// SPDX-License-Identifier: MIT OR Apache-2.0
// pair__hwg_accumulator: sums the words of a group, or of several groups that take turns.
//
// Function:  where enable_i is high, sum_o = (first_i ? 0 : the sum SUMS words ago) + word_i.
// Format:    signed words of WIDTH bits to signed sums of SUM_WIDTH bits.
// Latency:   1 clock.
// Overflow:  the generator proves that SUM_WIDTH bits hold every partial sum (hwgen: docs/numerics.md).
// Reset:     none: first_i clears.
// Model:     hwgen: sim/src/model/array.rs, Array
`default_nettype none

module pair__hwg_accumulator #(
  parameter integer WIDTH     = 8,  // bits of a word, 2 or more
  parameter integer SUM_WIDTH = 9,  // bits of a sum, WIDTH or more
  parameter integer SUMS      = 1   // groups that take turns
) (
  input  wire                 clk_i,
  input  wire                 enable_i,
  input  wire                 first_i,
  input  wire [WIDTH-1:0]     word_i,
  output wire [SUM_WIDTH-1:0] sum_o
);
  reg [SUMS*SUM_WIDTH-1:0] sum_q = {SUMS*SUM_WIDTH{1'b0}};  // the newest lowest

  wire [SUM_WIDTH-1:0] word   = {{(SUM_WIDTH-WIDTH+1){word_i[WIDTH-1]}}, word_i[WIDTH-2:0]};
  wire [SUM_WIDTH-1:0] oldest = sum_q[(SUMS-1)*SUM_WIDTH +: SUM_WIDTH];

  integer i;
  always @(posedge clk_i) begin
    if (enable_i) begin
      sum_q[0 +: SUM_WIDTH] <= (first_i ? {SUM_WIDTH{1'b0}} : oldest) + word;
      for (i = 1; i < SUMS; i = i + 1)
        sum_q[i*SUM_WIDTH +: SUM_WIDTH] <= sum_q[(i-1)*SUM_WIDTH +: SUM_WIDTH];
    end
  end

  assign sum_o = sum_q[0 +: SUM_WIDTH];
endmodule

`default_nettype wire
