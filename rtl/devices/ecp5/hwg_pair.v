// SPDX-License-Identifier: MIT OR Apache-2.0
// hwg_pair: a word times two bits in one carry chain of an ECP5.
//
// Function:  p_o = a_i * b_i, unsigned and exact. The tables of the chain take both words and the
//            bits that let them through, for which synthesis takes tables of their own.
// Latency:   none.
// Overflow:  impossible: the product has WIDTH + 2 bits.
`default_nettype none

module hwg_pair #(
  parameter integer WIDTH = 8
) (
  input  wire [WIDTH-1:0] a_i,
  input  wire [1:0]       b_i,
  output wire [WIDTH+1:0] p_o
);
  localparam integer CELLS = (WIDTH + 3) / 2;  // two bits each

  // verilator lint_off UNUSED
  // The product has no carry, and an even number of bits is summed.
  wire [CELLS:0]     carry;
  wire [2*CELLS-1:0] sum;
  // verilator lint_on UNUSED
  wire [2*CELLS:0]   a = {{(2*CELLS-WIDTH){1'b0}}, a_i, 1'b0};  // bit k + 1 is bit k of a_i
  assign carry[0] = 1'b0;

  genvar i;
  generate
    for (i = 0; i < CELLS; i = i + 1) begin : g_cell
      // A & B of the word, C & D of the word moved up: their sum without carry, and where C is none, the
      // carry that they bring forth.
      CCU2C #(
        .INIT0    (16'h7888),
        .INIT1    (16'h7888),
        .INJECT1_0("NO"),
        .INJECT1_1("NO")
      ) u_cell (
        .CIN(carry[i]),
        .A0(a[2*i+1]), .B0(b_i[0]), .C0(a[2*i]),   .D0(b_i[1]), .S0(sum[2*i]),
        .A1(a[2*i+2]), .B1(b_i[0]), .C1(a[2*i+1]), .D1(b_i[1]), .S1(sum[2*i+1]),
        .COUT(carry[i+1])
      );
    end
  endgenerate

  assign p_o = sum[WIDTH+1:0];
endmodule

`default_nettype wire
