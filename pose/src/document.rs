//! Files as trees of values that know where they stand, for errors that name the place.
//!
//! TOML, YAML and XML lead to the same tree: a reader does not ask which syntax it has.

use std::ops::Range;

use hwgen_spec::json::{Fault, nearest};

mod lines;
mod toml;
mod xml;
mod yaml;

/// Longest text, in bytes: 1 MiB.
pub(crate) const MAX_BYTES: usize = 1 << 20;

/// Deepest nesting of arrays and tables.
const MAX_DEPTH: usize = 32;

/// A text and the values in it.
#[derive(Clone, Debug)]
pub(crate) struct Document {
    text: String,
    root: Node,
}

#[derive(Clone, Debug)]
struct Node {
    /// Bytes of the text.
    span: Range<usize>,
    content: Content,
}

#[derive(Clone, Debug)]
enum Content {
    Number(f64),
    Text(String),
    /// What no file of ours holds: a date, a truth value.
    Other,
    Array(Vec<Node>),
    Table(Vec<Entry>),
}

#[derive(Clone, Debug)]
struct Entry {
    key: String,
    key_offset: usize,
    value: Node,
}

impl Document {
    /// Reads TOML.
    pub(crate) fn toml(text: &[u8]) -> Result<Self, Fault> {
        Self::parse(text, toml::parse)
    }

    /// Reads XML if it begins as such, else YAML, of which JSON is a part.
    pub(crate) fn xml_or_yaml(text: &[u8]) -> Result<Self, Fault> {
        if text.trim_ascii_start().starts_with(b"<") {
            Self::parse(text, xml::parse)
        } else {
            Self::parse(text, yaml::parse)
        }
    }

    fn parse(text: &[u8], parse: fn(&str) -> Result<Node, Fault>) -> Result<Self, Fault> {
        let whole =
            |offset, code, message: String| Fault::new(text, offset, String::new(), code, message);
        if text.len() > MAX_BYTES {
            let message =
                format!("a file of at most {MAX_BYTES} bytes expected, a longer one found");
            return Err(whole(0, "too-long", message)
                .help("a scene or a calibration takes a few kilobytes; is it the right file?"));
        }
        let text = std::str::from_utf8(text).map_err(|e| {
            let message = "text in UTF-8 expected, other bytes found".to_owned();
            whole(e.valid_up_to(), "encoding", message).help("save the file as UTF-8")
        })?;
        if text.starts_with('\u{feff}') {
            let message = "text expected, a byte order mark found".to_owned();
            return Err(whole(0, "encoding", message).help("save the file as UTF-8 without BOM"));
        }
        Ok(Self {
            root: parse(text)?,
            text: text.to_owned(),
        })
    }

    /// The value that all others are in.
    pub(crate) fn root(&self) -> At<'_> {
        At {
            document: self,
            node: &self.root,
        }
    }

    /// The value at a path such as `camera.width_px` or `landmarks[2]`, or the nearest around it.
    pub(crate) fn nearest_to(&self, path: &str) -> At<'_> {
        let mut at = self.root();
        for step in path.split(['.', '[']) {
            let inner = match (&at.node.content, step.strip_suffix(']')) {
                (Content::Array(items), Some(index)) => {
                    index.parse().ok().and_then(|i: usize| items.get(i))
                }
                (Content::Table(entries), None) => {
                    entries.iter().find(|e| e.key == step).map(|e| &e.value)
                }
                _ => None,
            };
            match inner {
                Some(node) => at.node = node,
                None => break,
            }
        }
        at
    }
}

fn syntax(text: &str, offset: usize, message: impl Into<String>) -> Fault {
    Fault::new(text.as_bytes(), offset, String::new(), "syntax", message)
}

fn too_deep(text: &str, offset: usize) -> Fault {
    let message = format!("at most {MAX_DEPTH} levels of nesting expected, more found");
    Fault::new(text.as_bytes(), offset, String::new(), "too-deep", message)
}

fn duplicate(text: &str, first: usize, second: usize, key: &str) -> Fault {
    let first = Fault::new(text.as_bytes(), first, String::new(), "", "");
    let message = format!("each key once expected, {key} found again");
    Fault::new(
        text.as_bytes(),
        second,
        String::new(),
        "duplicate-key",
        message,
    )
    .help(format!(
        "the first is at line {}, column {}; remove one of the two",
        first.line, first.column
    ))
}

/// A number, if the text of an untyped value is one.
fn number_or_text(text: &str) -> Content {
    // YAML writes infinities and NaN with a dot in front.
    let bare = text
        .strip_prefix('.')
        .filter(|t| t.starts_with(char::is_alphabetic));
    match bare.unwrap_or(text).parse() {
        Ok(number) => Content::Number(number),
        Err(_) => Content::Text(text.to_owned()),
    }
}

/// A value at its place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct At<'a> {
    document: &'a Document,
    node: &'a Node,
}

impl<'a> At<'a> {
    fn to(self, node: &'a Node) -> Self {
        Self { node, ..self }
    }

    /// Path from the root, such as `landmarks[2][0]`. For errors only: it searches.
    pub(crate) fn path(self) -> String {
        let mut path = String::new();
        find(&self.document.root, self.node, &mut path);
        path
    }

    /// A fault at this value.
    pub(crate) fn fault(self, code: &'static str, message: impl Into<String>) -> Fault {
        let text = self.document.text.as_bytes();
        Fault::new(text, self.node.span.start, self.path(), code, message)
    }

    /// The value in a few words, as it stands in the text if it is short.
    pub(crate) fn describe(self) -> String {
        let excerpt = self.document.text.get(self.node.span.clone());
        let excerpt = shorten(excerpt.unwrap_or_default());
        match &self.node.content {
            Content::Table(_) => "a table".to_owned(),
            Content::Array(items) if items.is_empty() => "an empty array".to_owned(),
            Content::Array(_) => "an array".to_owned(),
            Content::Text(text) if text.is_empty() => "an empty string".to_owned(),
            Content::Text(_) => format!("a string {excerpt}"),
            Content::Number(_) | Content::Other => excerpt,
        }
    }

    pub(crate) fn wrong_type(self, expected: &str) -> Fault {
        let message = format!("{expected} expected, {} found", self.describe());
        self.fault("wrong-type", message)
    }

    /// A finite number.
    pub(crate) fn number(self) -> Result<f64, Fault> {
        match &self.node.content {
            Content::Number(number) if number.is_finite() => Ok(*number),
            Content::Number(_) => {
                let message = format!("a finite number expected, {} found", self.describe());
                Err(self
                    .fault("not-finite", message)
                    .help("write the number that was measured"))
            }
            Content::Text(text) if text.parse::<f64>().is_ok() => Err(self
                .wrong_type("a number")
                .help("write the number without quotes")),
            Content::Array(items) if items.len() == 1 => Err(self
                .wrong_type("a number")
                .help("write the number without brackets")),
            _ => Err(self
                .wrong_type("a number")
                .help("write a decimal number such as 12.5")),
        }
    }

    /// A finite number above zero.
    pub(crate) fn positive(self) -> Result<f64, Fault> {
        let number = self.number()?;
        if number > 0.0 {
            return Ok(number);
        }
        let message = format!("a number above zero expected, {} found", self.describe());
        Err(self
            .fault("out-of-range", message)
            .help("a size or a focal length is above zero"))
    }

    /// A string.
    pub(crate) fn text(self) -> Result<&'a str, Fault> {
        match &self.node.content {
            Content::Text(text) => Ok(text),
            _ => Err(self
                .wrong_type("a string")
                .help("write it in double quotes")),
        }
    }

    /// The elements, if it is an array.
    pub(crate) fn as_array(self) -> Option<impl ExactSizeIterator<Item = Self>> {
        match &self.node.content {
            Content::Array(items) => Some(items.iter().map(move |node| self.to(node))),
            _ => None,
        }
    }

    /// The elements of an array.
    pub(crate) fn array(self, example: &str) -> Result<impl ExactSizeIterator<Item = Self>, Fault> {
        let help = || format!("write it in brackets: {example}");
        self.as_array()
            .ok_or_else(|| self.wrong_type("an array").help(help()))
    }

    /// As many numbers as the example shows.
    pub(crate) fn numbers<const N: usize>(self, example: &str) -> Result<[f64; N], Fault> {
        let items = self.array(example)?;
        if items.len() != N {
            let message = format!("{N} numbers expected, {} found", items.len());
            return Err(self
                .fault("wrong-length", message)
                .help(format!("write {example}")));
        }
        let mut numbers = [0.0; N];
        for (number, item) in numbers.iter_mut().zip(items) {
            *number = item.number()?;
        }
        Ok(numbers)
    }

    /// The table, if it is one.
    pub(crate) fn as_table(self) -> Option<Table<'a>> {
        match &self.node.content {
            Content::Table(entries) => Some(Table { at: self, entries }),
            _ => None,
        }
    }

    /// The table.
    pub(crate) fn table(self, example: &str) -> Result<Table<'a>, Fault> {
        self.as_table().ok_or_else(|| {
            let fault = self.wrong_type("a table");
            fault.help(format!("write {example}"))
        })
    }
}

/// Keys and values, in the order of the file where the syntax keeps it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Table<'a> {
    at: At<'a>,
    entries: &'a [Entry],
}

impl<'a> Table<'a> {
    /// Refuses keys that are not in the list.
    pub(crate) fn only(self, known: &[&str]) -> Result<(), Fault> {
        let unknown = self.entries.iter().filter(|e| !known.contains(&&*e.key));
        let Some(entry) = unknown.min_by_key(|e| e.key_offset) else {
            return Ok(());
        };
        let message = format!(
            "one of the keys {} expected, {} found",
            known.join(", "),
            shorten(&entry.key)
        );
        let text = self.at.document.text.as_bytes();
        let path = self.at.path();
        let fault = Fault::new(text, entry.key_offset, path, "unknown-key", message);
        // A key that stands already is no candidate: it was not misspelt.
        let free: Vec<&str> = known
            .iter()
            .copied()
            .filter(|key| self.optional(key).is_none())
            .collect();
        Err(match nearest(&entry.key, &free) {
            // Of keys with two letters all are alike.
            Some(near) if near.len() > 2 => fault.help(format!("did you mean {near}?")),
            _ => fault.help("remove it; unknown keys are not skipped"),
        })
    }

    /// The value of a key, if it stands there.
    pub(crate) fn optional(self, key: &str) -> Option<At<'a>> {
        let entry = self.entries.iter().find(|e| e.key == key)?;
        Some(self.at.to(&entry.value))
    }

    /// The value of the first of several keys that stands there.
    pub(crate) fn first_of(self, keys: &[&str]) -> Option<At<'a>> {
        keys.iter().find_map(|key| self.optional(key))
    }

    /// The value of a key; `example` is how a line with it looks.
    pub(crate) fn required(self, key: &str, example: &str) -> Result<At<'a>, Fault> {
        self.optional(key).ok_or_else(|| self.missing(key, example))
    }

    /// The fault that a key is missing.
    pub(crate) fn missing(self, key: &str, example: &str) -> Fault {
        let found = match self.entries {
            [] => "none".to_owned(),
            entries => {
                let mut entries: Vec<_> = entries.iter().collect();
                entries.sort_by_key(|e| e.key_offset);
                let keys: Vec<_> = entries.iter().map(|e| &*e.key).collect();
                format!("only {}", shorten(&keys.join(", ")))
            }
        };
        let message = format!("the key {key} expected, {found} found");
        self.at
            .fault("missing-key", message)
            .help(format!("add {example}"))
    }
}

/// Whether `target` is in `node`; if so, `path` is longer by the way there.
fn find(node: &Node, target: &Node, path: &mut String) -> bool {
    if std::ptr::eq(node, target) {
        return true;
    }
    let length = path.len();
    match &node.content {
        Content::Array(items) => {
            for (i, item) in items.iter().enumerate() {
                path.push_str(&format!("[{i}]"));
                if find(item, target, path) {
                    return true;
                }
                path.truncate(length);
            }
        }
        Content::Table(entries) => {
            for entry in entries {
                if !path.is_empty() {
                    path.push('.');
                }
                path.push_str(&shorten(&entry.key));
                if find(&entry.value, target, path) {
                    return true;
                }
                path.truncate(length);
            }
        }
        Content::Number(_) | Content::Text(_) | Content::Other => {}
    }
    false
}

/// The first line of a piece of text, at most 40 characters of it.
fn shorten(text: &str) -> String {
    let line = text.lines().next().unwrap_or_default().trim_end();
    match line.char_indices().nth(40) {
        None => line.to_owned(),
        Some((end, _)) => format!("{}...", &line[..end]),
    }
}
