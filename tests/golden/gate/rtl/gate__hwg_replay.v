// SPDX-License-Identifier: MIT OR Apache-2.0
// gate__hwg_replay: holds one vector and offers it to an array, SIMD words a clock.
//
// Function:  after start_i, NEURON_FOLDS times over, the words SIMD at a time; address_o counts the
//            clocks of a frame and is the address of the weights. Words beyond the last are zero.
//            Every bit of start_i is the same; each one loads words that come to the same few multipliers.
// Latency:   the first words are offered 1 clock after start_i; a vector every
//            NEURON_FOLDS * SYNAPSE_FOLDS clocks, without a gap.
// Overflow:  the stage's schedule keeps start_i away while a vector is in use.
// Reset:     stops.
// Model:     hwgen: sim/src/model/feed.rs, Replay
`default_nettype none

module gate__hwg_replay #(
  parameter integer WORDS         = 4,  // words of a vector, 1 or more
  parameter integer SIMD          = 2,  // words a clock, 1 to WORDS
  parameter integer WIDTH         = 8,  // bits of a word
  parameter integer SYNAPSE_FOLDS = 2,  // ceil(WORDS / SIMD)
  parameter integer NEURON_FOLDS  = 1,  // times that the vector is offered
  parameter integer ADDRESS_WIDTH = 1,  // max(1, clog2(NEURON_FOLDS * SYNAPSE_FOLDS))
  parameter integer STARTS        = 1   // copies of start_i
) (
  input  wire                     clk_i,
  input  wire                     rst_i,
  input  wire [STARTS-1:0]        start_i,
  input  wire                     flag_i,
  input  wire [WORDS*WIDTH-1:0]   vector_i,
  output wire                     valid_o,
  output wire                     first_o,    // first words of the vector
  output wire                     last_o,     // last words of the vector
  output wire                     flag_o,
  output wire [SIMD*WIDTH-1:0]    words_o,
  output wire [ADDRESS_WIDTH-1:0] address_o
);
  localparam integer SLOTS      = SYNAPSE_FOLDS * SIMD;
  localparam integer LAST_STEP  = SYNAPSE_FOLDS - 1;
  localparam integer LAST       = NEURON_FOLDS * SYNAPSE_FOLDS - 1;
  localparam integer STEP_WIDTH = $clog2(SYNAPSE_FOLDS + 1);

  reg [SLOTS*WIDTH-1:0]   slot_q    = {SLOTS*WIDTH{1'b0}};
  reg [ADDRESS_WIDTH-1:0] address_q = {ADDRESS_WIDTH{1'b0}};
  reg [STEP_WIDTH-1:0]    step_q    = {STEP_WIDTH{1'b0}};
  reg                     busy_q    = 1'b0;
  reg                     flag_q    = 1'b0;

  wire last_step = step_q == LAST_STEP[STEP_WIDTH-1:0];
  wire last      = address_q == LAST[ADDRESS_WIDTH-1:0];

  always @(posedge clk_i) begin
    if (rst_i) begin
      busy_q    <= 1'b0;
      address_q <= {ADDRESS_WIDTH{1'b0}};
      step_q    <= {STEP_WIDTH{1'b0}};
    end else if (start_i[0]) begin
      busy_q    <= 1'b1;
      address_q <= {ADDRESS_WIDTH{1'b0}};
      step_q    <= {STEP_WIDTH{1'b0}};
    end else if (busy_q) begin
      busy_q    <= ~last;
      address_q <= last ? {ADDRESS_WIDTH{1'b0}} : address_q + 1'b1;
      step_q    <= last_step ? {STEP_WIDTH{1'b0}} : step_q + 1'b1;
    end
  end

  // The vector turns like a ring: after SYNAPSE_FOLDS clocks it stands as it was loaded. It turns on
  // when nobody reads it, so that nothing but the next start reaches so many registers.
  integer i;
  always @(posedge clk_i) begin
    if (start_i[0]) flag_q <= flag_i;
    for (i = 0; i < SLOTS; i = i + 1) begin
      if (start_i[((i % SIMD) * SYNAPSE_FOLDS + i / SIMD) * STARTS / SLOTS]) begin
        if (i < WORDS) slot_q[i*WIDTH +: WIDTH] <= vector_i[(i % WORDS)*WIDTH +: WIDTH];
        else           slot_q[i*WIDTH +: WIDTH] <= {WIDTH{1'b0}};
      end else begin
        slot_q[i*WIDTH +: WIDTH] <= slot_q[((i + SIMD) % SLOTS)*WIDTH +: WIDTH];
      end
    end
  end

  assign valid_o   = busy_q;
  assign first_o   = step_q == {STEP_WIDTH{1'b0}};
  assign last_o    = last_step;
  assign flag_o    = flag_q;
  assign words_o   = slot_q[0 +: SIMD*WIDTH];
  assign address_o = address_q;
endmodule

`default_nettype wire
