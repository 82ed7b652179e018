// SPDX-License-Identifier: MIT OR Apache-2.0
// gate__hwg_pwl: piecewise-linear tanh or sigmoid of one word.
//
// Function:  m = |z|; segment and distance are its high and low bits;
//            t = ((offset << (SLOPE_BITS - 2)) + slope * distance) >> SLOPE_BITS, negated if z < 0.
//            The result is t for tanh and 1 + t for sigmoid, whose argument and result are read with
//            the binary point one place further left: sigmoid(x) = (1 + tanh(x / 2)) / 2.
// Format:    z_i is signed, in [-max, max]; t has FRACTION fraction bits. The offset has 2 guard bits
//            and contains half an output step, so that the shift rounds to nearest; that of segment 0
//            is below an output step, so that zero leads to zero.
// Latency:   6 + TABLE clocks, one word a clock: stage 1 magnitude, 2 segment ROM, 3 to 5 multiplier,
//            6 sum, 7 result, those behind the ROM a clock later if it takes two. offset_i and the slope
//            follow segment_o by TABLE clocks, product_i = slope * distance_o both by 3.
// Overflow:  impossible: the table's values stay below 2^FRACTION (checked for every code).
// Reset:     none.
// Model:     hwgen: sim/src/model/finish.rs, Pwl
`default_nettype none

module gate__hwg_pwl #(
  parameter integer MAGNITUDE_WIDTH = 14,  // bits of |z|
  parameter integer SEGMENT_WIDTH   = 6,   // bits of the segment number, below MAGNITUDE_WIDTH
  parameter integer SLOPE_BITS      = 8,   // fraction bits of a slope, 2 or more
  parameter integer FRACTION        = 12,  // fraction bits of t
  parameter integer WIDTH           = 13,  // bits of the result, FRACTION + 1 (sigmoid + 2) or more
  parameter integer TABLE           = 1,   // clocks of the segment ROM, 1 or more
  parameter integer SIGMOID         = 0    // 1: sigmoid, 0: tanh
) (
  input  wire                                                clk_i,
  input  wire [MAGNITUDE_WIDTH:0]                            z_i,
  output wire [SEGMENT_WIDTH-1:0]                            segment_o,
  input  wire [FRACTION+1:0]                                 offset_i,
  output wire [MAGNITUDE_WIDTH-SEGMENT_WIDTH-1:0]            distance_o,
  input  wire [MAGNITUDE_WIDTH-SEGMENT_WIDTH+SLOPE_BITS+2:0] product_i,
  output wire [WIDTH-1:0]                                    y_o
);
  localparam integer DISTANCE_WIDTH = MAGNITUDE_WIDTH - SEGMENT_WIDTH;
  localparam integer SLOPE_WIDTH    = SLOPE_BITS + 1;
  localparam integer OFFSET_WIDTH   = FRACTION + 2;
  localparam integer PRODUCT_WIDTH  = DISTANCE_WIDTH + SLOPE_WIDTH + 2;
  localparam integer SUM_WIDTH      = FRACTION + SLOPE_BITS;

  reg [MAGNITUDE_WIDTH-1:0]      magnitude_q = {MAGNITUDE_WIDTH{1'b0}};       // stage 1
  reg [TABLE*DISTANCE_WIDTH-1:0] distance_q  = {TABLE*DISTANCE_WIDTH{1'b0}};  // stage 2, beside the ROM
  reg [3*OFFSET_WIDTH-1:0]       offset_q    = {3*OFFSET_WIDTH{1'b0}};        // stages 3 to 5, as the multiplier
  reg [TABLE+4:0]                negative_q  = {(TABLE+5){1'b0}};             // stages 1 to 6: put back last
  // verilator lint_off UNUSED
  // The fraction bits below the result are dropped; their half was added with the offset.
  reg [SUM_WIDTH-1:0]            sum_q       = {SUM_WIDTH{1'b0}};             // stage 6
  // verilator lint_on UNUSED
  reg [WIDTH-1:0]                y_q         = {WIDTH{1'b0}};                 // stage 7

  wire                       negative = z_i[MAGNITUDE_WIDTH];
  wire [MAGNITUDE_WIDTH-1:0] low_bits = z_i[MAGNITUDE_WIDTH-1:0];

  // verilator lint_off UNUSED
  // The product is below 2^SUM_WIDTH, as the sum is: bits above are zero.
  wire [PRODUCT_WIDTH+SUM_WIDTH-1:0] rise = {{SUM_WIDTH{1'b0}}, product_i};
  // verilator lint_on UNUSED
  wire [OFFSET_WIDTH-1:0] old_offset = offset_q[2*OFFSET_WIDTH +: OFFSET_WIDTH];
  wire [SUM_WIDTH-1:0]    base;
  generate
    if (SLOPE_BITS > 2) begin : g_shift
      assign base = {old_offset, {(SLOPE_BITS-2){1'b0}}};
    end else begin : g_no_shift
      assign base = old_offset;
    end
  endgenerate

  wire [WIDTH-1:0] t   = {{(WIDTH-FRACTION){1'b0}}, sum_q[SUM_WIDTH-1:SLOPE_BITS]};
  wire [WIDTH-1:0] one = SIGMOID != 0 ? {{(WIDTH-1){1'b0}}, 1'b1} << FRACTION : {WIDTH{1'b0}};

  // verilator lint_off UNUSED
  // The oldest leaves.
  wire [(TABLE+1)*DISTANCE_WIDTH-1:0] distances = {distance_q, magnitude_q[DISTANCE_WIDTH-1:0]};
  // verilator lint_on UNUSED

  always @(posedge clk_i) begin
    magnitude_q <= negative ? -low_bits : low_bits;
    distance_q  <= distances[TABLE*DISTANCE_WIDTH-1:0];
    offset_q    <= {offset_q[0 +: 2*OFFSET_WIDTH], offset_i};
    negative_q  <= {negative_q[TABLE+3:0], negative};
    sum_q       <= base + rise[SUM_WIDTH-1:0];
    y_q         <= negative_q[TABLE+4] ? one - t : one + t;
  end

  assign distance_o = distance_q[(TABLE-1)*DISTANCE_WIDTH +: DISTANCE_WIDTH];
  assign segment_o  = magnitude_q[MAGNITUDE_WIDTH-1:DISTANCE_WIDTH];
  assign y_o        = y_q;
endmodule

`default_nettype wire
