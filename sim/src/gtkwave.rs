//! Save files for GTKWave that show some signals around a time.

use std::fmt::Write;
use std::path::Path;

use crate::trace::{PERIOD_PS, edge_time_ps};

/// What a save file shows.
#[derive(Clone, Debug)]
pub struct View<'a> {
    /// The dump, as GTKWave shall open it: best relative to the save file.
    pub dump: &'a Path,
    /// Instances above the signals, `echo_tb_icarus.u_tb.u_dut` or `TOP.echo_tb.u_dut`.
    pub scope: &'a str,
    /// The signals, from the top down.
    pub signals: &'a [Signal],
    /// The rising edge that the marker stands on.
    pub clock: usize,
    /// Clocks to be seen before it.
    pub clocks_before: usize,
}

/// A signal in a view.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Signal {
    /// Path from the core down.
    pub path: String,
    /// Bits.
    pub bits: u64,
    /// How it is shown.
    pub radix: Radix,
}

/// How the bits of a signal are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Radix {
    /// For single bits.
    Binary,
    /// For vectors of several lanes.
    Hexadecimal,
    /// For one signed word.
    SignedDecimal,
}

/// The text of a `.gtkw` file.
///
/// # Units
/// Its times are picoseconds, the time unit of all dumps.
pub fn save_file(view: &View<'_>) -> String {
    let marker = edge_time_ps(view.clock);
    let span = PERIOD_PS.saturating_mul(u64::try_from(view.clocks_before).unwrap_or(u64::MAX));
    let mut text = String::from("[*] hwgen\n");
    // Writing to a string cannot fail.
    let _ = writeln!(text, "[dumpfile] \"{}\"", view.dump.display());
    let _ = writeln!(text, "[timestart] {}", marker.saturating_sub(span));
    // Zoom is the power of two of picoseconds a pixel, negative; 2^8 shows about 25 clocks.
    let _ = writeln!(text, "*-8.000000 {marker}{}", " -1".repeat(26));
    for signal in view.signals {
        let flags = match signal.radix {
            Radix::Binary => "@28",
            Radix::Hexadecimal => "@22",
            Radix::SignedDecimal => "@420",
        };
        let range = match signal.bits {
            1 => String::new(),
            bits => format!("[{}:0]", bits.saturating_sub(1)),
        };
        let _ = writeln!(text, "{flags}\n{}.{}{range}", view.scope, signal.path);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_marker_stands_on_the_edge() {
        let signals = [
            Signal {
                path: "valid_q".to_owned(),
                bits: 1,
                radix: Radix::Binary,
            },
            Signal {
                path: "g_pe[0].acc_q".to_owned(),
                bits: 18,
                radix: Radix::SignedDecimal,
            },
        ];
        let text = save_file(&View {
            dump: Path::new("icarus.fst"),
            scope: "echo_tb_icarus.u_tb.u_dut",
            signals: &signals,
            clock: 7,
            clocks_before: 3,
        });
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[1], "[dumpfile] \"icarus.fst\"");
        assert_eq!(lines[2], "[timestart] 45000");
        assert!(lines[3].starts_with("*-8.000000 75000 -1"));
        assert_eq!(
            lines[4..],
            [
                "@28",
                "echo_tb_icarus.u_tb.u_dut.valid_q",
                "@420",
                "echo_tb_icarus.u_tb.u_dut.g_pe[0].acc_q[17:0]",
            ]
        );
    }
}
