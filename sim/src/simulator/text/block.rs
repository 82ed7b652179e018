//! `always` blocks: how far they reach, and whether simulators and synthesis take their assignments
//! alike.

use std::collections::HashSet;

use super::token::{Kind, Token, is_reserved};

/// What starts a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Event<'a> {
    /// `@*`.
    Any,
    /// `@(posedge clock)`, with its name.
    Clock(&'a str),
}

/// The first assignment in the block whose event ends before `at` that is refused.
pub(super) fn refused(
    code: &[Token<'_>],
    at: usize,
    event: Event,
) -> Option<(usize, &'static str)> {
    let end = statement_end(code, at);
    let (mut depth, mut fresh) = (0_usize, true);
    let (mut written, mut read): (HashSet<&str>, Vec<&str>) = (HashSet::new(), Vec::new());
    let mut target = None;
    let mut choices = 0_usize;
    for (i, token) in code.iter().enumerate().take(end).skip(at) {
        let before = |n: usize| i.checked_sub(n).map_or("", |j| code[j].text);
        match token.text {
            // The name of a block.
            _ if before(1) == ":" && before(2) == "begin" => {}
            "?" if depth == 0 => choices += 1,
            ":" if depth == 0 && choices > 0 => choices -= 1,
            // The end of a label, in which a comparison may stand.
            ":" if depth == 0 => (fresh, target) = (true, None),
            // What another block reads at the same edge is the old or the new value, as the simulator
            // likes.
            "=" if depth == 0 && matches!(event, Event::Clock(_)) => {
                return Some((i, "a blocking assignment in a block with a clock"));
            }
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth = depth.saturating_sub(1),
            ";" | "begin" | "end" | "else" | "endcase" => (fresh, target) = (true, None),
            // The first one assigns, others compare.
            "=" | "<=" if depth == 0 && fresh => {
                fresh = false;
                written.extend(target.take());
                // What follows from it follows later than what is assigned at once.
                if (event, token.text) == (Event::Any, "<=") {
                    return Some((i, "a nonblocking assignment in a block without a clock"));
                }
            }
            // It is 1 for a simulator; a flip-flop takes what is there before it rises.
            name if event == Event::Clock(name) => {
                return Some((i, "the clock in a block that it starts"));
            }
            name if token.kind == Kind::Word && !is_reserved(name) => {
                if fresh && depth == 0 && target.is_none() {
                    target = Some(name);
                } else {
                    read.push(name);
                }
            }
            _ => {}
        }
    }
    let constant = constants(code);
    let reads = |name: &&str| !written.contains(name) && !constant.contains(name);
    // A simulator may never start it.
    (event == Event::Any && !read.iter().any(reads))
        .then_some((at, "an `always @*` that reads nothing that changes"))
}

/// Names of parameters and of variables of loops.
fn constants<'a>(code: &[Token<'a>]) -> HashSet<&'a str> {
    let mut names = HashSet::new();
    for (i, token) in code.iter().enumerate() {
        match token.text {
            "parameter" | "localparam" => {
                let name = code[i..].iter().take_while(|t| t.text != "=").last();
                names.extend(name.map(|name| name.text));
            }
            "integer" | "genvar" => names.extend(code.get(i + 1).map(|name| name.text)),
            _ => {}
        }
    }
    names
}

/// Index behind the statement that begins at `at`.
fn statement_end(code: &[Token<'_>], at: usize) -> usize {
    let Some(token) = code.get(at) else {
        return code.len();
    };
    match token.text {
        _ if token.kind == Kind::Attribute => statement_end(code, at + 1),
        "begin" => behind(code, at, ("begin", "end")),
        "case" => behind(code, at, ("case", "endcase")),
        "for" => statement_end(code, behind(code, at + 1, ("(", ")"))),
        "if" => {
            let end = statement_end(code, behind(code, at + 1, ("(", ")")));
            match code.get(end) {
                Some(token) if token.text == "else" => statement_end(code, end + 1),
                _ => end,
            }
        }
        _ => {
            let length = code[at..].iter().position(|token| token.text == ";");
            length.map_or(code.len(), |length| at + length + 1)
        }
    }
}

/// Index behind the token that closes what `at` opens.
fn behind(code: &[Token<'_>], at: usize, (opens, closes): (&str, &str)) -> usize {
    let mut depth = 0_usize;
    for (i, token) in code.iter().enumerate().skip(at) {
        if token.text == opens {
            depth += 1;
        } else if token.text == closes {
            depth = depth.saturating_sub(1);
        }
        if depth == 0 {
            return i + 1;
        }
    }
    code.len()
}
