// SPDX-License-Identifier: MIT OR Apache-2.0
// echo_sums: a packed vector of running sums, and a register in each of some generated scopes
`default_nettype none

module echo_sums #(
    parameter integer LANES = 20  // 2 or more
) (
    input  wire                clk_i,
    input  wire                rst_ni,
    input  wire                take_i,
    input  wire [        15:0] word_i,
    output wire [LANES*24-1:0] sums_o
);

  reg [LANES*24-1:0] acc_q;
  integer i;

  assign sums_o = acc_q;

  always @(posedge clk_i) begin
    if (!rst_ni) begin
      acc_q <= {LANES * 24{1'b0}};
    end else if (take_i) begin
      for (i = 0; i < LANES; i = i + 1) begin
        acc_q[24*i+:24] <= acc_q[24*i+:24] + {{8{word_i[15]}}, word_i} * (i[23:0] + 24'd1);
      end
    end
  end

  genvar g;
  generate
    for (g = 0; g < 3; g = g + 1) begin : g_pe
      echo_pe u_pe (
          .clk_i (clk_i),
          .rst_ni(rst_ni),
          .word_i(word_i[4*g+:8])
      );
    end
  endgenerate

endmodule

`default_nettype wire
