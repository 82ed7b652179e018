// SPDX-License-Identifier: MIT OR Apache-2.0
// MULT18X18: what hwg_mul uses of the Nexus's multiplier, for simulation alone.
//
// Function:  Z = A * B, 18 bits times 18 bits, signed or unsigned by SIGNEDA and SIGNEDB.
// Registers: at both operands, their signs with them, and at the output.
// Left out:  enables and resets, all tied off by hwg_mul; another setting of a pin or parameter ends
//            the simulation.
// Source:    Lattice FPGA-TN-02096, sysDSP usage guide for Nexus platform.
`ifndef HWGEN_NEXUS_MULT18X18  // the bundles of other designs have the same file
`define HWGEN_NEXUS_MULT18X18
`default_nettype none

module MULT18X18 #(
  parameter REGINPUTA = "BYPASS",
  parameter REGINPUTB = "BYPASS",
  parameter REGOUTPUT = "BYPASS"
) (
  // verilator lint_off UNUSED
  // Tied off by hwg_mul.
  input  wire        CEA, CEB, CEOUT,
  input  wire        RSTA, RSTB, RSTOUT,
  // verilator lint_on UNUSED
  input  wire        CLK,
  input  wire [17:0] A, B,
  input  wire        SIGNEDA, SIGNEDB,
  output wire [35:0] Z
);
  // One bit more tells signed from unsigned.
  reg signed [18:0] a_q = 19'b0;
  reg signed [18:0] b_q = 19'b0;
  reg        [35:0] z_q = 36'b0;

  // verilator lint_off UNUSED
  // The product of two words of 18 bits has 36.
  wire signed [37:0] product = a_q * b_q;
  // verilator lint_on UNUSED

  always @(posedge CLK) begin
    a_q <= {SIGNEDA & A[17], A};
    b_q <= {SIGNEDB & B[17], B};
    z_q <= product[35:0];
  end

  // A pin that is tied in another way would change what the block does: none of that is modelled.
  always @(posedge CLK) begin
    if ({CEA, CEB, CEOUT} !== {3{1'b1}}) begin
      $display("hwgen: block %m: expected ones at CEA CEB CEOUT, found %b",
               {CEA, CEB, CEOUT});
      $finish;
    end
    if ({RSTA, RSTB, RSTOUT} !== {3{1'b0}}) begin
      $display("hwgen: block %m: expected zeros at RSTA RSTB RSTOUT, found %b",
               {RSTA, RSTB, RSTOUT});
      $finish;
    end
  end

  initial begin
    if (REGINPUTA != "REGISTER" || REGINPUTB != "REGISTER" || REGOUTPUT != "REGISTER") begin
      $display("hwgen: block %m: expected registers at operands and product, found none");
      $finish;
    end
  end

  assign Z = z_q;
endmodule

`default_nettype wire
`endif
