//! Fixed-point words: formats, rounding, saturation and width arithmetic.
//!
//! A word is an integer *code*; its format says which real number the code stands for.
//! Formats are chosen at run time, so they are values, not types.
//! All rounding, saturation and width arithmetic of the project is in this module.

use std::fmt;
use std::str::FromStr;

use fixed::types::I64F64;

/// A signed two's-complement format `Qm.n`: `1 + m + n` bits, `n` of them fraction bits.
///
/// `m` may be negative and `n` may be negative or exceed the width, for power-of-two scales.
///
/// # Format
/// The code `c` stands for `c * 2^-n`, and `-2^(m+n) <= c <= 2^(m+n) - 1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct QFormat {
    width: u32,
    fraction: i32,
}

/// Widest word that codes are kept in: sums stay below so that `i64` is exact.
pub const MAX_WIDTH: u32 = 62;

/// What a text that is no `Qm.n` was missing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FormatError {
    /// Not of the shape `Qm.n`.
    #[error("a format `Qm.n` with integers m and n expected, `{0}` found")]
    Syntax(String),
    /// `1 + m + n` is no usable width.
    #[error("a width 1 + m + n of 1 to {MAX_WIDTH} bits expected, {0} found")]
    Width(i64),
    /// `n` is no usable number of fraction bits.
    #[error("-1000 to 1000 fraction bits expected, {0} found")]
    Fraction(i32),
}

/// How a value between two codes is brought to one of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounding {
    /// To the nearest code, ties towards plus infinity: `floor(x + 1/2)`.
    HalfUp,
    /// Towards minus infinity: `floor(x)`, what dropping bits does.
    Floor,
}

/// A code, and whether it was clipped to the format's range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Saturated {
    /// The code within the range.
    pub code: i64,
    /// True if the exact value was outside.
    pub clipped: bool,
}

impl QFormat {
    /// A format of `width` bits (1 to [`MAX_WIDTH`]) with `fraction` fraction bits.
    ///
    /// # Errors
    /// [`FormatError::Width`] if the width is out of range.
    pub fn new(width: u32, fraction: i32) -> Result<Self, FormatError> {
        if !(1..=MAX_WIDTH).contains(&width) {
            return Err(FormatError::Width(i64::from(width)));
        }
        if !(-1000..=1000).contains(&fraction) {
            return Err(FormatError::Fraction(fraction));
        }
        Ok(Self { width, fraction })
    }

    /// The finest format of `width` bits that holds every value of `[low, high]`.
    pub fn holding(width: u32, low: f64, high: f64) -> Result<Self, FormatError> {
        let magnitude = low.abs().max(high.abs());
        // The upper end is one step short of the power of two: try from fine to coarse.
        let mut integer = if magnitude == 0.0 {
            0
        } else {
            libm::ilogb(magnitude) - 1
        };
        loop {
            let format = Self::new(width, to_i32(width) - 1 - integer)?;
            if format.fits(low) && format.fits(high) {
                return Ok(format);
            }
            integer += 1;
        }
    }

    /// The narrowest format with `fraction` fraction bits that holds every value of `[low, high]`.
    pub fn with_fraction(fraction: i32, low: f64, high: f64) -> Result<Self, FormatError> {
        (1..=MAX_WIDTH)
            .filter_map(|width| Self::new(width, fraction).ok())
            .find(|format| format.fits(low) && format.fits(high))
            .ok_or(FormatError::Width(i64::from(MAX_WIDTH) + 1))
    }

    fn fits(self, value: f64) -> bool {
        !self.quantize(value, Rounding::HalfUp).clipped
    }

    /// Bits of the word, sign included.
    pub fn width(self) -> u32 {
        self.width
    }

    /// Fraction bits, `n` of `Qm.n`.
    pub fn fraction(self) -> i32 {
        self.fraction
    }

    /// Integer bits without the sign, `m` of `Qm.n`.
    pub fn integer(self) -> i32 {
        to_i32(self.width) - 1 - self.fraction
    }

    /// The least code.
    #[inline]
    pub fn min_code(self) -> i64 {
        -(1i64 << (self.width - 1))
    }

    /// The greatest code.
    #[inline]
    pub fn max_code(self) -> i64 {
        (1i64 << (self.width - 1)) - 1
    }

    /// The real number between two neighbouring codes.
    pub fn step(self) -> f64 {
        libm::ldexp(1.0, -self.fraction)
    }

    /// Rounds a real number to a code and saturates it.
    pub fn quantize(self, value: f64, rounding: Rounding) -> Saturated {
        // ldexp is exact, and beyond 2^53 a double has no fraction left to round.
        let scaled = libm::ldexp(value, self.fraction);
        let floor = scaled.floor();
        let rounded = match rounding {
            Rounding::HalfUp if scaled - floor >= 0.5 => floor + 1.0,
            Rounding::HalfUp | Rounding::Floor => floor,
        };
        // The cast saturates; a NaN cannot come here, the reader refuses it.
        #[expect(
            clippy::cast_possible_truncation,
            reason = "saturation is what is wanted"
        )]
        self.saturate(rounded as i64)
    }

    /// Clips an integer in units of this format's step to its range.
    #[inline]
    pub fn saturate(self, code: i64) -> Saturated {
        let clipped_code = code.clamp(self.min_code(), self.max_code());
        Saturated {
            code: clipped_code,
            clipped: clipped_code != code,
        }
    }

    /// The code if `value` is a multiple of the step inside the range.
    pub fn exact_code(self, value: f64) -> Option<i64> {
        let q = self.quantize(value, Rounding::Floor);
        (!q.clipped && self.to_f64(q.code) == value).then_some(q.code)
    }

    /// The real number that a code stands for; exact while the code has at most 53 bits.
    pub fn to_f64(self, code: i64) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "documented")]
        libm::ldexp(code as f64, -self.fraction)
    }

    /// Reads a decimal number and rounds it once, to the nearest code (ties up), and saturates it.
    ///
    /// Returns `None` if the text is no finite number.
    pub fn parse_decimal(self, text: &str) -> Option<Saturated> {
        let text = text.trim();
        let value: f64 = text.parse().ok().filter(|v: &f64| v.is_finite())?;
        let shift = 64 - self.fraction;
        // The wide fixed-point type reads the decimal digits themselves and rounds them to its
        // last bit, which decides nothing but whether the number is above or below a tie.
        match I64F64::from_str(text) {
            Ok(wide) if (1..=100).contains(&shift) => {
                let (bits, shift) = (wide.to_bits(), shift.unsigned_abs());
                if bits & ((1i128 << shift) - 1) != 1i128 << (shift - 1) {
                    let code = shift_right_i128(bits, shift, Rounding::HalfUp);
                    // Between the ties even a code beyond 63 bits is beyond on the same side.
                    return Some(i64::try_from(code).map_or_else(
                        |_| self.quantize(value, Rounding::HalfUp),
                        |code| self.saturate(code),
                    ));
                }
            }
            _ => {}
        }
        Some(self.round_digits(text, value))
    }

    /// Rounds the decimal number `text`, a finite double `value` apart from its rounding, by
    /// doubling or halving its digits.
    fn round_digits(self, text: &str, value: f64) -> Saturated {
        let (number, exponent) = match text.split_once(['e', 'E']) {
            Some((number, exponent)) => (number, exponent.parse().unwrap_or(0)),
            None => (text, 0i64),
        };
        let number = number.trim_start_matches(['+', '-']);
        let (whole, part) = number.split_once('.').unwrap_or((number, ""));
        let mut digits: Vec<u8> = whole
            .bytes()
            .chain(part.bytes())
            .map(|b| b - b'0')
            .collect();
        // Digits before the point. A double that isn't zero has it near.
        let mut point = i64::try_from(whole.len())
            .unwrap_or(i64::MAX)
            .saturating_add(exponent);
        if value == 0.0 || digits.iter().all(|d| *d == 0) {
            return self.saturate(0);
        }
        while point > i64::try_from(digits.len()).unwrap_or(i64::MAX) {
            digits.push(0);
        }
        while point < 1 {
            digits.insert(0, 0);
            point += 1;
        }
        let mut point = usize::try_from(point).expect("1 or more");
        // Twice the code, so that its lowest bit tells of a half.
        for _ in 0..self.fraction + 1 {
            let mut carry = 0;
            for digit in digits.iter_mut().rev() {
                let doubled = 2 * *digit + carry;
                (*digit, carry) = (doubled % 10, doubled / 10);
            }
            if carry > 0 {
                digits.insert(0, carry);
                point += 1;
            }
        }
        for _ in self.fraction + 1..0 {
            let mut rest = 0;
            for digit in &mut digits {
                let value = 10 * rest + *digit;
                (*digit, rest) = (value / 2, value % 2);
            }
            if rest > 0 {
                digits.push(5);
            }
        }
        let (whole, part) = digits.split_at(point);
        let twice = whole.iter().fold(0i64, |sum, digit| {
            sum.saturating_mul(10).saturating_add(i64::from(*digit))
        });
        let exact = part.iter().all(|d| *d == 0);
        self.saturate(if value > 0.0 {
            (twice >> 1) + (twice & 1)
        } else if exact {
            -(twice >> 1)
        } else {
            -((twice >> 1) + (twice & 1))
        })
    }
}

/// `value / 2^shift`, rounded.
#[inline]
pub fn shift_right(value: i64, shift: u32, rounding: Rounding) -> i64 {
    let floor = value >> shift.min(63);
    // The bit below the result: beyond the word it is the sign.
    let half_bit = |shift: u32| value >> (shift - 1).min(63) & 1;
    match rounding {
        Rounding::HalfUp if shift > 0 => floor + half_bit(shift),
        Rounding::HalfUp | Rounding::Floor => floor,
    }
}

fn shift_right_i128(value: i128, shift: u32, rounding: Rounding) -> i128 {
    let floor = value >> shift.min(127);
    match rounding {
        Rounding::HalfUp if shift > 0 && (value >> (shift - 1)) & 1 == 1 => floor + 1,
        Rounding::HalfUp | Rounding::Floor => floor,
    }
}

/// Half of `2^shift`: what is added before `shift` bits are dropped to round half up.
///
/// Beyond 63 places it stays at `2^62`, more than any word of [`MAX_WIDTH`] bits.
#[inline]
pub fn half(shift: u32) -> i64 {
    match shift {
        0 => 0,
        _ => 1i64 << (shift - 1).min(62),
    }
}

/// Bits of the narrowest signed word that holds every integer of `[low, high]`.
pub fn signed_width(low: i64, high: i64) -> u32 {
    let bits = |v: i64| {
        65 - if v < 0 {
            (!v).leading_zeros()
        } else {
            v.leading_zeros()
        }
    };
    bits(low).max(bits(high)).max(1)
}

/// Bits of the narrowest unsigned word that holds `0..=high`, at least one.
pub fn unsigned_width(high: u64) -> u32 {
    (64 - high.leading_zeros()).max(1)
}

/// The lowest `width` bits of a code, as they stand in a register.
#[inline]
pub fn to_bits(code: i64, width: u32) -> u64 {
    code.cast_unsigned() & (u64::MAX >> (64 - width))
}

/// The code whose lowest `width` bits are these: the inverse of [`to_bits`].
#[inline]
pub fn from_bits(bits: u64, width: u32) -> i64 {
    (bits << (64 - width)).cast_signed() >> (64 - width)
}

fn to_i32(width: u32) -> i32 {
    width.cast_signed()
}

impl fmt::Display for QFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Q{}.{}", self.integer(), self.fraction)
    }
}

impl FromStr for QFormat {
    type Err = FormatError;

    fn from_str(text: &str) -> Result<Self, FormatError> {
        let syntax = || FormatError::Syntax(text.to_owned());
        let (m, n) = text
            .strip_prefix('Q')
            .and_then(|t| t.split_once('.'))
            .ok_or_else(syntax)?;
        let (m, n): (i32, i32) = (
            m.parse().map_err(|_| syntax())?,
            n.parse().map_err(|_| syntax())?,
        );
        let width = 1 + i64::from(m) + i64::from(n);
        u32::try_from(width)
            .ok()
            .and_then(|w| Self::new(w, n).ok())
            .ok_or(FormatError::Width(width))
    }
}

impl serde::Serialize for QFormat {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}
