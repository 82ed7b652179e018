// SPDX-License-Identifier: MIT OR Apache-2.0
// echo_pe: one signed register, deep in the hierarchy
`default_nettype none

module echo_pe (
    input wire              clk_i,
    input wire              rst_ni,
    input wire signed [7:0] word_i
);

  reg signed [7:0] acc_q;

  always @(posedge clk_i) begin
    if (!rst_ni) acc_q <= 8'sd0;
    else acc_q <= acc_q - word_i;
  end

endmodule

`default_nettype wire
