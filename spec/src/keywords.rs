//! Words that no name in generated hardware may be.
//!
//! # Source
//! IEEE 1800-2017 annex B (with every word of IEEE 1364-2005) and
//! IEEE 1076-2008 clause 15.10 with the additions of 2019.

const SYSTEM_VERILOG: &str = "
    accept_on alias always always_comb always_ff always_latch and assert assign assume automatic
    before begin bind bins binsof bit break buf bufif0 bufif1 byte
    case casex casez cell chandle checker class clocking cmos config const constraint context
    continue cover covergroup coverpoint cross
    deassign default defparam design disable dist do
    edge else end endcase endchecker endclass endclocking endconfig endfunction endgenerate
    endgroup endinterface endmodule endpackage endprimitive endprogram endproperty endsequence
    endspecify endtable endtask enum event eventually expect export extends extern
    final first_match for force foreach forever fork forkjoin function
    generate genvar global
    highz0 highz1
    if iff ifnone ignore_bins illegal_bins implements implies import incdir include initial inout
    input inside instance int integer interconnect interface intersect
    join join_any join_none
    large let liblist library local localparam logic longint
    macromodule matches medium modport module
    nand negedge nettype new nexttime nmos nor noshowcancelled not notif0 notif1 null
    or output
    package packed parameter pmos posedge primitive priority program property protected pull0 pull1
    pulldown pullup pulsestyle_ondetect pulsestyle_onevent pure
    rand randc randcase randsequence rcmos real realtime ref reg reject_on release repeat restrict
    return rnmos rpmos rtran rtranif0 rtranif1
    s_always s_eventually s_nexttime s_until s_until_with scalared sequence shortint shortreal
    showcancelled signed small soft solve specify specparam static string strong strong0 strong1
    struct super supply0 supply1 sync_accept_on sync_reject_on
    table tagged task this throughout time timeprecision timeunit tran tranif0 tranif1 tri tri0
    tri1 triand trior trireg type typedef
    union unique unique0 unsigned until until_with untyped use uwire
    var vectored virtual void
    wait wait_order wand weak weak0 weak1 while wildcard wire with within wor
    xnor xor
";

const VHDL: &str = "
    abs access after alias all and architecture array assert assume assume_guarantee attribute
    begin block body buffer bus
    case component configuration constant context cover
    default disconnect downto
    else elsif end entity exit
    fairness file for force function
    generate generic group guarded
    if impure in inertial inout is
    label library linkage literal loop
    map mod
    nand new next nor not null
    of on open or others out
    package parameter port postponed private procedure process property protected pure
    range record register reject release rem report restrict restrict_guarantee return rol ror
    select sequence severity shared signal sla sll sra srl strong subtype
    then to transport type
    unaffected units until use
    variable view vmode vpkg vprop vunit
    wait when while with
    xnor xor
";

/// The language that reserves a word, if one does: `Verilog/SystemVerilog` or `VHDL`.
///
/// VHDL does not tell upper from lower case, so neither does this for its words.
pub fn reserving_language(word: &str) -> Option<&'static str> {
    let among = |list: &str, same: fn(&str, &str) -> bool| {
        list.split_ascii_whitespace()
            .any(|keyword| same(keyword, word))
    };
    if among(SYSTEM_VERILOG, |a, b| a == b) {
        Some("Verilog/SystemVerilog")
    } else if among(VHDL, str::eq_ignore_ascii_case) {
        Some("VHDL")
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lists_are_complete_and_sorted() {
        for (list, count) in [(SYSTEM_VERILOG, 248), (VHDL, 118)] {
            let words: Vec<_> = list.split_ascii_whitespace().collect();
            assert!(words.is_sorted_by(|a, b| a < b));
            assert_eq!(words.len(), count);
        }
    }

    #[test]
    fn case_counts_in_verilog_and_not_in_vhdl() {
        assert_eq!(reserving_language("reg"), Some("Verilog/SystemVerilog"));
        assert_eq!(reserving_language("Reg"), None);
        assert_eq!(reserving_language("Signal"), Some("VHDL"));
        assert_eq!(reserving_language("position"), None);
    }
}
