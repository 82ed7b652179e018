// SPDX-License-Identifier: MIT OR Apache-2.0
// pair__hwg_ingress: AXI4-Stream beats to whole frames, clipped to the input box.
//
// Function:  a frame ends with TLAST. Word w comes in beat w / BEAT_WORDS, lane w % BEAT_WORDS, and
//            is clipped to low_i[w] .. high_i[w]. Missing words take the value low_i, words beyond
//            the last are dropped; either raises error_o and leaves the next frame alone.
// Format:    lanes are sign-extended words; words are signed and WIDTH bits wide.
// Latency:   the frame is offered 4 clocks after its last beat was taken; a frame every BEATS clocks.
// Overflow:  clipped_o tells that a word was outside of its bounds.
// Reset:     drops the frame that is being gathered; quiet_i comes before it, so that no beat is taken
//            that the reset would drop.
// Model:     hwgen: sim/src/model/stream.rs, Ingress
`default_nettype none

module pair__hwg_ingress #(
  parameter integer WORDS      = 4,   // words of a frame, 1 or more
  parameter integer BEAT_WORDS = 1,   // words of a beat, 1 to WORDS
  parameter integer LANE_WIDTH = 16,  // bits of a lane, WIDTH or more
  parameter integer WIDTH      = 16   // bits of a word, 2 or more
) (
  input  wire                             clk_i,
  input  wire                             rst_i,
  input  wire                             quiet_i,        // tready_o is low after this edge, the slice empty
  input  wire                             tvalid_i,
  output wire                             tready_o,
  input  wire                             tlast_i,
  input  wire [BEAT_WORDS*LANE_WIDTH-1:0] tdata_i,
  input  wire [WORDS*WIDTH-1:0]           low_i,
  input  wire [WORDS*WIDTH-1:0]           high_i,
  output wire                             frame_next_o,   // a frame stands in frame_o after this edge
  input  wire                             take_next_i,    // it is taken at the edge behind that
  output wire [WORDS*WIDTH-1:0]           frame_o,
  output wire                             clipped_o,
  output wire                             error_o
);
  localparam integer BEATS       = (WORDS + BEAT_WORDS - 1) / BEAT_WORDS;
  localparam integer LAST        = BEATS - 1;
  localparam integer INDEX_WIDTH = $clog2(BEATS + 1);

  wire                             beat_valid;
  wire                             beat_last;
  wire [BEAT_WORDS*LANE_WIDTH-1:0] beat_data;

  // The beat at the slice's head, with its bounds, compared with them, within them: _q, _q2, _q3. Bit b
  // of enable_q3: it goes to the words of beat b, its own, and if it is the first, all others' defaults.
  reg [INDEX_WIDTH-1:0] index_q   = {INDEX_WIDTH{1'b0}};  // of the beat at the head; BEATS: too long
  reg [INDEX_WIDTH-1:0] beat_q    = {INDEX_WIDTH{1'b0}};
  reg [INDEX_WIDTH-1:0] beat_q2   = {INDEX_WIDTH{1'b0}};
  reg [BEATS-1:0]       enable_q3 = {BEATS{1'b0}};
  reg                   valid_q   = 1'b0;
  reg                   valid_q2  = 1'b0;
  reg                   valid_q3  = 1'b0;
  reg                   last_q    = 1'b0;
  reg                   last_q2   = 1'b0;
  reg                   last_q3   = 1'b0;
  reg                   short_q3  = 1'b0;  // not the beat that should be the last
  reg                   clip_q3   = 1'b0;  // a word of it was outside of the box
  wire [BEAT_WORDS-1:0] outside;           // which of its words are

  // The frame.
  reg [WORDS*WIDTH-1:0] word_q    = {WORDS*WIDTH{1'b0}};
  reg                   clipped_q = 1'b0;
  reg                   error_q   = 1'b0;

  // All are decided a clock ahead, so that registers drive what moves whole beats.
  reg             room_q  = 1'b0;           // no frame stands in word_q, or the one that does is taken now
  reg             move_q  = 1'b0;           // beats move on, for none waits for room
  reg             put_q   = 1'b0;           // a beat goes into word_q
  reg [BEATS-1:0] write_q = {BEATS{1'b0}};  // where it goes

  wire take  = beat_valid & move_q;
  wire first = enable_q3[0];

  wire unused_ready_next;
  pair__hwg_slice #(
    .WIDTH(1 + BEAT_WORDS*LANE_WIDTH)
  ) u_slice (
    .clk_i       (clk_i),
    .rst_i       (quiet_i),
    .valid_i     (tvalid_i),
    .ready_o     (tready_o),
    .ready_next_o(unused_ready_next),
    .data_i      ({tlast_i, tdata_i}),
    .valid_o     (beat_valid),
    .ready_i     (move_q),
    .data_o      ({beat_last, beat_data})
  );

  wire full_d   = (put_q & last_q3) | ~room_q;
  wire room_d   = ~full_d | take_next_i;
  wire valid_d3 = move_q ? valid_q2 : valid_q3;
  wire put_d    = ~rst_i & valid_d3 & room_d;

  always @(posedge clk_i) begin
    if (rst_i) begin
      index_q  <= {INDEX_WIDTH{1'b0}};
      valid_q  <= 1'b0;
      valid_q2 <= 1'b0;
      valid_q3 <= 1'b0;
      room_q   <= 1'b1;
      move_q   <= 1'b1;
    end else begin
      if (take) begin
        if (beat_last)                              index_q <= {INDEX_WIDTH{1'b0}};
        else if (index_q != BEATS[INDEX_WIDTH-1:0]) index_q <= index_q + 1'b1;
      end
      if (move_q) begin
        valid_q  <= beat_valid;
        valid_q2 <= valid_q;
      end
      valid_q3 <= valid_d3;
      room_q   <= room_d;
      move_q   <= ~valid_d3 | room_d;
    end
    put_q <= put_d;
  end

  reg [BEATS-1:0] enable_d3;
  integer         b;
  always @* begin
    for (b = 0; b < BEATS; b = b + 1)
      enable_d3[b] = (beat_q2 == b[INDEX_WIDTH-1:0]) | (beat_q2 == {INDEX_WIDTH{1'b0}});
    if (~move_q) enable_d3 = enable_q3;
  end

  always @(posedge clk_i) begin
    enable_q3 <= enable_d3;
    write_q   <= enable_d3 & {BEATS{put_d}};
    if (move_q) begin
      beat_q   <= index_q;
      beat_q2  <= beat_q;
      last_q   <= beat_last;
      last_q2  <= last_q;
      last_q3  <= last_q2;
      short_q3 <= beat_q2 != LAST[INDEX_WIDTH-1:0];
      clip_q3  <= |outside;
    end
  end

  // Each lane is compared with the bounds of the word that it carries in this beat.
  wire [BEAT_WORDS*WIDTH-1:0] bounded;
  genvar j;
  generate
    for (j = 0; j < BEAT_WORDS; j = j + 1) begin : g_lane
      reg [WIDTH-1:0] low;
      reg [WIDTH-1:0] high;
      reg             used;
      integer         w;
      always @* begin
        low  = {WIDTH{1'b0}};
        high = {WIDTH{1'b0}};
        used = 1'b0;
        for (w = j; w < WORDS; w = w + BEAT_WORDS) begin
          if ($signed({{(32-INDEX_WIDTH){1'b0}}, index_q}) == w / BEAT_WORDS) begin
            low  = low_i[w*WIDTH +: WIDTH];
            high = high_i[w*WIDTH +: WIDTH];
            used = 1'b1;
          end
        end
      end

      reg        [LANE_WIDTH-1:0] value_q  = {LANE_WIDTH{1'b0}};
      reg        [WIDTH-1:0]      low_q    = {WIDTH{1'b0}};
      reg        [WIDTH-1:0]      high_q   = {WIDTH{1'b0}};
      reg                         used_q   = 1'b0;
      reg        [WIDTH-1:0]      value_q2 = {WIDTH{1'b0}};
      reg        [WIDTH-1:0]      low_q2   = {WIDTH{1'b0}};
      reg        [WIDTH-1:0]      high_q2  = {WIDTH{1'b0}};
      reg                         used_q2  = 1'b0;
      reg                         below_q2 = 1'b0;
      reg                         above_q2 = 1'b0;
      reg        [WIDTH-1:0]      word_q3  = {WIDTH{1'b0}};
      // verilator lint_off UNUSED
      // Differences of one bit more, of which the signs alone are read: the comparisons stand at the
      // ends of the carry chains.
      wire [LANE_WIDTH:0] value = {value_q[LANE_WIDTH-1], value_q};
      wire [LANE_WIDTH:0] under = value - {{(LANE_WIDTH-WIDTH+2){low_q[WIDTH-1]}}, low_q[WIDTH-2:0]};
      wire [LANE_WIDTH:0] over  = {{(LANE_WIDTH-WIDTH+2){high_q[WIDTH-1]}}, high_q[WIDTH-2:0]} - value;
      // verilator lint_on UNUSED
      always @(posedge clk_i) begin
        if (move_q) begin
          value_q  <= beat_data[j*LANE_WIDTH +: LANE_WIDTH];
          low_q    <= low;
          high_q   <= high;
          used_q   <= used;
          value_q2 <= value_q[WIDTH-1:0];
          low_q2   <= low_q;
          high_q2  <= high_q;
          used_q2  <= used_q;
          below_q2 <= under[LANE_WIDTH];
          above_q2 <= over[LANE_WIDTH];
          word_q3  <= below_q2 ? low_q2 : above_q2 ? high_q2 : value_q2;
        end
      end

      assign outside[j] = used_q2 & (below_q2 | above_q2);
      assign bounded[j*WIDTH +: WIDTH] = word_q3;
    end
  endgenerate

  integer k;
  always @(posedge clk_i) begin
    if (put_q) begin
      clipped_q <= (clipped_q & ~first) | clip_q3;
      error_q   <= short_q3;
    end
    for (k = 0; k < WORDS; k = k + 1)
      if (write_q[k/BEAT_WORDS])
        word_q[k*WIDTH +: WIDTH] <= first & (k >= BEAT_WORDS) ? low_i[k*WIDTH +: WIDTH] :
                                    bounded[(k % BEAT_WORDS)*WIDTH +: WIDTH];
  end

  assign frame_next_o = ~rst_i & full_d;
  assign frame_o      = word_q;
  assign clipped_o    = clipped_q;
  assign error_o      = error_q;
endmodule

`default_nettype wire
