//! The arithmetic against the `fixed` crate and against plain wide integers.

mod networks;
#[path = "../support/mod.rs"]
mod support;
mod words;

fn ldexp(value: f64, exponent: i32) -> f64 {
    libm::ldexp(value, exponent)
}

/// `floor(a / 2^shift)` in plain integers.
fn floor_shift(a: i128, shift: u32) -> i128 {
    a.div_euclid(1i128.checked_shl(shift).expect("below 127 places"))
}

fn clip(a: i128, width: u32) -> (i64, bool) {
    let top = (1i128 << (width - 1)) - 1;
    let inside = a.max(-top - 1).min(top);
    (i64::try_from(inside).expect("a code"), inside != a)
}
