// SPDX-License-Identifier: MIT OR Apache-2.0
// hwg_gather: beats of LANES words to one vector.
//
// Function:  puts the beats of a frame in their places; start_o marks the clock in which the vector
//            is whole, every bit of it alike, for readers that take many words at once. flag_o is
//            the OR of the beats' flags.
// Latency:   the vector is whole 1 clock after its last beat, and until the next beat comes.
// Reset:     the next beat is the first of a frame.
// Model:     hwgen: sim/src/model/feed.rs, Gather
`default_nettype none

module hwg_gather #(
  parameter integer WORDS  = 4,  // words of a vector, 1 or more
  parameter integer LANES  = 1,  // words of a beat, 1 or more
  parameter integer WIDTH  = 8,  // bits of a word
  parameter integer STARTS = 1   // copies of start_o
) (
  input  wire                   clk_i,
  input  wire                   rst_i,
  input  wire                   next_i,   // valid_i after this edge
  input  wire                   valid_i,
  input  wire                   flag_i,
  input  wire [LANES*WIDTH-1:0] data_i,
  output wire [STARTS-1:0]      start_o,
  output wire                   flag_o,
  output wire [WORDS*WIDTH-1:0] vector_o
);
  localparam integer BEATS = (WORDS + LANES - 1) / LANES;
  localparam integer BEAT  = LANES * WIDTH;
  localparam integer SLOTS = BEATS * LANES;  // the last beat may carry padding

  // verilator lint_off UNUSED
  // The slots that hold the padding of the last beat are read by none.
  reg [SLOTS*WIDTH-1:0] slot_q  = {SLOTS*WIDTH{1'b0}};
  // verilator lint_on UNUSED
  reg                   flag_q  = 1'b0;

  // A one for each beat of the frame that came, from below; the last one's place is the next frame's
  // beginning. So the register itself tells, without a gate, whether the next beat is the last.
  wire [BEATS-1:0] taken;
  wire [BEATS-1:0] more = ~(~taken << 1);  // one beat more
  wire [BEATS-1:0] here = more & ~taken;   // where the next beat goes
  wire             last_d;                 // the beat after this edge, if one comes, is the last

  generate
    if (BEATS > 1) begin : g_taken
      reg  [BEATS-2:0] taken_q = {(BEATS-1){1'b0}};
      wire             last    = more[BEATS-1];
      always @(posedge clk_i) begin
        if (rst_i)        taken_q <= {(BEATS-1){1'b0}};
        else if (valid_i) taken_q <= last ? {(BEATS-1){1'b0}} : more[BEATS-2:0];
      end
      assign taken  = {1'b0, taken_q};
      assign last_d = valid_i ? ~last & more[BEATS-2] : last;
    end else begin : g_whole
      assign taken  = 1'b0;
      assign last_d = 1'b1;
    end
  endgenerate

  // What the copies take is known a clock ahead and comes from a register, with its load of copies
  // alone.
  reg complete_q = 1'b0;  // the last beat is here
  always @(posedge clk_i) complete_q <= next_i & last_d & ~rst_i;

  // Copies that drive a part of the readers' words each: `keep` keeps them.
  genvar g;
  generate
    for (g = 0; g < STARTS; g = g + 1) begin : g_copy
      (* keep *) reg start_q = 1'b0;
      (* keep *) always @(posedge clk_i) start_q <= complete_q & ~rst_i;
      assign start_o[g] = start_q;
    end
  endgenerate

  integer i;
  always @(posedge clk_i) begin
    if (valid_i) flag_q <= (flag_q & ~here[0]) | flag_i;
    for (i = 0; i < BEATS; i = i + 1)
      if (valid_i & here[i]) slot_q[i*BEAT +: BEAT] <= data_i;
  end

  assign flag_o   = flag_q;
  assign vector_o = slot_q[0 +: WORDS*WIDTH];
endmodule

`default_nettype wire
