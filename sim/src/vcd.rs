//! Writes a recording as VCD, so that it opens beside a simulator's dump.
//!
//! Names, hierarchy below `u_dut`, time scale and times are those of the simulators.
//! Before rising edge 0 every register is X, for the recording says nothing about it.

use std::collections::BTreeMap;
use std::io::{self, Write};

use hwgen_spec::format::to_bits;

use crate::record::{Recording, Register};
use crate::trace::{PERIOD_PS, edge_time_ps};

/// Writes the whole recording under the instance `<design>_model.u_dut`.
///
/// # Errors
/// If `out` cannot be written.
pub fn write(recording: &Recording, design: &str, out: impl Write) -> io::Result<()> {
    let mut out = io::BufWriter::new(out);
    let registers = recording.registers();
    writeln!(out, "$version hwgen model $end")?;
    writeln!(out, "$timescale 1ps $end")?;
    writeln!(out, "$scope module {design}_model $end")?;
    writeln!(out, "$scope module u_dut $end")?;
    writeln!(out, "$var wire 1 {} aclk $end", code(0))?;
    let mut tree = Scope::default();
    for (index, register) in registers.iter().enumerate() {
        tree.add(&register.path, index);
    }
    tree.write(registers, &mut out)?;
    writeln!(out, "$upscope $end\n$upscope $end\n$enddefinitions $end")?;

    writeln!(out, "#0\n$dumpvars\n0{}", code(0))?;
    for index in 0..registers.len() {
        writeln!(out, "bx {}", code(index + 1))?;
    }
    writeln!(out, "$end")?;
    for clock in 0..recording.clocks() {
        writeln!(out, "#{}\n1{}", edge_time_ps(clock), code(0))?;
        for (index, register) in registers.iter().enumerate() {
            let values = recording.values(clock, index);
            if clock > 0 && same(register, values, recording.values(clock - 1, index)) {
                continue;
            }
            write_value(register, values, &mut out)?;
            writeln!(out, " {}", code(index + 1))?;
        }
        writeln!(
            out,
            "#{}\n0{}",
            edge_time_ps(clock) + PERIOD_PS / 2,
            code(0)
        )?;
    }
    out.flush()
}

fn same(register: &Register, now: &[i64], before: &[i64]) -> bool {
    let lanes = register.lanes.iter().zip(now.iter().zip(before));
    lanes
        .into_iter()
        .all(|(bits, (now, before))| to_bits(now ^ before, *bits) == 0)
}

fn write_value(register: &Register, values: &[i64], out: &mut impl Write) -> io::Result<()> {
    write!(out, "b")?;
    for (value, bits) in values.iter().zip(&register.lanes).rev() {
        let width = usize::try_from(*bits).unwrap_or(0);
        write!(out, "{:0width$b}", to_bits(*value, *bits))?;
    }
    Ok(())
}

/// Short name of a signal in the file: printable ASCII, number to the base 94.
fn code(mut number: usize) -> String {
    let mut text = String::new();
    loop {
        let digit = u8::try_from(number % 94).unwrap_or(0);
        text.push(char::from(b'!' + digit));
        number /= 94;
        if number == 0 {
            return text;
        }
        number -= 1;
    }
}

/// Registers by instance.
#[derive(Default)]
struct Scope {
    registers: Vec<(String, usize)>,
    inner: BTreeMap<String, Scope>,
}

impl Scope {
    fn add(&mut self, path: &str, index: usize) {
        match path.split_once('.') {
            Some((scope, rest)) => {
                let inner = self.inner.entry(scope.to_owned()).or_default();
                inner.add(rest, index);
            }
            None => self.registers.push((path.to_owned(), index)),
        }
    }

    fn write(&self, registers: &[Register], out: &mut impl Write) -> io::Result<()> {
        for (name, index) in &self.registers {
            let bits = registers[*index].bits();
            let range = match bits {
                1 => String::new(),
                _ => format!(" [{}:0]", bits - 1),
            };
            writeln!(
                out,
                "$var reg {bits} {} {name}{range} $end",
                code(index + 1)
            )?;
        }
        for (name, scope) in &self.inner {
            writeln!(out, "$scope module {name} $end")?;
            scope.write(registers, out)?;
            writeln!(out, "$upscope $end")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::compare;
    use crate::error::TraceError;
    use crate::trace::{Dump, RtlValue};

    fn recording() -> Recording {
        let register = |path: &str, bits, lanes| Register::uniform(path, bits, lanes);
        let mut recording = Recording::new(vec![
            register("valid_q", 1, 1),
            register("u_a.g_pe[0].u_pe.acc_q", 62, 5),
            register("u_a.g_pe[1].u_pe.acc_q", 7, 3),
            register("u_a.wide_q", 13, 200),
        ]);
        for clock in 0..300i64 {
            let row: Vec<i64> = (0..209)
                .map(|lane| (clock / 3 + lane).wrapping_mul(0x5DEE_CE66_D1CE) ^ -clock)
                .collect();
            recording.push(&row);
        }
        recording
    }

    fn dumped(recording: &Recording, directory: &tempfile::TempDir) -> Dump {
        let path = directory.path().join("model.vcd");
        let file = std::fs::File::create(&path).expect("a file");
        write(recording, "test", file).expect("written");
        Dump::open(&path).expect("readable")
    }

    #[test]
    fn what_is_written_reads_back_as_equal() {
        let directory = tempfile::tempdir().expect("a directory");
        let recording = recording();
        let mut dump = dumped(&recording, &directory);
        let comparison = compare(&recording, &mut dump, 0).expect("comparable");
        assert_eq!(comparison.first_difference, None);
        assert_eq!(comparison.registers, 4);
        assert_eq!(comparison.edges, 300);
        assert_eq!(comparison.values_compared, 300 * 209);
    }

    #[test]
    fn one_altered_value_is_found_where_it_is() {
        let directory = tempfile::tempdir().expect("a directory");
        let recording = recording();
        for (clock, lane, register, lane_in_register) in [
            (0, 0, 0, 0),
            (17, 5, 1, 4),
            (150, 6, 2, 0),
            (299, 208, 3, 199),
        ] {
            let mut altered = recording.clone();
            altered.row_mut(clock)[lane] ^= 1;
            let mut dump = dumped(&altered, &directory);
            let comparison = compare(&recording, &mut dump, 0).expect("comparable");
            let found = comparison.first_difference.expect("a difference");
            assert_eq!(
                (found.clock, found.register, found.lane),
                (clock, register, lane_in_register)
            );
            assert_eq!(found.path, recording.registers()[register].path);
            let bits = recording.registers()[register].lanes[lane_in_register];
            let RtlValue::Known(rtl) = found.rtl else {
                panic!("known");
            };
            assert_eq!(to_bits(rtl, bits), to_bits(found.model ^ 1, bits));
            // The same, but not looked at.
            let mut dump = dumped(&altered, &directory);
            let later = compare(&recording, &mut dump, clock + 1);
            match later {
                Ok(comparison) => assert_eq!(comparison.first_difference, None),
                Err(TraceError::Nothing { edges: 0, .. }) => assert_eq!(clock, 299),
                Err(other) => panic!("{other}"),
            }
        }
    }

    #[test]
    fn bits_above_the_lane_do_not_count() {
        let directory = tempfile::tempdir().expect("a directory");
        let recording = recording();
        let mut altered = recording.clone();
        altered.row_mut(40)[6] ^= 1 << 7;
        let mut dump = dumped(&recording, &directory);
        let comparison = compare(&altered, &mut dump, 0).expect("comparable");
        assert_eq!(comparison.first_difference, None);
    }

    #[test]
    fn a_dump_of_another_length_or_without_a_register_is_refused() {
        let directory = tempfile::tempdir().expect("a directory");
        let recording = recording();
        let mut longer = recording.clone();
        longer.push(&[0; 209]);
        let error = compare(&longer, &mut dumped(&recording, &directory), 0).unwrap_err();
        assert!(
            matches!(
                error,
                TraceError::EdgeCount {
                    expected: 301,
                    found: 300
                }
            ),
            "{error}"
        );
        let error = compare(&recording, &mut dumped(&longer, &directory), 0).unwrap_err();
        assert!(
            matches!(
                error,
                TraceError::EdgeCount {
                    expected: 300,
                    found: 301
                }
            ),
            "{error}"
        );

        let misspelt = Register::uniform("u_a.g_pe[1].u_pe.sum_q", 7, 3);
        let mut dump = dumped(&recording, &directory);
        let error = dump.values(&misspelt, 300).unwrap_err();
        let TraceError::MissingRegister { register, nearest } = error else {
            panic!("{error}");
        };
        assert_eq!(register, misspelt.path);
        assert_eq!(nearest[0], "u_a.g_pe[1].u_pe.acc_q");

        let narrow = Register::uniform("valid_q", 2, 1);
        let error = dump.values(&narrow, 300).unwrap_err();
        assert!(
            matches!(
                error,
                TraceError::Width {
                    expected: 2,
                    found: 1,
                    ..
                }
            ),
            "{error}"
        );
    }

    #[test]
    fn nothing_to_compare_is_an_error() {
        let directory = tempfile::tempdir().expect("a directory");
        let recording = recording();
        let mut dump = dumped(&recording, &directory);
        let error = compare(&recording, &mut dump, 300).unwrap_err();
        assert!(matches!(error, TraceError::Nothing { edges: 0, .. }));
        let mut empty = Recording::new(Vec::new());
        empty.push(&[]);
        let error = compare(&empty, &mut dump, 0).unwrap_err();
        assert!(matches!(error, TraceError::Nothing { registers: 0, .. }));
    }

    #[test]
    fn no_dump_and_half_a_dump_are_errors() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("x.vcd");
        assert!(Dump::open(&path).is_err());
        for text in [
            "",
            "garbage\n",
            "$timescale 1ps $end\n$enddefinitions $end\n#0\n",
        ] {
            std::fs::write(&path, text).expect("written");
            assert!(Dump::open(&path).is_err(), "{text:?}");
        }
        let recording = recording();
        drop(dumped(&recording, &directory));
        let whole = std::fs::read(directory.path().join("model.vcd")).expect("a dump");
        for part in [2, 3, 5] {
            std::fs::write(&path, &whole[..whole.len() * part / 6]).expect("written");
            let outcome = Dump::open(&path).and_then(|mut d| compare(&recording, &mut d, 0));
            // The cut may fall into a value: then that is what differs.
            let equal = matches!(&outcome, Ok(c) if c.first_difference.is_none());
            assert!(!equal, "{outcome:?}");
        }
    }

    #[test]
    fn codes_are_unique() {
        let codes: std::collections::HashSet<String> = (0..20_000).map(code).collect();
        assert_eq!(codes.len(), 20_000);
    }
}
