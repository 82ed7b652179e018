// SPDX-License-Identifier: MIT OR Apache-2.0
// CCU2C: simulation model of two bits of a carry chain of an ECP5.
//
// Function:  each half is a table of four inputs, whose sum with the carry comes out; the carry goes on
//            where the table is one, else it is what the lowest four words of the table say of A and B.
//            Cells that inject a one are not modelled.
// Source:    Lattice FPGA-DS-02012, section 2.2, slices in ripple mode; equal to Yosys' model of it
//            (hwgen: tests/blocks.rs).
`ifndef HWGEN_ECP5_CCU2C  // the bundles of other designs have the same file
`define HWGEN_ECP5_CCU2C
`default_nettype none

module CCU2C #(
  parameter [15:0] INIT0     = 16'h0000,
  parameter [15:0] INIT1     = 16'h0000,
  parameter        INJECT1_0 = "NO",
  parameter        INJECT1_1 = "NO"
) (
  input  wire CIN,
  input  wire A0, B0, C0, D0,
  input  wire A1, B1, C1, D1,
  output wire S0, S1, COUT
);
  // Constants that say what is not modelled.
  initial begin
    if (INJECT1_0 != "NO" || INJECT1_1 != "NO") begin
      $display("hwgen: block %m: expected a cell that injects no one, found one that does");
      $finish;
    end
  end

  wire table0    = INIT0[{D0, C0, B0, A0}];
  wire table1    = INIT1[{D1, C1, B1, A1}];
  wire generate0 = INIT0[{2'b00, B0, A0}];
  wire generate1 = INIT1[{2'b00, B1, A1}];
  wire carry     = table0 ? CIN : generate0;

  assign S0   = table0 ^ CIN;
  assign S1   = table1 ^ carry;
  assign COUT = table1 ? carry : generate1;
endmodule

`default_nettype wire
`endif
