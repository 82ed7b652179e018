//! What the Verilog of a core must not contain: text that simulators and synthesis read differently,
//! and calls of the simulator.

/// Directives that are allowed, with what follows them.
const DIRECTIVES: [&str; 2] = ["default_nettype none", "default_nettype wire"];
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
/// Words that are for simulation alone, or that synthesis takes in another way.
const WORDS: [&str; 34] = [
    "highz0",
    "highz1",
    "pull0",
    "pull1",
    "strong0",
    "strong1",
    "supply0",
    "supply1",
    "trireg",
    "tri1",
    "weak0",
    "weak1",
    "casex",
    "casez",
    "deassign",
    "disable",
    "event",
    "force",
    "forever",
    "fork",
    "inside",
    "join",
    "negedge",
    "primitive",
    "pullup",
    "pulldown",
    "real",
    "realtime",
    "release",
    "specify",
    "table",
    "time",
    "tri0",
    "wait",
];
/// Comments that a tool reads as a command.
const COMMANDS: [&str; 5] = [
    "synthesis",
    "synopsys",
    "pragma",
    "translate_off",
    "translate_on",
];

/// The first thing that is refused: its line, from 1, and what it is.
pub(super) fn refused(text: &str) -> Option<(usize, String)> {
    let mut rest = text;
    let line = |rest: &str| 1 + text[..text.len() - rest.len()].matches('\n').count();
    while let Some(first) = rest.chars().next() {
        let after = &rest[first.len_utf8()..];
        let length;
        if rest.starts_with("//") || rest.starts_with("/*") {
            let end = if rest.starts_with("//") { "\n" } else { "*/" };
            length = rest.find(end).map_or(rest.len(), |at| at + end.len());
            if let Some(found) = comment(&rest[..length]) {
                return Some((line(rest), found));
            }
        } else if first == '"' {
            let end = after.find(['"', '\n']).map_or(rest.len(), |at| at + 2);
            length = end.min(rest.len());
        } else if first == '\\' {
            return Some((line(rest), "an escaped identifier".into()));
        } else if first == '`' {
            let directive = after.lines().next().unwrap_or("").trim();
            if !DIRECTIVES.contains(&directive) {
                let word = directive.split_whitespace().next().unwrap_or("");
                return Some((line(rest), format!("`{word}")));
            }
            length = 1 + directive.len();
        } else if first == '#' {
            if !after.trim_start().starts_with('(') || is_delay(&text[..text.len() - rest.len()]) {
                return Some((line(rest), "a delay".into()));
            }
            length = 1;
        } else if rest.starts_with("(*") && !rest.starts_with("(*)") {
            length = rest.find("*)").map_or(rest.len(), |at| at + 2);
            if let Some(found) = attribute(&rest[2..length.saturating_sub(2).max(2)]) {
                return Some((line(rest), found));
            }
        } else if rest.starts_with("===") || rest.starts_with("!==") {
            return Some((line(rest), "a comparison with X or Z".into()));
        } else if first == '\'' {
            length = 1 + after
                .find(|c: char| !(c.is_ascii_alphanumeric() || "_?".contains(c)))
                .unwrap_or(after.len());
            let digits = rest[1..length].to_ascii_lowercase();
            let digits = digits.trim_start_matches(['s', 'b', 'o', 'd', 'h']);
            if digits.contains(['x', 'z', '?']) {
                return Some((line(rest), "a literal with X or Z".into()));
            }
        } else if first.is_ascii_alphabetic() || "_$".contains(first) {
            length = rest
                .find(|c: char| !(c.is_ascii_alphanumeric() || "_$".contains(c)))
                .unwrap_or(rest.len());
            if let Some(found) = word(&rest[..length], &rest[length..]) {
                return Some((line(rest), found));
            }
        } else {
            length = first.len_utf8();
        }
        rest = &rest[length..];
    }
    None
}

fn word(word: &str, after: &str) -> Option<String> {
    if word.starts_with('$') && !FUNCTIONS.contains(&word) {
        return Some(format!("`{word}`"));
    }
    if WORDS.contains(&word) {
        return Some(format!("`{word}`"));
    }
    if word == "always" {
        let sensitivity: String = after
            .chars()
            .filter(|c| !c.is_whitespace())
            .take(14)
            .collect();
        let fits = ["@*", "@(*)", "@(posedge"]
            .iter()
            .any(|s| sensitivity.starts_with(s));
        if !fits {
            return Some("an `always` that is neither `@*` nor `@(posedge ...)`".into());
        }
    }
    None
}

/// Whether `#(` behind this text is a delay: behind an assignment or `assign`, not a module's name.
fn is_delay(before: &str) -> bool {
    let before = before.trim_end();
    let word = before
        .rsplit(|c: char| !(c.is_ascii_alphanumeric() || c == '_'))
        .next()
        .unwrap_or("");
    word.is_empty() || ["assign", "begin", "else", "wire", "initial"].contains(&word)
}

fn attribute(text: &str) -> Option<String> {
    let names = text
        .split(',')
        .map(|a| a.split('=').next().unwrap_or("").trim());
    names
        .into_iter()
        .find(|name| !ATTRIBUTES.contains(name))
        .map(|name| format!("the attribute `{name}`"))
}

fn comment(text: &str) -> Option<String> {
    let body = text.trim_start_matches(['/', '*']).trim();
    if let Some(command) = body.strip_prefix("verilator") {
        let command = command.trim_start();
        let lint = ["lint_off ", "lint_on "]
            .iter()
            .any(|c| command.starts_with(c));
        return (!lint && body.starts_with("verilator ")).then(|| format!("the comment `{body}`"));
    }
    let first = body
        .split_whitespace()
        .next()
        .unwrap_or("")
        .to_ascii_lowercase();
    let found = COMMANDS.contains(&&*first) || body.contains("translate_o");
    found.then(|| format!("the comment `{}`", body.lines().next().unwrap_or("")))
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
                "the comment `synopsys translate_off */`",
            ),
            (
                "// pragma translate_off\n",
                "the comment `pragma translate_off`",
            ),
            ("/*verilator public*/", "the comment `verilator public*/`"),
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
                "an `always` that is neither `@*` nor `@(posedge ...)`",
            ),
            (
                "always @(negedge clk_i) a <= b;",
                "an `always` that is neither `@*` nor `@(posedge ...)`",
            ),
            ("(* blackbox *) module", "the attribute `blackbox`"),
            ("wire \\a ;", "an escaped identifier"),
            ("assign (supply1, strong0) a = b;", "`supply1`"),
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
        ] {
            assert_eq!(refused(text), None, "{text}");
        }
    }
}
