//! How registers are shown to the outside: one walk for their names and for their values.

use std::fmt;

/// Is shown every architectural register of the model, always in the same order.
///
/// Names and values come from the same walk, so that they can't fall apart.
pub trait Probe {
    /// Steps into an instance or generate block.
    fn enter(&mut self, scope: fmt::Arguments<'_>);
    /// Steps out again.
    fn leave(&mut self);
    /// A packed register of equal words, the first in the lowest bits.
    fn words(&mut self, name: &str, bits: u32, values: &[i64]);
    /// A packed register of unequal fields, the first in the lowest bits.
    fn fields(&mut self, name: &str, bits: &[u32], values: &[i64]);

    /// A register whose value is not shown: its name and width alone are known.
    fn interior(&mut self, _name: &str, _bits: u32) {}

    /// A register of one word.
    fn word(&mut self, name: &str, bits: u32, value: i64) {
        self.words(name, bits, &[value]);
    }

    /// A register of one bit.
    fn bit(&mut self, name: &str, value: bool) {
        self.words(name, 1, &[i64::from(value)]);
    }

    /// A counter.
    fn count(&mut self, name: &str, bits: u32, value: usize) {
        self.words(
            name,
            bits,
            &[i64::try_from(value).expect("a counter of few bits")],
        );
    }
}

/// Shows an instance below a scope.
pub(super) fn within<P: Probe>(
    probe: &mut P,
    scope: fmt::Arguments<'_>,
    show: impl FnOnce(&mut P),
) {
    probe.enter(scope);
    show(probe);
    probe.leave();
}

/// The registers around the blocks of a multiplier that takes several: they are built as the operands'
/// widths ask for, and some synthesis tools move them into the blocks.
pub(super) fn show_wide<P: Probe>(probe: &mut P, a_bits: u32, b_bits: u32) {
    within(probe, format_args!("g_wide"), |probe| {
        probe.interior("a_r", a_bits);
        probe.interior("b_r", b_bits);
        probe.interior("p_r", a_bits + b_bits);
    });
}

/// The registers of a multiplier of adders, of whose second operand each pair of bits makes a sum, and
/// two pairs another: `[(a, b); 2]` are the operands of one and two clocks ago.
pub(super) fn show_adders<P: Probe>(
    probe: &mut P,
    (a_bits, b_bits): (u32, u32),
    operands: [(i64, i64); 2],
) {
    let pairs = b_bits.div_ceil(2);
    let pair = |(a, b): (i64, i64), i: u32| {
        let bits = b >> (2 * i);
        // The highest bit has a negative weight; of an odd number of bits it is there twice.
        match i + 1 == pairs {
            true => a * ((bits & 1) - (bits & 2)),
            false => a * (bits & 3),
        }
    };
    for i in 0..pairs {
        within(probe, format_args!("g_pair[{i}]"), |probe| {
            probe.word("sum_q", a_bits + 2, pair(operands[0], i));
        });
    }
    for i in 0..pairs.div_ceil(2) {
        within(probe, format_args!("g_quad[{i}]"), |probe| {
            let high = match 2 * i + 1 < pairs {
                true => pair(operands[1], 2 * i + 1),
                false => 0,
            };
            probe.word("sum_q", a_bits + 4, pair(operands[1], 2 * i) + 4 * high);
        });
    }
}

/// `$clog2(n + 1)`: bits of a counter that reaches `n`.
pub(super) fn counter_bits(n: usize) -> u32 {
    usize::BITS - n.leading_zeros()
}

/// Bits of an address of `words` words, at least one.
pub(super) fn address_bits(words: usize) -> u32 {
    counter_bits(words - 1).max(1)
}
