//! Sums of constant multiples without multipliers: shifts and adders.
//!
//! A weight is a sum of signed powers of two, so a weighted sum is one of shifted words. Where weights
//! have few such digits this takes no multipliers and few clocks.

use std::collections::BTreeMap;

use crate::format::signed_width;

/// What an adder reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Source {
    /// A word of the vector.
    Input(usize),
    /// An adder before.
    Adder(usize),
}

/// A word, moved up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Term {
    /// The word.
    pub source: Source,
    /// Places that it is moved up.
    pub shift: u32,
}

/// One adder with its register.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Adder {
    /// What it adds to; zero where it turns a sign.
    pub a: Option<Term>,
    /// What is added to it, or subtracted.
    pub b: Term,
    /// `a - b`, not `a + b`.
    pub subtract: bool,
    /// Registers from the vector to the sum, its own included.
    pub level: usize,
    /// Bits that hold its sum for every vector.
    pub width: u32,
    /// The sum in terms of the inputs.
    pub weights: Vec<i64>,
}

/// Adders that bring forth weighted sums of a vector, a register behind each, a vector a clock.
///
/// Source of the search: the two-term patterns of Hartley, "Subexpression sharing in filters using
/// canonic signed digit multipliers", IEEE Trans. Circuits Syst. II 43(10), 1996.
///
/// ```
/// use hwgen_spec::adders::Adders;
/// // 5 x0 + 3 x1 and 5 x0 - 3 x1 share 4 x0 + x0 and 4 x1 - x1.
/// let adders = Adders::of(&[vec![5, 3], vec![5, -3]], 8);
/// assert_eq!((adders.adders.len(), adders.levels), (4, 2));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Adders {
    /// The adders, each after those that it reads.
    pub adders: Vec<Adder>,
    /// The sums; none where all weights are zero.
    pub outputs: Vec<Option<Term>>,
    /// Registers from the vector to the sums, which all come in the same clock; 1 or more.
    pub levels: usize,
    /// Clocks that each input waits for its last reader.
    pub input_waits: Vec<usize>,
    /// Clocks that each adder's sum waits, beyond its own register.
    pub adder_waits: Vec<usize>,
}

/// Digits of a canonic signed-digit number, not zero: places and signs, lowest first.
///
/// Source: Reitwiesner, "Binary arithmetic", Advances in Computers 1, 1960: no other form has fewer.
fn digits(code: i64) -> Vec<(u32, bool)> {
    let mut left = i128::from(code);
    let mut digits = Vec::new();
    let mut place = 0;
    while left != 0 {
        if left & 1 != 0 {
            let negative = left & 3 == 3;
            digits.push((place, negative));
            left += if negative { 1 } else { -1 };
        }
        left >>= 1;
        place += 1;
    }
    digits
}

/// Digits that are not zero, of all weights.
fn count_digits(weights: &[Vec<i64>]) -> usize {
    weights.iter().flatten().map(|w| digits(*w).len()).sum()
}

/// Digits of a layer at most: the search for shared sums takes the square of a row's.
const MOST_DIGITS: usize = 256;

/// A term of a sum with its sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Signed {
    source: Source,
    shift: u32,
    negative: bool,
}

/// Two terms, whatever their common shift and sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Pattern {
    a: (Source, u32),
    b: (Source, u32),
    subtract: bool,
}

impl Pattern {
    /// The pattern of two terms, and the shift and the sign that it has there.
    fn of(one: Signed, other: Signed) -> (Self, u32, bool) {
        let (a, b) = (one.min(other), one.max(other));
        let shift = a.shift.min(b.shift);
        let pattern = Self {
            a: (a.source, a.shift - shift),
            b: (b.source, b.shift - shift),
            subtract: a.negative != b.negative,
        };
        (pattern, shift, a.negative)
    }
}

/// What is under construction.
struct Search {
    inputs: usize,
    bits: u32,
    adders: Vec<Adder>,
}

impl Search {
    fn level(&self, source: Source) -> usize {
        match source {
            Source::Input(_) => 0,
            Source::Adder(k) => self.adders[k].level,
        }
    }

    /// Adds an adder; `a` none is zero.
    fn add(&mut self, a: Option<Term>, b: Term, subtract: bool) -> Source {
        let mut weights = vec![0; self.inputs];
        for (term, sign) in a
            .map(|a| (a, 1))
            .into_iter()
            .chain([(b, if subtract { -1 } else { 1 })])
        {
            match term.source {
                Source::Input(i) => weights[i] += sign << term.shift,
                Source::Adder(k) => {
                    for (sum, weight) in weights.iter_mut().zip(&self.adders[k].weights) {
                        *sum += sign * (weight << term.shift);
                    }
                }
            }
        }
        let level = a.into_iter().chain([b]).map(|t| self.level(t.source)).max();
        let width = self.width(&weights);
        self.adders.push(Adder {
            a,
            b,
            subtract,
            level: 1 + level.unwrap_or(0),
            width,
            weights,
        });
        Source::Adder(self.adders.len() - 1)
    }

    /// Bits of a weighted sum of any words.
    fn width(&self, weights: &[i64]) -> u32 {
        let most = (1i64 << (self.bits - 1)) - 1;
        let bound = |sign: i64| -> i64 {
            let greatest = |w: &i64| (sign * w * most).max(sign * w * (-most - 1));
            weights.iter().map(greatest).sum()
        };
        signed_width(-bound(-1), bound(1)).max(2)
    }

    /// Makes an adder of the pattern that comes most often, wherever it does; whether one came twice.
    fn share(&mut self, rows: &mut [Vec<Signed>]) -> bool {
        let mut counts: BTreeMap<Pattern, usize> = BTreeMap::new();
        for row in rows.iter() {
            let mut own: BTreeMap<Pattern, Vec<usize>> = BTreeMap::new();
            for (i, one) in row.iter().enumerate() {
                for (j, other) in row.iter().enumerate().skip(i + 1) {
                    let taken = own.entry(Pattern::of(*one, *other).0).or_default();
                    // A term counts in one pair.
                    if !taken.contains(&i) && !taken.contains(&j) {
                        taken.extend([i, j]);
                    }
                }
            }
            for (pattern, taken) in own {
                *counts.entry(pattern).or_default() += taken.len() / 2;
            }
        }
        let rank = |(pattern, count): &(Pattern, usize)| {
            let level = self.level(pattern.a.0).max(self.level(pattern.b.0));
            (std::cmp::Reverse(*count), level, *pattern)
        };
        let Some((pattern, _)) = counts.into_iter().filter(|c| c.1 > 1).min_by_key(rank) else {
            return false;
        };
        let term = |(source, shift)| Term { source, shift };
        let source = self.add(Some(term(pattern.a)), term(pattern.b), pattern.subtract);
        for row in rows {
            'again: loop {
                for i in 0..row.len() {
                    for j in i + 1..row.len() {
                        let (found, shift, negative) = Pattern::of(row[i], row[j]);
                        if found == pattern {
                            row.remove(j);
                            row[i] = Signed {
                                source,
                                shift,
                                negative,
                            };
                            continue 'again;
                        }
                    }
                }
                break;
            }
        }
        true
    }

    /// Adds the terms of a row, those of the lowest levels first.
    fn sum(&mut self, mut row: Vec<Signed>) -> Option<Term> {
        while row.len() > 1 {
            row.sort_by_key(|t| {
                (
                    std::cmp::Reverse(self.level(t.source)),
                    std::cmp::Reverse(*t),
                )
            });
            let (one, other) = (row.pop().expect("two terms"), row.pop().expect("two terms"));
            let (plus, minus) = if one.negative && !other.negative {
                (other, one)
            } else {
                (one, other)
            };
            let shift = plus.shift.min(minus.shift);
            let term = |t: Signed| Term {
                source: t.source,
                shift: t.shift - shift,
            };
            let subtract = plus.negative != minus.negative;
            let source = self.add(Some(term(plus)), term(minus), subtract);
            row.push(Signed {
                source,
                shift,
                negative: plus.negative,
            });
        }
        let last = row.pop()?;
        let term = Term {
            source: last.source,
            shift: last.shift,
        };
        if !last.negative {
            return Some(term);
        }
        let source = self.add(None, Term { shift: 0, ..term }, true);
        Some(Term { source, ..term })
    }
}

impl Adders {
    /// Adders for weights of few digits, at most three for every two weights that are not zero; none
    /// for others, where multipliers take less.
    pub fn of_short(weights: &[Vec<i64>], bits: u32) -> Option<Self> {
        let digits = count_digits(weights);
        let read = weights.iter().flatten().filter(|w| **w != 0).count();
        (read > 0 && 2 * digits <= 3 * read && digits <= MOST_DIGITS)
            .then(|| Self::of(weights, bits))
    }

    /// Adders for `weights`, `[out][in]`, of words of so many bits.
    pub fn of(weights: &[Vec<i64>], bits: u32) -> Self {
        let mut search = Search {
            inputs: weights[0].len(),
            bits,
            adders: Vec::new(),
        };
        let terms = |row: &Vec<i64>| -> Vec<Signed> {
            let inputs = row.iter().enumerate();
            inputs
                .flat_map(|(i, weight)| {
                    digits(*weight)
                        .into_iter()
                        .map(move |(shift, negative)| Signed {
                            source: Source::Input(i),
                            shift,
                            negative,
                        })
                })
                .collect()
        };
        let mut rows: Vec<Vec<Signed>> = weights.iter().map(terms).collect();
        while search.share(&mut rows) {}
        let outputs: Vec<Option<Term>> = rows.into_iter().map(|row| search.sum(row)).collect();
        let adders = search.adders;
        let levels = adders.iter().map(|a| a.level).max().unwrap_or(1);
        let mut input_waits = vec![0; weights[0].len()];
        let mut adder_waits = vec![0; adders.len()];
        let mut read = |source: Source, level: usize| match source {
            Source::Input(i) => input_waits[i] = input_waits[i].max(level - 1),
            Source::Adder(k) => {
                adder_waits[k] = adder_waits[k].max(level - 1 - adders[k].level);
            }
        };
        for adder in &adders {
            for term in adder.a.iter().chain([&adder.b]) {
                read(term.source, adder.level);
            }
        }
        // What stands behind the last level reads the sums.
        for term in outputs.iter().flatten() {
            read(term.source, levels + 1);
        }
        Self {
            adders,
            outputs,
            levels,
            input_waits,
            adder_waits,
        }
    }

    /// Bits of registers, those of words that wait included.
    pub fn register_bits(&self, input_bits: u32) -> usize {
        let to_usize = |bits: u32| usize::try_from(bits).expect("a small number");
        let inputs: usize = self.input_waits.iter().sum();
        let adders = self.adders.iter().zip(&self.adder_waits);
        adders
            .map(|(adder, waits)| (1 + waits) * to_usize(adder.width))
            .sum::<usize>()
            + inputs * to_usize(input_bits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::collection::vec;
    use proptest::prelude::*;

    #[test]
    fn digits_are_few_and_add_up() {
        for code in -5000i64..5000 {
            let digits = digits(code);
            let sum: i64 = digits
                .iter()
                .map(|(place, negative)| (1 << place) * if *negative { -1 } else { 1 })
                .sum();
            assert_eq!(sum, code);
            assert!(digits.windows(2).all(|d| d[1].0 > d[0].0 + 1));
        }
        assert_eq!(digits(i64::MIN).len(), 1);
    }

    fn weights_of(adders: &Adders, term: Option<Term>, inputs: usize) -> Vec<i64> {
        let mut weights = vec![0; inputs];
        if let Some(term) = term {
            match term.source {
                Source::Input(i) => weights[i] = 1 << term.shift,
                Source::Adder(k) => {
                    for (w, own) in weights.iter_mut().zip(&adders.adders[k].weights) {
                        *w = own << term.shift;
                    }
                }
            }
        }
        weights
    }

    proptest! {
        #[test]
        fn sums_are_those_of_the_weights(
            weights in (1..7usize, 0..10u32).prop_flat_map(|(inputs, log2)| {
                let most = 1i64 << log2;
                vec(vec(-most..=most, inputs), 1..7)
            }),
        ) {
            let adders = Adders::of(&weights, 8);
            for (row, term) in weights.iter().zip(&adders.outputs) {
                prop_assert_eq!(row, &weights_of(&adders, *term, row.len()));
            }
            // Never more than without sharing, but for a sign a row.
            prop_assert!(adders.adders.len() <= count_digits(&weights) + weights.len());
            for adder in &adders.adders {
                let most: i64 = adder.weights.iter().map(|w| w.abs() * 128).sum();
                prop_assert!(adder.width <= signed_width(-most, most).max(2));
            }
        }
    }

    #[test]
    fn nothing_to_add_is_one_level_of_waiting() {
        let adders = Adders::of(&[vec![4, 0], vec![0, 0]], 8);
        assert_eq!((adders.adders.len(), adders.levels), (0, 1));
        assert_eq!(adders.input_waits, [1, 0]);
        assert_eq!(
            adders.outputs,
            [
                Some(Term {
                    source: Source::Input(0),
                    shift: 2
                }),
                None
            ]
        );
    }
}
