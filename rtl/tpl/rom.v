// SPDX-License-Identifier: MIT OR Apache-2.0
// @{ module }@: @{ purpose }@.
//
@% for line in notes %@// @{ line }@
@% endfor %@// Latency:   @% if own_address %@3 clocks: the address is registered twice, the word once@% else %@1 clock, the word is registered@% endif %@. Reset: none.
// @{ provenance }@
`default_nettype none

module @{ module }@ (
  input  wire clk_i,
  input  wire @{ address_range }@ address_i,
  output wire @{ data_range }@ data_o
);
@% if own_address %@  // A copy of the address for this ROM alone, a clock to it and a clock from it; without `keep`,
  // which some tools look for at the register and others at the process, they share one for all.
  (* keep *) reg @{ address_copy_range }@ address_q = @{ address_width }@'d0;
  (* keep *) reg @{ copies_range }@ address_q2 = @{ copies_width }@'d0;@% if copies > 1 %@  // one for each weight@% endif %@
  (* keep *) always @(posedge clk_i) begin
    address_q  <= address_i;
    address_q2 <= @{ copied }@;
  end

@% endif %@  // @{ rom_note }@
@% if pieces.is_empty() %@  (* rom_style = "@{ rom_style }@" *)
  reg @{ data_range }@ data_q = @{ width }@'h0;
@% else %@  // It is built of several, or most of one would be empty; its word is that of the one addressed.
@% for piece in pieces %@  (* rom_style = "@{ rom_style }@" *)
  reg @{ data_range }@ @{ piece.data }@ = @{ width }@'h0;
@% endfor %@  reg @{ pieces_range }@ here_q = @{ pieces.len() }@'d0;
  always @(posedge clk_i) begin
@% for piece in pieces %@    here_q[@{ loop.index0 }@] <= @{ piece.here }@;
@% endfor %@  end
  wire @{ data_range }@ data_q =
@% for piece in pieces %@    ({@{ width }@{here_q[@{ loop.index0 }@]}} & @{ piece.data }@)@% if loop.last %@;@% else %@ |@% endif %@
@% endfor %@@% endif %@
  // The second time for tools that take the style of a ROM from its case statement.
@% for block in blocks %@  always @(posedge clk_i) begin
    (* rom_style = "@{ rom_style }@" *)
    case (@{ block.address }@)
@% for row in block.rows %@      @{ row.address }@: @{ block.data }@ <= @{ row.word }@;  // @{ row.comment }@
@% endfor %@      default: @{ block.data }@ <= @{ block.width }@'h0;
    endcase
  end
@% endfor %@
  assign data_o = data_q;
endmodule

`default_nettype wire
