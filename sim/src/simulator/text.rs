//! What the Verilog of a core must not contain: text that simulators and synthesis may read
//! differently, and calls of the simulator.
//!
//! The text is cut into tokens as IEEE 1364-2005, clause 3, has them; keywords, directives, system
//! functions and attributes are taken from lists of what is allowed.

mod block;
mod token;

use std::collections::HashSet;

use block::Event;
use token::{Kind, Token, tokens};

/// Keywords that are allowed: the part of Verilog that synthesis reads as simulators do.
const KEYWORDS: [&str; 25] = [
    "always",
    "assign",
    "begin",
    "case",
    "default",
    "else",
    "end",
    "endcase",
    "endgenerate",
    "endmodule",
    "for",
    "generate",
    "genvar",
    "if",
    "initial",
    "input",
    "integer",
    "localparam",
    "module",
    "output",
    "parameter",
    "posedge",
    "reg",
    "signed",
    "wire",
];
/// Directives that are allowed.
const DIRECTIVES: [&str; 2] = ["`default_nettype none", "`default_nettype wire"];
/// System functions that are allowed: constants and types, without an effect.
const FUNCTIONS: [&str; 3] = ["$clog2", "$signed", "$unsigned"];
/// Attributes that are allowed: they choose what a register is built of, not what it does.
const ATTRIBUTES: [&str; 7] = [
    "dont_merge",
    "keep",
    "multstyle",
    "rom_style",
    "syn_multstyle",
    "syn_preserve",
    "use_dsp",
];
/// First words of comments that a tool reads as a command.
const COMMANDS: [&str; 8] = [
    "ambit",
    "exemplar",
    "pragma",
    "rtl_synthesis",
    "synopsys",
    "synthesis",
    "synthesis_off",
    "vcs",
];

/// The first thing that is refused: its line, from 1, and what it is.
pub(super) fn refused(text: &str) -> Option<(usize, String)> {
    // Where a line ends for one tool and not for another, a comment does.
    if let Some((at, c)) = text.char_indices().find(|(_, c)| token::is_odd_space(*c)) {
        let line = 1 + text[..at].matches('\n').count();
        return Some((line, format!("the character U+{:04X}", u32::from(c))));
    }
    let all = tokens(text);
    // Comments stand anywhere; the rules on what precedes and follows a token leave them out.
    let comments = all.iter().filter(|token| token.kind == Kind::Comment);
    let comment = comments
        .filter_map(|token| Some((token, comment(token.text)?)))
        .next();
    let code: Vec<Token> = all
        .iter()
        .filter(|token| token.kind != Kind::Comment)
        .copied()
        .collect();
    let code = rule(&code);
    let first = [comment, code]
        .into_iter()
        .flatten()
        .min_by_key(|(token, _)| token.at);
    first.map(|(token, found)| (1 + text[..token.at].matches('\n').count(), found))
}

/// Names of the modules of a file, each with its line, from 1.
pub(super) fn modules(text: &str) -> Vec<(usize, String)> {
    let code = tokens(text)
        .into_iter()
        .filter(|token| token.kind != Kind::Comment);
    let code: Vec<Token> = code.collect();
    let pairs = code.windows(2).filter(|pair| pair[0].text == "module");
    pairs
        .map(|pair| {
            (
                1 + text[..pair[1].at].matches('\n').count(),
                pair[1].text.to_owned(),
            )
        })
        .collect()
}

/// What a model of a block has: names of its outputs, of its parameters, and whether it has registers.
pub(crate) fn interface(text: &str) -> (HashSet<String>, HashSet<String>, bool) {
    let code = tokens(text)
        .into_iter()
        .filter(|token| token.kind != Kind::Comment);
    let code: Vec<Token> = code.collect();
    let clocked = code.iter().any(|token| token.text == "posedge");
    let (mut outputs, mut parameters) = (HashSet::new(), HashSet::new());
    let mut kind = "";
    for pair in code.windows(2) {
        match (pair[0].text, pair[1].text) {
            (")", ";") => break,
            (keyword @ ("input" | "output" | "inout" | "parameter"), _) => kind = keyword,
            (name, "=") if kind == "parameter" => drop(parameters.insert(name.to_owned())),
            (name, "," | ")") if kind == "output" => drop(outputs.insert(name.to_owned())),
            _ => {}
        }
    }
    (outputs, parameters, clocked)
}

/// The first token of the code that is refused.
fn rule<'a, 'b>(code: &'b [Token<'a>]) -> Option<(&'b Token<'a>, String)> {
    for (i, token) in code.iter().enumerate() {
        let text = token.text;
        let before = |n: usize| i.checked_sub(n).map_or("", |j| code[j].text);
        let after = |n: usize| code.get(i + n).map_or("", |token| token.text);
        let found = match token.kind {
            Kind::Comment => None,
            Kind::Directive => (!DIRECTIVES.contains(&text)).then(|| {
                let word = text.split_whitespace().next().unwrap_or("");
                word.to_owned()
            }),
            Kind::System => (!FUNCTIONS.contains(&text)).then(|| format!("`{text}`")),
            Kind::Attribute => attribute(text),
            Kind::Escaped => Some("an escaped identifier".into()),
            Kind::Text if text.len() < 2 || !text.ends_with('"') => {
                Some("a text without an end".into())
            }
            // Of no text some tools make 8 bits, others none.
            Kind::Text if text == "\"\"" || !["(", "=", "==", "!="].contains(&before(1)) => {
                Some("a text among bits".into())
            }
            Kind::Text => text
                .contains('\\')
                .then(|| "a text with a backslash".into()),
            Kind::Number if text.contains(['x', 'X', 'z', 'Z', '?']) => {
                Some("a literal with X or Z".into())
            }
            // Whether 0.4 counts as true is answered in two ways.
            Kind::Number => (!text.starts_with('\'')
                && !text.bytes().all(|c| c.is_ascii_digit() || c == b'_'))
            .then(|| "a number that is no integer".into()),
            Kind::Strange => Some(match text.chars().next() {
                Some(c) if !c.is_ascii_graphic() => format!("the character U+{:04X}", u32::from(c)),
                _ => format!("`{text}`"),
            }),
            Kind::Word if text == "always" => {
                let event = [after(1), after(2), after(3), after(4), after(5)];
                let event = match event {
                    ["@", "*", ..] => Some((3, Event::Any)),
                    ["@", "(", "*", ")", _] => Some((5, Event::Any)),
                    ["@", "(", "posedge", clock, ")"] => Some((6, Event::Clock(clock))),
                    _ => None,
                };
                match event {
                    Some((length, event)) => {
                        if let Some((at, found)) = block::refused(code, i + length, event) {
                            return Some((&code[at.min(code.len() - 1)], found.to_owned()));
                        }
                        None
                    }
                    None => {
                        Some("an `always` that is neither `@*` nor `@(posedge <clock>)`".into())
                    }
                }
            }
            Kind::Word if ["initial", "reg"].contains(&text) => {
                if let Some(at) = block::initial_value(code, i) {
                    return Some((&code[at], "an initial value that is no constant".into()));
                }
                None
            }
            Kind::Word if token::is_reserved(text) && !KEYWORDS.contains(&text) => {
                Some(format!("`{text}`"))
            }
            Kind::Word => None,
            Kind::Symbol => match text {
                // Parameters stand between the name of a module and `(`.
                "#" if !(after(1) == "(" && is_name(code, i.wrapping_sub(1))) => {
                    Some("a delay".into())
                }
                "===" | "!==" => Some("a comparison with X or Z".into()),
                "->" | "->>" => Some("an event".into()),
                // A port's name follows a bracket or a comma.
                "." if !["(", ","].contains(&before(1)) && !is_in_block(code, i) => {
                    Some("a name in another module".into())
                }
                "@" if before(1) != "always" => Some("an event control in a statement".into()),
                _ => None,
            },
        };
        if let Some(found) = found {
            return Some((token, found));
        }
    }
    None
}

/// Whether the name in front of the dot is that of a block in this file, be it one of several.
fn is_in_block(code: &[Token<'_>], dot: usize) -> bool {
    let mut at = dot;
    let mut depth = 0_usize;
    while let Some(before) = at.checked_sub(1) {
        at = before;
        match code[at].text {
            "]" => depth += 1,
            "[" => depth = depth.saturating_sub(1),
            _ if depth > 0 => {}
            name => {
                let begins =
                    |w: &[Token<'_>]| [w[0].text, w[1].text, w[2].text] == ["begin", ":", name];
                let inner = at > 0 && code[at - 1].text == ".";
                return !inner && code.windows(3).any(begins);
            }
        }
    }
    false
}

fn is_name(code: &[Token<'_>], at: usize) -> bool {
    code.get(at)
        .is_some_and(|token| token.kind == Kind::Word && !token::is_reserved(token.text))
}

fn attribute(text: &str) -> Option<String> {
    let inner = text.strip_prefix("(*").and_then(|t| t.strip_suffix("*)"));
    let Some(inner) = inner else {
        return Some("an attribute without an end".into());
    };
    // A value is a number or a plain text, so that no comma but those between attributes is met.
    let plain = |value: &str| {
        let value = value.trim().trim_matches('"');
        !value.is_empty() && value.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
    };
    inner.split(',').find_map(|one| {
        let (name, value) = one.split_once('=').unwrap_or((one, "1"));
        let name = name.trim();
        (!ATTRIBUTES.contains(&name) || !plain(value))
            .then(|| format!("the attribute `{}`", one.trim()))
    })
}

fn comment(text: &str) -> Option<String> {
    if text.starts_with("/*") && (text.len() < 4 || !text.ends_with("*/")) {
        return Some("a comment without an end".into());
    }
    let body = text
        .trim_start_matches(['/', '*'])
        .trim_end_matches(['/', '*'])
        .trim();
    let first_line = || body.lines().next().unwrap_or("").trim();
    let first = body
        .split_whitespace()
        .next()
        .unwrap_or("")
        .to_ascii_lowercase();
    if first.starts_with("verilator") {
        let command = body["verilator".len()..].trim_start();
        let lint = ["lint_off ", "lint_on "]
            .iter()
            .any(|c| command.starts_with(c));
        return (!(first == "verilator" && lint))
            .then(|| format!("the comment `{}`", first_line()));
    }
    let lower = body.to_ascii_lowercase();
    let found = COMMANDS.contains(&&*first)
        || [
            "translate_o",
            "synthesis_o",
            "synthesis o",
            "pragma_o",
            "full_case",
            "parallel_case",
        ]
        .iter()
        .any(|word| lower.contains(word));
    found.then(|| format!("the comment `{}`", first_line()))
}

#[cfg(test)]
mod tests {
    use super::refused;

    #[test]
    fn what_simulators_and_synthesis_read_differently_is_refused_with_its_line() {
        for (text, found) in [
            ("`ifdef SYNTHESIS\n", "`ifdef"),
            ("`ifndef SYNTHESIS\n", "`ifndef"),
            ("`include \"a.v\"\n", "`include"),
            ("`define A 1\n", "`define"),
            (
                "// synthesis translate_off\n",
                "the comment `synthesis translate_off`",
            ),
            (
                "/* synopsys translate_off */",
                "the comment `synopsys translate_off`",
            ),
            (
                "// pragma translate_off\n",
                "the comment `pragma translate_off`",
            ),
            ("/*verilator public*/", "the comment `verilator public`"),
            ("initial $system(\"ls\");", "`$system`"),
            ("initial $c(\"system()\");", "`$c`"),
            ("initial $writememh(\"f\", m);", "`$writememh`"),
            ("initial $readmemh(\"f\", m);", "`$readmemh`"),
            ("if ($test$plusargs(\"x\"))", "`$test$plusargs`"),
            ("assign #1 a = b;", "a delay"),
            ("assign #(1) a = b;", "a delay"),
            ("a <= #1 b;", "a delay"),
            ("a <= #(1) b;", "a delay"),
            ("wire c = a === 1'bx;", "a comparison with X or Z"),
            ("wire c = 1'bx;", "a literal with X or Z"),
            ("casez (a)", "`casez`"),
            (
                "always @(a) b = c;",
                "an `always` that is neither `@*` nor `@(posedge <clock>)`",
            ),
            (
                "always @(negedge clk_i) a <= b;",
                "an `always` that is neither `@*` nor `@(posedge <clock>)`",
            ),
            ("(* blackbox *) module", "the attribute `blackbox`"),
            ("wire \\a ;", "an escaped identifier"),
            ("assign (supply1, strong0) a = b;", "`supply1`"),
            ("wire a = 1'b x;", "a literal with X or Z"),
            ("wire a = 'z;", "`'`"),
            (
                "parameter S = \"\\\" \"; initial $system(\"ls\");",
                "a text with a backslash",
            ),
            (
                "(* keep = \"*)\" *) initial $system(\"ls\");",
                "the attribute `keep = \"`",
            ),
            (
                "wire a; (* keep ) initial $finish;",
                "an attribute without an end",
            ),
            ("function f; input a; f = a & b; endfunction", "`function`"),
            ("always_latch if (a) b = c;", "`always_latch`"),
            ("bind a b c();", "`bind`"),
            (
                "always @(posedge clk_i) begin a = b; end",
                "a blocking assignment in a block with a clock",
            ),
            (
                "always @(posedge clk_i) if (a) b <= c; else d = b;",
                "a blocking assignment in a block with a clock",
            ),
            (
                "always @(posedge clk_i or posedge rst_i) a <= b;",
                "an `always` that is neither `@*` nor `@(posedge <clock>)`",
            ),
            (
                "always @* begin @(posedge clk_i); a = b; end",
                "an event control in a statement",
            ),
            ("wire a = u_b.c_q;", "a name in another module"),
            ("wire a = u_b[0].c_q;", "a name in another module"),
            (
                "begin : g_a end wire a = g_a.u_b.c_q;",
                "a name in another module",
            ),
            ("mul #3 u_a (b);", "a delay"),
            ("and (a, b, c);", "`and`"),
            ("assign a ==? b;", "`==?`"),
            ("hwg_mul u_a (.*);", "`.*`"),
            (
                "// altera translate_off\n",
                "the comment `altera translate_off`",
            ),
            (
                "case (a) // SYNOPSYS full_case\n",
                "the comment `SYNOPSYS full_case`",
            ),
            (
                "// verilator tracing_off\n",
                "the comment `verilator tracing_off`",
            ),
        ] {
            let text = format!("// A comment.\n{text}");
            assert_eq!(refused(&text), Some((2, found.to_owned())), "{text}");
        }
    }

    #[test]
    fn the_verilog_that_is_emitted_is_taken() {
        for text in [
            "// synthesised by no one; `ifdef in a comment\n// verilator lint_off UNUSED\n",
            "(* keep, dont_merge, syn_preserve = 1 *) reg a = 1'b0;",
            "always @* begin\nalways @(*)\nalways @(posedge clk_i) begin",
            "hwg_mul #(\n  .A(3)\n) u_mul (.a(16'h8000));",
            "`default_nettype none\nlocalparam A = $clog2(3); wire b = $signed(c) * 4'd3;",
            "hwg_hold #(.A(1)) u_hold ();",
            "always @(posedge clk_i) for (i = 0; i < 4; i = i + 1) a[i] <= b[i +: 2];\nassign c = d;",
            "always @(posedge clk_i) begin a <= b; end\nwire [3:0] c = a;\nreg [3:0] d = 4'd0;",
            "begin : g_a\nwire b = c;\nend\nwire d = g_a[2 * i[0]].b & g_a.b;",
            "always @* begin for (i = 0; i < 4; i = i + 1) if (a <= b) c[i] = d <= e; else c[i] = 1'b0; end",
            "always @(posedge clk_i) case (a)\n4'd0: b <= c <= d;\ndefault: b <= 1'b0;\nendcase\nwire e = 1'b0;",
            "localparam integer W = 4, V = 2;\nreg [W-1:0] a = {V{2'b0}}, b = W;\nreg [3:0] m [0:1];\n\
             genvar g;\ninitial m[g] = {W{1'b0}};\nassign c = a;",
            "always @(posedge clk_i) if (a) if (b) c <= d; else c <= e; else c <= f;\nassign g = h;",
            "(* rom_style = \"logic\" *) reg [3:0] rom [0:15];",
        ] {
            assert_eq!(refused(text), None, "{text}");
        }
    }
}
