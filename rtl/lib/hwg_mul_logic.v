// SPDX-License-Identifier: MIT OR Apache-2.0
// hwg_mul_logic: unsigned multiplier of adders, for narrow operands whose blocks others need.
//
// Function:  p_o = a_i * b_i, exact: a times two bits of b, four bits of b, all of them.
// Latency:   3 clocks, one product a clock, as hwg_mul.
// Overflow:  impossible: the product has A_WIDTH + B_WIDTH bits.
// Reset:     none.
// Model:     hwgen: sim/src/model/finish.rs, Units
`default_nettype none

module hwg_mul_logic #(
  parameter integer A_WIDTH = 8,
  parameter integer B_WIDTH = 8
) (
  input  wire                       clk_i,
  input  wire [A_WIDTH-1:0]         a_i,
  input  wire [B_WIDTH-1:0]         b_i,
  output wire [A_WIDTH+B_WIDTH-1:0] p_o
);
  localparam integer PAIRS       = (B_WIDTH + 1) / 2;
  localparam integer QUADS       = (PAIRS + 1) / 2;
  localparam integer PAIR_WIDTH  = A_WIDTH + 2;
  localparam integer QUAD_WIDTH  = A_WIDTH + 4;
  localparam integer TOTAL_WIDTH = A_WIDTH + 4 * QUADS;

  wire [QUADS*QUAD_WIDTH-1:0] quads;

  genvar i;
  generate
    for (i = 0; i < PAIRS; i = i + 1) begin : g_pair
      reg  [PAIR_WIDTH-1:0] sum_q = {PAIR_WIDTH{1'b0}};
      wire [PAIR_WIDTH-1:0] sum;
      wire [1:0]            b;
      if (2 * i + 1 < B_WIDTH) begin : g_two
        assign b = b_i[2*i +: 2];
      end else begin : g_one
        assign b = {1'b0, b_i[2*i]};
      end
      hwg_pair #(
        .WIDTH(A_WIDTH)
      ) u_pair (
        .a_i(a_i),
        .b_i(b),
        .p_o(sum)
      );
      always @(posedge clk_i) sum_q <= sum;
    end
    for (i = 0; i < QUADS; i = i + 1) begin : g_quad
      reg  [QUAD_WIDTH-1:0] sum_q = {QUAD_WIDTH{1'b0}};
      wire [QUAD_WIDTH-1:0] low = {2'b0, g_pair[2*i].sum_q};
      wire [QUAD_WIDTH-1:0] high;
      if (2 * i + 1 < PAIRS) begin : g_high
        assign high = {g_pair[2*i+1].sum_q, 2'b0};
      end else begin : g_low_alone
        assign high = {QUAD_WIDTH{1'b0}};
      end
      always @(posedge clk_i) sum_q <= low + high;
      assign quads[i*QUAD_WIDTH +: QUAD_WIDTH] = sum_q;
    end
  endgenerate

  // verilator lint_off UNUSED
  // The bits above the product are zero.
  reg [TOTAL_WIDTH-1:0]     total;
  // verilator lint_on UNUSED
  reg [A_WIDTH+B_WIDTH-1:0] p_q = {(A_WIDTH+B_WIDTH){1'b0}};

  integer j;
  always @(*) begin
    total = {TOTAL_WIDTH{1'b0}};
    for (j = 0; j < QUADS; j = j + 1)
      total[4*j +: QUAD_WIDTH] = total[4*j +: QUAD_WIDTH] + quads[j*QUAD_WIDTH +: QUAD_WIDTH];
  end
  always @(posedge clk_i) p_q <= total[A_WIDTH+B_WIDTH-1:0];

  assign p_o = p_q;
endmodule

`default_nettype wire
