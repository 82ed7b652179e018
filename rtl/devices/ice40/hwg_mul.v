// SPDX-License-Identifier: MIT OR Apache-2.0
// hwg_mul: signed multiplier in a DSP block of an iCE40 UltraPlus, with the block's own registers.
//
// Function:  p_o = a_i * b_i, exact.
// Latency:   3 clocks, one product a clock: the block's input, pipeline and output registers. Synthesis
//            moves no register of ours into the block, which is why it is instantiated.
// Operands:  up to 16 bits fill one SB_MAC16; wider ones are left to synthesis.
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
  wire [A_WIDTH+B_WIDTH-1:0] r_q;  // the last register, whoever holds it; the block shows no other

  generate
    if (A_WIDTH <= 16 && B_WIDTH <= 16) begin : g_block
      // Bits above the operands' are copies of the sign.
      wire [15:0] a = {{(17-A_WIDTH){a_i[A_WIDTH-1]}}, a_i[A_WIDTH-2:0]};
      wire [15:0] b = {{(17-B_WIDTH){b_i[B_WIDTH-1]}}, b_i[B_WIDTH-2:0]};
      // verilator lint_off UNUSED
      // Bits above the product's are copies of its sign.
      wire [31:0] p;
      // verilator lint_on UNUSED

      // A and B are registered, then their product, then the sum of the product and zero in the
      // block's adder, from which the output registers are fed.
      SB_MAC16 #(
        .A_REG                   (1'b1),
        .B_REG                   (1'b1),
        .PIPELINE_16x16_MULT_REG2(1'b1),
        .TOPOUTPUT_SELECT        (2'd1),
        .TOPADDSUB_LOWERINPUT    (2'd2),
        .TOPADDSUB_UPPERINPUT    (1'b1),
        .BOTOUTPUT_SELECT        (2'd1),
        .BOTADDSUB_LOWERINPUT    (2'd2),
        .BOTADDSUB_UPPERINPUT    (1'b1),
        .A_SIGNED                (1'b1),
        .B_SIGNED                (1'b1)
      ) u_block (
        .CLK(clk_i), .CE(1'b1),
        .A(a), .B(b), .C(16'b0), .D(16'b0), .O(p),
        .AHOLD(1'b0), .BHOLD(1'b0), .CHOLD(1'b0), .DHOLD(1'b0),
        .IRSTTOP(1'b0), .IRSTBOT(1'b0), .ORSTTOP(1'b0), .ORSTBOT(1'b0),
        .OLOADTOP(1'b0), .OLOADBOT(1'b0), .ADDSUBTOP(1'b0), .ADDSUBBOT(1'b0),
        .OHOLDTOP(1'b0), .OHOLDBOT(1'b0), .CI(1'b0), .ACCUMCI(1'b0), .SIGNEXTIN(1'b0),
        // verilator lint_off PINCONNECTEMPTY
        // Carry and sign to a block above: there is none.
        .CO(), .ACCUMCO(), .SIGNEXTOUT()
        // verilator lint_on PINCONNECTEMPTY
      );

      assign r_q = p[A_WIDTH+B_WIDTH-1:0];
    end else begin : g_wide
      reg signed [A_WIDTH-1:0]         a_r = {A_WIDTH{1'b0}};
      reg signed [B_WIDTH-1:0]         b_r = {B_WIDTH{1'b0}};
      reg signed [A_WIDTH+B_WIDTH-1:0] p_r = {(A_WIDTH+B_WIDTH){1'b0}};
      reg signed [A_WIDTH+B_WIDTH-1:0] r_r = {(A_WIDTH+B_WIDTH){1'b0}};

      always @(posedge clk_i) begin
        a_r <= a_i;
        b_r <= b_i;
        p_r <= a_r * b_r;
        r_r <= p_r;
      end

      assign r_q = r_r;
    end
  endgenerate

  assign p_o = r_q;
endmodule

`default_nettype wire
