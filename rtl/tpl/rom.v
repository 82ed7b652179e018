// SPDX-License-Identifier: MIT OR Apache-2.0
// @{ module }@: @{ purpose }@.
//
@% for line in notes %@// @{ line }@
@% endfor %@// Latency:   @{ latency }@. Reset: none.
// @{ provenance }@
`default_nettype none

module @{ module }@ (
  input  wire clk_i,
  input  wire @{ address_range }@ address_i,
  output wire @{ data_range }@ data_o
);
@% if own_address %@  // A copy of the address for this ROM alone, a clock to it and a clock from it; without `keep`,
  // which some tools look for at the register and others at the process, they share one for all.
  (* keep, dont_merge, syn_preserve = 1 *) reg @{ address_copy_range }@ address_q = @{ address_width }@'d0;
  (* keep, dont_merge, syn_preserve = 1 *) reg @{ copies_range }@ address_q2 = @{ copies_width }@'d0;@% if copies > 1 %@  // one for each weight@% endif %@
  (* keep *) always @(posedge clk_i) begin
    address_q  <= address_i;
    address_q2 <= @{ copied }@;
  end

@% endif %@  // @{ rom_note }@
@% if starts_with_ones %@  // Bits that all words have start as they stay: as ones that rise once they would be no constants.
@% endif %@@% match tables %@
@% when Some with (tables) %@  // It is built of several tables, of which the highest bits of the address choose one@% if tables.registered %@, a clock
  // later@% endif %@.
@% for register in tables.registers %@  (* rom_style = "@{ rom_style }@" *)
  reg @{ data_range }@ @{ register.0 }@ = @{ register.1 }@;
@% endfor %@  reg @{ tables.above_range }@ above_q = @{ tables.above_width }@'d0;
  always @(posedge clk_i) above_q <= @{ tables.above }@;

@% if tables.registered %@  reg @{ data_range }@ data_q = @{ start }@;
  always @(posedge clk_i) begin
@% for choice in tables.choices %@    @{ choice.data }@ <=
      @{ choice.word }@;
@% endfor %@  end
@% else %@@% for choice in tables.choices %@  wire @{ data_range }@ @{ choice.data }@ =
      @{ choice.word }@;
@% endfor %@@% endif %@
@% when None %@  (* rom_style = "@{ rom_style }@" *)
  reg @{ data_range }@ data_q = @{ start }@;

@% endmatch %@  // The second time for tools that take the style of a ROM from its case statement.
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
