//! What the pins of `echo` do in the tests, and what its registers must hold.

use hwgen_sim::record::{Recording, Register};

const LANES: usize = 20;

/// The pins at one rising edge.
#[derive(Clone, Copy)]
pub struct Pins {
    pub aresetn: bool,
    pub valid: bool,
    pub last: bool,
    pub ready: bool,
    pub word: u16,
}

/// Three clocks of reset, then words with gaps, frames and back-pressure.
pub fn pins(clocks: usize) -> Vec<Pins> {
    let mut random = 12_345u64;
    (0..clocks)
        .map(|clock| {
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            let word = u16::try_from(random >> 48).expect("16 bits");
            Pins {
                aresetn: clock >= 3 && clock != 50,
                valid: (random >> 40) & 3 != 0,
                last: (random >> 36) & 7 < 2,
                ready: (random >> 32) & 3 != 1,
                word,
            }
        })
        .collect()
}

/// The stimulus file of the bench.
pub fn stimulus(pins: &[Pins]) -> String {
    pins.iter()
        .map(|p| {
            let bit = |on: bool, place: u32| u32::from(on) << place;
            let word = bit(p.aresetn, 19) | bit(p.valid, 18) | bit(p.last, 17) | bit(p.ready, 16);
            format!("{:05x}\n", word | u32::from(p.word))
        })
        .collect()
}

/// The model: every register of `echo` after every edge.
pub fn record(pins: &[Pins]) -> Recording {
    let register = |path: String, bits, lanes| Register::uniform(path, bits, lanes);
    let mut registers = vec![
        register("count_q".to_owned(), 3, 1),
        register("valid_q".to_owned(), 1, 1),
        register("data_q".to_owned(), 24, 1),
        register("u_sums.acc_q".to_owned(), 24, LANES),
    ];
    registers.extend((0..3).map(|pe| register(format!("u_sums.g_pe[{pe}].u_pe.acc_q"), 8, 1)));
    let mut recording = Recording::new(registers);
    let (mut count, mut valid, mut data) = (0i64, false, 0i64);
    let mut sums = [0i64; LANES];
    let mut pe = [0i64; 3];
    for p in pins {
        let take = p.valid && (!valid || p.ready);
        let word = i64::from(p.word.cast_signed());
        if p.aresetn {
            if take {
                count += 1;
                let ones: u32 = sums.iter().map(|s| (s & 0xff_ffff).count_ones()).sum();
                data = sums[0] + i64::from(ones % 2);
                for (sum, weight) in sums.iter_mut().zip(1..) {
                    *sum += word * weight;
                }
            }
            valid = (take && p.last) || (valid && !p.ready);
            for (acc, place) in pe.iter_mut().zip([0, 4, 8]) {
                *acc -= i64::from(p.word >> place);
            }
        } else {
            (count, valid, data) = (0, false, 0);
            sums.fill(0);
            pe.fill(0);
        }
        let mut row = vec![count, i64::from(valid), data];
        row.extend(sums);
        row.extend(pe);
        recording.push(&row);
    }
    recording
}
