//! Words: rounding, saturation, shifts, widths, decimals.

use fixed::types::extra::{U0, U1, U4, U12, U20, U32};
use fixed::types::{I32F32, I64F64};
use fixed::{FixedI64, FixedI128};
use hwgen_spec::format::{
    MAX_WIDTH, QFormat, Rounding, from_bits, half, shift_right, signed_width, to_bits,
    unsigned_width,
};
use proptest::prelude::*;

use super::{clip, floor_shift, ldexp};

fn format(width: u32, fraction: i32) -> QFormat {
    QFormat::new(width, fraction).expect("a format")
}

/// A double as `mantissa * 2^exponent`.
fn parts(value: f64) -> (i128, i32) {
    let bits = value.to_bits();
    let exponent = i32::try_from(bits >> 52 & 0x7ff).expect("11 bits");
    let mantissa = i128::from(bits & ((1 << 52) - 1));
    let (mantissa, exponent) = match exponent {
        0 => (mantissa, -1074),
        _ => (mantissa | 1 << 52, exponent - 1075),
    };
    (if value < 0.0 { -mantissa } else { mantissa }, exponent)
}

/// What `quantize` has to give, from the bits of the double.
fn quantized(value: f64, width: u32, fraction: i32, rounding: Rounding) -> (i64, bool) {
    let (mantissa, exponent) = parts(value);
    let shift = exponent + fraction;
    let exact = if shift >= 0 {
        // 2^70 is beyond every word, and so is what has more.
        if mantissa == 0 {
            0
        } else {
            mantissa << shift.min(70)
        }
    } else {
        let places = (-shift).unsigned_abs().min(120);
        match rounding {
            Rounding::Floor => floor_shift(mantissa, places),
            Rounding::HalfUp => floor_shift(2 * mantissa + (1i128 << places), places + 1),
        }
    };
    clip(exact, width)
}

fn rounding() -> impl Strategy<Value = Rounding> {
    prop_oneof![Just(Rounding::HalfUp), Just(Rounding::Floor)]
}

/// Doubles of every size, ties and neighbours of ties of the format among them.
fn doubles(fraction: i32) -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<f64>().prop_filter("finite", |v| v.is_finite()),
        -1e6..1e6,
        (-(1i64 << 40)..1 << 40, -3i32..=3).prop_map(move |(code, ulps)| {
            #[expect(clippy::cast_precision_loss, reason = "42 bits")]
            let tie = ldexp((2 * code + 1) as f64, -fraction - 1);
            (0..ulps.abs()).fold(
                tie,
                |v, _| if ulps < 0 { v.next_down() } else { v.next_up() },
            )
        }),
        Just(0.0),
        Just(-0.0),
        Just(f64::MAX),
        Just(f64::MIN),
        Just(f64::MIN_POSITIVE),
        Just(-f64::MIN_POSITIVE),
        Just(0.499_999_999_999_999_94),
        Just(-0.5),
    ]
}

fn word() -> impl Strategy<Value = (u32, i32, f64)> {
    (1..=MAX_WIDTH, -30i32..80)
        .prop_flat_map(|(width, fraction)| (Just(width), Just(fraction), doubles(fraction)))
}

/// Decimal texts: any digits, and ties of a format with digits far behind them.
fn decimals(fraction: i32) -> impl Strategy<Value = String> {
    let tie = (-(1i64 << 16)..1 << 16, 1usize..18, 0u8..3).prop_map(move |(code, far, side)| {
        // (2 code + 1) / 2^(fraction + 1), whose digits come to an end.
        let places = usize::try_from(fraction + 1).expect("a fraction");
        let five = 5i128.pow(u32::try_from(places).expect("small"));
        let mut number = i128::from(2 * code + 1) * five;
        for _ in 0..far {
            number *= 10;
        }
        number += i128::from(side) - 1;
        decimal(number, places + far)
    });
    prop_oneof![
        3 => tie,
        1 => "-?[0-9]{1,9}(\\.[0-9]{1,12})?",
        1 => "-?[0-9]{1,3}\\.[0-9]{1,6}e-?[0-9]",
    ]
}

/// `number / 10^places` in digits.
fn decimal(number: i128, places: usize) -> String {
    let digits = format!("{:0>1$}", number.abs(), places + 1);
    let (whole, part) = digits.split_at(digits.len() - places);
    let sign = if number < 0 { "-" } else { "" };
    format!("{sign}{whole}.{part}")
}

/// `number / 10^places` of a text.
fn rational(text: &str) -> (i128, i32) {
    let (number, exponent) = text.split_once('e').unwrap_or((text, "0"));
    let (whole, part) = number.split_once('.').unwrap_or((number, ""));
    let digits: i128 = format!("{whole}{part}").parse().expect("digits");
    let exponent: i32 = exponent.parse().expect("an exponent");
    (digits, i32::try_from(part.len()).expect("short") - exponent)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn quantize_is_exact((width, fraction, value) in word(), rounding in rounding()) {
        let found = format(width, fraction).quantize(value, rounding);
        let expected = quantized(value, width, fraction, rounding);
        prop_assert_eq!((found.code, found.clipped), expected);
    }

    /// The crate rounds ties to even and floors where it drops bits: half a step is added in a
    /// wide number first, which is exact there.
    #[test]
    fn quantize_agrees_with_fixed(value in -2e9..2e9f64, fraction in 0usize..6) {
        let wide = I64F64::from_num(value);
        let fractions = [0, 1, 4, 12, 20, 32];
        let rounded = [
            FixedI64::<U0>::wrapping_from_num(wide + I64F64::ONE / 2).to_bits(),
            FixedI64::<U1>::wrapping_from_num(wide + I64F64::ONE / 4).to_bits(),
            FixedI64::<U4>::wrapping_from_num(wide + I64F64::ONE / 32).to_bits(),
            FixedI64::<U12>::wrapping_from_num(wide + (I64F64::ONE >> 13)).to_bits(),
            FixedI64::<U20>::wrapping_from_num(wide + (I64F64::ONE >> 21)).to_bits(),
            FixedI64::<U32>::wrapping_from_num(wide + (I64F64::ONE >> 33)).to_bits(),
        ];
        let floors = [
            FixedI64::<U0>::from_num(wide).to_bits(),
            FixedI64::<U1>::from_num(wide).to_bits(),
            FixedI64::<U4>::from_num(wide).to_bits(),
            FixedI64::<U12>::from_num(wide).to_bits(),
            FixedI64::<U20>::from_num(wide).to_bits(),
            FixedI64::<U32>::from_num(wide).to_bits(),
        ];
        // A double of this size has bits below the 64 places only where it is tiny.
        prop_assume!(value.abs() > 1e-3);
        // 62 bits hold them all but the last format's: it is saturated by 32 bits as I32F32 is.
        let format = format(MAX_WIDTH, fractions[fraction]);
        if fraction < 5 || value.abs() < 5e8 {
            prop_assert_eq!(format.quantize(value, Rounding::HalfUp).code, rounded[fraction]);
            prop_assert_eq!(format.quantize(value, Rounding::Floor).code, floors[fraction]);
        }
        let narrow = self::format(32, 12);
        let saturated = fixed::FixedI32::<U12>::saturating_from_num(wide);
        let clipped = fixed::FixedI32::<U12>::checked_from_num(wide).is_none();
        let found = narrow.quantize(value, Rounding::Floor);
        prop_assert_eq!((found.code, found.clipped), (i64::from(saturated.to_bits()), clipped));
        prop_assert_eq!(I32F32::from_num(wide).to_num::<f64>(), I32F32::from_bits(floors[5]).to_num::<f64>());
    }

    #[test]
    fn saturate_clips(width in 1..=MAX_WIDTH, code: i64, fraction in -40i32..40) {
        let found = format(width, fraction).saturate(code);
        prop_assert_eq!((found.code, found.clipped), clip(code.into(), width));
    }

    #[test]
    fn saturate_agrees_with_fixed(code: i64) {
        let wide = FixedI128::<U12>::from_bits(code.into());
        let found = format(32, 12).saturate(code);
        let expected = fixed::FixedI32::<U12>::saturating_from_num(wide);
        prop_assert_eq!(found.code, i64::from(expected.to_bits()));
    }

    #[test]
    fn shifts_round(value: i64, shift in 0u32..100) {
        let value = value >> (value.rem_euclid(50));
        let wide = i128::from(value);
        prop_assert_eq!(i128::from(shift_right(value, shift, Rounding::Floor)), floor_shift(wide, shift));
        let up = if shift == 0 { wide } else { floor_shift(2 * wide + (1i128 << shift), shift + 1) };
        prop_assert_eq!(i128::from(shift_right(value, shift, Rounding::HalfUp)), up);
        if shift < 64 && let Some(sum) = value.checked_add(half(shift)) {
            prop_assert_eq!(i128::from(shift_right(sum, shift, Rounding::Floor)), up);
        }
    }

    #[test]
    fn shifts_agree_with_fixed(value: i32) {
        let word = I64F64::from_bits(i128::from(value) << 52);
        let up = (word + I64F64::ONE / 2).floor().to_num::<i64>();
        prop_assert_eq!(shift_right(value.into(), 12, Rounding::HalfUp), up);
        prop_assert_eq!(shift_right(value.into(), 12, Rounding::Floor), word.floor().to_num::<i64>());
    }

    #[test]
    fn widths_are_the_least(a: i64, b: i64, bits in 0u32..64) {
        let (a, b) = (a >> bits, b >> (bits / 2));
        let (low, high) = (a.min(b), a.max(b));
        let holds = |width: u32| {
            let top = 1i128 << (width - 1);
            -top <= i128::from(low) && i128::from(high) < top
        };
        let width = signed_width(low, high);
        prop_assert!(holds(width));
        prop_assert!(width == 1 || !holds(width - 1));
        let high = a.unsigned_abs();
        let width = unsigned_width(high);
        prop_assert!(u128::from(high) < 1u128 << width);
        prop_assert!(width == 1 || u128::from(high) >= 1u128 << (width - 1));
    }

    #[test]
    fn bits_are_two_s_complement(code: i64, width in 1u32..=64) {
        let code = code >> (64 - width);
        let bits = to_bits(code, width);
        prop_assert_eq!(from_bits(bits, width), code);
        prop_assert_eq!(i128::from(bits), i128::from(code).rem_euclid(1i128 << width));
        // Bits above the word are nothing to it.
        if width < 64 {
            prop_assert_eq!(from_bits(bits | u64::MAX << width, width), code);
        }
    }

    #[test]
    fn decimals_are_rounded_once((fraction, text) in (0i32..14).prop_flat_map(|f| (Just(f), decimals(f))), width in 1..=MAX_WIDTH) {
        let found = format(width, fraction).parse_decimal(&text).expect("a number");
        let (number, places) = rational(&text);
        let up = 1i128 << (fraction + 1);
        let power = |n: i32| 10i128.pow(n.max(0).unsigned_abs());
        // floor(number * 2^fraction / 10^places + 1/2)
        let exact = (number * power(-places) * up + power(places)).div_euclid(2 * power(places));
        prop_assert_eq!((found.code, found.clipped), clip(exact, width), "{}", text);
    }

    /// Where a double holds the number, both ways of reading it agree.
    #[test]
    fn decimals_of_doubles((width, fraction, value) in word()) {
        let format = format(width, fraction);
        let expected = format.quantize(value, Rounding::HalfUp);
        for text in [format!("{value:.1100}"), format!(" {value:.1100e} ")] {
            // 1100 places are all that there are of most doubles.
            let same = text.trim().parse::<f64>() == Ok(value);
            let short = value == 0.0 || value.abs() > 1e-200;
            if same && short {
                prop_assert_eq!(format.parse_decimal(&text), Some(expected), "{}", value);
            }
        }
    }

    #[test]
    fn holding_is_the_finest(width in 1u32..=40, a in doubles(9), b in doubles(9)) {
        let (low, high) = (a.min(b), a.max(b));
        let fits = |f: QFormat| [low, high].iter().all(|v| !quantized(*v, f.width(), f.fraction(), Rounding::HalfUp).1);
        match QFormat::holding(width, low, high) {
            Ok(found) => {
                prop_assert!(fits(found));
                prop_assert_eq!(found.width(), width);
                let finer = QFormat::new(width, found.fraction() + 1);
                prop_assert!((low, high) == (0.0, 0.0) || finer.is_err() || !fits(finer.expect("checked")));
            }
            Err(_) => {
                let magnitude = low.abs().max(high.abs());
                prop_assert!(!(1e-280..1e280).contains(&magnitude));
            }
        }
    }

    #[test]
    fn with_fraction_is_the_narrowest(fraction in -20i32..40, a in -1e9..1e9f64, b in -1e9..1e9f64) {
        let (low, high) = (a.min(b), a.max(b));
        let fits = |width: u32| [low, high].iter().all(|v| !quantized(*v, width, fraction, Rounding::HalfUp).1);
        match QFormat::with_fraction(fraction, low, high) {
            Ok(found) => {
                prop_assert_eq!(found.fraction(), fraction);
                prop_assert!(fits(found.width()));
                prop_assert!(found.width() == 1 || !fits(found.width() - 1));
            }
            Err(_) => prop_assert!(!fits(MAX_WIDTH)),
        }
    }

    #[test]
    fn formats_read_back(width in 1..=MAX_WIDTH, fraction in -1000i32..=1000) {
        let format = format(width, fraction);
        let text = format.to_string();
        prop_assert_eq!(&text, &format!("Q{}.{fraction}", i64::from(width) - 1 - i64::from(fraction)));
        prop_assert_eq!(text.parse::<QFormat>(), Ok(format));
        prop_assert_eq!(serde_json::to_string(&format).expect("a string"), format!("\"{text}\""));
        prop_assert_eq!(format.step(), ldexp(1.0, -fraction));
        prop_assert_eq!(format.integer() + fraction + 1, width.cast_signed());
    }
}

#[test]
fn what_is_no_decimal_is_refused() {
    for text in [
        "",
        " ",
        "x",
        "1,5",
        "nan",
        "inf",
        "-infinity",
        "1e400",
        "--1",
        "1e",
        "0x10",
        "1_0",
    ] {
        assert_eq!(format(16, 8).parse_decimal(text), None, "{text}");
    }
    for (text, code) in [
        ("+1.5", 3),
        ("1.", 2),
        (".5", 1),
        ("1e-400", 0),
        ("-0", 0),
        ("25e-2", 1),
    ] {
        assert_eq!(
            format(16, 1).parse_decimal(text).expect(text).code,
            code,
            "{text}"
        );
    }
}

/// Through a double, or through 64 fraction bits, these become ties and are rounded up.
#[test]
fn decimals_just_below_a_tie() {
    for (text, fraction, code) in [
        ("0.4999999999999999999999999999999999", 0, 0),
        ("0.4999999999999999999", 0, 0),
        ("-0.5000000000000000000000000000000001", 0, -1),
        ("-0.5", 0, 0),
        ("1048576.49999999999999999999999", 0, 1_048_576),
        ("0.12499999999999999999999999999", 2, 0),
        ("0.125", 2, 1),
        ("1.249999999999999999999999999999e-1", 2, 0),
        ("1535.9999999999999999999999999", -10, 1),
        ("1536", -10, 2),
    ] {
        let found = format(40, fraction).parse_decimal(text).expect(text);
        assert_eq!(found.code, code, "{text}");
    }
}
