//! Faults of texts that are no JSON: encoding, size, nesting, grammar.

use super::{Fault, Limits, place, shorten};

const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Refuses what is to be refused before the text is read as characters.
pub(super) fn check_encoding(text: &[u8], limits: Limits) -> Result<(), Fault> {
    if text.len() > limits.bytes {
        let message = format!(
            "a file of at most {} bytes expected, {} bytes found",
            limits.bytes,
            text.len()
        );
        return Err(Fault::at(text, 0, "too-large", message)
            .help("write fewer digits and no spaces, or split the network"));
    }
    if text.starts_with(BYTE_ORDER_MARK) {
        let message = "JSON without a byte order mark expected, the bytes EF BB BF found";
        return Err(Fault::at(text, 0, "byte-order-mark", message.to_owned())
            .help("save the file as UTF-8 without a byte order mark"));
    }
    if let Some(offset) = place::too_deep(text, limits.depth) {
        let message = format!(
            "nesting of at most {} arrays and objects expected, a deeper one found",
            limits.depth
        );
        return Err(Fault::at(text, offset, "too-deep", message)
            .help("no file of this kind nests so deep; check what wrote it"));
    }
    Ok(())
}

/// The text as characters.
pub(super) fn utf8(text: &[u8]) -> Result<&str, Fault> {
    std::str::from_utf8(text).map_err(|e| {
        let offset = e.valid_up_to();
        let message = format!(
            "UTF-8 expected, the byte {:02X} found at byte offset {offset}",
            text[offset]
        );
        let help = if text.starts_with(b"\xff\xfe") || text.starts_with(b"\xfe\xff") {
            "the file looks like UTF-16; save it as UTF-8"
        } else {
            "save the file as UTF-8"
        };
        Fault::at(text, offset, "not-utf-8", message).help(help)
    })
}

/// What serde_json says, without the position.
fn reason(error: &serde_json::Error) -> String {
    let text = error.to_string();
    let end = text.rfind(" at line ").unwrap_or(text.len());
    text[..end].to_owned()
}

/// The fault that stopped serde_json.
pub(super) fn fault(text: &str, error: &serde_json::Error) -> Fault {
    let reason = reason(error);
    if error.is_eof() {
        let expected = match reason.as_str() {
            "EOF while parsing a list" => "the rest of an array",
            "EOF while parsing an object" => "the rest of an object",
            "EOF while parsing a string" => "the rest of a string",
            _ => "a value",
        };
        let message = format!("{expected} expected, the end of the file found");
        return Fault::at(text.as_bytes(), text.len(), "syntax", message)
            .help("the file is empty or cut off; write it again");
    }
    let mut offset = offset(text, error.line(), error.column());
    match reason.as_str() {
        // serde_json stops inside the word; the user wants to see all of it.
        "invalid number" | "expected ident" => {
            offset = text[..offset].trim_end_matches(is_word).len();
        }
        "invalid escape" => offset = text[..offset].rfind('\\').unwrap_or(offset),
        other if other.starts_with("control character") => {
            let rest = text[offset..].find(char::is_control);
            offset += rest.unwrap_or(0);
        }
        _ => {}
    }
    let word = word(&text[offset..]);
    let expected = match reason.as_str() {
        "expected value" | "expected ident" => "a value",
        "invalid number" => "a number",
        "invalid escape" => r#"one of the escapes \" \\ \/ \b \f \n \r \t \uXXXX"#,
        "key must be a string" => "a key in double quotes",
        "trailing characters" => "the end of the file",
        "trailing comma" => "a value after the comma",
        other if other.starts_with("control character") => "an escape such as \\n",
        other => other.strip_prefix("expected ").unwrap_or("JSON"),
    };
    let found = match word.chars().next() {
        Some(c) if c.is_control() => format!("the control character U+{:04X}", u32::from(c)),
        _ => format!("`{}`", shorten(word)),
    };
    let message = format!("{expected} expected, {found} found");
    let fault = Fault::at(text.as_bytes(), offset, "syntax", message);
    match help(expected, word, &text[..offset]) {
        Some(help) => fault.help(help),
        None => fault,
    }
}

/// The word or the single character that a text begins with.
fn word(text: &str) -> &str {
    let end = text.find(|c| !is_word(c)).unwrap_or(text.len());
    let characters = text
        .chars()
        .take(if text.starts_with('\\') { 2 } else { 1 });
    let least = characters.map(char::len_utf8).sum();
    &text[..end.max(least)]
}

fn help(expected: &str, word: &str, before: &str) -> Option<&'static str> {
    let bare = word.trim_start_matches(['-', '+']).to_ascii_lowercase();
    Some(match bare.as_str() {
        "nan" | "inf" | "infinity" => {
            "JSON has neither NaN nor infinity; the training has diverged, train again"
        }
        "true" | "false" => "JSON writes true and false in lower case",
        "none" => "JSON has no None; leave the key out",
        "/" | "#" => "JSON has no comments; remove it",
        "'" => "JSON writes strings in double quotes",
        "]" | "}" if before.trim_end().ends_with(',') => "remove the comma before the bracket",
        _ if expected == "the end of the file" => "remove what follows the last bracket",
        _ if expected == "a key in double quotes" => "write \"key\": value",
        _ if expected.starts_with("`,`") => "put a comma before it, or close the bracket",
        number if number.starts_with(['.', '+']) || expected == "a number" || is_digit(number) => {
            "JSON writes numbers as 0.5, -3 or 1e-7: no plus sign, no leading zero, \
             digits on both sides of the point"
        }
        _ => return None,
    })
}

fn is_digit(word: &str) -> bool {
    word.starts_with(|c: char| c.is_ascii_digit())
}

fn is_word(c: char) -> bool {
    c.is_ascii_alphanumeric() || matches!(c, '+' | '-' | '.' | '_')
}

/// Offset of a place as serde_json counts it: lines from 1, bytes of the line up to and with it.
fn offset(text: &str, line: usize, column: usize) -> usize {
    let start: usize = text
        .split_inclusive('\n')
        .take(line.saturating_sub(1))
        .map(str::len)
        .sum();
    let offset = (start + column.saturating_sub(1)).min(text.len());
    text.floor_char_boundary(offset)
}
