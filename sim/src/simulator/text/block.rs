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
    let mut kind = "";
    for pair in code.windows(2) {
        match pair[0].text {
            // The type of a parameter.
            "integer" if ["parameter", "localparam"].contains(&kind) => {}
            keyword @ ("parameter" | "localparam" | "integer" | "genvar") => kind = keyword,
            ";" => kind = "",
            name if ["integer", "genvar"].contains(&kind) && [",", ";"].contains(&pair[1].text) => {
                names.insert(name);
            }
            name if ["parameter", "localparam"].contains(&kind) && pair[1].text == "=" => {
                names.insert(name);
            }
            _ => {}
        }
    }
    names
}

/// The first name in an initial value that is no constant: it is read once by a simulator, and who
/// knows how often by synthesis. `at` is the place of `initial`, or of `reg` in a declaration.
pub(super) fn initial_value(code: &[Token<'_>], at: usize) -> Option<usize> {
    let constant = constants(code);
    let end = match code[at].text {
        "initial" => statement_end(code, at + 1),
        _ => statement_end(code, at),
    };
    let (mut depth, mut value) = (0_usize, false);
    for (i, token) in code.iter().enumerate().take(end).skip(at) {
        match token.text {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth = depth.saturating_sub(1),
            ";" => value = false,
            "," if depth == 0 => value = false,
            "=" if depth == 0 => value = true,
            name if value
                && token.kind == Kind::Word
                && !is_reserved(name)
                && !constant.contains(name) =>
            {
                return Some(i);
            }
            _ => {}
        }
    }
    None
}

/// Index behind the statement that begins at `at`.
fn statement_end(code: &[Token<'_>], mut at: usize) -> usize {
    // Conditions whose `else` may still come, the innermost first to take it.
    let mut open = 0_usize;
    while let Some(token) = code.get(at) {
        match token.text {
            _ if token.kind == Kind::Attribute => {
                at += 1;
                continue;
            }
            "for" => {
                at = behind(code, at + 1, ("(", ")"));
                continue;
            }
            "if" => {
                open += 1;
                at = behind(code, at + 1, ("(", ")"));
                continue;
            }
            "begin" => at = behind(code, at, ("begin", "end")),
            "case" => at = behind(code, at, ("case", "endcase")),
            _ => {
                let length = code[at..].iter().position(|token| token.text == ";");
                at = length.map_or(code.len(), |length| at + length + 1);
            }
        }
        if open == 0 {
            return at;
        }
        match code.get(at) {
            Some(token) if token.text == "else" => {
                open -= 1;
                at += 1;
            }
            _ => return at,
        }
    }
    code.len()
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
