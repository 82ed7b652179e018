// SPDX-License-Identifier: MIT OR Apache-2.0
// @{ module }@: @{ purpose }@.
//
@% for line in notes %@// @{ line }@
@% endfor %@// Latency:   1 clock, the word is registered. Reset: none.
// @{ provenance }@
`default_nettype none

module @{ module }@ (
  input  wire clk_i,
  input  wire @{ address_range }@ address_i,
  output wire @{ data_range }@ data_o
);
  // @{ rom_note }@
  (* rom_style = "@{ rom_style }@" *)
  reg @{ data_range }@ data_q = @{ width }@'h0;

  always @(posedge clk_i) begin
    case (address_i)
@% for row in rows %@      @{ row.address }@: data_q <= @{ row.word }@;  // @{ row.comment }@
@% endfor %@      default: data_q <= @{ width }@'h0;
    endcase
  end

  assign data_o = data_q;
endmodule

`default_nettype wire
