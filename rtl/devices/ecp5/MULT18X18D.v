// SPDX-License-Identifier: MIT OR Apache-2.0
// MULT18X18D: what hwg_mul uses of the ECP5's multiplier, for simulation alone.
//
// Function:  P = A * B, signed or unsigned by SIGNEDA and SIGNEDB; ROA and ROB show the operands.
// Registers: at both operands and at the product, each if its parameter names CLK0.
// Left out:  cascades, operand C, enables, resets, other clocks, all tied off by hwg_mul: one that is
//            tied otherwise ends the simulation, as a pipeline register does.
// Source:    Lattice FPGA-TN-02205, ECP5 and ECP5-5G sysDSP usage guide.
`ifndef HWGEN_ECP5_MULT18X18D  // the bundles of other designs have the same file
`define HWGEN_ECP5_MULT18X18D
`default_nettype none

module MULT18X18D #(
  parameter REG_INPUTA_CLK   = "NONE",
  parameter REG_INPUTB_CLK   = "NONE",
  parameter REG_PIPELINE_CLK = "NONE",
  parameter REG_OUTPUT_CLK   = "NONE"
) (
  // verilator lint_off UNUSED
  input  wire CLK0, CLK1, CLK2, CLK3,
  input  wire CE0, CE1, CE2, CE3,
  input  wire RST0, RST1, RST2, RST3,
  input  wire SIGNEDA, SIGNEDB, SOURCEA, SOURCEB,
  input  wire A0, A1, A2, A3, A4, A5, A6, A7, A8,
              A9, A10, A11, A12, A13, A14, A15, A16, A17,
  input  wire B0, B1, B2, B3, B4, B5, B6, B7, B8,
              B9, B10, B11, B12, B13, B14, B15, B16, B17,
  input  wire C0, C1, C2, C3, C4, C5, C6, C7, C8,
              C9, C10, C11, C12, C13, C14, C15, C16, C17,
  // verilator lint_on UNUSED
  output wire ROA0, ROA1, ROA2, ROA3, ROA4, ROA5, ROA6, ROA7, ROA8,
              ROA9, ROA10, ROA11, ROA12, ROA13, ROA14, ROA15, ROA16, ROA17,
  output wire ROB0, ROB1, ROB2, ROB3, ROB4, ROB5, ROB6, ROB7, ROB8,
              ROB9, ROB10, ROB11, ROB12, ROB13, ROB14, ROB15, ROB16, ROB17,
  output wire P0, P1, P2, P3, P4, P5, P6, P7, P8,
              P9, P10, P11, P12, P13, P14, P15, P16, P17,
              P18, P19, P20, P21, P22, P23, P24, P25, P26,
              P27, P28, P29, P30, P31, P32, P33, P34, P35
);
  wire [17:0] a_now = {A17, A16, A15, A14, A13, A12, A11, A10, A9,
                      A8, A7, A6, A5, A4, A3, A2, A1, A0};
  wire [17:0] b_now = {B17, B16, B15, B14, B13, B12, B11, B10, B9,
                      B8, B7, B6, B5, B4, B3, B2, B1, B0};
  wire [17:0] a;
  wire [17:0] b;
  // One bit more tells signed from unsigned.
  wire signed [18:0] a_value = {SIGNEDA & a[17], a};
  wire signed [18:0] b_value = {SIGNEDB & b[17], b};
  // verilator lint_off UNUSED
  wire signed [37:0] product = a_value * b_value;
  // verilator lint_on UNUSED
  wire [35:0] p;

  generate
    if (REG_INPUTA_CLK == "CLK0") begin : g_a_registered
      reg [17:0] a_q = 18'b0;
      always @(posedge CLK0) a_q <= a_now;
      assign a = a_q;
    end else begin : g_a_open
      assign a = a_now;
    end
    if (REG_INPUTB_CLK == "CLK0") begin : g_b_registered
      reg [17:0] b_q = 18'b0;
      always @(posedge CLK0) b_q <= b_now;
      assign b = b_q;
    end else begin : g_b_open
      assign b = b_now;
    end
    if (REG_OUTPUT_CLK == "CLK0") begin : g_p_registered
      reg [35:0] p_q = 36'b0;
      always @(posedge CLK0) p_q <= product[35:0];
      assign p = p_q;
    end else begin : g_p_open
      assign p = product[35:0];
    end
  endgenerate

  // A pin that is tied in another way would change what the block does: none of that is modelled.
  always @(posedge CLK0) begin
    if ({CE0, CE1, CE2, CE3} !== {4{1'b1}}) begin
      $display("hwgen: block %m: expected ones at CE0 CE1 CE2 CE3, found %b",
               {CE0, CE1, CE2, CE3});
      $finish;
    end
    if ({RST0, RST1, RST2, RST3, SOURCEA, SOURCEB, CLK1, CLK2, CLK3, C0, C1, C2, C3, C4, C5,
         C6, C7, C8, C9, C10, C11, C12, C13, C14, C15, C16, C17} !== {27{1'b0}}) begin
      $display("hwgen: block %m: expected zeros at RST0 RST1 RST2 RST3 SOURCEA SOURCEB CLK1 CLK2 CLK3 C, found %b",
               {RST0, RST1, RST2, RST3, SOURCEA, SOURCEB, CLK1, CLK2, CLK3, C0, C1, C2, C3, C4, C5,
                C6, C7, C8, C9, C10, C11, C12, C13, C14, C15, C16, C17});
      $finish;
    end
  end

  initial begin
    if (REG_PIPELINE_CLK != "NONE") begin
      $display("hwgen: block %m: expected no pipeline register, found one at %s", REG_PIPELINE_CLK);
      $finish;
    end
  end

  assign {ROA17, ROA16, ROA15, ROA14, ROA13, ROA12, ROA11, ROA10, ROA9,
                      ROA8, ROA7, ROA6, ROA5, ROA4, ROA3, ROA2, ROA1, ROA0} = a;
  assign {ROB17, ROB16, ROB15, ROB14, ROB13, ROB12, ROB11, ROB10, ROB9,
                      ROB8, ROB7, ROB6, ROB5, ROB4, ROB3, ROB2, ROB1, ROB0} = b;
  assign {P35, P34, P33, P32, P31, P30, P29, P28, P27,
                      P26, P25, P24, P23, P22, P21, P20, P19, P18,
                      P17, P16, P15, P14, P13, P12, P11, P10, P9,
                      P8, P7, P6, P5, P4, P3, P2, P1, P0} = p;
endmodule

`default_nettype wire
`endif
