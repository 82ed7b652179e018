//! Compares what a model recorded with what a simulator dumped, register by register, clock by
//! clock.

use std::ops::ControlFlow;

use hwgen_spec::format::to_bits;

use crate::error::TraceError;
use crate::record::{Recording, Register, offsets};
use crate::trace::{Dump, Moment, RtlValue};

/// The outcome of a comparison that was made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Comparison {
    /// Registers compared.
    pub registers: usize,
    /// Rising edges compared, the one with the first difference included.
    pub edges: usize,
    /// Lane values times edges.
    pub values_compared: u64,
    /// The earliest difference, ties by the order of the registers; `None` means equal.
    pub first_difference: Option<Difference>,
}

/// Where model and simulator part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Number of the rising edge, from 0.
    pub clock: usize,
    /// Index of the register.
    pub register: usize,
    /// Its path from the core down.
    pub path: String,
    /// The lane, 0 in the lowest bits.
    pub lane: usize,
    /// The code in the model.
    pub model: i64,
    /// What the simulator had.
    pub rtl: RtlValue,
    /// Whether it was equal after the edge and changed before the next one.
    pub between: bool,
}

/// Compares a recording with a dump from rising edge `first_clock` on.
///
/// # Errors
/// If there is nothing to compare, or the dump is not one of this run.
pub fn compare(
    recording: &Recording,
    dump: &mut Dump,
    first_clock: usize,
) -> Result<Comparison, TraceError> {
    let plan = Plan {
        registers: recording.registers(),
        clocks: recording.clocks(),
        first_clock,
    };
    compare_rows(&plan, dump, |clock, row| {
        row.copy_from_slice(recording.row(clock));
    })
}

/// What is compared when there is no recording.
#[derive(Clone, Copy, Debug)]
pub struct Plan<'a> {
    /// The registers.
    pub registers: &'a [Register],
    /// Rising edges that the dump must have.
    pub clocks: usize,
    /// The first edge that is compared.
    pub first_clock: usize,
}

/// Compares a dump with a model that runs along: `model` is called for every clock from 0 on,
/// in order, and fills in all lanes. Needs no memory per clock.
///
/// # Errors
/// As [`compare`].
pub fn compare_rows(
    plan: &Plan<'_>,
    dump: &mut Dump,
    mut model: impl FnMut(usize, &mut [i64]),
) -> Result<Comparison, TraceError> {
    let registers = plan.registers;
    let masks: Vec<u64> = registers
        .iter()
        .flat_map(|r| r.lanes.iter().map(|bits| to_bits(-1, *bits)))
        .collect();
    let edges = plan.clocks.saturating_sub(plan.first_clock);
    if masks.is_empty() || edges == 0 {
        return Err(TraceError::Nothing {
            registers: registers.len(),
            edges,
        });
    }

    let mut expected = vec![0i64; masks.len()];
    let mut compared = 0;
    let mut first_difference = None;
    dump.replay(registers, plan.clocks, |moment, row| {
        // Between two edges a register keeps its value, and so do the ports.
        let (clock, edge) = match moment {
            Moment::Edge(clock) => (clock, true),
            Moment::Between(clock) => (clock, false),
        };
        if edge {
            model(clock, &mut expected);
        }
        if clock < plan.first_clock {
            return ControlFlow::Continue(());
        }
        compared += usize::from(edge);
        // One pass without branches decides for nearly every clock.
        let rtl = row.bits().iter().zip(row.unknown());
        let lanes = expected.iter().zip(&masks).zip(rtl);
        let wrong = lanes.fold(0, |wrong, ((model, mask), (bits, unknown))| {
            wrong | ((model.cast_unsigned() ^ bits) & mask) | unknown
        });
        if wrong == 0 {
            return ControlFlow::Continue(());
        }
        let Some(at) = (0..masks.len()).find(|&i| {
            let different = (expected[i].cast_unsigned() ^ row.bits()[i]) & masks[i];
            (different | row.unknown()[i]) != 0
        }) else {
            return ControlFlow::Continue(());
        };
        let starts = offsets(registers);
        let register = starts.partition_point(|start| *start <= at) - 1;
        let lane = at - starts[register];
        first_difference = Some(Difference {
            clock,
            register,
            path: registers[register].path.clone(),
            lane,
            model: expected[at],
            rtl: row.value(at, registers[register].lanes[lane]),
            between: !edge,
        });
        ControlFlow::Break(())
    })?;

    let per_edge = u64::try_from(masks.len()).unwrap_or(u64::MAX);
    Ok(Comparison {
        registers: registers.len(),
        edges: compared,
        values_compared: per_edge * u64::try_from(compared).unwrap_or(u64::MAX),
        first_difference,
    })
}
