// SPDX-License-Identifier: MIT OR Apache-2.0
// SB_MAC16: what hwg_mul uses of the iCE40 UltraPlus's multiplier, for simulation alone.
//
// Function:  O = A * B, 16 bits times 16 bits, signed or unsigned by A_SIGNED and B_SIGNED.
// Registers: at both operands (A_REG, B_REG), behind the product (PIPELINE_16x16_MULT_REG2), and at the
//            output, from the adder to which product and constants C and D go.
// Left out:  the other multiplications, accumulation, carries, holds, loads, enables and resets, all
//            tied off by hwg_mul; another setting of a pin or parameter ends the simulation.
// Source:    Lattice FPGA-TN-02007, DSP function usage guide for iCE40 devices.
`ifndef HWGEN_ICE40_SB_MAC16  // the bundles of other designs have the same file
`define HWGEN_ICE40_SB_MAC16
`default_nettype none

module SB_MAC16 #(
  parameter [0:0] A_REG                    = 1'b0,
  parameter [0:0] B_REG                    = 1'b0,
  parameter [0:0] PIPELINE_16x16_MULT_REG2 = 1'b0,
  parameter [1:0] TOPOUTPUT_SELECT         = 2'd0,
  parameter [1:0] TOPADDSUB_LOWERINPUT     = 2'd0,
  parameter [0:0] TOPADDSUB_UPPERINPUT     = 1'b0,
  parameter [1:0] BOTOUTPUT_SELECT         = 2'd0,
  parameter [1:0] BOTADDSUB_LOWERINPUT     = 2'd0,
  parameter [0:0] BOTADDSUB_UPPERINPUT     = 1'b0,
  parameter [0:0] A_SIGNED                 = 1'b0,
  parameter [0:0] B_SIGNED                 = 1'b0
) (
  // verilator lint_off UNUSED
  // Tied off by hwg_mul.
  input  wire        CE,
  input  wire        AHOLD, BHOLD, CHOLD, DHOLD,
  input  wire        IRSTTOP, IRSTBOT, ORSTTOP, ORSTBOT,
  input  wire        OLOADTOP, OLOADBOT, ADDSUBTOP, ADDSUBBOT,
  input  wire        OHOLDTOP, OHOLDBOT, CI, ACCUMCI, SIGNEXTIN,
  // verilator lint_on UNUSED
  input  wire        CLK,
  input  wire [15:0] A, B, C, D,
  output wire [31:0] O,
  output wire        CO, ACCUMCO, SIGNEXTOUT
);
  reg [15:0] a_q = 16'b0;
  reg [15:0] b_q = 16'b0;
  reg [31:0] p_q = 32'b0;
  reg [15:0] top_q = 16'b0;
  reg [15:0] bottom_q = 16'b0;

  // One bit more tells signed from unsigned.
  wire signed [16:0] a_value = {A_SIGNED & a_q[15], a_q};
  wire signed [16:0] b_value = {B_SIGNED & b_q[15], b_q};
  // verilator lint_off UNUSED
  // The product of two words of 16 bits has 32.
  wire signed [33:0] product = a_value * b_value;
  // verilator lint_on UNUSED

  // The two halves of the adder, with no carry between them.
  always @(posedge CLK) begin
    a_q      <= A;
    b_q      <= B;
    p_q      <= product[31:0];
    top_q    <= p_q[31:16] + C;
    bottom_q <= p_q[15:0] + D;
  end

  // A pin that is tied in another way would change what the block does: none of that is modelled.
  always @(posedge CLK) begin
    if ({CE} !== {1{1'b1}}) begin
      $display("hwgen: block %m: expected ones at CE, found %b",
               {CE});
      $finish;
    end
    if ({AHOLD, BHOLD, CHOLD, DHOLD, IRSTTOP, IRSTBOT, ORSTTOP, ORSTBOT, OLOADTOP, OLOADBOT,
         ADDSUBTOP, ADDSUBBOT, OHOLDTOP, OHOLDBOT, CI, ACCUMCI, SIGNEXTIN, C, D} !== {49{1'b0}}) begin
      $display("hwgen: block %m: expected zeros at AHOLD BHOLD CHOLD DHOLD IRSTTOP IRSTBOT ORSTTOP ORSTBOT OLOADTOP OLOADBOT ADDSUBTOP ADDSUBBOT OHOLDTOP OHOLDBOT CI ACCUMCI SIGNEXTIN C D, found %b",
               {AHOLD, BHOLD, CHOLD, DHOLD, IRSTTOP, IRSTBOT, ORSTTOP, ORSTBOT, OLOADTOP, OLOADBOT,
                ADDSUBTOP, ADDSUBBOT, OHOLDTOP, OHOLDBOT, CI, ACCUMCI, SIGNEXTIN, C, D});
      $finish;
    end
  end

  initial begin
    if (!(A_REG && B_REG && PIPELINE_16x16_MULT_REG2
          && TOPOUTPUT_SELECT == 2'd1 && TOPADDSUB_LOWERINPUT == 2'd2 && TOPADDSUB_UPPERINPUT
          && BOTOUTPUT_SELECT == 2'd1 && BOTADDSUB_LOWERINPUT == 2'd2 && BOTADDSUB_UPPERINPUT)) begin
      $display("hwgen: block %m: expected the parameters of hwg_mul, found others");
      $finish;
    end
  end

  assign O          = {top_q, bottom_q};
  assign CO         = 1'b0;
  assign ACCUMCO    = 1'b0;
  assign SIGNEXTOUT = 1'b0;
endmodule

`default_nettype wire
`endif
