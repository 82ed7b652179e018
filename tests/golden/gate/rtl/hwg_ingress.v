// SPDX-License-Identifier: MIT OR Apache-2.0
// hwg_ingress: AXI4-Stream beats to whole frames, clipped to the input box.
//
// Function:  a frame ends with TLAST. Word w comes in beat w / BEAT_WORDS, lane w % BEAT_WORDS, and
//            is clipped to low_i[w] .. high_i[w]. Missing words take the value low_i, words beyond
//            the last are dropped; either raises error_o and leaves the next frame alone.
// Format:    lanes are sign-extended words; words are signed and WIDTH bits wide.
// Latency:   the frame is offered 1 clock after its last beat was taken; a frame every BEATS clocks.
// Overflow:  clipped_o tells that a word was outside of its bounds.
// Reset:     drops the frame that is being gathered.
// Model:     hwgen: sim/src/model/stream.rs, Ingress
`default_nettype none

module hwg_ingress #(
  parameter integer WORDS      = 4,   // words of a frame, 1 or more
  parameter integer BEAT_WORDS = 1,   // words of a beat, 1 to WORDS
  parameter integer LANE_WIDTH = 16,  // bits of a lane, WIDTH or more
  parameter integer WIDTH      = 16   // bits of a word, 2 or more
) (
  input  wire                             clk_i,
  input  wire                             rst_ni,
  input  wire                             tvalid_i,
  output wire                             tready_o,
  input  wire                             tlast_i,
  input  wire [BEAT_WORDS*LANE_WIDTH-1:0] tdata_i,
  input  wire [WORDS*WIDTH-1:0]           low_i,
  input  wire [WORDS*WIDTH-1:0]           high_i,
  output wire                             frame_valid_o,
  input  wire                             frame_ready_i,
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

  reg [INDEX_WIDTH-1:0] index_q   = {INDEX_WIDTH{1'b0}};  // beat of the frame; BEATS: too long
  reg [WORDS*WIDTH-1:0] word_q    = {WORDS*WIDTH{1'b0}};
  reg                   full_q    = 1'b0;
  reg                   clipped_q = 1'b0;
  reg                   error_q   = 1'b0;

  wire room  = ~full_q | frame_ready_i;
  wire take  = beat_valid & room;
  wire first = index_q == {INDEX_WIDTH{1'b0}};

  hwg_fifo #(
    .WIDTH(1 + BEAT_WORDS*LANE_WIDTH),
    .DEPTH(2)
  ) u_slice (
    .clk_i  (clk_i),
    .rst_ni (rst_ni),
    .valid_i(tvalid_i),
    .ready_o(tready_o),
    .data_i ({tlast_i, tdata_i}),
    .valid_o(beat_valid),
    .ready_i(room),
    .data_o ({beat_last, beat_data})
  );

  // Each lane is compared with the bounds of the word that it carries in this beat.
  wire [BEAT_WORDS*WIDTH-1:0] bounded;
  wire [BEAT_WORDS-1:0]       outside;
  genvar j;
  generate
    for (j = 0; j < BEAT_WORDS; j = j + 1) begin : g_lane
      wire signed [LANE_WIDTH-1:0] value = beat_data[j*LANE_WIDTH +: LANE_WIDTH];
      reg  signed [LANE_WIDTH-1:0] low;
      reg  signed [LANE_WIDTH-1:0] high;
      reg                          used;
      integer                      w;
      always @* begin
        low  = {LANE_WIDTH{1'b0}};
        high = {LANE_WIDTH{1'b0}};
        used = 1'b0;
        for (w = j; w < WORDS; w = w + BEAT_WORDS) begin
          if ({{(32-INDEX_WIDTH){1'b0}}, index_q} == w / BEAT_WORDS) begin
            low  = {{(LANE_WIDTH-WIDTH+1){low_i[w*WIDTH+WIDTH-1]}}, low_i[w*WIDTH +: WIDTH-1]};
            high = {{(LANE_WIDTH-WIDTH+1){high_i[w*WIDTH+WIDTH-1]}}, high_i[w*WIDTH +: WIDTH-1]};
            used = 1'b1;
          end
        end
      end
      wire below = value < low;
      wire above = value > high;
      assign outside[j] = used & (below | above);
      assign bounded[j*WIDTH +: WIDTH] = below ? low[WIDTH-1:0] :
                                         above ? high[WIDTH-1:0] : value[WIDTH-1:0];
    end
  endgenerate

  always @(posedge clk_i) begin
    if (!rst_ni) begin
      index_q <= {INDEX_WIDTH{1'b0}};
      full_q  <= 1'b0;
    end else begin
      if (take) begin
        if (beat_last)                              index_q <= {INDEX_WIDTH{1'b0}};
        else if (index_q != BEATS[INDEX_WIDTH-1:0]) index_q <= index_q + 1'b1;
      end
      if (take & beat_last)   full_q <= 1'b1;
      else if (frame_ready_i) full_q <= 1'b0;
    end
  end

  integer k;
  always @(posedge clk_i) begin
    if (take) begin
      clipped_q <= (clipped_q & ~first) | (|outside);
      error_q   <= index_q != LAST[INDEX_WIDTH-1:0];
      for (k = 0; k < WORDS; k = k + 1) begin
        if ({{(32-INDEX_WIDTH){1'b0}}, index_q} == k / BEAT_WORDS)
          word_q[k*WIDTH +: WIDTH] <= bounded[(k % BEAT_WORDS)*WIDTH +: WIDTH];
        else if (first)
          word_q[k*WIDTH +: WIDTH] <= low_i[k*WIDTH +: WIDTH];
      end
    end
  end

  assign frame_valid_o = full_q;
  assign frame_o       = word_q;
  assign clipped_o     = clipped_q;
  assign error_o       = error_q;
endmodule

`default_nettype wire
