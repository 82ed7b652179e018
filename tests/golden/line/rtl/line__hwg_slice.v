// SPDX-License-Identifier: MIT OR Apache-2.0
// line__hwg_slice: a register slice: two words, so that both handshakes come out of registers.
//
// Function:  words leave in the order in which they came; none is lost or doubled. Whether a word
//            comes or goes does not choose what is loaded: without a word the slots take what is
//            offered, whatever it is.
// Latency:   1 clock, one word a clock.
// Overflow:  impossible: a word is taken with ready_o high only.
// Reset:     empties it; not ready while reset is held.
// Model:     hwgen: sim/src/model/stream.rs, Slice
`default_nettype none

module line__hwg_slice #(
  parameter integer WIDTH = 8  // bits of a word, 1 or more
) (
  input  wire             clk_i,
  input  wire             rst_i,
  input  wire             valid_i,
  output wire             ready_o,
  output wire             ready_next_o,  // ready_o after this edge, unless it is one in reset
  input  wire [WIDTH-1:0] data_i,
  output wire             valid_o,
  input  wire             ready_i,
  output wire [WIDTH-1:0] data_o
);
  reg [2*WIDTH-1:0] slot_q  = {2*WIDTH{1'b0}};
  reg               valid_q = 1'b0;
  reg               ready_q = 1'b0;

  wire pop   = valid_q & ready_i;
  wire two   = valid_q & ~ready_q;
  wire two_d = valid_q & ~pop & (two | valid_i);

  always @(posedge clk_i) begin
    valid_q <= ~rst_i & (two | (valid_i & ready_q) | (valid_q & ~pop));
    ready_q <= ~rst_i & ~two_d;
  end

  // The head, and the word behind it.
  always @(posedge clk_i) begin
    if (pop | ~valid_q) slot_q[0 +: WIDTH]     <= ready_q ? data_i : slot_q[WIDTH +: WIDTH];
    if (ready_q)        slot_q[WIDTH +: WIDTH] <= data_i;
  end

  assign ready_next_o = ~two_d;

  assign valid_o = valid_q;
  assign ready_o = ready_q;
  assign data_o  = slot_q[0 +: WIDTH];
endmodule

`default_nettype wire
