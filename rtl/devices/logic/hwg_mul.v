// SPDX-License-Identifier: MIT OR Apache-2.0
// hwg_mul: signed multiplier of adders, for devices without multipliers.
//
// Function:  p_o = a_i * b_i, exact: a times two bits of b, four bits of b, all of them. The highest bit
//            of b counts negative.
// Latency:   3 clocks, one product a clock: after each of these steps stands a register.
// Overflow:  impossible: the product has A_WIDTH + B_WIDTH bits.
// Reset:     none.
// Model:     hwgen: sim/src/model/array.rs, Array
`default_nettype none

module hwg_mul #(
  parameter integer A_WIDTH = 8,
  parameter integer B_WIDTH = 8
) (
  input  wire                              clk_i,
  input  wire signed [A_WIDTH-1:0]         a_i,
  input  wire signed [B_WIDTH-1:0]         b_i,
  output wire signed [A_WIDTH+B_WIDTH-1:0] p_o
);
  localparam integer PAIRS       = (B_WIDTH + 1) / 2;
  localparam integer QUADS       = (PAIRS + 1) / 2;
  localparam integer PAIR_WIDTH  = A_WIDTH + 2;
  localparam integer QUAD_WIDTH  = A_WIDTH + 4;
  localparam integer TOTAL_WIDTH = A_WIDTH + 4 * QUADS;

  // An odd bit is preceded by its copy.
  wire        [2*PAIRS-1:0]            b     = {{(2*PAIRS-B_WIDTH+1){b_i[B_WIDTH-1]}}, b_i[B_WIDTH-2:0]};
  wire signed [PAIR_WIDTH-1:0]         once  = {{2{a_i[A_WIDTH-1]}}, a_i};
  wire signed [PAIR_WIDTH-1:0]         twice = {a_i[A_WIDTH-1], a_i, 1'b0};
  reg signed  [A_WIDTH+B_WIDTH-1:0]    r_q = {(A_WIDTH+B_WIDTH){1'b0}};

  genvar i;
  generate
    for (i = 0; i < PAIRS; i = i + 1) begin : g_pair
      reg  signed [PAIR_WIDTH-1:0] sum_q = {PAIR_WIDTH{1'b0}};
      wire signed [PAIR_WIDTH-1:0] low   = b[2*i]   ? once  : {PAIR_WIDTH{1'b0}};
      wire signed [PAIR_WIDTH-1:0] high  = b[2*i+1] ? twice : {PAIR_WIDTH{1'b0}};
      if (i == PAIRS - 1) begin : g_sign
        always @(posedge clk_i) sum_q <= low - high;
      end else begin : g_plain
        always @(posedge clk_i) sum_q <= low + high;
      end
    end
    for (i = 0; i < QUADS; i = i + 1) begin : g_quad
      reg  signed [QUAD_WIDTH-1:0] sum_q = {QUAD_WIDTH{1'b0}};
      wire signed [PAIR_WIDTH-1:0] first = g_pair[2*i].sum_q;
      wire signed [QUAD_WIDTH-1:0] low   = {{2{first[PAIR_WIDTH-1]}}, first};
      wire signed [QUAD_WIDTH-1:0] high;
      if (2 * i + 1 < PAIRS) begin : g_high
        assign high = {g_pair[2*i+1].sum_q, 2'b0};
      end else begin : g_low_alone
        assign high = {QUAD_WIDTH{1'b0}};
      end
      always @(posedge clk_i) sum_q <= low + high;
      wire signed [TOTAL_WIDTH-1:0] word = {{(TOTAL_WIDTH-QUAD_WIDTH+1){sum_q[QUAD_WIDTH-1]}},
                                            sum_q[QUAD_WIDTH-2:0]};
      // verilator lint_off UNUSED
      // Bits above the product's are copies of its sign.
      wire signed [TOTAL_WIDTH-1:0] total;
      // verilator lint_on UNUSED
      if (i == 0) begin : g_first
        assign total = word;
      end else begin : g_next
        assign total = g_quad[i-1].total + (word <<< (4 * i));
      end
    end
  endgenerate

  always @(posedge clk_i) r_q <= g_quad[QUADS-1].total[A_WIDTH+B_WIDTH-1:0];

  assign p_o = r_q;
endmodule

`default_nettype wire
