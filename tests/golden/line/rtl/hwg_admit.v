// SPDX-License-Identifier: MIT OR Apache-2.0
// hwg_admit: lets frames into a stage that has no back-pressure inside.
//
// Function:  a frame may start when INTERVAL clocks have passed since the one before and fewer than
//            CREDITS are under way. It says so a clock ahead, so that start_i comes from a register.
// Latency:   none: ready_next_o counts with start_i and release_i of this clock.
// Overflow:  impossible: the stage's queues hold CREDITS frames.
// Reset:     all credits are there, the next frame may start at once.
// Model:     hwgen: sim/src/model/stream.rs, Admit
`default_nettype none

module hwg_admit #(
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

  reg [GAP_WIDTH-1:0]    gap_q    = {GAP_WIDTH{1'b0}};            // clocks still to wait
  reg [CREDIT_WIDTH-1:0] credit_q = {CREDIT_WIDTH{1'b0}};

  // What the next decision asks of them, a clock ahead.
  reg ends_q = 1'b0;  // the gap is over after this edge, unless a frame starts
  reg some_q = 1'b0;  // a credit is left
  reg more_q = 1'b0;  // more than one

  wire some_d = release_i | (start_i ? more_q : some_q);

  always @(posedge clk_i) begin
    if (rst_i) begin
      gap_q    <= {GAP_WIDTH{1'b0}};
      credit_q <= CREDITS[CREDIT_WIDTH-1:0];
      ends_q   <= 1'b1;
      some_q   <= 1'b1;
      more_q   <= CREDITS > 1;
    end else begin
      if (start_i)                         gap_q <= GAP[GAP_WIDTH-1:0];
      else if (gap_q != {GAP_WIDTH{1'b0}}) gap_q <= gap_q - 1'b1;
      ends_q <= start_i ? GAP <= 1 : {{(32-GAP_WIDTH){1'b0}}, gap_q} <= 2;
      some_q <= some_d;
      if (start_i & ~release_i) begin
        credit_q <= credit_q - 1'b1;
        more_q   <= {{(32-CREDIT_WIDTH){1'b0}}, credit_q} > 2;
      end else if (release_i & ~start_i) begin
        credit_q <= credit_q + 1'b1;
        more_q   <= some_q;
      end
    end
  end

  assign ready_next_o = ~rst_i & (start_i ? GAP == 0 : ends_q) & some_d;
endmodule

`default_nettype wire
