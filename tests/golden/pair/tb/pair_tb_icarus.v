// SPDX-License-Identifier: MIT OR Apache-2.0
// pair_tb_icarus: clock and dump around the replaying bench, for Icarus Verilog
//
// Function: rising edge k of the clock is at 5 ns + k * 10 ns. With +dump=FILE the
//           whole core is dumped; the format (VCD, FST) is an option of vvp.
//           For Verilator sim_main.cpp does the same.
`default_nettype none
`timescale 1ns / 1ps

module pair_tb_icarus;

  reg clk = 1'b0;
  reg [8*1024-1:0] path = {8 * 1024{1'b0}};

  always #5 clk <= ~clk;

  initial begin
    if ($value$plusargs("dump=%s", path) != 0) begin
      $dumpfile(path);
      $dumpvars(0, u_tb.u_dut);
      $dumpvars(0, u_tb.nonce_q);
    end
  end

  pair_tb u_tb (.clk_i(clk));

endmodule

`default_nettype wire
