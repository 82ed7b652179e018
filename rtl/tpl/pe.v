// SPDX-License-Identifier: MIT OR Apache-2.0
// @{ module }@: one neuron at a time of layer @{ layer }@, @{ simd }@ input@{ simd_s }@ a clock.
//
// Function:  sum_o = sum of operand * weight@{ sum_note }@.
// Format:    operands @{ x_format }@, weights @{ w_format }@@{ shift_note }@,
//            products @{ product_width }@ bits, sums @{ sum_width }@ bits, all exact.
// Latency:   @{ latency }@ clocks from operands to sum_o; weights @{ weight_delay }@ their operands.
// Overflow:  impossible: @{ sum_width }@ bits hold the sum of the weights' magnitudes times the operand's
//            greatest, of any part of it and in any order.
// Reset:     none.
// Model:     hwgen: sim/src/model/array.rs, Array
// @{ provenance }@
`default_nettype none

module @{ module }@ (
  input  wire clk_i,
@% if accumulates %@  input  wire enable_i,  // a clock before the foot of the tree
  input  wire first_i,
@% endif %@  input  wire @{ operands_range }@ operands_i,
  input  wire @{ weights_range }@ weights_i,
  output wire @{ sum_range }@ sum_o
);
@% if accumulates || operand_registers.len() > 0 %@  // Copies for this element alone, a clock to them and a clock from them; without `keep`, which some
  // tools look for at the register and others at the process, all elements share one.
@% for register in operand_registers %@  (* keep, dont_merge, syn_preserve = 1 *) reg @{ operands_range }@ @{ register.name }@ = {@{ operands_width }@{1'b0}};
@% endfor %@@% if accumulates %@  (* keep, dont_merge, syn_preserve = 1 *) reg enable_q = 1'b0;
  (* keep, dont_merge, syn_preserve = 1 *) reg first_q = 1'b0;
@% endif %@  (* keep *) always @(posedge clk_i) begin
@% for register in operand_registers %@    @{ "{:<11}"|format(register.name) }@ <= @{ register.source }@;
@% endfor %@@% if accumulates %@    enable_q    <= enable_i;
    first_q     <= first_i;
@% endif %@  end

@% endif %@  wire @{ products_range }@ products;

  genvar i;
  generate
    for (i = 0; i < @{ simd }@; i = i + 1) begin : g_mul
      @{ prefix }@__hwg_mul #(
        .A_WIDTH(@{ x_width }@),
        .B_WIDTH(@{ w_width }@)
      ) u_mul (
        .clk_i(clk_i),
        .a_i  (@{ operands }@[i*@{ x_width }@ +: @{ x_width }@]),
        .b_i  (weights_i[i*@{ w_width }@ +: @{ w_width }@]),
        .p_o  (products[i*@{ product_width }@ +: @{ product_width }@])
      );
    end
  endgenerate
@% for level in levels %@
  wire @{ level.range }@ level@{ level.number }@;
  @{ prefix }@__hwg_tree_level #(
    .INPUTS   (@{ level.inputs }@),
    .WIDTH    (@{ level.width }@),
    .SUM_WIDTH(@{ level.sum_width }@)
  ) u_level@{ level.number }@ (
    .clk_i  (clk_i),
    .words_i(@{ level.source }@),
    .sums_o (level@{ level.number }@)
  );
@% endfor %@
@% if accumulates %@  @{ prefix }@__hwg_accumulator #(
    .WIDTH    (@{ tree_width }@),
    .SUM_WIDTH(@{ sum_width }@)@% if turns > 1 %@,
    .SUMS     (@{ turns }@)@% endif %@
  ) u_acc (
    .clk_i   (clk_i),
    .enable_i(enable_q),
    .first_i (first_q),
    .word_i  (@{ tree }@),
    .sum_o   (sum_o)
  );
@% else %@  assign sum_o = @{ tree }@;
@% endif %@endmodule

`default_nettype wire
