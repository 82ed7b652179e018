// SPDX-License-Identifier: MIT OR Apache-2.0
// pair__hwg_gather: beats of LANES words to one vector.
//
// Function:  puts the beats of a frame in their places; start_o marks the clock in which the vector
//            is whole, every bit of it alike, for readers that take many words at once. flag_o is
//            the OR of the beats' flags.
// Latency:   the vector is whole 1 clock after its last beat, and until the next beat comes; a clock
//            later with HOP.
// Reset:     the next beat is the first of a frame.
// Model:     hwgen: sim/src/model/feed.rs, Gather
`default_nettype none

module pair__hwg_gather #(
  parameter integer WORDS  = 4,  // words of a vector, 1 or more
  parameter integer LANES  = 1,  // words of a beat, 1 or more
  parameter integer WIDTH  = 8,  // bits of a word
  parameter integer HOP    = 0,  // 1: the words take a clock to a copy, for many places far away
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

  localparam [BEATS-1:0] FIRST = 1;

  wire            next;  // a beat after this edge
  wire            flag;
  wire [BEAT-1:0] data;

  generate
    if (HOP != 0) begin : g_hop
      reg            hop_q  = 1'b0;
      reg [BEAT-1:0] data_q = {BEAT{1'b0}};
      always @(posedge clk_i) begin
        hop_q  <= flag_i;
        data_q <= data_i;
      end
      wire unused_next = next_i;
      assign next = valid_i;
      assign flag = hop_q;
      assign data = data_q;
    end else begin : g_at_once
      wire unused_valid = valid_i;
      assign next = next_i;
      assign flag = flag_i;
      assign data = data_i;
    end
  endgenerate

  // verilator lint_off UNUSED
  // The slots that hold the padding of the last beat are read by none.
  reg [SLOTS*WIDTH-1:0] slot_q  = {SLOTS*WIDTH{1'b0}};
  // verilator lint_on UNUSED
  reg                   flag_q  = 1'b0;

  // A one where the next beat goes. What writes a beat's places is known a clock ahead, so that it comes
  // from a register of its own.
  reg [BEATS-1:0] place_q = FIRST;
  reg [BEATS-1:0] put_q   = {BEATS{1'b0}};
  reg             valid_q = 1'b0;  // any of them
  // verilator lint_off UNUSED
  // Of the rotated place the highest bit is the lowest one too, and is left out.
  wire [BEATS:0] turned = {place_q, place_q[BEATS-1]};
  // verilator lint_on UNUSED
  always @(posedge clk_i) begin
    if (rst_i)     place_q <= FIRST;
    else if (next) place_q <= turned[BEATS-1:0];
    put_q   <= place_q & {BEATS{next & ~rst_i}};
    valid_q <= next & ~rst_i;
  end

  // That the last beat is here, for the copies alone: without `keep` it would be the last of put_q.
  (* keep, dont_merge, syn_preserve = 1 *) reg complete_q = 1'b0;
  (* keep *) always @(posedge clk_i) complete_q <= next & place_q[BEATS-1] & ~rst_i;

  // Copies that drive a part of the readers' words each: `keep` keeps them.
  genvar g;
  generate
    for (g = 0; g < STARTS; g = g + 1) begin : g_copy
      (* keep, dont_merge, syn_preserve = 1 *) reg start_q = 1'b0;
      (* keep *) always @(posedge clk_i) start_q <= complete_q & ~rst_i;
      assign start_o[g] = start_q;
    end
  endgenerate

  integer i;
  always @(posedge clk_i) begin
    if (valid_q) flag_q <= (flag_q & ~put_q[0]) | flag;
    for (i = 0; i < BEATS; i = i + 1)
      if (put_q[i]) slot_q[i*BEAT +: BEAT] <= data;
  end

  assign flag_o   = flag_q;
  assign vector_o = slot_q[0 +: WORDS*WIDTH];
endmodule

`default_nettype wire
