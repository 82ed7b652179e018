//! A small core for the tests: its Verilog, its bench, and what its registers must hold.

use std::path::{Path, PathBuf};
use std::time::Duration;

use hwgen_sim::record::{Recording, Register};
use hwgen_sim::simulator::{BuildPlan, Purpose};

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
                valid: (random >> 40) % 4 != 0,
                last: (random >> 36) % 5 == 0,
                ready: (random >> 32) % 3 != 0,
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
    let register = |path: String, lane_bits, lanes| Register {
        path,
        lane_bits,
        lanes,
    };
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

/// Writes the bench for `echo`, the sources with `edit` applied, and says how to build them.
pub fn plan(directory: &Path, cache: &Path, edit: impl Fn(&str, String) -> String) -> BuildPlan {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let rtl = package.parent().expect("a workspace").join("rtl");
    let read = |path: &Path| std::fs::read_to_string(path).expect("a file of the project");
    let write = |name: &str, text: &str| -> PathBuf {
        let path = directory.join(name);
        std::fs::write(&path, text).expect("written");
        path
    };
    let bench = |template: &str, name: &str| {
        let text = read(&rtl.join("tpl").join(template))
            .replace("@{ design }@", "echo")
            .replace("@{ s_data_bits }@", "16")
            .replace("@{ m_data_bits }@", "24")
            .replace("@{ m_user_bits }@", "1");
        assert!(!text.contains("@{"), "a placeholder was left");
        write(name, &text)
    };
    let sources = ["echo.v", "echo_sums.v", "echo_pe.v"]
        .map(|name| {
            let text = read(&package.join("tests/data").join(name));
            write(name, &edit(name, text))
        })
        .to_vec();
    BuildPlan {
        design: "echo".to_owned(),
        sources,
        bench: bench("tb.v", "echo_tb.v"),
        bench_icarus: bench("tb_icarus.v", "echo_tb_icarus.v"),
        main_cpp: rtl.join("tb/sim_main.cpp"),
        work_dir: directory.to_owned(),
        cache_dir: cache.to_owned(),
        purpose: Purpose::Trace,
        timeout: Duration::from_secs(300),
    }
}
