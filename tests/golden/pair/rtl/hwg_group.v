// SPDX-License-Identifier: MIT OR Apache-2.0
// hwg_group: tells when a group's accumulators are done.
//
// Function:  done_o follows the last word of a group; flag_o is the OR of the group's flags.
// Latency:   2 clocks, those of the control bits' copies and of the accumulators.
// Reset:     no group is done.
// Model:     hwgen: sim/src/model/array.rs, Group
`default_nettype none

module hwg_group (
  input  wire clk_i,
  input  wire rst_i,
  input  wire valid_i,
  input  wire first_i,
  input  wire last_i,
  input  wire flag_i,
  output wire done_o,
  output wire flag_o
);
  reg done_q  = 1'b0;
  reg done_q2 = 1'b0;
  reg flag_q  = 1'b0;
  reg flag_q2 = 1'b0;

  always @(posedge clk_i) begin
    if (rst_i) begin
      done_q  <= 1'b0;
      done_q2 <= 1'b0;
    end else begin
      done_q  <= valid_i & last_i;
      done_q2 <= done_q;
    end
  end

  always @(posedge clk_i) begin
    if (valid_i) flag_q <= (flag_q & ~first_i) | flag_i;
    flag_q2 <= flag_q;
  end

  assign done_o = done_q2;
  assign flag_o = flag_q2;
endmodule

`default_nettype wire
