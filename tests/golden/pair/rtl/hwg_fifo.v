// SPDX-License-Identifier: MIT OR Apache-2.0
// hwg_fifo: a short FIFO whose head is always slot 0.
//
// Function:  words leave in the order in which they came; none is lost or doubled.
// Latency:   1 clock; one word a clock from DEPTH = 2 on. Both handshakes are registered,
//            and what they are going to be is told a clock ahead.
// Overflow:  impossible: a word is taken with ready_o high only.
// Reset:     empties it; not ready while reset is held.
// Model:     hwgen: sim/src/model/stream.rs, Fifo
`default_nettype none

module hwg_fifo #(
  parameter integer WIDTH = 8,  // bits of a word, 1 or more
  parameter integer DEPTH = 2   // words, 1 or more
) (
  input  wire             clk_i,
  input  wire             rst_i,
  input  wire             valid_i,
  output wire             ready_o,
  output wire             ready_next_o,  // ready_o after this edge
  input  wire [WIDTH-1:0] data_i,
  output wire             valid_o,
  output wire             valid_next_o,  // valid_o after this edge
  input  wire             ready_i,
  output wire [WIDTH-1:0] data_o
);
  localparam integer COUNT_WIDTH = $clog2(DEPTH + 1);

  reg [DEPTH*WIDTH-1:0]  slot_q  = {DEPTH*WIDTH{1'b0}};
  reg [COUNT_WIDTH-1:0]  count_q = {COUNT_WIDTH{1'b0}};
  reg                    valid_q = 1'b0;
  reg                    ready_q = 1'b0;

  wire push = valid_i & ready_q;
  wire pop  = valid_q & ready_i;

  // A new word goes behind those that stay.
  wire [COUNT_WIDTH-1:0] tail    = pop ? count_q - 1'b1 : count_q;
  wire [COUNT_WIDTH-1:0] count_d = push ? tail + 1'b1 : tail;

  always @(posedge clk_i) begin
    if (rst_i) begin
      count_q <= {COUNT_WIDTH{1'b0}};
    end else begin
      count_q <= count_d;
    end
    valid_q <= valid_next_o;
    ready_q <= ready_next_o;
  end

  genvar i;
  generate
    for (i = 0; i < DEPTH; i = i + 1) begin : g_slot
      wire [WIDTH-1:0] behind;
      if (i + 1 < DEPTH) begin : g_inner
        assign behind = slot_q[(i+1)*WIDTH +: WIDTH];
      end else begin : g_last
        assign behind = slot_q[i*WIDTH +: WIDTH];
      end
      always @(posedge clk_i) begin
        if (push && tail == i[COUNT_WIDTH-1:0]) slot_q[i*WIDTH +: WIDTH] <= data_i;
        else if (pop)                           slot_q[i*WIDTH +: WIDTH] <= behind;
      end
    end
  endgenerate

  assign valid_next_o = ~rst_i & (count_d != {COUNT_WIDTH{1'b0}});
  assign ready_next_o = ~rst_i & (count_d != DEPTH[COUNT_WIDTH-1:0]);

  assign valid_o = valid_q;
  assign ready_o = ready_q;
  assign data_o  = slot_q[0 +: WIDTH];
endmodule

`default_nettype wire
