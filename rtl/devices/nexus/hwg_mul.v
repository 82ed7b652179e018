// SPDX-License-Identifier: MIT OR Apache-2.0
// hwg_mul: signed multiplier in a DSP block of a Nexus, with the block's own registers.
//
// Function:  p_o = a_i * b_i, exact.
// Latency:   3 clocks, one product a clock: the block's input and output registers, and one outside, on
//            the way to the adders. Synthesis moves no register of ours into the block, which is why it
//            is instantiated.
// Operands:  up to 18 bits fill one MULT18X18; wider ones are left to synthesis.
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
  wire [A_WIDTH+B_WIDTH-1:0] p_q;  // the register before the last, whoever holds it
  reg  [A_WIDTH+B_WIDTH-1:0] r_q = {(A_WIDTH+B_WIDTH){1'b0}};

  generate
    if (A_WIDTH <= 18 && B_WIDTH <= 18) begin : g_block
      // Bits above the operands' are copies of the sign.
      wire [17:0] a = {{(19-A_WIDTH){a_i[A_WIDTH-1]}}, a_i[A_WIDTH-2:0]};
      wire [17:0] b = {{(19-B_WIDTH){b_i[B_WIDTH-1]}}, b_i[B_WIDTH-2:0]};
      // verilator lint_off UNUSED
      // Bits above the product's are copies of its sign.
      wire [35:0] p;
      // verilator lint_on UNUSED

      MULT18X18 #(
        .REGINPUTA("REGISTER"),
        .REGINPUTB("REGISTER"),
        .REGOUTPUT("REGISTER")
      ) u_block (
        .CLK(clk_i), .A(a), .B(b), .SIGNEDA(1'b1), .SIGNEDB(1'b1), .Z(p),
        .CEA(1'b1), .CEB(1'b1), .CEOUT(1'b1),
        .RSTA(1'b0), .RSTB(1'b0), .RSTOUT(1'b0)
      );

      assign p_q = p[A_WIDTH+B_WIDTH-1:0];
    end else begin : g_wide
      reg signed [A_WIDTH-1:0]         a_r = {A_WIDTH{1'b0}};
      reg signed [B_WIDTH-1:0]         b_r = {B_WIDTH{1'b0}};
      reg signed [A_WIDTH+B_WIDTH-1:0] p_r = {(A_WIDTH+B_WIDTH){1'b0}};

      always @(posedge clk_i) begin
        a_r <= a_i;
        b_r <= b_i;
        p_r <= a_r * b_r;
      end

      assign p_q = p_r;
    end
  endgenerate

  always @(posedge clk_i) r_q <= p_q;

  assign p_o = r_q;
endmodule

`default_nettype wire
