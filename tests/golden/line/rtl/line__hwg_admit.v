// SPDX-License-Identifier: MIT OR Apache-2.0
// line__hwg_admit: lets frames into a stage that has no back-pressure inside.
//
// Function:  a frame may start when INTERVAL clocks have passed since the one before and fewer than
//            CREDITS are under way. It says so a clock ahead, so that start_i comes from a register.
// Latency:   none: ready_next_o counts with start_i and release_i of this clock.
// Overflow:  impossible: the stage's queues hold CREDITS frames.
// Reset:     all credits are there, the next frame may start at once.
// Model:     hwgen: sim/src/model/stream.rs, Admit
`default_nettype none

module line__hwg_admit #(
  parameter integer INTERVAL = 4,  // clocks, 1 or more
  parameter integer CREDITS  = 2   // frames, 1 or more
) (
  input  wire clk_i,
  input  wire rst_i,
  output wire ready_next_o,  // a frame may start after this edge
  input  wire start_i,       // a frame starts; only where one may
  input  wire release_i      // a frame has left
);
  localparam integer GAP          = INTERVAL - 1;
  localparam integer GAP_WIDTH    = $clog2(INTERVAL + 1);
  localparam integer CREDIT_WIDTH = $clog2(CREDITS + 1);

  reg [GAP_WIDTH-1:0] gap_q  = {GAP_WIDTH{1'b0}};  // clocks still to wait
  reg                 ends_q = 1'b0;               // the gap is over after this edge, unless a frame starts

  always @(posedge clk_i) begin
    if (rst_i) begin
      gap_q  <= {GAP_WIDTH{1'b0}};
      ends_q <= 1'b1;
    end else begin
      if (start_i)                         gap_q <= GAP[GAP_WIDTH-1:0];
      else if (gap_q != {GAP_WIDTH{1'b0}}) gap_q <= gap_q - 1'b1;
      ends_q <= start_i ? GAP <= 1 : {{(32-GAP_WIDTH){1'b0}}, gap_q} <= 2;
    end
  end

  wire [CREDIT_WIDTH-1:0] unused_count;
  wire                    unused_some;
  wire                    unused_more;
  wire                    some_next;
  line__hwg_count #(
    .MOST (CREDITS),
    .START(CREDITS)
  ) u_credits (
    .clk_i      (clk_i),
    .rst_i      (rst_i),
    .up_i       (release_i),
    .down_i     (start_i),
    .count_o    (unused_count),
    .some_o     (unused_some),
    .more_o     (unused_more),
    .some_next_o(some_next)
  );

  assign ready_next_o = (start_i ? GAP == 0 : ends_q) & some_next;
endmodule

`default_nettype wire
