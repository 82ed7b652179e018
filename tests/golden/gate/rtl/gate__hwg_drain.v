// SPDX-License-Identifier: MIT OR Apache-2.0
// gate__hwg_drain: a group's sums, LANES at a time.
//
// Function:  takes WORDS sums at load_i and puts them out lowest first.
// Latency:   the first sums follow load_i by 1 clock; WORDS / LANES clocks a group.
// Overflow:  the stage's schedule keeps load_i away while sums are left.
// Reset:     stops.
// Model:     hwgen: sim/src/model/array.rs, Drain
`default_nettype none

module gate__hwg_drain #(
  parameter integer WORDS = 4,  // sums of a group, a multiple of LANES
  parameter integer LANES = 1,  // sums a clock
  parameter integer WIDTH = 8,  // bits of a sum
  parameter integer LOADS = 1   // copies of load_i, each for its part of the sums
) (
  input  wire                   clk_i,
  input  wire                   rst_i,
  input  wire [LOADS-1:0]       load_i,
  input  wire                   flag_i,
  input  wire [WORDS*WIDTH-1:0] words_i,
  output wire                   valid_o,
  output wire                   flag_o,
  output wire [LANES*WIDTH-1:0] words_o
);
  localparam integer BEATS      = WORDS / LANES;
  localparam integer LEFT_WIDTH = $clog2(BEATS + 1);

  reg [WORDS*WIDTH-1:0] word_q = {WORDS*WIDTH{1'b0}};
  reg [LEFT_WIDTH-1:0]  left_q = {LEFT_WIDTH{1'b0}};  // beats still to put out
  reg                   flag_q = 1'b0;

  wire valid = left_q != {LEFT_WIDTH{1'b0}};

  always @(posedge clk_i) begin
    if (rst_i)          left_q <= {LEFT_WIDTH{1'b0}};
    else if (load_i[0]) left_q <= BEATS[LEFT_WIDTH-1:0];
    else if (valid)     left_q <= left_q - 1'b1;
  end

  integer i;
  always @(posedge clk_i) begin
    if (load_i[0]) flag_q <= flag_i;
    for (i = 0; i < WORDS; i = i + 1) begin
      if (load_i[i*LOADS/WORDS])  word_q[i*WIDTH +: WIDTH] <= words_i[i*WIDTH +: WIDTH];
      else if (i < WORDS - LANES) word_q[i*WIDTH +: WIDTH] <= word_q[(i+LANES)%WORDS*WIDTH +: WIDTH];
    end
  end

  assign valid_o = valid;
  assign flag_o  = flag_q;
  assign words_o = word_q[0 +: LANES*WIDTH];
endmodule

`default_nettype wire
