//! Tables of numbers in CSV files: vectors in, results out.

use std::path::Path;

use hwgen_spec::network::Inputs;

use crate::aside::Aside;
use crate::failure::Failure;

/// A CSV file with a header, all of its cells still text.
#[derive(Clone, Debug)]
pub struct Table {
    file: String,
    header: Vec<String>,
    /// Line in the file, and the cells.
    records: Vec<(usize, csv::StringRecord)>,
}

impl Table {
    /// Reads a file.
    ///
    /// # Errors
    /// If it can't be read, is empty or ragged, has no header, or one that names a column twice.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let text = std::fs::read(path).map_err(|e| Failure::io(path, &e))?;
        Self::parse(&path.display().to_string(), &text)
    }

    /// Reads a text; `file` is what errors call it.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn parse(file: &str, text: &[u8]) -> Result<Self, Failure> {
        let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .trim(csv::Trim::All)
            .from_reader(text);
        let mut records = Vec::new();
        let mut lines = Lines {
            text,
            seen: 0,
            line: 1,
        };
        for record in reader.records() {
            let record = record.map_err(|e| {
                let line = e.position().map_or(1, csv::Position::line);
                let message = match e.kind() {
                    csv::ErrorKind::Utf8 { .. } => "text in UTF-8 expected".into(),
                    _ => e.to_string(),
                };
                fault(file, "csv-syntax", message).at(usize_of(line), None)
            })?;
            let start = record.position().map_or(0, |p| usize_of(p.byte()));
            records.push((lines.at(start), record));
        }
        if records.is_empty() {
            let message = "a header with the names of the columns expected, an empty file found";
            return Err(fault(file, "csv-empty", message)
                .help("give a CSV file with a header and a row for each frame"));
        }
        let (line, header) = records.remove(0);
        let header: Vec<String> = header.iter().map(str::to_owned).collect();
        if let Some((i, name)) = header
            .iter()
            .enumerate()
            .find(|(i, name)| !name.is_empty() && header[..*i].contains(name))
        {
            let message = format!("columns with different names expected, `{name}` found twice");
            return Err(fault(file, "csv-duplicate-column", message).at(line, Some(i + 1)));
        }
        if let Some((line, record)) = records.iter().find(|(_, r)| r.len() != header.len()) {
            let message = format!(
                "{} values expected, as many as in the header, {} found",
                header.len(),
                record.len()
            );
            return Err(fault(file, "csv-ragged", message).at(*line, None));
        }
        Ok(Self {
            file: file.to_owned(),
            header,
            records,
        })
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.records.len()
    }

    /// Whether there is a header only.
    pub fn is_empty(&self) -> bool {
        self.records.is_empty()
    }

    /// The numbers of some columns, row by row, in the order of `names`.
    ///
    /// # Errors
    /// If a column is missing, a value is no finite number, or there is no row.
    pub fn numbers(&self, names: &[String]) -> Result<Vec<Vec<f64>>, Failure> {
        let columns = names
            .iter()
            .map(|name| self.column(name))
            .collect::<Result<Vec<_>, _>>()?;
        if self.is_empty() {
            let message = "at least one row expected below the header, none found";
            return Err(fault(&self.file, "csv-empty", message).at(2, None));
        }
        self.records
            .iter()
            .map(|(line, record)| {
                let number = |column: &usize| {
                    let text = &record[*column];
                    let number: Option<f64> = text.parse().ok();
                    number.filter(|v| v.is_finite()).ok_or_else(|| {
                        let message = format!(
                            "column `{}`: a finite number expected, `{}` found",
                            self.header[*column],
                            excerpt(text)
                        );
                        fault(&self.file, "csv-number", message).at(*line, Some(column + 1))
                    })
                };
                columns.iter().map(number).collect()
            })
            .collect()
    }

    fn column(&self, name: &str) -> Result<usize, Failure> {
        if let Some(column) = self.header.iter().position(|h| h == name) {
            return Ok(column);
        }
        let message = format!("a column `{name}` expected, none found");
        let failure = fault(&self.file, "csv-missing-column", message).at(1, None);
        let mut others: Vec<&str> = self.header.iter().map(String::as_str).collect();
        let distance =
            |other: &&str| strsim::damerau_levenshtein(&name.to_lowercase(), &other.to_lowercase());
        others.sort_by_key(distance);
        others.truncate(4);
        let others: Vec<String> = others.iter().map(|o| format!("`{}`", excerpt(o))).collect();
        Err(failure.help(format!(
            "the first line names the columns; the nearest of them are {}",
            others.join(", ")
        )))
    }
}

/// Whether a row of raw inputs lies outside of the input box.
pub fn outside_box(inputs: &Inputs, row: &[f64]) -> bool {
    let edges = inputs.min.iter().zip(&inputs.max);
    row.iter()
        .zip(edges)
        .any(|(v, (min, max))| !(*min..=*max).contains(v))
}

/// A header and rows as CSV text.
pub fn to_csv(header: &[String], rows: impl Iterator<Item = Vec<String>>) -> String {
    let mut text = Vec::new();
    {
        let mut writer = csv::Writer::from_writer(&mut text);
        // Writing to memory does not fail.
        let _ = writer.write_record(header);
        for row in rows {
            let _ = writer.write_record(row);
        }
        let _ = writer.flush();
    }
    String::from_utf8_lossy(&text).into_owned()
}

/// Writes a file whole or not at all: beside its place, then renamed.
///
/// # Errors
/// If the system refuses it.
pub fn write_whole(path: &Path, text: &str) -> Result<(), Failure> {
    let mut aside = Aside::create(path, true)?;
    aside.write(text)?;
    aside.keep()
}

/// Counts lines along a text. The reader's own count is behind where it skipped empty lines.
struct Lines<'a> {
    text: &'a [u8],
    seen: usize,
    line: usize,
}

impl Lines<'_> {
    /// Line of the first character at or behind `start` that ends no line.
    fn at(&mut self, start: usize) -> usize {
        let rest = self.text.get(start..).unwrap_or_default();
        let empty = rest.iter().take_while(|c| matches!(c, b'\r' | b'\n'));
        let end = start + empty.count();
        let passed = self.text.get(self.seen..end).unwrap_or_default();
        self.line += passed.iter().filter(|c| **c == b'\n').count();
        self.seen = end.max(self.seen);
        self.line
    }
}

fn fault(file: &str, code: &'static str, message: impl Into<String>) -> Failure {
    Failure::input(code, message).file(file)
}

fn excerpt(text: &str) -> String {
    const MOST: usize = 40;
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

fn usize_of(line: u64) -> usize {
    usize::try_from(line).unwrap_or(usize::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(names: &[&str]) -> Vec<String> {
        names.iter().map(|n| (*n).to_owned()).collect()
    }

    fn refused(text: &str) -> (String, String) {
        let failure = Table::parse("f.csv", text.as_bytes())
            .and_then(|t| t.numbers(&names(&["a", "b"])))
            .expect_err(text);
        (failure.code.to_owned(), failure.to_string())
    }

    #[test]
    fn columns_come_in_any_order_among_others() {
        let text = "\u{feff}note,b, a\r\nx,1,-2.5e1\r\n\r\ny,3,4\r\n";
        let table = Table::parse("f.csv", text.as_bytes()).unwrap();
        let numbers = table.numbers(&names(&["a", "b"])).unwrap();
        assert_eq!(numbers, [[-25.0, 1.0], [4.0, 3.0]]);
    }

    #[test]
    fn refusals_name_line_and_column() {
        let cases = [
            (
                "",
                "csv-empty",
                "f.csv: a header with the names of the columns expected, an empty file found",
            ),
            (
                "a,b\n",
                "csv-empty",
                "f.csv:2: at least one row expected below the header, none found",
            ),
            (
                "a,B\n1,2\n",
                "csv-missing-column",
                "f.csv:1: a column `b` expected, none found",
            ),
            (
                "a,b,a\n1,2,3\n",
                "csv-duplicate-column",
                "f.csv:1:3: columns with different names expected, `a` found twice",
            ),
            (
                "a,b\n1,2\n3\n",
                "csv-ragged",
                "f.csv:3: 2 values expected, as many as in the header, 1 found",
            ),
            (
                "a,b\n\n1,x y\n",
                "csv-number",
                "f.csv:3:2: column `b`: a finite number expected, `x y` found",
            ),
            (
                "a,b\n1,nan\n",
                "csv-number",
                "f.csv:2:2: column `b`: a finite number expected, `nan` found",
            ),
            (
                "a,b\n-inf,1\n",
                "csv-number",
                "f.csv:2:1: column `a`: a finite number expected, `-inf` found",
            ),
            (
                "a,b\n1,1e999\n",
                "csv-number",
                "f.csv:2:2: column `b`: a finite number expected, `1e999` found",
            ),
            (
                "a,b\n1,\n",
                "csv-number",
                "f.csv:2:2: column `b`: a finite number expected, `` found",
            ),
        ];
        for (text, code, message) in cases {
            assert_eq!(refused(text), (code.to_owned(), message.to_owned()));
        }
    }

    #[test]
    fn bytes_that_are_no_text_are_refused() {
        let failure = Table::parse("f.csv", b"a,b\n1,\xff\n").unwrap_err();
        assert_eq!(failure.to_string(), "f.csv:2: text in UTF-8 expected");
    }
}
