// SPDX-License-Identifier: MIT OR Apache-2.0
// hwg_gather: beats of LANES words to one vector.
//
// Function:  shifts the beats of a frame in; start_o marks the clock in which the vector is whole.
//            flag_o is the OR of the beats' flags.
// Latency:   the vector is whole 1 clock after its last beat, and until the next beat comes.
// Reset:     the next beat is the first of a frame.
// Model:     hwgen: sim/src/model/feed.rs, Gather
`default_nettype none

module hwg_gather #(
  parameter integer WORDS = 4,  // words of a vector, 1 or more
  parameter integer LANES = 1,  // words of a beat, 1 or more
  parameter integer WIDTH = 8   // bits of a word
) (
  input  wire                   clk_i,
  input  wire                   rst_i,
  input  wire                   valid_i,
  input  wire                   flag_i,
  input  wire [LANES*WIDTH-1:0] data_i,
  output wire                   start_o,
  output wire                   flag_o,
  output wire [WORDS*WIDTH-1:0] vector_o
);
  localparam integer BEATS       = (WORDS + LANES - 1) / LANES;
  localparam integer LAST        = BEATS - 1;
  localparam integer SLOTS       = BEATS * LANES;  // the last beat may carry padding
  localparam integer COUNT_WIDTH = $clog2(BEATS + 1);

  // verilator lint_off UNUSED
  // The slots that hold the padding of the last beat are read by none.
  reg [SLOTS*WIDTH-1:0] slot_q  = {SLOTS*WIDTH{1'b0}};
  // verilator lint_on UNUSED
  reg [COUNT_WIDTH-1:0] count_q = {COUNT_WIDTH{1'b0}};
  reg                   start_q = 1'b0;
  reg                   flag_q  = 1'b0;

  wire first = count_q == {COUNT_WIDTH{1'b0}};
  wire last  = count_q == LAST[COUNT_WIDTH-1:0];

  always @(posedge clk_i) begin
    if (rst_i) begin
      count_q <= {COUNT_WIDTH{1'b0}};
      start_q <= 1'b0;
    end else begin
      start_q <= valid_i & last;
      if (valid_i) count_q <= last ? {COUNT_WIDTH{1'b0}} : count_q + 1'b1;
    end
  end

  integer i;
  always @(posedge clk_i) begin
    if (valid_i) begin
      flag_q <= (flag_q & ~first) | flag_i;
      slot_q[(SLOTS-LANES)*WIDTH +: LANES*WIDTH] <= data_i;
      for (i = 0; i < SLOTS - LANES; i = i + 1)
        slot_q[i*WIDTH +: WIDTH] <= slot_q[(i+LANES)*WIDTH +: WIDTH];
    end
  end

  assign start_o  = start_q;
  assign flag_o   = flag_q;
  assign vector_o = slot_q[0 +: WORDS*WIDTH];
endmodule

`default_nettype wire
