//! OpenCV's XML as a tree of values: elements are keys, words are numbers or strings.

use hwgen_spec::json::Fault;
use roxmltree::{Document, Error, Node as Element, ParsingOptions};

use super::lines::Lines;
use super::{Content, Entry, MAX_DEPTH, Node, duplicate, number_or_text, syntax, too_deep};

/// The element that OpenCV writes around all others.
const ROOT: &str = "opencv_storage";

pub(super) fn parse(text: &str) -> Result<Node, Fault> {
    let options = ParsingOptions {
        nodes_limit: 100_000,
        ..ParsingOptions::default()
    };
    let document = Document::parse_with_options(text, options).map_err(|error| {
        let number = |n: u32| usize::try_from(n).unwrap_or(usize::MAX);
        let offset = match error {
            // The parser knows no place for it; it is where the text ends.
            Error::UnclosedRootNode => text.trim_end().len(),
            _ => Lines::new(text).offset(number(error.pos().row), number(error.pos().col)),
        };
        let told = error.to_string();
        // The place is told apart from the message.
        let message = told
            .rsplit_once(" at ")
            .map_or(&*told, |(message, _)| message);
        syntax(text, offset, message.to_owned())
            .help("the file is cut off or no XML; write it again")
    })?;
    let root = document.root_element();
    if root.tag_name().name() != ROOT {
        let message = format!(
            "the element {ROOT} expected, {} found",
            root.tag_name().name()
        );
        return Err(syntax(text, root.range().start, message)
            .help("give a file that OpenCV's FileStorage wrote"));
    }
    node(text, root, 0)
}

fn node(text: &str, element: Element<'_, '_>, depth: usize) -> Result<Node, Fault> {
    let span = element.range();
    if depth > MAX_DEPTH {
        return Err(too_deep(text, span.start));
    }
    let mut entries: Vec<Entry> = Vec::new();
    for child in element.children().filter(Element::is_element) {
        let key = child.tag_name().name().to_owned();
        let key_offset = child.range().start;
        // Elements of a sequence are all called `_`, and no camera matrix is one.
        if let Some(first) = entries.iter().find(|e| e.key == key && key != "_") {
            return Err(duplicate(text, first.key_offset, key_offset, &key));
        }
        entries.push(Entry {
            key,
            key_offset,
            value: node(text, child, depth + 1)?,
        });
    }
    let content = if entries.is_empty() {
        return Ok(words(text, element));
    } else {
        Content::Table(entries)
    };
    Ok(Node { span, content })
}

/// The words of an element: one value, or an array of them.
fn words(text: &str, element: Element<'_, '_>) -> Node {
    let Some(inner) = element.children().find(Element::is_text) else {
        return Node {
            span: element.range(),
            content: Content::Array(Vec::new()),
        };
    };
    let range = inner.range();
    let raw = &text[range.clone()];
    let mut items: Vec<Node> = raw
        .split_ascii_whitespace()
        .map(|word| {
            let start = word.as_ptr().addr() - text.as_ptr().addr();
            Node {
                span: start..start + word.len(),
                content: number_or_text(word),
            }
        })
        .collect();
    if items.len() == 1 {
        return items.remove(0);
    }
    Node {
        span: range,
        content: Content::Array(items),
    }
}
