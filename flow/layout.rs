//! Tables and numbers for people.

/// Lays out rows in columns; the first row is the header. `alignment` has an `l` or `r` a column.
pub fn columns(alignment: &str, rows: &[Vec<String>]) -> String {
    let width = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let sides: Vec<(char, usize)> = alignment.chars().zip((0..).map(width)).collect();
    let mut text = String::new();
    for row in rows {
        let mut line = String::from(" ");
        for (cell, (side, width)) in row.iter().zip(&sides) {
            let padding = " ".repeat(width - cell.chars().count());
            line.push(' ');
            match side {
                'r' => line.extend([padding.as_str(), cell, " "]),
                _ => line.extend([cell, padding.as_str(), " "]),
            }
        }
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}

/// A row of cells.
macro_rules! row {
    ($($cell:expr),* $(,)?) => { vec![$($cell.to_string()),*] };
}
pub(crate) use row;

/// A number with four significant digits.
pub fn significant(value: f64) -> String {
    rounded(value, 4)
}

/// A number with so many significant digits, one to six.
pub fn rounded(value: f64, digits: u8) -> String {
    let after_first = usize::from(digits.clamp(1, 6)) - 1;
    let magnitude = value.abs();
    if value == 0.0 {
        "0".into()
    } else if !(1e-4..1e6).contains(&magnitude) {
        format!("{value:.after_first$e}")
    } else {
        #[expect(clippy::cast_precision_loss, reason = "0 to 5")]
        let digits = (after_first as f64 - magnitude.log10().floor()).max(0.0);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0 to 9"
        )]
        let digits = digits as usize;
        format!("{value:.digits$}")
    }
}

/// `1 frame`, `2 frames`.
pub fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// A word as a shell reads it, quoted where it has to be.
pub fn shell_word(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "._-/+=:,@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits() {
        let texts = [0.0, 12.34567, 0.001234567, -1.5, 123456.7, 1e-7, 2e9].map(significant);
        assert_eq!(
            texts,
            [
                "0", "12.35", "0.001235", "-1.500", "123457", "1.000e-7", "2.000e9"
            ]
        );
    }

    #[test]
    fn columns_are_aligned_without_trailing_blanks() {
        let rows = [row!["a", "n"], row!["long", 12], row!["b", ""]];
        assert_eq!(columns("lr", &rows), "  a      n\n  long  12\n  b\n");
    }
}
