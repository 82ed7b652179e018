//! YAML as a tree of values, in the dialect of OpenCV too.

use std::borrow::Cow;
use std::ops::Range;

use hwgen_spec::json::Fault;
use saphyr_parser::{Event, Parser, ScalarStyle, Span};

use super::lines::Lines;
use super::{Content, Entry, MAX_DEPTH, Node, duplicate, number_or_text, syntax, too_deep};

pub(super) fn parse(text: &str) -> Result<Node, Fault> {
    let lines = Lines::new(text);
    let mut tree = Tree {
        text,
        open: Vec::new(),
        root: None,
    };
    let readable = without_directive(text);
    for event in Parser::new_from_str(&readable) {
        let (event, span) = event.map_err(|error| {
            let at = error.marker();
            let offset = lines.offset(at.line(), at.col() + 1);
            syntax(text, offset, error.info())
                .help("the file is cut off or no YAML; write it again")
        })?;
        tree.take(event, bytes(&lines, span))?;
    }
    tree.root.ok_or_else(|| {
        syntax(text, 0, "keys and values expected, an empty file found")
            .help("give the file that the calibration wrote")
    })
}

/// OpenCV's first line, `%YAML:1.0`, is no directive of YAML: blanks take its place.
fn without_directive(text: &str) -> Cow<'_, str> {
    if !text.starts_with("%YAML") {
        return Cow::Borrowed(text);
    }
    let end = text.find('\n').unwrap_or(text.len());
    Cow::Owned(" ".repeat(end) + &text[end..])
}

fn bytes(lines: &Lines<'_>, span: Span) -> Range<usize> {
    let start = lines.offset(span.start.line(), span.start.col() + 1);
    let end = lines.offset(span.end.line(), span.end.col() + 1);
    start..end.max(start)
}

/// What is open while the events of a parser come.
enum Open {
    Array(usize, Vec<Node>),
    Table(usize, Vec<Entry>, Option<(String, usize)>),
}

struct Tree<'a> {
    text: &'a str,
    open: Vec<Open>,
    root: Option<Node>,
}

impl Tree<'_> {
    fn take(&mut self, event: Event<'_>, span: Range<usize>) -> Result<(), Fault> {
        let node = match event {
            Event::Scalar(text, style, ..) => Node {
                span,
                content: match style {
                    ScalarStyle::Plain => number_or_text(&text),
                    _ => Content::Text(text.into_owned()),
                },
            },
            Event::SequenceStart(..) => {
                self.open.push(Open::Array(span.start, Vec::new()));
                return self.check_depth(span.start);
            }
            Event::MappingStart(..) => {
                self.open.push(Open::Table(span.start, Vec::new(), None));
                return self.check_depth(span.start);
            }
            Event::SequenceEnd | Event::MappingEnd => match self.open.pop() {
                Some(Open::Array(start, items)) => Node {
                    span: start..span.end.max(start),
                    content: Content::Array(items),
                },
                Some(Open::Table(start, entries, _)) => Node {
                    span: start..span.end.max(start),
                    content: Content::Table(entries),
                },
                None => return Ok(()),
            },
            Event::Alias(_) => {
                let message = "a value expected, an alias found";
                return Err(syntax(self.text, span.start, message)
                    .help("write the value itself in place of the alias"));
            }
            _ => return Ok(()),
        };
        self.put(node)
    }

    fn check_depth(&self, offset: usize) -> Result<(), Fault> {
        if self.open.len() > MAX_DEPTH {
            return Err(too_deep(self.text, offset));
        }
        Ok(())
    }

    fn put(&mut self, node: Node) -> Result<(), Fault> {
        match self.open.last_mut() {
            None if self.root.is_none() => self.root = Some(node),
            // A separator at the end opens an empty document, as in what `ros2 topic echo` prints.
            None if matches!(&node.content, Content::Text(text) if text.is_empty()) => {}
            None => {
                let message = "one document expected, a second found";
                return Err(syntax(self.text, node.span.start, message)
                    .help("keep the document of one camera"));
            }
            Some(Open::Array(_, items)) => items.push(node),
            Some(Open::Table(_, entries, key)) => match key.take() {
                Some((key, key_offset)) => entries.push(Entry {
                    key,
                    key_offset,
                    value: node,
                }),
                None => {
                    let start = node.span.start;
                    let name = match node.content {
                        Content::Text(text) => text,
                        Content::Number(_) => self.text[node.span].to_owned(),
                        _ => return Err(syntax(self.text, start, "a word as key expected")),
                    };
                    if let Some(first) = entries.iter().find(|e| e.key == name) {
                        return Err(duplicate(self.text, first.key_offset, start, &name));
                    }
                    *key = Some((name, start));
                }
            },
        }
        Ok(())
    }
}
