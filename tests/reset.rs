//! Resets in the simulators: every length at every moment, and a core without initial values.

#[expect(dead_code, reason = "other tests use the rest")]
mod support;

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Duration;

use hwgen::harness::harness;
use hwgen_gen::Source;
use hwgen_sim::model::Model;
use hwgen_sim::session::{self, stimulus_text};
use hwgen_sim::simulator::{BuildPlan, Purpose, ReplayPlan, Simulator};
use hwgen_sim::stimulus::{Effort, segments};
use hwgen_sim::tool::Toolbox;
use hwgen_sim::trace::{Dump, Moment, RtlValue};
use hwgen_spec::format::to_bits;
use hwgen_spec::options::Options;
use hwgen_spec::weights;
use support::{Check, assert_verified, check, emit};

fn tiny(directory: &Path) -> std::path::PathBuf {
    let text = include_bytes!("../designs/tiny/weights.json");
    let net = weights::read(text).expect("the project's own weights");
    emit(&net, &Options::default(), directory)
}

/// 1 to 8 cycles at each of the moments, every register compared.
#[test]
fn resets_of_any_length_at_any_moment_are_equal_in_verilator() {
    let directory = tempfile::tempdir().expect("a directory");
    let bundle = tiny(directory.path());
    let plan = Check {
        random: 0,
        seed: 1,
        simulators: &[Simulator::Verilator],
        effort: Effort::Thorough,
    };
    let report = check(&bundle, &plan).expect("Verilator runs");
    assert_verified(&report, "tiny");
    assert!(report.stimulus.resets > 8 * 16, "{:?}", report.stimulus);
}

/// The core with every initial value of its registers taken out.
fn without_initial_values(text: &str) -> String {
    let lines = text.lines().map(|line| {
        let trimmed = line
            .trim_start()
            .trim_start_matches("(* keep, dont_merge, syn_preserve = 1 *) ");
        if trimmed.starts_with("initial ") {
            return String::new();
        }
        match (trimmed.starts_with("reg"), line.rfind(" = ")) {
            (true, Some(at)) => {
                let comment = line.find(";").map_or("", |end| &line[end + 1..]);
                format!("{};{comment}", line[..at].trim_end())
            }
            _ => line.to_owned(),
        }
    });
    lines.collect::<Vec<_>>().join("\n") + "\n"
}

/// Answers after which every register has been written.
const ANSWERS: usize = 4;

/// Where registers start with X: behind a reset no handshake and no beat that is valid is X, and a
/// register, once it is written, is the model's and stays so.
#[test]
fn a_core_without_initial_values_works_behind_a_reset() {
    let directory = tempfile::tempdir().expect("a directory");
    let bundle = tiny(directory.path());
    let source = Source::read(&bundle).expect("a bundle as it was emitted");
    let mut taken_out = 0;
    for file in source.rtl() {
        let path = bundle.join(file);
        let text = fs::read_to_string(&path).expect("Verilog");
        let bare = without_initial_values(&text);
        taken_out += usize::from(bare != text);
        fs::write(&path, bare).expect("written");
    }
    assert!(taken_out > 10, "{taken_out} files with initial values");
    let (design, harness) = (&source.design, harness(&source));
    let work = directory.path().join("work");
    let built = Simulator::Icarus
        .build(
            &Toolbox::new(Path::new(env!("CARGO_MANIFEST_DIR"))),
            &BuildPlan {
                design: design.name().to_owned(),
                sources: source.rtl().iter().map(|f| bundle.join(f)).collect(),
                bench: harness.bench,
                bench_icarus: harness.bench_icarus,
                main_cpp: harness.main_cpp,
                models: harness.models,
                work_dir: work.clone(),
                cache_dir: work.clone(),
                purpose: Purpose::Trace,
                timeout: Duration::from_secs(300),
            },
        )
        .expect("builds");
    let all = segments(design, &[], 32, 1, Effort::Usual);
    let segment = all
        .iter()
        .find(|s| s.name == "conditions x crossed")
        .expect("one");
    let pins = session::run(design, segment).pins;
    let stimulus = work.join("pins.hex");
    fs::write(&stimulus, stimulus_text(design, &pins)).expect("written");
    let replay = built
        .replay(&ReplayPlan {
            stimulus,
            clocks: pins.len(),
            nonce: 1,
            dump: work.join("pins.vcd"),
            timeout: Duration::from_secs(300),
        })
        .expect("replays");

    let mut model = Model::new(design);
    let registers = model.registers();
    let lanes: Vec<(&str, u32)> = registers
        .iter()
        .flat_map(|r| r.lanes.iter().map(|bits| (&*r.path, *bits)))
        .collect();
    let at = |name: &str| {
        lanes
            .iter()
            .position(|(path, _)| *path == name)
            .expect(name)
    };
    let (ready, valid) = (at("s_axis_tready"), at("m_axis_tvalid"));
    let mut settled = vec![false; lanes.len()];
    let (mut row, mut compared, mut answers) = (Vec::new(), 0, 0);
    let mut wrong = Vec::new();
    let mut dump = Dump::open(&replay.dump).expect("a dump");
    dump.replay(&registers, pins.len(), |moment, rtl| {
        let Moment::Edge(edge) = moment else {
            return ControlFlow::Continue(());
        };
        answers += usize::from(pins[edge].m_ready && model.output().is_some());
        model.step(&pins[edge]);
        row.clear();
        model.values(&mut row);
        for (lane, (path, bits)) in lanes.iter().enumerate() {
            let value = rtl.value(lane, *bits);
            let equal = match &value {
                RtlValue::Known(code) => to_bits(code ^ row[lane], *bits) == 0,
                RtlValue::Unknown(_) => false,
            };
            // A register is written when the first frames have gone through; until then it may hold
            // what an unknown address of a ROM or a memory gives.
            settled[lane] |= equal && answers >= ANSWERS;
            let handshake = lane == ready || lane == valid;
            let beat = path.starts_with("m_axis_t") && row[valid] != 0;
            let must = settled[lane] || ((handshake || beat) && edge > 0);
            compared += usize::from(must);
            if must && !equal {
                wrong.push(format!(
                    "{path} at edge {edge}: {value:?}, model {}",
                    row[lane]
                ));
            }
        }
        match wrong.len() {
            0 => ControlFlow::Continue(()),
            _ => ControlFlow::Break(()),
        }
    })
    .expect("readable");
    assert!(wrong.is_empty(), "{wrong:?}");
    assert!(compared > 10_000, "{compared} values");
    let never: Vec<&str> = (0..lanes.len())
        // A word of a queue's memory that none came to is not written.
        .filter(|lane| !settled[*lane] && !lanes[*lane].0.ends_with("].word"))
        .map(|lane| lanes[lane].0)
        .collect();
    assert!(never.is_empty(), "never known: {never:?}");
}
