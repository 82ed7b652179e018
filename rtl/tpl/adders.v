// SPDX-License-Identifier: MIT OR Apache-2.0
// @{ module }@: the weighted sums of layer @{ layer }@ by shifts and adders.
//
// Function:  sums = W x; a weight is a sum of a few powers of two, and what several sums have in
//            common is added once: @{ adders.len() }@ adder@{ adders_s }@.
// Format:    x @{ x_format }@, W @{ w_format }@@{ shift_note }@, sums @{ sum_width }@ bits, all exact.
// Latency:   @{ levels }@ clock@{ levels_s }@, a vector a clock.
// Overflow:  impossible: an adder is as wide as its greatest sum.
// Reset:     none.
// Model:     hwgen: sim/src/model/adders.rs
// @{ provenance }@
`default_nettype none

module @{ module }@ (
  input  wire clk_i,
  input  wire @{ vector_range }@ vector_i,
  output wire @{ sums_range }@ sums_o
);
@% for x in inputs %@  wire @{ word_range }@ @{ x.name }@ = vector_i[@{ x.low }@ +: @{ word_width }@];
@% endfor %@
@% for a in adders %@  wire @{ a.range }@ @{ a.name }@;  // @{ a.note }@
@% endfor %@@% if waits.len() > 0 %@
  // Words that a later level reads.
@% for w in waits %@  reg @{ w.range }@ @{ w.name }@ = @{ w.width }@'d0;
@% endfor %@  always @(posedge clk_i) begin
@% for w in waits %@    @{ w.name }@ <= @{ w.source }@;
@% endfor %@  end
@% endif %@@% for a in adders %@
  @{ prefix }@__hwg_add #(
    .A_WIDTH (@{ a.a.width }@),
    .A_SHIFT (@{ a.a.shift }@),
    .B_WIDTH (@{ a.b.width }@),
    .B_SHIFT (@{ a.b.shift }@),
    .SUBTRACT(@{ a.subtract }@),
    .WIDTH   (@{ a.width }@)
  ) u_add@{ a.number }@ (
    .clk_i(clk_i),
    .a_i  (@{ a.a.name }@),
    .b_i  (@{ a.b.name }@),
    .sum_o(@{ a.name }@)
  );
@% endfor %@
  // Neuron by neuron, sign-extended and moved up.
@% for sum in sums %@  assign sums_o[@{ sum.low }@ +: @{ sum_width }@] = @{ sum.value }@;
@% endfor %@endmodule

`default_nettype wire
