// SPDX-License-Identifier: MIT OR Apache-2.0
// @{ module }@: @{ purpose }@
//
// Function:  one output frame for each input frame, in order.
// Format:    s_axis: @{ source_words }@ words@{ x_format }@ in @{ source_lane }@-bit lanes, @{ source_per_beat }@ a beat, @{ source_beats }@ beats a frame:
@% for line in source_notes %@//              @{ line }@
@% endfor %@//            m_axis: @{ sink_words }@ words in @{ sink_lane }@-bit lanes, @{ sink_per_beat }@ a beat, @{ sink_beats }@ beats a frame:
@% for line in sink_notes %@//              @{ line }@
@% endfor %@//            A word is an integer; divided by 2^n it is the value in its unit (format Qm.n).
//            m_axis_tuser[0]: an input was outside of its bounds, or a word inside was clipped;
//            m_axis_tuser[1]: the input frame was too short or too long.
// Latency:   @{ latency }@ clocks from the edge that takes the first input beat to the edge that hands over
//            the last output beat; a frame every @{ interval }@ clocks.
// Overflow:  no sum can overflow; words are clipped, and say so in m_axis_tuser[0].
// Reset:     aresetn is synchronous and active low, and drops the frames under way.
@% for line in reset_notes %@//            @{ line }@
@% endfor %@// Model:     hwgen: sim/src/model.rs
// Bench:     tb/@{ module }@_tb.v
// @{ provenance }@
`default_nettype none

module @{ module }@ (
  input  wire aclk,
  input  wire aresetn,
  input  wire @{ source_range }@ s_axis_tdata,
  input  wire s_axis_tvalid,
  output wire s_axis_tready,
  input  wire s_axis_tlast,
  output wire @{ sink_range }@ m_axis_tdata,
  output wire m_axis_tvalid,
  input  wire m_axis_tready,
  output wire m_axis_tlast,
  output wire @{ user_range }@ m_axis_tuser
);
  // The box that inputs are clipped to, the last word first.
  localparam @{ box_range }@ LOW = {
@% for word in low %@    @{ word }@
@% endfor %@  };
  localparam @{ box_range }@ HIGH = {
@% for word in high %@    @{ word }@
@% endfor %@  };

  // The reset goes out in two steps, by a register of its own to copies near to what they reset.
  reg rst_nq = 1'b0;
  (* keep, dont_merge, syn_preserve = 1 *) reg ingress_rst_q2 = 1'b1;
  (* keep, dont_merge, syn_preserve = 1 *) reg egress_rst_q2  = 1'b1;
  always @(posedge aclk) rst_nq <= aresetn;
  (* keep *) always @(posedge aclk) ingress_rst_q2 <= ~rst_nq;
  (* keep *) always @(posedge aclk) egress_rst_q2  <= ~rst_nq;

  // Until then no beat is exchanged: both streams are quiet from the edge that samples aresetn low.
  wire quiet = ~(aresetn & rst_nq);

  wire in_next;
  wire in_take;
  wire in_clipped;
  wire in_error;
  wire @{ box_range }@ in_frame;
  @{ prefix }@__hwg_ingress #(
    .WORDS     (@{ source_words }@),
    .BEAT_WORDS(@{ source_per_beat }@),
    .LANE_WIDTH(@{ source_lane }@),
    .WIDTH     (@{ x_width }@)
  ) u_ingress (
    .clk_i        (aclk),
    .rst_i        (ingress_rst_q2),
    .quiet_i      (quiet),
    .tvalid_i     (s_axis_tvalid),
    .tready_o     (s_axis_tready),
    .tlast_i      (s_axis_tlast),
    .tdata_i      (s_axis_tdata),
    .low_i        (LOW),
    .high_i       (HIGH),
    .frame_next_o (in_next),
    .take_next_i  (in_take),
    .frame_o      (in_frame),
    .clipped_o    (in_clipped),
    .error_o      (in_error)
  );

  wire out_next;
  wire out_room;
  wire out_saturated;
  wire out_error;
  wire @{ out_range }@ out_frame;
  @{ prefix }@__mlp u_mlp (
    .clk_i        (aclk),
    .rst_ni       (rst_nq),
    .frame_next_i (in_next),
    .take_next_o  (in_take),
    .frame_i      (in_frame),
    .clipped_i    (in_clipped),
    .error_i      (in_error),
    .room_next_i  (out_room),
    .frame_next_o (out_next),
    .frame_o      (out_frame),
    .saturated_o  (out_saturated),
    .error_o      (out_error)
  );

  @{ prefix }@__hwg_egress #(
    .WORDS     (@{ sink_words }@),
    .BEAT_WORDS(@{ sink_per_beat }@),
    .LANE_WIDTH(@{ sink_lane }@),
    .EAGER     (@{ sink_eager }@)
  ) u_egress (
    .clk_i        (aclk),
    .rst_i        (egress_rst_q2),
    .quiet_i      (quiet),
    .room_next_o  (out_room),
    .frame_next_i (out_next),
    .frame_i      (out_frame),
    .saturated_i  (out_saturated),
    .error_i      (out_error),
    .tvalid_o     (m_axis_tvalid),
    .tready_i     (m_axis_tready),
    .tlast_o      (m_axis_tlast),
    .tuser_o      (m_axis_tuser),
    .tdata_o      (m_axis_tdata)
  );
endmodule

`default_nettype wire
