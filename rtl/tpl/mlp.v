// SPDX-License-Identifier: MIT OR Apache-2.0
// @{ module }@: the stage of multilayer perceptrons, frame in, frame out.
//
// Function:  @{ shared_note }@
@% for line in network_notes %@//            @{ line }@
@% endfor %@// Format:    words of the input frame are read as @{ x_format }@; those of the output frame are sign-extended to
//            @{ lane_bits }@ bits.
// Latency:   @{ latency }@ clocks from start to the output frame; a frame every @{ interval }@ clocks.
// Overflow:  inside there is no back-pressure: at most @{ credits }@ frames are under way, and the queues
//            behind the networks hold as many.
// Reset:     control bits only; frames under way are dropped.
// Model:     hwgen: sim/src/model/stage.rs
// @{ provenance }@
`default_nettype none

module @{ module }@ (
  input  wire clk_i,
  input  wire rst_ni,
  input  wire frame_next_i,   // an input frame stands in frame_i after this edge
  output wire take_next_o,    // it is taken at the edge behind that
  input  wire @{ frame_range }@ frame_i,
  input  wire clipped_i,      // an input was outside of the box
  input  wire error_i,        // the frame was too short or too long
  input  wire room_next_i,    // an output frame may be given after this edge
  output wire frame_next_o,   // one is given in frame_o after this edge
  output wire @{ out_range }@ frame_o,
  output wire saturated_o,    // an input or a word inside was clipped
  output wire error_o
);
  // Copies of the reset, one for each part that may stand elsewhere; this one is for what is here.
  (* keep, dont_merge, syn_preserve = 1 *) reg rst_q2 = 1'b1;
  (* keep *) always @(posedge clk_i) rst_q2 <= ~rst_ni;

  // Both decisions fall a clock ahead, so that registers drive what loads and moves whole frames.
  reg  start_q = 1'b0;
  reg  leave_q = 1'b0;
  wire may_start;
  wire may_leave;
  wire leave = room_next_i & may_leave;
  always @(posedge clk_i) begin
    start_q <= frame_next_i & may_start;
    leave_q <= leave;
  end

  // A copy of leave_q for the credits, which stand with the ingress: `keep` keeps it.
  (* keep, dont_merge, syn_preserve = 1 *) reg release_q = 1'b0;
  (* keep *) always @(posedge clk_i) release_q <= leave;

  @{ prefix }@__hwg_admit #(
    .INTERVAL(@{ interval }@),
    .CREDITS (@{ credits }@)
  ) u_admit (
    .clk_i       (clk_i),
    .rst_i       (rst_q2),
    .ready_next_o(may_start),
    .start_i     (start_q),
    .release_i   (release_q)
  );

  // What is known of a frame at its start waits for its words.
  wire clipped;
  wire unused_frames_valid;
  wire unused_frames_ready;  // credits keep the queues from being full
  @{ prefix }@__hwg_queue #(
    .WIDTH(2),
    .DEPTH(@{ fifo_depth }@)
  ) u_frames (
    .clk_i   (clk_i),
    .rst_i   (rst_q2),
    .valid_i (start_q),
    .ready_o (unused_frames_ready),
    .data_i  ({error_i, clipped_i}),
    .valid_o (unused_frames_valid),
    .ready_i (leave_q),
    .data_o  ({error_o, clipped})
  );
@% for l in layers %@
  // Layer @{ l.name }@: @{ l.inputs }@ to @{ l.outputs }@ @{ l.activation }@@{ l.note }@.
  (* keep, dont_merge, syn_preserve = 1 *) reg @{ l.name }@_rst_q2 = 1'b1;
  (* keep *) always @(posedge clk_i) @{ l.name }@_rst_q2 <= ~rst_ni;
  wire @{ l.next }@;
  wire @{ l.name }@_valid;
  wire @{ l.name }@_flag;
  wire @{ l.words_range }@ @{ l.name }@_words;
  @{ l.module }@ u_@{ l.name }@ (
    .clk_i   (clk_i),
    .rst_i   (@{ l.name }@_rst_q2),
@% if l.whole %@    .start_i (@{ l.start }@),
    .flag_i  (@{ l.flag }@),
    .vector_i(@{ l.vector }@),
@% else %@    .valid_i (@{ l.start }@),
    .flag_i  (@{ l.flag }@),
    .words_i (@{ l.vector }@),
@% endif %@    .next_o  (@{ l.next }@),
    .valid_o (@{ l.name }@_valid),
    .flag_o  (@{ l.name }@_flag),
    .words_o (@{ l.name }@_words)
  );
@% if l.gathered %@  wire @{ l.starts_range }@@{ l.name }@_start;
  wire @{ l.name }@_clipped;
  wire @{ l.vector_range }@ @{ l.name }@_vector;
  @{ prefix }@__hwg_gather #(
    .WORDS (@{ l.outputs }@),
    .LANES (@{ l.lanes }@),
    .WIDTH (@{ l.width }@),
@% if l.hop %@    .HOP   (1),
@% endif %@    .STARTS(@{ l.starts }@)
  ) u_@{ l.name }@_gather (
    .clk_i   (clk_i),
    .rst_i   (@{ l.name }@_rst_q2),
    .next_i  (@{ l.next }@),
    .valid_i (@{ l.name }@_valid),
    .flag_i  (@{ l.name }@_flag),
    .data_i  (@{ l.name }@_words),
    .start_o (@{ l.name }@_start),
    .flag_o  (@{ l.name }@_clipped),
    .vector_o(@{ l.name }@_vector)
  );
@% endif %@@% endfor %@@% for n in networks %@
  // Answers of network @{ n.name }@: @{ n.words }@ words, @{ n.format }@.
  wire unused_@{ n.name }@_valid;
  wire unused_@{ n.name }@_ready;
  wire @{ n.name }@_saturated;
  wire @{ n.range }@ @{ n.name }@_answer;
  // Copies of leave_q and of the reset for this queue alone: `keep` keeps them.
  (* keep, dont_merge, syn_preserve = 1 *) reg @{ n.name }@_leave_q = 1'b0;
  (* keep *) always @(posedge clk_i) @{ n.name }@_leave_q <= leave;
  (* keep, dont_merge, syn_preserve = 1 *) reg @{ n.name }@_rst_q2 = 1'b1;
  (* keep *) always @(posedge clk_i) @{ n.name }@_rst_q2 <= ~rst_ni;
  @{ prefix }@__hwg_queue #(
    .WIDTH(@{ n.fifo_width }@),
    .DEPTH(@{ fifo_depth }@)
  ) u_@{ n.name }@_answers (
    .clk_i   (clk_i),
    .rst_i   (@{ n.name }@_rst_q2),
    .valid_i (@{ n.last }@_start[0]),
    .ready_o (unused_@{ n.name }@_ready),
    .data_i  ({@{ n.last }@_clipped, @{ n.last }@_vector}),
    .valid_o (unused_@{ n.name }@_valid),
    .ready_i (@{ n.name }@_leave_q),
    .data_o  ({@{ n.name }@_saturated, @{ n.name }@_answer})
  );

  // How many they are is counted beside the decision, which so need not ask the queue.
  wire @{ n.known_range }@ unused_@{ n.name }@_count;
  wire unused_@{ n.name }@_known;
  wire unused_@{ n.name }@_more;
  wire @{ n.name }@_known_next;
  @{ prefix }@__hwg_count #(
    .MOST(@{ fifo_depth }@)
  ) u_@{ n.name }@_known (
    .clk_i      (clk_i),
    .rst_i      (rst_q2),
    .up_i       (@{ n.last }@_start[1]),
    .down_i     (leave_q),
    .count_o    (unused_@{ n.name }@_count),
    .some_o     (unused_@{ n.name }@_known),
    .more_o     (unused_@{ n.name }@_more),
    .some_next_o(@{ n.name }@_known_next)
  );
@% endfor %@
  // A frame leaves when all networks have answered.
  assign may_leave     = @% for n in networks %@@% if !loop.first %@ & @% endif %@@{ n.name }@_known_next@% endfor %@;
  assign take_next_o   = may_start;
  assign frame_next_o  = leave;
  assign saturated_o   = clipped@% for n in networks %@ | @{ n.name }@_saturated@% endfor %@;
  genvar i;
  generate
@% for n in networks %@    for (i = 0; i < @{ n.words }@; i = i + 1) begin : g_@{ n.name }@
      assign frame_o[(@{ n.first }@+i)*@{ lane_bits }@ +: @{ lane_bits }@] =
        {{@{ n.signs }@{@{ n.name }@_answer[i*@{ n.width }@+@{ n.width - 1 }@]}}, @{ n.name }@_answer[i*@{ n.width }@ +: @{ n.width - 1 }@]};
    end
@% endfor %@  endgenerate
endmodule

`default_nettype wire
