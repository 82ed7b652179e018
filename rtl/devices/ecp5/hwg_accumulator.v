// SPDX-License-Identifier: MIT OR Apache-2.0
// hwg_accumulator: the accumulator in one carry chain of an ECP5, whose tables take first_i too.
//
// Function:  where enable_i is high, sum_o = (first_i ? 0 : the sum SUMS words ago) + word_i.
// Format:    signed words of WIDTH bits to signed sums of SUM_WIDTH bits.
// Latency:   1 clock.
// Overflow:  the generator proves that SUM_WIDTH bits hold every partial sum (hwgen: docs/numerics.md).
// Reset:     none: first_i clears.
// Model:     hwgen: sim/src/model/array.rs, Array; equal to the portable one (tests/blocks.rs)
`default_nettype none

module hwg_accumulator #(
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
  localparam integer CELLS = (SUM_WIDTH + 1) / 2;  // two bits each

  reg [SUMS*SUM_WIDTH-1:0] sum_q = {SUMS*SUM_WIDTH{1'b0}};  // the newest lowest

  wire [2*CELLS-1:0] word   = {{(2*CELLS-WIDTH+1){word_i[WIDTH-1]}}, word_i[WIDTH-2:0]};
  wire [2*CELLS-1:0] oldest = {{(2*CELLS-SUM_WIDTH+1){sum_q[SUMS*SUM_WIDTH-1]}},
                               sum_q[(SUMS-1)*SUM_WIDTH +: SUM_WIDTH-1]};

  // verilator lint_off UNUSED
  // The sum has no carry, and an even number of bits is summed.
  wire [CELLS:0]     carry;
  wire [2*CELLS-1:0] sum;
  // verilator lint_on UNUSED
  assign carry[0] = 1'b0;

  genvar k;
  generate
    for (k = 0; k < CELLS; k = k + 1) begin : g_cell
      // A of the word, B of the sum, which C takes away: A ^ (B & ~C); where that is none, A is the carry.
      // For what C does, synthesis takes tables of their own, in front of the chain.
      CCU2C #(
        .INIT0    (16'hA6AA),
        .INIT1    (16'hA6AA),
        .INJECT1_0("NO"),
        .INJECT1_1("NO")
      ) u_cell (
        .CIN(carry[k]),
        .A0(word[2*k]),   .B0(oldest[2*k]),   .C0(first_i), .D0(1'b1), .S0(sum[2*k]),
        .A1(word[2*k+1]), .B1(oldest[2*k+1]), .C1(first_i), .D1(1'b1), .S1(sum[2*k+1]),
        .COUT(carry[k+1])
      );
    end
  endgenerate

  integer i;
  always @(posedge clk_i) begin
    if (enable_i) begin
      sum_q[0 +: SUM_WIDTH] <= sum[SUM_WIDTH-1:0];
      for (i = 1; i < SUMS; i = i + 1)
        sum_q[i*SUM_WIDTH +: SUM_WIDTH] <= sum_q[(i-1)*SUM_WIDTH +: SUM_WIDTH];
    end
  end

  assign sum_o = sum_q[0 +: SUM_WIDTH];
endmodule

`default_nettype wire
