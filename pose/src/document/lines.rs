//! Lines and columns as offsets.

/// Where lines begin, to turn lines and columns into offsets.
pub(super) struct Lines<'a> {
    text: &'a str,
    starts: Vec<usize>,
}

impl<'a> Lines<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        let after = text.match_indices('\n').map(|(at, _)| at + 1);
        Self {
            text,
            starts: std::iter::once(0).chain(after).collect(),
        }
    }

    /// Byte offset of a line and a column in characters, both from 1.
    pub(super) fn offset(&self, line: usize, column: usize) -> usize {
        let last = self.starts.len();
        let start = self.starts[line.clamp(1, last) - 1];
        let rest = &self.text[start..];
        let before = rest.char_indices().nth(column.saturating_sub(1));
        start + before.map_or(rest.len(), |(at, _)| at)
    }
}
