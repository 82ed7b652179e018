//! Numbers to places along an axis, and the ticks beside it.

/// An axis from one place of the page to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    scale: Scale,
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scale {
    Linear,
    Logarithmic,
}

impl Axis {
    /// An axis on which equal steps are equally long.
    pub fn linear((low, high): (f64, f64), (from, to): (f64, f64)) -> Self {
        Self {
            scale: Scale::Linear,
            low,
            high,
            from,
            to,
        }
    }

    /// An axis on which equal factors are equally long, for numbers above zero.
    pub fn logarithmic((low, high): (f64, f64), (from, to): (f64, f64)) -> Self {
        debug_assert!(0.0 < low && low < high, "a range above zero expected");
        Self {
            scale: Scale::Logarithmic,
            low,
            high,
            from,
            to,
        }
    }

    /// The place of a number.
    pub fn at(&self, value: f64) -> f64 {
        let along = match self.scale {
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Logarithmic => (value / self.low).ln() / (self.high / self.low).ln(),
        };
        self.from + (self.to - self.from) * along
    }

    /// Whether a number is on the axis.
    pub fn holds(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }

    /// Round numbers along the axis, `most` of them if the axis is linear.
    pub fn ticks(&self, most: u32) -> Vec<f64> {
        match self.scale {
            Scale::Linear => {
                let step = rounded_up((self.high - self.low) / f64::from(most));
                let first = (self.low / step).ceil();
                (0..=most)
                    .map(|i| (first + f64::from(i)) * step)
                    .filter(|tick| *tick <= self.high)
                    .collect()
            }
            Scale::Logarithmic => steps(self.low, self.high),
        }
    }
}

/// The range of some numbers above zero, widened to 1, 2 or 5 times a power of ten.
pub fn decades(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let (low, high) = values
        .filter(|value| value.is_finite() && *value > 0.0)
        .fold((f64::INFINITY, 0.0f64), |(low, high), value| {
            (low.min(value), high.max(value))
        });
    if high == 0.0 {
        return None;
    }
    let all = steps(low / 10.0, high * 10.0);
    let below = all.iter().rev().find(|step| **step <= low)?;
    let above = all.iter().find(|step| **step >= high)?;
    let above = if above > below { *above } else { 2.0 * above };
    Some((*below, above))
}

/// 1, 2 and 5 times the powers of ten from one number to another.
fn steps(low: f64, high: f64) -> Vec<f64> {
    #[expect(clippy::cast_possible_truncation, reason = "exponents of doubles")]
    let exponents = (low.log10().floor() as i32)..=(high.log10().ceil() as i32);
    exponents
        .flat_map(|exponent| [1.0, 2.0, 5.0].map(|m| (m, exponent)))
        // Read, so that 0.2 is the double that is nearest to it.
        .filter_map(|(m, exponent)| format!("{m}e{exponent}").parse().ok())
        .filter(|step| (low..=high).contains(step))
        .collect()
}

/// The next of 1, 2 and 5 times a power of ten.
fn rounded_up(step: f64) -> f64 {
    steps(step, 10.0 * step).first().copied().unwrap_or(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_end_at_round_numbers() {
        let range = |values: &[f64]| decades(values.iter().copied());
        assert_eq!(range(&[0.137, 91.4, 0.0, f64::NAN]), Some((0.1, 100.0)));
        assert_eq!(range(&[2.0]), Some((2.0, 4.0)));
        assert_eq!(range(&[3.0, 3.0]), Some((2.0, 5.0)));
        assert_eq!(range(&[0.0]), None);
    }

    #[test]
    fn ticks_are_round_and_on_the_axis() {
        let axis = Axis::logarithmic((0.1, 5.0), (0.0, 100.0));
        assert_eq!(axis.ticks(9), [0.1, 0.2, 0.5, 1.0, 2.0, 5.0]);
        assert_eq!((axis.at(0.1), axis.at(5.0)), (0.0, 100.0));
        let axis = Axis::linear((0.0, 1280.0), (10.0, 20.0));
        assert_eq!(axis.ticks(5), [0.0, 500.0, 1000.0]);
        assert_eq!(axis.at(640.0), 15.0);
        assert!(axis.holds(1280.0) && !axis.holds(1281.0));
    }
}
