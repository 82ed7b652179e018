// SPDX-License-Identifier: MIT OR Apache-2.0
// hwg_add: sum or difference of two words that are moved up, registered.
//
// Function:  sum_o = (a_i << A_SHIFT) + (b_i << B_SHIFT), or their difference.
// Format:    signed words of A_WIDTH and B_WIDTH bits to a signed word of WIDTH bits.
// Latency:   1 clock.
// Overflow:  the generator proves that WIDTH bits hold every sum (hwgen: docs/numerics.md).
// Reset:     none.
// Model:     hwgen: sim/src/model/adders.rs
`default_nettype none

module hwg_add #(
  parameter integer A_WIDTH  = 8,
  parameter integer A_SHIFT  = 0,
  parameter integer B_WIDTH  = 8,
  parameter integer B_SHIFT  = 0,
  parameter integer SUBTRACT = 0,  // 1: the difference a - b
  parameter integer WIDTH    = 9
) (
  input  wire               clk_i,
  input  wire [A_WIDTH-1:0] a_i,
  input  wire [B_WIDTH-1:0] b_i,
  output wire [WIDTH-1:0]   sum_o
);
  // verilator lint_off UNUSED
  // Sign-extended by more bits than the sum has.
  wire [WIDTH+A_WIDTH-1:0] a_wide = {{WIDTH{a_i[A_WIDTH-1]}}, a_i} << A_SHIFT;
  wire [WIDTH+B_WIDTH-1:0] b_wide = {{WIDTH{b_i[B_WIDTH-1]}}, b_i} << B_SHIFT;
  // verilator lint_on UNUSED
  wire [WIDTH-1:0] a = a_wide[WIDTH-1:0];
  wire [WIDTH-1:0] b = b_wide[WIDTH-1:0];

  reg [WIDTH-1:0] sum_q = {WIDTH{1'b0}};
  always @(posedge clk_i) sum_q <= SUBTRACT != 0 ? a - b : a + b;

  assign sum_o = sum_q;
endmodule

`default_nettype wire
