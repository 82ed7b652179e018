//! Tokens of Verilog (IEEE 1364-2005, clause 3).

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Comment,
    /// A back quote and the rest of its line.
    Directive,
    /// `$` and a name.
    System,
    /// From `(*` to `*)`.
    Attribute,
    Escaped,
    /// A string.
    Text,
    Number,
    /// A name or a keyword.
    Word,
    Symbol,
    /// Nothing that Verilog has.
    Strange,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Token<'a> {
    pub(super) kind: Kind,
    pub(super) text: &'a str,
    /// Where it begins, in bytes.
    pub(super) at: usize,
}

/// Symbols of more than one character, long ones first.
const SYMBOLS: [&str; 20] = [
    "===", "!==", "<<<", ">>>", "==", "!=", "<=", ">=", "&&", "||", "**", "<<", ">>", "~&", "~|",
    "~^", "^~", "->", "+:", "-:",
];
/// Symbols that Verilog does not have.
const SYSTEM_VERILOG: [&str; 19] = [
    "<<<=", ">>>=", "->>", "==?", "!=?", "::", ".*", "##", "+=", "-=", "*=", "/=", "%=", "&=",
    "|=", "^=", "++", "--", "'{",
];

/// All tokens, in order.
pub(super) fn tokens(text: &str) -> Vec<Token<'_>> {
    let mut tokens = Vec::new();
    let mut at = 0;
    loop {
        // Tools differ on all other white space.
        at += text[at..].len() - text[at..].trim_start_matches([' ', '\t', '\n']).len();
        let rest = &text[at..];
        if rest.is_empty() {
            return tokens;
        }
        let (kind, length) = first(rest);
        tokens.push(Token {
            kind,
            text: &rest[..length],
            at,
        });
        at += length;
    }
}

/// Whether a tool may take it for the end of a line, or leave it out.
pub(super) fn is_odd_space(c: char) -> bool {
    c.is_control() && !"\t\n".contains(c) || "\u{2028}\u{2029}\u{feff}".contains(c)
}

/// Kind and length of the token at the start of a text that starts with no space.
fn first(rest: &str) -> (Kind, usize) {
    let until = |end: &str, from: usize| {
        rest[from..]
            .find(end)
            .map_or(rest.len(), |at| from + at + end.len())
    };
    let while_ = |from: usize, fits: fn(char) -> bool| {
        rest[from..]
            .find(|c: char| !fits(c))
            .map_or(rest.len(), |at| from + at)
    };
    let is_word = |c: char| c.is_ascii_alphanumeric() || "_$".contains(c);
    let Some(c) = rest.chars().next() else {
        return (Kind::Strange, 0);
    };
    match c {
        '/' if rest.starts_with("//") => (Kind::Comment, while_(0, |c| c != '\n')),
        '/' if rest.starts_with("/*") => (Kind::Comment, until("*/", 2)),
        '`' => (
            Kind::Directive,
            rest[..while_(0, |c| c != '\n')].trim_end().len(),
        ),
        '(' if rest.starts_with("(*") && !rest.starts_with("(*)") => {
            (Kind::Attribute, until("*)", 2))
        }
        '"' => (Kind::Text, string(rest)),
        '\\' => (Kind::Escaped, while_(0, |c| !c.is_whitespace())),
        '$' => (Kind::System, while_(1, is_word)),
        '\'' => match based(rest) {
            Some(length) => (Kind::Number, length),
            None => (Kind::Strange, 1),
        },
        _ if c.is_ascii_digit() => (
            Kind::Number,
            while_(0, |c| c.is_ascii_alphanumeric() || "_.".contains(c)),
        ),
        _ if c.is_ascii_alphabetic() || c == '_' => (Kind::Word, while_(0, is_word)),
        _ if c.is_ascii_punctuation() => {
            if let Some(symbol) = SYSTEM_VERILOG.iter().find(|s| rest.starts_with(**s)) {
                return (Kind::Strange, symbol.len());
            }
            let longest = SYMBOLS.iter().find(|s| rest.starts_with(**s));
            (Kind::Symbol, longest.map_or(1, |symbol| symbol.len()))
        }
        _ => (Kind::Strange, c.len_utf8()),
    }
}

/// Length of a string with its quotes; a backslash hides the character behind it.
fn string(rest: &str) -> usize {
    let mut hidden = false;
    for (at, c) in rest.char_indices().skip(1) {
        match c {
            _ if hidden => hidden = false,
            '\\' => hidden = true,
            '"' | '\n' => return at + 1,
            _ => {}
        }
    }
    rest.len()
}

/// Length of a base with its digits, between which there may be spaces.
fn based(rest: &str) -> Option<usize> {
    let mut at = 1;
    at += usize::from(rest[at..].starts_with(['s', 'S']));
    if !rest[at..].starts_with(['b', 'B', 'o', 'O', 'd', 'D', 'h', 'H']) {
        return None;
    }
    at += 1;
    at += rest[at..].len() - rest[at..].trim_start().len();
    let digits = rest[at..]
        .find(|c: char| !(c.is_ascii_alphanumeric() || "_?".contains(c)))
        .unwrap_or(rest[at..].len());
    Some(at + digits)
}

/// Whether a word is a keyword of Verilog or of SystemVerilog (IEEE 1800-2017, annex B), which some
/// tools read every file as.
pub(super) fn is_reserved(word: &str) -> bool {
    RESERVED.split_whitespace().any(|reserved| reserved == word)
}

const RESERVED: &str = "
accept_on alias always always_comb always_ff always_latch and assert assign assume automatic
before begin bind bins binsof bit break buf bufif0 bufif1 byte case casex casez cell chandle
checker class clocking cmos config const constraint context continue cover covergroup coverpoint
cross deassign default defparam design disable dist do edge else end endcase endchecker endclass
endclocking endconfig endfunction endgenerate endgroup endinterface endmodule endpackage
endprimitive endprogram endproperty endsequence endspecify endtable endtask enum event eventually
expect export extends extern final first_match for force foreach forever fork forkjoin function
generate genvar global highz0 highz1 if iff ifnone ignore_bins illegal_bins implements implies
import incdir include initial inout input inside instance int integer interconnect interface
intersect join join_any join_none large let liblist library local localparam logic longint
macromodule matches medium modport module nand negedge nettype new nexttime nmos nor
noshowcancelled not notif0 notif1 null or output package packed parameter pmos posedge primitive
priority program property protected pull0 pull1 pulldown pullup pulsestyle_ondetect
pulsestyle_onevent pure rand randc randcase randsequence rcmos real realtime ref reg reject_on
release repeat restrict return rnmos rpmos rtran rtranif0 rtranif1 s_always s_eventually
s_nexttime s_until s_until_with scalared sequence shortint shortreal showcancelled signed small
soft solve specify specparam static string strong strong0 strong1 struct super supply0 supply1
sync_accept_on sync_reject_on table tagged task this throughout time timeprecision timeunit tran
tranif0 tranif1 tri tri0 tri1 triand trior trireg type typedef union unique unique0 unsigned until
until_with untyped use uwire var vectored virtual void wait wait_order wand weak weak0 weak1 while
wildcard wire with within wor xnor xor
";
