// SPDX-License-Identifier: MIT OR Apache-2.0
// hwg_mul: signed multiplier in a DSP block of a Gowin GW2A, with the block's own registers.
//
// Function:  p_o = a_i * b_i, exact.
// Latency:   3 clocks, one product a clock: the block's input, pipeline and output registers, or the sum's
//            of several. Synthesis moves no register of ours into the block, which is why it is instantiated.
// Operands:  up to 18 bits fill one MULT18X18; of wider ones each 18 bits with each other fill one.
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
      // A block for each 18 bits of one operand with each of the other, of which the highest have the sign,
      // and their sum in the place of the output register.
      localparam integer A_PARTS = (A_WIDTH + 17) / 18;
      localparam integer B_PARTS = (B_WIDTH + 17) / 18;
      localparam integer TOTAL   = 18 * (A_PARTS + B_PARTS);
      wire [18*A_PARTS-1:0] a = {{(18*A_PARTS-A_WIDTH+1){a_i[A_WIDTH-1]}}, a_i[A_WIDTH-2:0]};
      wire [18*B_PARTS-1:0] b = {{(18*B_PARTS-B_WIDTH+1){b_i[B_WIDTH-1]}}, b_i[B_WIDTH-2:0]};
      wire [A_PARTS*B_PARTS*TOTAL-1:0] words;  // products in their places

      genvar i, j;
      for (i = 0; i < A_PARTS; i = i + 1) begin : g_a
        for (j = 0; j < B_PARTS; j = j + 1) begin : g_b
          localparam A_SIGN = i == A_PARTS - 1;
          localparam B_SIGN = j == B_PARTS - 1;
          wire [35:0] p;
          MULT18X18 #(
            .AREG    (1'b1),
            .BREG    (1'b1),
            .PIPE_REG(1'b1),
            .OUT_REG (1'b0)
          ) u_block (
            .CLK(clk_i), .CE(1'b1), .RESET(1'b0),
            .A(a[18*i +: 18]), .B(b[18*j +: 18]), .ASIGN(A_SIGN), .BSIGN(B_SIGN), .DOUT(p),
            .ASEL(1'b0), .BSEL(1'b0), .SIA(18'b0), .SIB(18'b0),
            // verilator lint_off PINCONNECTEMPTY
            .SOA(), .SOB()
            // verilator lint_on PINCONNECTEMPTY
          );
          wire sign = (A_SIGN | B_SIGN) & p[35];
          assign words[(i*B_PARTS+j)*TOTAL +: TOTAL] = {{(TOTAL-36){sign}}, p} << (18 * (i + j));
        end
      end

      // verilator lint_off UNUSED
      // Bits above the product's are copies of its sign.
      reg [TOTAL-1:0]           total;
      // verilator lint_on UNUSED
      reg [A_WIDTH+B_WIDTH-1:0] r_r = {(A_WIDTH+B_WIDTH){1'b0}};

      integer k;
      always @(*) begin
        total = {TOTAL{1'b0}};
        for (k = 0; k < A_PARTS * B_PARTS; k = k + 1) total = total + words[k*TOTAL +: TOTAL];
      end
      always @(posedge clk_i) r_r <= total[A_WIDTH+B_WIDTH-1:0];

      assign r_q = r_r;
    end
  endgenerate

  assign p_o = r_q;
endmodule

`default_nettype wire
