//! Which clock the router is asked for, again and again, on one placement.
//!
//! A router that tears up late routes (nextpnr's `--tmg-ripup`) strives for the clock that it is told and
//! no further, and beyond what a placement allows comes to no end. So the highest clock is sought from
//! both sides, as the end of a sorted list of unknown length is (J. L. Bentley and A. C. Yao, "An almost
//! optimal algorithm for unbounded searching", 1976): the steps grow until one side is left, and then the
//! middle is asked for.

/// The least ratio of two clocks that are worth telling apart.
const NARROW: f64 = 1.03;
/// The first step.
const STEP: f64 = 1.06;
/// No clock above this is asked for. In MHz.
const HIGHEST: f64 = 2000.0;
/// Nor below this.
const LOWEST: f64 = 1.0;

/// The search as far as it has come.
///
/// ```
/// # use hwgen::synth::climb::Climb;
/// let ask = |first, likely, allowed| {
///     let mut climb = Climb::new(first, likely);
///     let mut asked = Vec::new();
///     while let Some(mhz) = climb.next() {
///         asked.push(mhz);
///         if mhz <= allowed { climb.made(mhz, mhz) } else { climb.missed(mhz) }
///     }
///     asked
/// };
/// assert_eq!(ask(100.0, None, 131.0), [100.0, 106.0, 119.1, 150.4, 133.8, 126.2, 129.9, 131.8]);
/// assert_eq!(ask(150.0, Some(120.0), 121.0), [150.0, 141.5, 125.9, 120.0, 122.9]);
/// assert_eq!(ask(150.0, Some(120.0), 131.0), [150.0, 141.5, 125.9, 133.5, 129.6, 131.5]);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Climb {
    first: f64,
    likely: Option<f64>,
    made: Option<f64>,
    missed: Option<f64>,
    /// The highest clock that was asked for and came to an end.
    ended: f64,
    step: f64,
}

impl Climb {
    /// Begins with a clock, and goes no lower than to one that is likely to be made before that is missed too;
    /// in MHz.
    pub fn new(first: f64, likely: Option<f64>) -> Self {
        Self {
            first,
            likely,
            made: None,
            missed: None,
            ended: 0.0,
            step: STEP,
        }
    }

    /// The clock to be asked for next, in MHz; none once the highest is known well enough.
    pub fn next(&self) -> Option<f64> {
        let mhz = match (self.made, self.missed) {
            (None, None) => return Some(self.first),
            (Some(made), None) => made * self.step,
            (None, Some(missed)) => {
                let likely = self.likely.filter(|&likely| likely < missed);
                (missed / self.step).max(likely.unwrap_or(LOWEST))
            }
            (Some(made), Some(missed)) if missed / made > NARROW => (made * missed).sqrt(),
            _ => return None,
        };
        let mhz = (mhz * 10.0).round() / 10.0;
        let below = self.missed.is_none_or(|missed| mhz < missed);
        (mhz > self.ended && below && (LOWEST..=HIGHEST).contains(&mhz)).then_some(mhz)
    }

    /// The router came to an end: what it was asked for and what it reached, in MHz. That may be a little
    /// less, for it knows only in the end what all of a path takes.
    pub fn made(&mut self, asked: f64, reached: f64) {
        self.grow(self.made.is_some());
        self.made = Some(self.made.map_or(reached, |made| made.max(reached)));
        self.ended = self.ended.max(asked);
    }

    /// A clock was not reached, in MHz.
    pub fn missed(&mut self, mhz: f64) {
        self.grow(self.missed.is_some());
        self.missed = Some(self.missed.map_or(mhz, |missed| missed.min(mhz)));
    }

    /// Another step the same way is twice as long.
    fn grow(&mut self, again: bool) {
        if again {
            self.step *= self.step;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_that_is_nearly_reached_is_not_asked_for_again() {
        let mut climb = Climb::new(150.0, Some(120.0));
        climb.made(150.0, 153.4);
        climb.missed(162.6);
        assert_eq!(climb.next(), Some(157.9));
        climb.made(157.9, 154.5);
        assert_eq!(climb.next(), Some(158.5));
        climb.made(158.5, 154.6);
        assert_eq!(climb.next(), None);
        // It is no bound either.
        let mut climb = Climb::new(150.0, None);
        climb.made(150.0, 149.4);
        assert_eq!(climb.next(), Some(158.4));
    }

    #[test]
    fn every_search_ends() {
        for tenths in 0..3000 {
            let allowed = f64::from(tenths) / 10.0;
            for first in [1.0, 2.3, 150.0, 1999.0] {
                let mut climb = Climb::new(first, Some(allowed * 0.7));
                let mut asked = Vec::new();
                while let Some(mhz) = climb.next() {
                    assert!(!asked.contains(&mhz), "{asked:?} {mhz}");
                    asked.push(mhz);
                    if mhz <= allowed {
                        // A little less than what was asked for, and a little more, in turns.
                        let by = if asked.len() % 2 == 0 { 0.99 } else { 1.01 };
                        climb.made(mhz, mhz * by);
                    } else {
                        climb.missed(mhz);
                    }
                }
                assert!(asked.len() < 30, "{asked:?}");
            }
        }
    }
}
