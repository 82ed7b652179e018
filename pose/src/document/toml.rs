//! TOML as a tree of values.

use hwgen_spec::json::Fault;
use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

use super::{Content, Entry, Node, shorten, syntax};

pub(super) fn parse(text: &str) -> Result<Node, Fault> {
    let root = DeTable::parse(text).map_err(|error| {
        let span = error.span().unwrap_or_default();
        let mut fault = syntax(text, span.start, error.message().trim_end());
        if error.message().starts_with("duplicate key") {
            let key = shorten(text.get(span).unwrap_or_default());
            fault.code = "duplicate-key";
            fault.message = format!("each key once expected, {key} found again");
            fault.help("remove one of the two")
        } else {
            fault.help("the file is TOML: `key = value`, and `[table]` above the keys of a table")
        }
    })?;
    Ok(Node {
        // The parser's span of the whole begins behind comments.
        span: 0..text.len(),
        content: table(root.get_ref()),
    })
}

fn table(table: &DeTable<'_>) -> Content {
    let entry = |(key, value): (&Spanned<DeString<'_>>, _)| Entry {
        key: key.get_ref().to_string(),
        key_offset: key.span().start,
        value: node(value),
    };
    Content::Table(table.iter().map(entry).collect())
}

fn node(value: &Spanned<DeValue<'_>>) -> Node {
    let content = match value.get_ref() {
        DeValue::String(text) => Content::Text(text.to_string()),
        DeValue::Integer(integer) if integer.radix() == 10 => number(integer.as_str()),
        DeValue::Float(float) => number(float.as_str()),
        DeValue::Array(items) => Content::Array(items.iter().map(node).collect()),
        DeValue::Table(inner) => table(inner),
        _ => Content::Other,
    };
    Node {
        span: value.span(),
        content,
    }
}

fn number(digits: &str) -> Content {
    digits.parse().map_or(Content::Other, Content::Number)
}
