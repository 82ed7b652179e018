//! JSON values that know where they stand, for errors that name the place.
//!
//! [`Node`] borrows a value's slice of the text.
//! Its path, line and column are worked out from the slice's offset when an error needs them,
//! so that reading a good file pays nothing for them.
//!
//! ```
//! use hwgen_spec::json::{Limits, parse};
//!
//! let limits = Limits { bytes: 1 << 20, depth: 32 };
//! let fault = parse(br#"{"layers": [{"bias": [0.5, "1"]}]}"#, limits)
//!     .and_then(|root| root.object())
//!     .and_then(|root| root.required("layers", "[...]")?.array())
//!     .and_then(|layers| layers[0].object()?.required("bias", "[...]")?.numbers())
//!     .unwrap_err();
//! assert_eq!(
//!     fault.to_string(),
//!     r#"layers[0].bias[1]: a number expected, a string "1" found"#
//! );
//! assert_eq!((fault.line, fault.column), (1, 28));
//! ```

use std::borrow::Cow;
use std::collections::HashMap;
use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, Visitor};
use serde_json::value::RawValue;

mod place;
mod syntax;

/// What a text may be at most.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Length in bytes.
    pub bytes: usize,
    /// Nesting of arrays and objects.
    pub depth: usize,
}

/// What is wrong with a text, and where.
///
/// Displayed as `<path>: <what was expected>, <what was found>`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub struct Fault {
    /// Short stable name of the kind of fault, such as `unknown-key`.
    pub code: &'static str,
    /// What was expected, and what was found.
    pub message: String,
    /// JSON path such as `networks[0].layers[1].weights[2][7]`; empty at the root.
    pub path: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// How to mend it.
    pub help: Option<String>,
}

impl Fault {
    /// A fault at an offset of a text in any syntax, and at the path that stands there.
    pub fn new(
        text: &[u8],
        offset: usize,
        path: String,
        code: &'static str,
        message: impl Into<String>,
    ) -> Self {
        let (line, column) = place::line_and_column(text, offset);
        Self {
            code,
            message: message.into(),
            path,
            line,
            column,
            help: None,
        }
    }

    fn at(text: &[u8], offset: usize, code: &'static str, message: String) -> Self {
        Self::new(text, offset, place::path(text, offset), code, message)
    }

    /// The same fault with a line that says how to mend it.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.path.is_empty() {
            f.write_str(&self.message)
        } else {
            write!(f, "{}: {}", self.path, self.message)
        }
    }
}

/// A value at its place in the text.
#[derive(Clone, Copy, Debug)]
pub struct Node<'a> {
    text: &'a str,
    raw: &'a str,
}

/// Reads a text as one JSON value.
///
/// The syntax of the whole text is checked; what the value holds is not.
///
/// # Errors
/// A [`Fault`] for a text beyond the limits, one that is not UTF-8, one with a byte order mark,
/// and one that is no JSON.
pub fn parse(text: &[u8], limits: Limits) -> Result<Node<'_>, Fault> {
    syntax::check_encoding(text, limits)?;
    let text = syntax::utf8(text)?;
    let raw: &RawValue = serde_json::from_str(text).map_err(|e| syntax::fault(text, &e))?;
    Ok(Node {
        text,
        raw: raw.get(),
    })
}

impl<'a> Node<'a> {
    fn child(self, raw: &'a RawValue) -> Self {
        Self {
            text: self.text,
            raw: raw.get(),
        }
    }

    fn offset(self) -> usize {
        // The slice lies within the text: serde_json borrows it.
        self.raw.as_ptr().addr() - self.text.as_ptr().addr()
    }

    /// JSON path of the value; empty for the root.
    ///
    /// Takes time proportional to the text before the value: for errors only.
    pub fn path(self) -> String {
        place::path(self.text.as_bytes(), self.offset())
    }

    /// Line and column of the value, from 1.
    pub fn line_and_column(self) -> (usize, usize) {
        place::line_and_column(self.text.as_bytes(), self.offset())
    }

    /// A fault at this value.
    pub fn fault(self, code: &'static str, message: impl Into<String>) -> Fault {
        Fault::at(self.text.as_bytes(), self.offset(), code, message.into())
    }

    /// The value as it stands in the text, cut short if it is long.
    pub fn excerpt(self) -> String {
        shorten(self.raw).into_owned()
    }

    /// The value in a few words: `a string "tanh"`, `an object`, `0.5`.
    pub fn describe(self) -> String {
        match self.raw.as_bytes().first() {
            Some(b'{') => "an object".to_owned(),
            Some(b'[') => "an array".to_owned(),
            Some(b'"') => format!("a string {}", self.excerpt()),
            _ => self.excerpt(),
        }
    }

    fn wrong_type(self, expected: &str) -> Fault {
        let fault = self.fault(
            "wrong-type",
            format!("{expected} expected, {} found", self.describe()),
        );
        if self.raw == "null" {
            fault.help(if expected == "a number" {
                "many writers put null for NaN: check that the training has not diverged"
            } else {
                "null stands for nothing here; leave the key out if there is nothing to say"
            })
        } else if expected == "a number" && self.raw.starts_with('"') {
            fault.help("write the number without quotes")
        } else if expected == "an array" && !self.raw.starts_with('{') {
            fault.help(format!("write it in brackets: [{}]", self.excerpt()))
        } else {
            fault
        }
    }

    /// The fields of an object in file order.
    ///
    /// # Errors
    /// A [`Fault`] if the value is no object or a key stands twice in it.
    pub fn object(self) -> Result<Object<'a>, Fault> {
        if !self.raw.starts_with('{') {
            return Err(self.wrong_type("an object"));
        }
        let RawObject(pairs) = self.decode()?;
        let mut fields: Vec<Field<'a>> = Vec::with_capacity(pairs.len());
        let mut places: HashMap<String, Node<'a>> = HashMap::with_capacity(pairs.len());
        for (key, value) in pairs {
            let key = self.child(key);
            let name = key.string()?;
            if let Some(first) = places.insert(name.clone(), key) {
                let (line, column) = first.line_and_column();
                let mut fault = key.fault("duplicate-key", "one value expected, a second found");
                fault.path = self.child(value).path();
                return Err(fault.help(format!(
                    "the first is at line {line}, column {column}; remove one of the two"
                )));
            }
            fields.push(Field {
                name,
                key,
                value: self.child(value),
            });
        }
        Ok(Object { node: self, fields })
    }

    /// The elements of an array.
    ///
    /// # Errors
    /// A [`Fault`] if the value is no array.
    pub fn array(self) -> Result<Vec<Self>, Fault> {
        if !self.raw.starts_with('[') {
            return Err(self.wrong_type("an array"));
        }
        let elements: Vec<&'a RawValue> = self.decode()?;
        Ok(elements.into_iter().map(|raw| self.child(raw)).collect())
    }

    /// A string with its escapes decoded.
    ///
    /// # Errors
    /// A [`Fault`] if the value is no string.
    pub fn string(self) -> Result<String, Fault> {
        if !self.raw.starts_with('"') {
            return Err(self.wrong_type("a string"));
        }
        self.decode()
    }

    /// A finite number, the double nearest to the decimal digits.
    ///
    /// # Errors
    /// A [`Fault`] if the value is no number or beyond the range of a double.
    pub fn number(self) -> Result<f64, Fault> {
        if !starts_number(self.raw) {
            return Err(self.wrong_type("a number"));
        }
        match self.raw.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(self
                .fault(
                    "number-overflow",
                    format!(
                        "a number of magnitude below 1.8e308 expected, {} found",
                        self.excerpt()
                    ),
                )
                .help("the number is infinite in double precision; check what wrote the file")),
        }
    }

    /// An array of finite numbers.
    ///
    /// # Errors
    /// A [`Fault`] if the value is no array, or at the first element that is no finite number.
    pub fn numbers(self) -> Result<Vec<f64>, Fault> {
        match plain_numbers(self.raw) {
            Some(numbers) => Ok(numbers),
            None => self.array()?.into_iter().map(Self::number).collect(),
        }
    }

    fn decode<T: Deserialize<'a>>(self) -> Result<T, Fault> {
        // The grammar was checked with the whole text, which leaves one thing to go wrong.
        serde_json::from_str(self.raw).map_err(|_| {
            let message = "Unicode characters expected, half of a surrogate pair found";
            self.fault("syntax", message)
                .help("characters beyond U+FFFF take two \\u escapes, or none at all in UTF-8")
        })
    }
}

/// The numbers of a well-formed array that holds nothing else; `None` sends to the slow path.
///
/// Splitting at commas is safe: a nested array, object or string leaves a piece that is no number.
fn plain_numbers(raw: &str) -> Option<Vec<f64>> {
    let inner = raw.strip_prefix('[')?.strip_suffix(']')?.trim_ascii();
    if inner.is_empty() {
        return Some(Vec::new());
    }
    inner
        .split(',')
        .map(|piece| {
            let piece = piece.trim_ascii();
            let value = starts_number(piece).then(|| piece.parse::<f64>().ok())?;
            value.filter(|v| v.is_finite())
        })
        .collect()
}

fn starts_number(raw: &str) -> bool {
    raw.starts_with(|c: char| c == '-' || c.is_ascii_digit())
}

/// A piece of the text for a message, at most 40 characters of it.
fn shorten(raw: &str) -> Cow<'_, str> {
    match raw.char_indices().nth(40) {
        None => Cow::Borrowed(raw),
        Some((end, _)) => Cow::Owned(format!("{}...", &raw[..end])),
    }
}

/// An object's fields, with the place of every key.
#[derive(Clone, Debug)]
pub struct Object<'a> {
    node: Node<'a>,
    fields: Vec<Field<'a>>,
}

#[derive(Clone, Debug)]
struct Field<'a> {
    name: String,
    key: Node<'a>,
    value: Node<'a>,
}

impl<'a> Object<'a> {
    /// The object as a value.
    pub fn node(&self) -> Node<'a> {
        self.node
    }

    /// Refuses keys that are not in the list.
    ///
    /// # Errors
    /// A [`Fault`] at the first unknown key, with the nearest known one as help.
    pub fn only(&self, known: &[&str]) -> Result<(), Fault> {
        let Some(field) = self.fields.iter().find(|f| !known.contains(&&*f.name)) else {
            return Ok(());
        };
        let (one, list) = match known {
            [only] => ("the key", (*only).to_owned()),
            _ => ("one of the keys", known.join(", ")),
        };
        let mut fault = field.key.fault(
            "unknown-key",
            format!("{one} {list} expected, {} found", shorten(field.key.raw)),
        );
        fault.path = self.node.path();
        // A key that stands already is no candidate: it was not misspelt.
        let free: Vec<&str> = known
            .iter()
            .copied()
            .filter(|key| self.optional(key).is_none())
            .collect();
        Err(match nearest(&field.name, &free) {
            Some(near) => fault.help(format!("did you mean \"{near}\"?")),
            None => fault.help("remove it; unknown keys are not skipped"),
        })
    }

    /// The value of a key, if it stands in the object.
    pub fn optional(&self, key: &str) -> Option<Node<'a>> {
        self.fields.iter().find(|f| f.name == key).map(|f| f.value)
    }

    /// Whether a key is missing and one like it stands in its place.
    pub fn misspells(&self, key: &str) -> bool {
        let alike = |f: &Field<'_>| nearest(&f.name, &[key]).is_some();
        self.optional(key).is_none() && self.fields.iter().any(alike)
    }

    /// The value of a key.
    ///
    /// # Errors
    /// A [`Fault`] at the object if the key is missing, with an example of a value as help.
    pub fn required(&self, key: &str, example: &str) -> Result<Node<'a>, Fault> {
        self.optional(key).ok_or_else(|| {
            let found = match self.fields.as_slice() {
                [] => "an empty object".to_owned(),
                fields => {
                    let names: Vec<_> = fields.iter().map(|f| &*f.name).collect();
                    format!("only {}", shorten(&names.join(", ")))
                }
            };
            let message = format!("the key \"{key}\" expected, {found} found");
            self.node
                .fault("missing-key", message)
                .help(format!("add \"{key}\": {example}"))
        })
    }
}

/// The candidate most like a misspelt word, if one is near enough to be meant.
pub fn nearest<'k>(word: &str, candidates: &[&'k str]) -> Option<&'k str> {
    // The distance takes memory in proportion to the length; no such word is a misspelling.
    if word.len() > 100 {
        return None;
    }
    let word = word.to_lowercase();
    candidates
        .iter()
        .map(|c| (strsim::damerau_levenshtein(&word, &c.to_lowercase()), *c))
        .filter(|(distance, c)| *distance <= (c.len() / 3).max(1))
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, c)| c)
}

/// Keys and values as they stand, duplicates included.
struct RawObject<'a>(Vec<(&'a RawValue, &'a RawValue)>);

impl<'a> Deserialize<'a> for RawObject<'a> {
    fn deserialize<D: Deserializer<'a>>(deserializer: D) -> Result<Self, D::Error> {
        struct Pairs;
        impl<'a> Visitor<'a> for Pairs {
            type Value = RawObject<'a>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object")
            }

            fn visit_map<M: MapAccess<'a>>(self, mut map: M) -> Result<Self::Value, M::Error> {
                let mut pairs = Vec::new();
                while let Some(pair) = map.next_entry()? {
                    pairs.push(pair);
                }
                Ok(RawObject(pairs))
            }
        }
        deserializer.deserialize_map(Pairs)
    }
}
