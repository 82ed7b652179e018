//! Where an offset of a JSON text lies: line and column, path, nesting.

/// Line and column of an offset, from 1; the column counts characters.
pub(super) fn line_and_column(text: &[u8], offset: usize) -> (usize, usize) {
    let before = &text[..offset.min(text.len())];
    let start = before
        .iter()
        .rposition(|b| *b == b'\n')
        .map_or(0, |newline| newline + 1);
    let line = 1 + before.iter().filter(|b| **b == b'\n').count();
    let column = 1 + before[start..]
        .iter()
        .filter(|b| **b & 0xc0 != 0x80)
        .count();
    (line, column)
}

/// Path of the value that begins at an offset or has it inside; of the object if it is at a key.
///
/// The text need not be JSON: what stands before the offset is understood as far as it is.
pub(super) fn path(text: &[u8], offset: usize) -> String {
    let mut scanner = Scanner::new(text);
    while scanner.next_offset() < offset && scanner.step() {}
    scanner.path()
}

/// Offset of the first bracket that nests deeper than `depth`.
pub(super) fn too_deep(text: &[u8], depth: usize) -> Option<usize> {
    let mut scanner = Scanner::new(text);
    loop {
        let offset = scanner.next_offset();
        if !scanner.step() {
            return None;
        }
        if scanner.open.len() > depth {
            return Some(offset);
        }
    }
}

/// An array or object that the scanner is in.
enum Open<'a> {
    /// Index of the current element.
    Array(usize),
    /// Key of the current field, absent where a key is to come.
    Object(Option<&'a [u8]>),
}

/// Walks over the brackets, strings and commas of a text.
struct Scanner<'a> {
    text: &'a [u8],
    offset: usize,
    open: Vec<Open<'a>>,
}

impl<'a> Scanner<'a> {
    fn new(text: &'a [u8]) -> Self {
        Self {
            text,
            offset: 0,
            open: Vec::new(),
        }
    }

    /// Offset of the next byte with a meaning for the nesting, or the end.
    fn next_offset(&mut self) -> usize {
        let rest = &self.text[self.offset..];
        let meaning = rest
            .iter()
            .position(|b| matches!(b, b'"' | b'[' | b']' | b'{' | b'}' | b','));
        self.offset += meaning.unwrap_or(rest.len());
        self.offset
    }

    /// Takes the next byte with a meaning, a string as a whole; false at the end.
    fn step(&mut self) -> bool {
        let start = self.next_offset();
        let Some(byte) = self.text.get(start) else {
            return false;
        };
        self.offset = start + 1;
        match byte {
            b'"' => {
                self.skip_string();
                if let Some(Open::Object(key @ None)) = self.open.last_mut() {
                    *key = Some(&self.text[start..self.offset]);
                }
            }
            b'[' => self.open.push(Open::Array(0)),
            b'{' => self.open.push(Open::Object(None)),
            b',' => match self.open.last_mut() {
                Some(Open::Array(index)) => *index += 1,
                Some(Open::Object(key)) => *key = None,
                None => {}
            },
            _ => {
                self.open.pop();
            }
        }
        true
    }

    /// From behind the opening quote to behind the closing one.
    fn skip_string(&mut self) {
        while let Some(byte) = self.text.get(self.offset) {
            self.offset += 1;
            match byte {
                b'"' => return,
                b'\\' => self.offset = (self.offset + 1).min(self.text.len()),
                _ => {}
            }
        }
    }

    fn path(&self) -> String {
        let mut path = String::new();
        for open in &self.open {
            match open {
                Open::Array(index) => path.push_str(&format!("[{index}]")),
                Open::Object(None) => {}
                Open::Object(Some(quoted)) => push_key(&mut path, &String::from_utf8_lossy(quoted)),
            }
        }
        path
    }
}

fn push_key(path: &mut String, quoted: &str) {
    let key = quoted.trim_matches('"');
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if key.is_empty() || key.len() > 40 || !key.chars().all(plain) {
        path.push_str(&format!("[{}]", super::shorten(quoted)));
    } else {
        if !path.is_empty() {
            path.push('.');
        }
        path.push_str(key);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_lead_to_the_value_at_an_offset() {
        let text = r#"{"a": [1, {"b c": [[], [2, "],{"]], "d": 3}], "e": 4"#;
        let at = |needle: &str| path(text.as_bytes(), text.find(needle).unwrap());
        assert_eq!(at("{\"a"), "");
        assert_eq!(at("\"a"), "");
        assert_eq!(at("[1"), "a");
        assert_eq!(at("1"), "a[0]");
        assert_eq!(at("2"), "a[1][\"b c\"][1][0]");
        assert_eq!(at("\"],{\""), "a[1][\"b c\"][1][1]");
        assert_eq!(at("3"), "a[1].d");
        assert_eq!(at("4"), "e");
        assert_eq!(path(text.as_bytes(), text.len()), "e");
    }

    #[test]
    fn columns_count_characters() {
        let text = "{\n \"µ\": x".as_bytes();
        assert_eq!(line_and_column(text, 0), (1, 1));
        assert_eq!(line_and_column(text, text.len() - 1), (2, 7));
        assert_eq!(line_and_column(text, text.len() + 9), (2, 8));
    }

    #[test]
    fn depth_is_counted_outside_strings() {
        assert_eq!(too_deep(br#"["[[[", []]"#, 2), None);
        assert_eq!(too_deep(br#"["[[[", []]"#, 1), Some(8));
    }
}
