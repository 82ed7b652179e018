// SPDX-License-Identifier: MIT OR Apache-2.0
// pair__hwg_group: tells when a group's accumulators are done.
//
// Function:  done_o follows the last word of a group, every bit of it alike, for readers that take many
//            sums at once; flag_o is the OR of the group's flags.
// Latency:   2 clocks, those of the control bits' copies and of the accumulators.
// Reset:     no group is done.
// Model:     hwgen: sim/src/model/array.rs, Group
`default_nettype none

module pair__hwg_group #(
  parameter integer COPIES = 1  // of done_o
) (
  input  wire              clk_i,
  input  wire              rst_i,
  input  wire              valid_i,
  input  wire              first_i,
  input  wire              last_i,
  input  wire              flag_i,
  output wire [COPIES-1:0] done_o,
  output wire              flag_o
);
  reg done_q  = 1'b0;
  reg flag_q  = 1'b0;
  reg flag_q2 = 1'b0;

  always @(posedge clk_i) done_q <= valid_i & last_i & ~rst_i;

  // Copies that drive a part of the readers' sums each: `keep` keeps them.
  genvar g;
  generate
    for (g = 0; g < COPIES; g = g + 1) begin : g_copy
      (* keep, dont_merge, syn_preserve = 1 *) reg done_q2 = 1'b0;
      (* keep *) always @(posedge clk_i) done_q2 <= done_q & ~rst_i;
      assign done_o[g] = done_q2;
    end
  endgenerate

  always @(posedge clk_i) begin
    if (valid_i) flag_q <= (flag_q & ~first_i) | flag_i;
    flag_q2 <= flag_q;
  end

  assign flag_o = flag_q2;
endmodule

`default_nettype wire
