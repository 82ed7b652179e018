// SPDX-License-Identifier: MIT OR Apache-2.0
// hwg_mul: signed multiplier in a DSP block of an ECP5, with the block's own registers.
//
// Function:  p_o = a_i * b_i, exact.
// Latency:   3 clocks, one product a clock: the block's input and output registers, and one outside, for
//            the blocks stand far from each other and from the adders. Synthesis moves no register
//            of ours into the block, which is why it is instantiated.
// Operands:  up to 18 bits fill one MULT18X18D; wider ones are left to synthesis.
// Overflow:  impossible: the product has A_WIDTH + B_WIDTH bits.
// Reset:     none; the block's registers are 0 after configuration.
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
  // The registers, whoever holds them: those of a block are seen at its outputs.
  // verilator lint_off UNUSED
  wire [A_WIDTH-1:0]         a_q;
  wire [B_WIDTH-1:0]         b_q;
  wire [A_WIDTH+B_WIDTH-1:0] p_q;
  // verilator lint_on UNUSED
  reg  [A_WIDTH+B_WIDTH-1:0] r_q = {(A_WIDTH+B_WIDTH){1'b0}};

  generate
    if (A_WIDTH <= 18 && B_WIDTH <= 18) begin : g_block
      // verilator lint_off UNUSED
      // Bits above the operands' and the product's are copies of the sign.
      wire [17:0] a;
      wire [17:0] b;
      wire [17:0] a_held;
      wire [17:0] b_held;
      wire [35:0] p;
      // verilator lint_on UNUSED

      assign a   = {{(19-A_WIDTH){a_i[A_WIDTH-1]}}, a_i[A_WIDTH-2:0]};
      assign b   = {{(19-B_WIDTH){b_i[B_WIDTH-1]}}, b_i[B_WIDTH-2:0]};
      assign a_q = a_held[A_WIDTH-1:0];
      assign b_q = b_held[B_WIDTH-1:0];
      assign p_q = p[A_WIDTH+B_WIDTH-1:0];

      MULT18X18D #(
        .REG_INPUTA_CLK("CLK0"),
        .REG_INPUTB_CLK("CLK0"),
        .REG_OUTPUT_CLK("CLK0")
      ) u_block (
        .CLK0(clk_i), .CLK1(1'b0), .CLK2(1'b0), .CLK3(1'b0),
        .CE0(1'b1), .CE1(1'b1), .CE2(1'b1), .CE3(1'b1),
        .RST0(1'b0), .RST1(1'b0), .RST2(1'b0), .RST3(1'b0),
        .SIGNEDA(1'b1), .SIGNEDB(1'b1), .SOURCEA(1'b0), .SOURCEB(1'b0),
        .A0(a[0]), .A1(a[1]), .A2(a[2]), .A3(a[3]), .A4(a[4]), .A5(a[5]),
        .A6(a[6]), .A7(a[7]), .A8(a[8]), .A9(a[9]), .A10(a[10]), .A11(a[11]),
        .A12(a[12]), .A13(a[13]), .A14(a[14]), .A15(a[15]), .A16(a[16]), .A17(a[17]),
        .B0(b[0]), .B1(b[1]), .B2(b[2]), .B3(b[3]), .B4(b[4]), .B5(b[5]),
        .B6(b[6]), .B7(b[7]), .B8(b[8]), .B9(b[9]), .B10(b[10]), .B11(b[11]),
        .B12(b[12]), .B13(b[13]), .B14(b[14]), .B15(b[15]), .B16(b[16]), .B17(b[17]),
        .C0(1'b0), .C1(1'b0), .C2(1'b0), .C3(1'b0), .C4(1'b0), .C5(1'b0),
        .C6(1'b0), .C7(1'b0), .C8(1'b0), .C9(1'b0), .C10(1'b0), .C11(1'b0),
        .C12(1'b0), .C13(1'b0), .C14(1'b0), .C15(1'b0), .C16(1'b0), .C17(1'b0),
        .ROA0(a_held[0]), .ROA1(a_held[1]), .ROA2(a_held[2]), .ROA3(a_held[3]), .ROA4(a_held[4]), .ROA5(a_held[5]),
        .ROA6(a_held[6]), .ROA7(a_held[7]), .ROA8(a_held[8]), .ROA9(a_held[9]), .ROA10(a_held[10]), .ROA11(a_held[11]),
        .ROA12(a_held[12]), .ROA13(a_held[13]), .ROA14(a_held[14]), .ROA15(a_held[15]), .ROA16(a_held[16]), .ROA17(a_held[17]),
        .ROB0(b_held[0]), .ROB1(b_held[1]), .ROB2(b_held[2]), .ROB3(b_held[3]), .ROB4(b_held[4]), .ROB5(b_held[5]),
        .ROB6(b_held[6]), .ROB7(b_held[7]), .ROB8(b_held[8]), .ROB9(b_held[9]), .ROB10(b_held[10]), .ROB11(b_held[11]),
        .ROB12(b_held[12]), .ROB13(b_held[13]), .ROB14(b_held[14]), .ROB15(b_held[15]), .ROB16(b_held[16]), .ROB17(b_held[17]),
        .P0(p[0]), .P1(p[1]), .P2(p[2]), .P3(p[3]), .P4(p[4]), .P5(p[5]),
        .P6(p[6]), .P7(p[7]), .P8(p[8]), .P9(p[9]), .P10(p[10]), .P11(p[11]),
        .P12(p[12]), .P13(p[13]), .P14(p[14]), .P15(p[15]), .P16(p[16]), .P17(p[17]),
        .P18(p[18]), .P19(p[19]), .P20(p[20]), .P21(p[21]), .P22(p[22]), .P23(p[23]),
        .P24(p[24]), .P25(p[25]), .P26(p[26]), .P27(p[27]), .P28(p[28]), .P29(p[29]),
        .P30(p[30]), .P31(p[31]), .P32(p[32]), .P33(p[33]), .P34(p[34]), .P35(p[35])
      );
    end else begin : g_wide
      reg signed [A_WIDTH-1:0]         a_r = {A_WIDTH{1'b0}};
      reg signed [B_WIDTH-1:0]         b_r = {B_WIDTH{1'b0}};
      reg signed [A_WIDTH+B_WIDTH-1:0] p_r = {(A_WIDTH+B_WIDTH){1'b0}};

      always @(posedge clk_i) begin
        a_r <= a_i;
        b_r <= b_i;
        p_r <= a_r * b_r;
      end

      assign a_q = a_r;
      assign b_q = b_r;
      assign p_q = p_r;
    end
  endgenerate

  always @(posedge clk_i) r_q <= p_q;

  assign p_o = r_q;
endmodule

`default_nettype wire
