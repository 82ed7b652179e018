// SPDX-License-Identifier: MIT OR Apache-2.0
// hwg_mul: signed multiplier in a DSP block of a Gowin GW2A, with the block's own registers.
//
// Function:  p_o = a_i * b_i, exact.
// Latency:   3 clocks, one product a clock: the block's input, pipeline and output registers. Synthesis
//            moves no register of ours into the block, which is why it is instantiated.
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
  wire [A_WIDTH+B_WIDTH-1:0] r_q;  // the last register, whoever holds it; the block shows no other

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
        .AREG    (1'b1),
        .BREG    (1'b1),
        .PIPE_REG(1'b1),
        .OUT_REG (1'b1)
      ) u_block (
        .CLK(clk_i), .CE(1'b1), .RESET(1'b0),
        .A(a), .B(b), .ASIGN(1'b1), .BSIGN(1'b1), .DOUT(p),
        // Operands come from the fabric, not from a block beside it.
        .ASEL(1'b0), .BSEL(1'b0), .SIA(18'b0), .SIB(18'b0),
        // verilator lint_off PINCONNECTEMPTY
        .SOA(), .SOB()
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
