// SPDX-License-Identifier: MIT OR Apache-2.0
// line__hwg_requant: bias, shift, rounding and saturation: from sums to words.
//
// Function:  word = saturate(((sum << PRODUCT_SHIFT) + bias) >>> (SHIFT + extra)) for each lane.
//            The bias contains half a step of the word, so the shift rounds to nearest, ties up.
//            SATURATION 0: to the word's range; 1: to [0, max], a ReLU; 2: to [-max, max], for the
//            argument of an odd function.
// Format:    the entry of a lane is {extra, bias}; extra is a neuron's own shift.
// Latency:   4 clocks, 5 with EXTRA_WIDTH > 0; a beat a clock. entry_i follows address_o by 1 clock.
// Overflow:  BIASED_WIDTH bits hold every biased sum by proof. A word that is clipped raises flag_o;
//            clipping to 0 by a ReLU and clipping the argument of an odd function are no overflow.
// Reset:     nothing under way stays valid; the next beat is the first of a frame.
// Model:     hwgen: sim/src/model/finish.rs, Requant
`default_nettype none

module line__hwg_requant #(
  parameter integer LANES         = 1,
  parameter integer SUM_WIDTH     = 16,
  parameter integer BIASED_WIDTH  = 18,  // SUM_WIDTH + PRODUCT_SHIFT and SHIFT + WIDTH + 1, or more
  parameter integer PRODUCT_SHIFT = 0,
  parameter integer EXTRA_WIDTH   = 0,   // bits of a neuron's own shift, 0 for none
  parameter integer SHIFT         = 4,
  parameter integer WIDTH         = 8,   // bits of a word, 3 or more
  parameter integer SATURATION    = 0,
  parameter integer ARRAY_BEATS   = 1,   // beats of a frame that come
  parameter integer OUTPUT_BEATS  = 1,   // beats of a frame that leave; the rest is padding
  parameter integer ADDRESS_WIDTH = 1,   // max(1, clog2(ARRAY_BEATS))
  parameter integer COPIES        = 1    // of the address: 1, or one for each lane's entries
) (
  input  wire                                        clk_i,
  input  wire                                        rst_i,
  input  wire                                        valid_i,
  input  wire                                        flag_i,
  input  wire [LANES*SUM_WIDTH-1:0]                  sums_i,
  output wire [COPIES*ADDRESS_WIDTH-1:0]             address_o,
  input  wire [LANES*(EXTRA_WIDTH+BIASED_WIDTH)-1:0] entry_i,
  output wire                                        next_o,   // valid_o after this edge
  output wire                                        valid_o,
  output wire                                        flag_o,
  output wire [LANES*WIDTH-1:0]                      words_o
);
  localparam integer ENTRY_WIDTH = EXTRA_WIDTH + BIASED_WIDTH;
  localparam integer VALUE_WIDTH = BIASED_WIDTH - SHIFT;
  localparam integer LAST        = ARRAY_BEATS - 1;
  localparam integer STAGES      = EXTRA_WIDTH > 0 ? 5 : 4;

  reg [ADDRESS_WIDTH-1:0]   beat_q = {ADDRESS_WIDTH{1'b0}};
  reg [LANES*SUM_WIDTH-1:0] sum_q  = {LANES*SUM_WIDTH{1'b0}};
  reg [STAGES-1:0]          valid_q = {STAGES{1'b0}};
  reg [STAGES-1:0]          flag_q  = {STAGES{1'b0}};

  wire last = beat_q == LAST[ADDRESS_WIDTH-1:0];
  wire keep;
  generate
    if (OUTPUT_BEATS < ARRAY_BEATS) begin : g_padding
      assign keep = beat_q < OUTPUT_BEATS[ADDRESS_WIDTH-1:0];
    end else begin : g_no_padding
      assign keep = 1'b1;
    end
  endgenerate

  wire [LANES-1:0] clipped;  // of the words that the last stage takes

  always @(posedge clk_i) begin
    if (rst_i) begin
      beat_q  <= {ADDRESS_WIDTH{1'b0}};
      valid_q <= {STAGES{1'b0}};
    end else begin
      if (valid_i) beat_q <= last ? {ADDRESS_WIDTH{1'b0}} : beat_q + 1'b1;
      valid_q <= {valid_q[STAGES-2:0], valid_i & keep};
    end
  end

  always @(posedge clk_i) begin
    sum_q  <= sums_i;
    flag_q <= {flag_q[STAGES-2] | (|clipped), flag_q[STAGES-3:0], flag_i};
  end

  genvar j;
  generate
    for (j = 0; j < LANES; j = j + 1) begin : g_lane
      reg  [BIASED_WIDTH-1:0] biased_q   = {BIASED_WIDTH{1'b0}};
      reg  [WIDTH-1:0]        value_q    = {WIDTH{1'b0}};  // without the bits above the word
      reg                     negative_q = 1'b0;
      reg                     beyond_q   = 1'b0;           // the word does not hold the value
      reg  [WIDTH-1:0]        word_q     = {WIDTH{1'b0}};
      wire [BIASED_WIDTH-1:0] sum;      // sign-extended and moved up
      wire [BIASED_WIDTH-1:0] shifted;  // the neuron's own shift undone

      if (PRODUCT_SHIFT > 0) begin : g_up
        assign sum = {{(BIASED_WIDTH-PRODUCT_SHIFT-SUM_WIDTH+1){sum_q[j*SUM_WIDTH+SUM_WIDTH-1]}},
                      sum_q[j*SUM_WIDTH +: SUM_WIDTH-1], {PRODUCT_SHIFT{1'b0}}};
      end else begin : g_level
        assign sum = {{(BIASED_WIDTH-SUM_WIDTH+1){sum_q[j*SUM_WIDTH+SUM_WIDTH-1]}},
                      sum_q[j*SUM_WIDTH +: SUM_WIDTH-1]};
      end
      always @(posedge clk_i) biased_q <= sum + entry_i[j*ENTRY_WIDTH +: BIASED_WIDTH];

      if (EXTRA_WIDTH > 0) begin : g_extra
        reg        [EXTRA_WIDTH-1:0]  extra_q   = {EXTRA_WIDTH{1'b0}};
        reg signed [BIASED_WIDTH-1:0] shifted_q = {BIASED_WIDTH{1'b0}};
        always @(posedge clk_i) begin
          extra_q   <= entry_i[j*ENTRY_WIDTH+BIASED_WIDTH +: EXTRA_WIDTH];
          shifted_q <= $signed(biased_q) >>> extra_q;
        end
        assign shifted = shifted_q;
      end else begin : g_no_extra
        assign shifted = biased_q;
      end

      // verilator lint_off UNUSED
      // The fraction bits below the word are dropped; their half was added with the bias.
      wire [BIASED_WIDTH-1:0] all_bits = shifted;
      // verilator lint_on UNUSED
      wire [VALUE_WIDTH-1:0] value    = all_bits[BIASED_WIDTH-1:SHIFT];
      wire                   negative = value[VALUE_WIDTH-1];
      wire beyond = value[VALUE_WIDTH-1:WIDTH-1] != {(VALUE_WIDTH-WIDTH+1){negative}};
      always @(posedge clk_i) begin
        value_q    <= value[WIDTH-1:0];
        negative_q <= negative;
      end

      if (SATURATION == 0) begin : g_linear
        assign clipped[j] = beyond_q;
        always @(posedge clk_i) begin
          beyond_q <= beyond;
          word_q   <= beyond_q ? {negative_q, {(WIDTH-1){~negative_q}}} : value_q;
        end
      end else if (SATURATION == 1) begin : g_relu
        assign clipped[j] = beyond_q & ~negative_q;
        always @(posedge clk_i) begin
          beyond_q <= beyond;
          word_q   <= negative_q ? {WIDTH{1'b0}} :
                      beyond_q   ? {1'b0, {(WIDTH-1){1'b1}}} : value_q;
        end
      end else begin : g_odd
        wire lowest = negative & (value[WIDTH-2:0] == {(WIDTH-1){1'b0}});
        assign clipped[j] = 1'b0;
        always @(posedge clk_i) begin
          beyond_q <= beyond | lowest;
          word_q   <= beyond_q ? {negative_q, {(WIDTH-2){~negative_q}}, 1'b1} : value_q;
        end
      end

      assign words_o[j*WIDTH +: WIDTH] = word_q;
    end
  endgenerate

  // Each copy counts by itself, near to the entries that it reads.
  generate
    for (j = 0; j < COPIES; j = j + 1) begin : g_copy
      if (COPIES == 1) begin : g_shared
        assign address_o = beat_q;
      end else begin : g_own
        (* keep, dont_merge, syn_preserve = 1 *) reg [ADDRESS_WIDTH-1:0] address_q = {ADDRESS_WIDTH{1'b0}};
        wire end_of_frame = address_q == LAST[ADDRESS_WIDTH-1:0];
        (* keep *) always @(posedge clk_i) begin
          if (rst_i)        address_q <= {ADDRESS_WIDTH{1'b0}};
          else if (valid_i) address_q <= end_of_frame ? {ADDRESS_WIDTH{1'b0}} : address_q + 1'b1;
        end
        assign address_o[j*ADDRESS_WIDTH +: ADDRESS_WIDTH] = address_q;
      end
    end
  endgenerate

  assign next_o    = valid_q[STAGES-2];
  assign valid_o   = valid_q[STAGES-1];
  assign flag_o    = flag_q[STAGES-1];
endmodule

`default_nettype wire
