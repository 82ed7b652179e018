// SPDX-License-Identifier: MIT OR Apache-2.0
// hwg_pair: a word times two bits, the leaf of hwg_mul_logic that a device family may replace.
//
// Function:  p_o = a_i * b_i, unsigned and exact.
// Latency:   none.
// Overflow:  impossible: the product has WIDTH + 2 bits.
`default_nettype none

module hwg_pair #(
  parameter integer WIDTH = 8
) (
  input  wire [WIDTH-1:0] a_i,
  input  wire [1:0]       b_i,
  output wire [WIDTH+1:0] p_o
);
  assign p_o = ({2'b0, a_i} & {(WIDTH+2){b_i[0]}}) + ({1'b0, a_i, 1'b0} & {(WIDTH+2){b_i[1]}});
endmodule

`default_nettype wire
