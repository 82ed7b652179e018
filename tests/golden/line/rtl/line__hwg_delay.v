// SPDX-License-Identifier: MIT OR Apache-2.0
// line__hwg_delay: control bits, DEPTH clocks later.
//
// Function:  data_o is data_i of DEPTH clocks ago.
// Latency:   DEPTH clocks.
// Reset:     all bits under way become zero: no valid bit survives a reset.
// Model:     hwgen: sim/src/model/layer.rs, Delay
`default_nettype none

module line__hwg_delay #(
  parameter integer WIDTH = 1,  // bits, 1 or more
  parameter integer DEPTH = 1   // clocks, 1 or more
) (
  input  wire             clk_i,
  input  wire             rst_i,
  input  wire [WIDTH-1:0] data_i,
  output wire [WIDTH-1:0] data_o
);
  reg [DEPTH*WIDTH-1:0] pipe_q = {DEPTH*WIDTH{1'b0}};  // the newest in the lowest bits

  integer i;
  always @(posedge clk_i) begin
    if (rst_i) begin
      pipe_q <= {DEPTH*WIDTH{1'b0}};
    end else begin
      pipe_q[0 +: WIDTH] <= data_i;
      for (i = 1; i < DEPTH; i = i + 1) pipe_q[i*WIDTH +: WIDTH] <= pipe_q[(i-1)*WIDTH +: WIDTH];
    end
  end

  assign data_o = pipe_q[(DEPTH-1)*WIDTH +: WIDTH];
endmodule

`default_nettype wire
