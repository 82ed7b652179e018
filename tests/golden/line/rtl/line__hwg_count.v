// SPDX-License-Identifier: MIT OR Apache-2.0
// line__hwg_count: how many there are of what comes and goes one by one.
//
// Function:  counts up_i and down_i. That there are some, and more than one, is told by registers; that
//            there are going to be some, a clock ahead.
// Latency:   1 clock; some_next_o counts with up_i and down_i of this clock.
// Overflow:  for whoever uses it to avoid: down_i only where there are some, up_i only below MOST.
// Reset:     START are there; some_next_o is low while reset is held.
// Model:     hwgen: sim/src/model/stream.rs, Count
`default_nettype none

module line__hwg_count #(
  parameter integer MOST  = 2,                 // 1 or more
  parameter integer START = 0,                 // 0 to MOST
  parameter integer WIDTH = $clog2(MOST + 1)   // derived: leave it alone
) (
  input  wire             clk_i,
  input  wire             rst_i,
  input  wire             up_i,
  input  wire             down_i,
  output wire [WIDTH-1:0] count_o,
  output wire             some_o,       // 1 or more
  output wire             more_o,       // 2 or more
  output wire             some_next_o   // some_o after this edge
);
  reg [WIDTH-1:0] count_q = {WIDTH{1'b0}};
  reg             some_q  = 1'b0;
  reg             more_q  = 1'b0;

  // What is going to be there is told from what is, so that no path goes by way of a sum.
  wire some_d = up_i | (down_i ? more_q : some_q);

  always @(posedge clk_i) begin
    if (rst_i) begin
      count_q <= START[WIDTH-1:0];
      some_q  <= START > 0;
      more_q  <= START > 1;
    end else begin
      some_q <= some_d;
      if (up_i & ~down_i) begin
        count_q <= count_q + 1'b1;
        more_q  <= some_q;
      end else if (down_i & ~up_i) begin
        count_q <= count_q - 1'b1;
        more_q  <= {{(32-WIDTH){1'b0}}, count_q} > 2;
      end
    end
  end

  assign count_o     = count_q;
  assign some_o      = some_q;
  assign more_o      = more_q;
  assign some_next_o = some_d & ~rst_i;
endmodule

`default_nettype wire
