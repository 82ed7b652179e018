// SPDX-License-Identifier: MIT OR Apache-2.0
// line__hwg_egress: whole frames to AXI4-Stream beats.
//
// Function:  word w leaves in beat w / BEAT_WORDS, lane w % BEAT_WORDS; lanes beyond the last word are
//            zero. TLAST marks the last beat, TUSER = {error, saturated} holds for the whole frame.
//            Room for a frame, and that one comes, are told a clock ahead.
// Latency:   the first beat is offered 2 clocks after the frame; a frame every BEATS clocks, one more if
//            not EAGER.
// Reset:     drops the frame that is being sent; quiet_i comes before it, so that no beat of a dropped
//            frame is offered.
// Model:     hwgen: sim/src/model/stream.rs, Egress
`default_nettype none

module line__hwg_egress #(
  parameter integer WORDS      = 4,  // words of a frame, 1 or more
  parameter integer BEAT_WORDS = 1,  // words of a beat, 1 to WORDS
  parameter integer LANE_WIDTH = 16, // bits of a word and its lane
  parameter integer EAGER      = 1   // 1: the last beat of a frame makes room when it goes on
) (
  input  wire                             clk_i,
  input  wire                             rst_i,
  input  wire                             quiet_i,        // tvalid_o is low after this edge
  output wire                             room_next_o,    // a frame may come after this edge
  input  wire                             frame_next_i,   // one comes; only where there is room
  input  wire [WORDS*LANE_WIDTH-1:0]      frame_i,
  input  wire                             saturated_i,
  input  wire                             error_i,
  output wire                             tvalid_o,
  input  wire                             tready_i,
  output wire                             tlast_o,
  output wire [1:0]                       tuser_o,
  output wire [BEAT_WORDS*LANE_WIDTH-1:0] tdata_o
);
  localparam integer BEATS      = (WORDS + BEAT_WORDS - 1) / BEAT_WORDS;
  localparam integer SLOTS      = BEATS * BEAT_WORDS;
  localparam integer LEFT_WIDTH = $clog2(BEATS + 1);
  localparam integer ONE        = 1;

  reg [SLOTS*LANE_WIDTH-1:0] slot_q = {SLOTS*LANE_WIDTH{1'b0}};
  reg [LEFT_WIDTH-1:0]       left_q = {LEFT_WIDTH{1'b0}};  // beats still to send
  reg [1:0]                  user_q = 2'b0;

  // All are decided a clock ahead, for they move the whole frame.
  reg next_q = 1'b0;  // the slice takes a beat: beat_valid & beat_ready
  reg move_q = 1'b0;  // it does, or a frame comes

  // A frame comes; `keep`, for the sender has the same in a register.
  (* keep, dont_merge, syn_preserve = 1 *) reg load_q = 1'b0;
  (* keep *) always @(posedge clk_i) load_q <= frame_next_i;

  wire beat_valid = left_q != {LEFT_WIDTH{1'b0}};
  wire beat_last  = left_q == ONE[LEFT_WIDTH-1:0];
  wire unused_ready;
  wire beat_ready_next;
  wire [LEFT_WIDTH-1:0] left_d = load_q ? BEATS[LEFT_WIDTH-1:0] :
                                 next_q ? left_q - 1'b1 : left_q;
  wire next_d = ~rst_i & (left_d != {LEFT_WIDTH{1'b0}}) & beat_ready_next;

  always @(posedge clk_i) begin
    if (rst_i) left_q <= {LEFT_WIDTH{1'b0}};
    else       left_q <= left_d;
    next_q <= next_d;
    move_q <= frame_next_i | next_d;
  end

  integer i;
  always @(posedge clk_i) begin
    if (load_q) user_q <= {error_i, saturated_i};
    if (move_q) begin
      if (load_q) begin
        for (i = 0; i < SLOTS; i = i + 1)
          if (i < WORDS) slot_q[i*LANE_WIDTH +: LANE_WIDTH] <= frame_i[(i % WORDS)*LANE_WIDTH +: LANE_WIDTH];
          else           slot_q[i*LANE_WIDTH +: LANE_WIDTH] <= {LANE_WIDTH{1'b0}};
      end else begin
        for (i = 0; i < SLOTS - BEAT_WORDS; i = i + 1)
          slot_q[i*LANE_WIDTH +: LANE_WIDTH] <= slot_q[(i+BEAT_WORDS)*LANE_WIDTH +: LANE_WIDTH];
      end
    end
  end

  line__hwg_slice #(
    .WIDTH(3 + BEAT_WORDS*LANE_WIDTH)
  ) u_slice (
    .clk_i       (clk_i),
    .rst_i       (quiet_i),
    .valid_i     (beat_valid),
    .ready_o     (unused_ready),
    .ready_next_o(beat_ready_next),
    .data_i      ({beat_last, user_q, slot_q[0 +: BEAT_WORDS*LANE_WIDTH]}),
    .valid_o     (tvalid_o),
    .ready_i     (tready_i),
    .data_o      ({tlast_o, tuser_o, tdata_o})
  );

  // Where frames come as fast as their beats leave, the last beat makes room in the clock in which it
  // goes on; else when it is gone, which does not ask for tready_i.
  assign room_next_o = (left_d == {LEFT_WIDTH{1'b0}}) |
                       (EAGER != 0 & (left_d == ONE[LEFT_WIDTH-1:0]) & beat_ready_next);
endmodule

`default_nettype wire
