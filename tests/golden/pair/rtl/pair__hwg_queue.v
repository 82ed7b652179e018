// SPDX-License-Identifier: MIT OR Apache-2.0
// pair__hwg_queue: a FIFO of several words: the head in a register, the others in a small memory.
//
// Function:  words leave in the order in which they came; none is lost or doubled.
// Latency:   1 clock; one word a clock. Both handshakes are registered.
// Overflow:  impossible: a word is taken with ready_o high only.
// Reset:     empties it; not ready while reset is held. Head and memory keep their words.
// Model:     hwgen: sim/src/model/stream.rs, Queue
`default_nettype none

module pair__hwg_queue #(
  parameter integer WIDTH = 8,  // bits of a word, 1 or more
  parameter integer DEPTH = 2   // words, 2 or more
) (
  input  wire             clk_i,
  input  wire             rst_i,
  input  wire             valid_i,
  output wire             ready_o,
  input  wire [WIDTH-1:0] data_i,
  output wire             valid_o,
  input  wire             ready_i,
  output wire [WIDTH-1:0] data_o
);
  localparam integer BEHIND        = DEPTH - 1;  // words of the memory
  localparam integer ADDRESS_WIDTH = BEHIND > 1 ? $clog2(BEHIND) : 1;
  localparam integer COUNT_WIDTH   = $clog2(DEPTH + 1);
  localparam integer LAST          = BEHIND - 1;

  reg [WIDTH-1:0]         head_q  = {WIDTH{1'b0}};
  reg [WIDTH-1:0]         memory [0:BEHIND-1];
  reg [ADDRESS_WIDTH-1:0] write_q = {ADDRESS_WIDTH{1'b0}};  // where the next word behind goes
  reg [ADDRESS_WIDTH-1:0] read_q  = {ADDRESS_WIDTH{1'b0}};  // where the one behind the head is
  reg                     ready_q = 1'b0;

  wire [COUNT_WIDTH-1:0] count;
  wire                   valid;
  wire                   more;  // there is a word behind the head

  wire push   = valid_i & ready_q;
  wire pop    = valid & ready_i;
  wire behind = push & valid & (more | ~ready_i);  // it is not the head at once
  wire near   = count == BEHIND[COUNT_WIDTH-1:0];
  wire full   = count == DEPTH[COUNT_WIDTH-1:0];

  wire unused_next;
  pair__hwg_count #(
    .MOST(DEPTH)
  ) u_count (
    .clk_i      (clk_i),
    .rst_i      (rst_i),
    .up_i       (push),
    .down_i     (pop),
    .count_o    (count),
    .some_o     (valid),
    .more_o     (more),
    .some_next_o(unused_next)
  );

  always @(posedge clk_i) begin
    if (rst_i) begin
      write_q <= {ADDRESS_WIDTH{1'b0}};
      read_q  <= {ADDRESS_WIDTH{1'b0}};
    end else begin
      if (behind)
        write_q <= write_q == LAST[ADDRESS_WIDTH-1:0] ? {ADDRESS_WIDTH{1'b0}} : write_q + 1'b1;
      if (pop & more)
        read_q <= read_q == LAST[ADDRESS_WIDTH-1:0] ? {ADDRESS_WIDTH{1'b0}} : read_q + 1'b1;
    end
    ready_q <= ~rst_i & (pop | ~(full | (near & push)));
  end

  // Where there is room, what is offered is written, be it a word or not: only write_q says that it counts,
  // and no gate stands between a register and all bits of the memory. Without a word behind it the head
  // takes it likewise.
  always @(posedge clk_i) begin
    if (ready_q)          memory[write_q] <= data_i;
    if (ready_i | ~valid) head_q <= more ? memory[read_q] : data_i;
  end

  genvar i;
  generate
    for (i = 0; i < BEHIND; i = i + 1) begin : g_word
      initial memory[i] = {WIDTH{1'b0}};
      // verilator lint_off UNUSED
      // Shows each word to a simulator's dump, and is nothing in hardware.
      wire [WIDTH-1:0] word = memory[i];
      // verilator lint_on UNUSED
    end
  endgenerate

  assign valid_o = valid;
  assign ready_o = ready_q;
  assign data_o  = head_q;
endmodule

`default_nettype wire
