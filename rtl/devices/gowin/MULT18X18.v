// SPDX-License-Identifier: MIT OR Apache-2.0
// MULT18X18: what hwg_mul uses of the GW2A's multiplier, for simulation, and a black box for synthesis.
//
// Function:  DOUT = A * B, 18 bits times 18 bits, signed or unsigned by ASIGN and BSIGN.
// Registers: at both operands, behind the multiplier and, with OUT_REG, at the output.
// Left out:  the enable, the reset and words from a block beside it, all tied off by hwg_mul; another
//            setting of a pin or parameter ends the simulation.
// Source:    Gowin UG287, Gowin DSP user guide, section 4.1.
`ifndef HWGEN_GOWIN_MULT18X18  // the bundles of other designs have the same file
`define HWGEN_GOWIN_MULT18X18
`default_nettype none

module MULT18X18 #(
  parameter AREG     = 1'b0,
  parameter BREG     = 1'b0,
  parameter PIPE_REG = 1'b0,
  parameter OUT_REG  = 1'b0
) (
  // verilator lint_off UNUSED
  // Tied off by hwg_mul.
  input  wire        CE, RESET, ASEL, BSEL,
  input  wire [17:0] SIA, SIB,
  // verilator lint_on UNUSED
  input  wire        CLK,
  input  wire [17:0] A, B,
  input  wire        ASIGN, BSIGN,
  output wire [35:0] DOUT,
  output wire [17:0] SOA, SOB
);
  // One bit more tells signed from unsigned.
  reg signed [18:0] a_q = 19'b0;
  reg signed [18:0] b_q = 19'b0;
  reg        [35:0] p_q = 36'b0;
  reg        [35:0] z_q = 36'b0;

  // verilator lint_off UNUSED
  // The product of two words of 18 bits has 36.
  wire signed [37:0] product = a_q * b_q;
  // verilator lint_on UNUSED

  always @(posedge CLK) begin
    a_q <= {ASIGN & A[17], A};
    b_q <= {BSIGN & B[17], B};
    p_q <= product[35:0];
    z_q <= p_q;
  end

`ifndef SYNTHESIS
  // A pin that is tied in another way would change what the block does: none of that is modelled.
  always @(posedge CLK) begin
    if ({CE} !== {1{1'b1}}) begin
      $display("hwgen: block %m: expected ones at CE, found %b",
               {CE});
      $finish;
    end
    if ({RESET, ASEL, BSEL, SIA, SIB} !== {39{1'b0}}) begin
      $display("hwgen: block %m: expected zeros at RESET ASEL BSEL SIA SIB, found %b",
               {RESET, ASEL, BSEL, SIA, SIB});
      $finish;
    end
  end

  initial begin
    if (!AREG || !BREG || !PIPE_REG) begin
      $display("hwgen: block %m: expected registers at operands and product, found none");
      $finish;
    end
  end
`endif

  assign DOUT = OUT_REG ? z_q : p_q;
  assign SOA  = a_q[17:0];
  assign SOB  = b_q[17:0];
endmodule

`default_nettype wire
`endif
