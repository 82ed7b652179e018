// SPDX-License-Identifier: MIT OR Apache-2.0
// @{ module }@: layer @{ layer }@, @{ inputs }@ inputs, @{ outputs }@ @{ activation }@ neurons.
//
// Function:  y = @{ activation }@(W x + b): @{ array_note }@;
@% for line in flow %@//            @{ line }@
@% endfor %@// Format:    x @{ x_format }@, W @{ w_format }@, y @{ y_format }@ (@{ y_width }@ bits).
// Latency:   @{ sum_latency }@ clock@% if sum_latency != 1 %@s@% endif %@ from @% if adders %@the vector to its sums@% else %@an operand to its sum@% endif %@, @{ drain_note }@@{ finish_latency }@ from a sum to its word.
// Overflow:  sums can't; @{ overflow }@
// Reset:     control bits only.
// Model:     hwgen: sim/src/model/layer.rs
// @{ provenance }@
`default_nettype none

module @{ module }@ (
  input  wire clk_i,
  input  wire rst_i,
@% if whole %@  input  wire @{ starts_range }@start_i,   // the vector is whole
  input  wire flag_i,    // a word before was clipped
  input  wire @{ vector_range }@ vector_i,
@% else %@  input  wire valid_i,
  input  wire flag_i,    // a word before was clipped
  input  wire @{ vector_range }@ words_i,
@% endif %@  output wire next_o,    // valid_o after this edge
  output wire valid_o,
  output wire flag_o,
  output wire @{ words_range }@ words_o
);
@% if adders %@  wire sums_valid;
  wire sums_flag;
  @{ prefix }@__hwg_delay #(
    .WIDTH(2),
    .DEPTH(@{ control_depth }@)
  ) u_control (
    .clk_i (clk_i),
    .rst_i (rst_i),
    .data_i({start_i, flag_i}),
    .data_o({sums_valid, sums_flag})
  );

  wire @{ sums_range }@ sums;
  @{ module }@_adders u_adders (
    .clk_i   (clk_i),
    .vector_i(vector_i),
    .sums_o  (sums)
  );
@% else %@  // Operands, @{ simd }@ a clock, and the address of their weights.
@% if replay || hold %@  wire valid;
@% endif %@@% if accumulates %@  wire first;
  wire last;
@% else %@  wire unused_first;  // a sum takes one clock
  wire unused_last;
@% endif %@@% if replay || hold %@  wire flag;
  wire @{ operands_range }@ operands;
@% endif %@  wire @{ address_range }@ address;
@% if replay %@  @{ prefix }@__hwg_replay #(
    .WORDS        (@{ inputs }@),
    .SIMD         (@{ simd }@),
    .WIDTH        (@{ x_width }@),
    .SYNAPSE_FOLDS(@{ synapse_folds }@),
    .NEURON_FOLDS (@{ neuron_folds }@),
    .ADDRESS_WIDTH(@{ address_width }@),
    .STARTS       (@{ starts }@)
  ) u_replay (
    .clk_i    (clk_i),
    .rst_i    (rst_i),
    .start_i  (start_i),
    .flag_i   (flag_i),
    .vector_i (vector_i),
    .valid_o  (valid),
    .first_o  (@% if accumulates %@first@% else %@unused_first@% endif %@),
    .last_o   (@% if accumulates %@last@% else %@unused_last@% endif %@),
    .flag_o   (flag),
    .words_o  (operands),
    .address_o(address)
  );
@% else if hold %@  @{ prefix }@__hwg_hold #(
    .BEATS        (@{ synapse_folds }@),
    .FOLDS        (@{ neuron_folds }@),
    .WIDTH        (@{ operands_width }@),
    .ADDRESS_WIDTH(@{ address_width }@)
  ) u_hold (
    .clk_i    (clk_i),
    .rst_i    (rst_i),
    .valid_i  (valid_i),
    .flag_i   (flag_i),
    .words_i  (words_i),
    .valid_o  (valid),
    .first_o  (@% if accumulates %@first@% else %@unused_first@% endif %@),
    .last_o   (@% if accumulates %@last@% else %@unused_last@% endif %@),
    .flag_o   (flag),
    .words_o  (operands),
    .address_o(address)
  );
@% else %@  @{ prefix }@__hwg_beats #(
    .BEATS        (@{ synapse_folds }@),
    .ADDRESS_WIDTH(@{ address_width }@)
  ) u_beats (
    .clk_i    (clk_i),
    .rst_i    (rst_i),
    .valid_i  (valid_i),
    .first_o  (@% if accumulates %@first@% else %@unused_first@% endif %@),
    .last_o   (@% if accumulates %@last@% else %@unused_last@% endif %@),
    .address_o(address)
  );
@% endif %@
  // The operands keep pace with the addresses, of which each weight ROM takes a copy; `keep`, for
  // another layer may read the same and stand elsewhere.
  (* keep, dont_merge, syn_preserve = 1 *) reg @{ operands_range }@ operands_q = {@{ operands_width }@{1'b0}};
  (* keep *) always @(posedge clk_i) operands_q <= @{ operands }@;

  // Control bits keep pace with copies, ROM, multipliers and adder tree@% if accumulates %@, less the clock of
  // the elements' own copies@% endif %@.
@% if accumulates %@  wire tree_valid;
  wire tree_first;
  wire tree_last;
  wire tree_flag;
  @{ prefix }@__hwg_delay #(
    .WIDTH(4),
    .DEPTH(@{ control_depth }@)
  ) u_control (
    .clk_i (clk_i),
    .rst_i (rst_i),
    .data_i({@{ valid }@, first, last, @{ flag }@}),
    .data_o({tree_valid, tree_first, tree_last, tree_flag})
  );

  wire @{ loads_range }@sums_valid;
  wire sums_flag;
  @{ prefix }@__hwg_group @% if loads > 1 %@#(
    .COPIES(@{ loads }@)
  ) @% endif %@u_group (
    .clk_i  (clk_i),
    .rst_i  (rst_i),
    .valid_i(tree_valid),
    .first_i(tree_first),
    .last_i (tree_last),
    .flag_i (tree_flag),
    .done_o (sums_valid),
    .flag_o (sums_flag)
  );
@% else %@  wire sums_valid;
  wire sums_flag;
  @{ prefix }@__hwg_delay #(
    .WIDTH(2),
    .DEPTH(@{ control_depth }@)
  ) u_control (
    .clk_i (clk_i),
    .rst_i (rst_i),
    .data_i({@{ valid }@, @{ flag }@}),
    .data_o({sums_valid, sums_flag})
  );
@% endif %@
  // The array: neuron @% if neuron_folds > 1 %@@{ pe }@ * g + @% endif %@p in processing element p@% if neuron_folds > 1 %@, group g of @{ neuron_folds }@@% endif %@.
  wire @{ sums_range }@ sums;
@% for p in 0..pe %@
  wire @{ weights_range }@ weights@{ p }@;
  @{ module }@_w@{ p }@ u_w@{ p }@ (
    .clk_i    (clk_i),
    .address_i(address),
    .data_o   (weights@{ p }@)
  );
  @{ module }@_pe u_pe@{ p }@ (
    .clk_i     (clk_i),
@% if accumulates %@    .enable_i  (tree_valid),
    .first_i   (tree_first),
@% endif %@    .operands_i(operands_q),
    .weights_i (weights@{ p }@),
    .sum_o     (sums[@{ p * sum_width }@ +: @{ sum_width }@])
  );
@% endfor %@@% endif %@
@% if drains %@  // @{ lanes }@ of the @{ pe }@ sums leave a clock.
  wire lanes_valid;
  wire lanes_flag;
  wire @{ lane_sums_range }@ lane_sums;
  @{ prefix }@__hwg_drain #(
    .WORDS(@{ pe }@),
    .LANES(@{ lanes }@),
    .WIDTH(@{ sum_width }@)@% if loads > 1 %@,
    .LOADS(@{ loads }@)@% endif %@
  ) u_drain (
    .clk_i  (clk_i),
    .rst_i  (rst_i),
    .load_i (sums_valid),
    .flag_i (sums_flag),
    .words_i(sums),
    .valid_o(lanes_valid),
    .flag_o (lanes_flag),
    .words_o(lane_sums)
  );

@% endif %@  // Bias, shift, rounding, saturation: sums to @{ pre_format }@.
  wire @{ bias_address_range }@ beat;
  wire @{ entries_range }@ entries;
  @{ module }@_bias u_bias (
    .clk_i    (clk_i),
    .address_i(beat),
    .data_o   (entries)
  );
@% if has_table %@  wire unused_z_next;
  wire z_valid;
  wire z_flag;
  wire @{ pre_range }@ z;
@% endif %@  @{ prefix }@__hwg_requant #(
    .LANES        (@{ lanes }@),
    .SUM_WIDTH    (@{ sum_width }@),
    .BIASED_WIDTH (@{ biased_width }@),
    .PRODUCT_SHIFT(@{ product_shift }@),
    .EXTRA_WIDTH  (@{ extra_width }@),
    .SHIFT        (@{ base_shift }@),
    .WIDTH        (@{ pre_width }@),
    .SATURATION   (@{ saturation }@),
    .ARRAY_BEATS  (@{ array_beats }@),
    .OUTPUT_BEATS (@{ output_beats }@),
    .ADDRESS_WIDTH(@{ bias_address_width }@)@% if bias_copies > 1 %@,
    .COPIES       (@{ bias_copies }@)@% endif %@
  ) u_requant (
    .clk_i    (clk_i),
    .rst_i    (rst_i),
@% if drains %@    .valid_i  (lanes_valid),
    .flag_i   (lanes_flag),
    .sums_i   (lane_sums),
@% else %@    .valid_i  (sums_valid),
    .flag_i   (sums_flag),
    .sums_i   (sums),
@% endif %@    .address_o(beat),
    .entry_i  (entries),
@% if has_table %@    .next_o   (unused_z_next),
    .valid_o  (z_valid),
    .flag_o   (z_flag),
    .words_o  (z)
@% else %@    .next_o   (next_o),
    .valid_o  (valid_o),
    .flag_o   (flag_o),
    .words_o  (words_o)
@% endif %@  );
@% if has_table %@
  // Activation: one unit a lane, each with its own copy of the segments.
  wire next_flag;
  @{ prefix }@__hwg_delay #(
    .WIDTH(2),
    .DEPTH(@{ activation_latency - 1 }@)
  ) u_act_control (
    .clk_i (clk_i),
    .rst_i (rst_i),
    .data_i({z_valid, z_flag}),
    .data_o({next_o, next_flag})
  );
  reg valid_q = 1'b0;
  reg flag_q  = 1'b0;
  always @(posedge clk_i) begin
    valid_q <= next_o & ~rst_i;
    flag_q  <= next_flag & ~rst_i;
  end
  assign valid_o = valid_q;
  assign flag_o  = flag_q;
  genvar i;
  generate
    for (i = 0; i < @{ lanes }@; i = i + 1) begin : g_act
      wire @{ segment_range }@ segment;
      wire @{ line_range }@ line;
      wire [@{ distance_width - 1 }@:0] distance;
      wire [@{ product_width - 1 }@:0] product;
      @{ table_module }@ u_segments (
        .clk_i    (clk_i),
        .address_i(segment),
        .data_o   (line)
      );
      @{ prefix }@__hwg_pwl #(
        .MAGNITUDE_WIDTH(@{ magnitude_width }@),
        .SEGMENT_WIDTH  (@{ segment_width }@),
        .SLOPE_BITS     (@{ slope_bits }@),
        .FRACTION       (@{ table_fraction }@),
        .WIDTH          (@{ y_width }@),
        .SIGMOID        (@{ sigmoid }@)@% if table_latency > 1 %@,
        .TABLE          (@{ table_latency }@)@% endif %@
      ) u_pwl (
        .clk_i     (clk_i),
        .z_i       (z[i*@{ pre_width }@ +: @{ pre_width }@]),
        .segment_o (segment),
        .offset_i  (line[@{ slope_width }@ +: @{ table_fraction + 2 }@]),
        .distance_o(distance),
        .product_i (product),
        .y_o       (words_o[i*@{ y_width }@ +: @{ y_width }@])
      );
@% if in_logic %@      assign product[@{ product_width - 1 }@ -: 2] = 2'b0;
      @{ prefix }@__hwg_mul_logic #(
        .A_WIDTH(@{ slope_width }@),
        .B_WIDTH(@{ distance_width }@)
      ) u_mul (
        .clk_i(clk_i),
        .a_i  (line[@{ slope_width - 1 }@:0]),
        .b_i  (distance),
        .p_o  (product[@{ product_width - 3 }@:0])
      );
@% else %@      @{ prefix }@__hwg_mul #(
        .A_WIDTH(@{ distance_width + 1 }@),
        .B_WIDTH(@{ slope_width + 1 }@)
      ) u_mul (
        .clk_i(clk_i),
        .a_i  ({1'b0, distance}),
        .b_i  ({1'b0, line[@{ slope_width - 1 }@:0]}),
        .p_o  (product)
      );
@% endif %@    end
  endgenerate
@% endif %@endmodule

`default_nettype wire
