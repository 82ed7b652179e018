// SPDX-License-Identifier: MIT OR Apache-2.0
// line__hwg_mul: signed multiplier, the leaf that a device family may replace by its DSP block.
//
// Function:  p_o = a_i * b_i, exact.
// Latency:   3 clocks, one product a clock: operands and product are registered, as in a DSP block,
//            and the product once more on its way to the adders.
// Overflow:  impossible: the product has A_WIDTH + B_WIDTH bits.
// Reset:     none.
// Model:     hwgen: sim/src/model/array.rs, Array
`default_nettype none

module line__hwg_mul #(
  parameter integer A_WIDTH = 8,
  parameter integer B_WIDTH = 8
) (
  input  wire                              clk_i,
  input  wire signed [A_WIDTH-1:0]         a_i,
  input  wire signed [B_WIDTH-1:0]         b_i,
  output wire signed [A_WIDTH+B_WIDTH-1:0] p_o
);
  // In a DSP block, by the names under which AMD's, Intel's and Lattice's tools know it.
  (* use_dsp = "yes", multstyle = "dsp", syn_multstyle = "block_mult" *)
  reg signed [A_WIDTH+B_WIDTH-1:0] p_q = {(A_WIDTH+B_WIDTH){1'b0}};
  reg signed [A_WIDTH-1:0]         a_q = {A_WIDTH{1'b0}};
  reg signed [B_WIDTH-1:0]         b_q = {B_WIDTH{1'b0}};
  reg signed [A_WIDTH+B_WIDTH-1:0] r_q = {(A_WIDTH+B_WIDTH){1'b0}};

  always @(posedge clk_i) begin
    a_q <= a_i;
    b_q <= b_i;
    p_q <= a_q * b_q;
    r_q <= p_q;
  end

  assign p_o = r_q;
endmodule

`default_nettype wire
