//! One bit of a ROM: found, and named by layer, neuron, input and cycle.

use std::fs;
use std::path::Path;

use hwgen_gen::Source;
use hwgen_sim::model::Model;
use hwgen_sim::session;
use hwgen_sim::stimulus::{Effort, segments};
use hwgen_sim::verify::FirstDifference;
use hwgen_spec::design::{Design, Layer, bias_rom_width};

use super::fixture::fixture;
use super::support::{check_source, emit, in_parallel};
use super::{ICARUS, RANDOM, SEED, bundle, edit};

/// Rewrites the digits of word `address` of a ROM.
fn edit_rom(path: &Path, address: usize, edit: impl FnOnce(&mut Vec<u8>)) {
    let text = fs::read_to_string(path).expect("an emitted ROM");
    let mut edit = Some(edit);
    let lines: Vec<String> = text
        .lines()
        .map(|line| {
            let number = line.split_once("'d").and_then(|(_, rest)| {
                let (number, rest) = rest.split_once(':')?;
                rest.starts_with(" data_q <= ").then(|| number.trim())
            });
            if number != Some(&address.to_string()) {
                return line.to_owned();
            }
            let (head, rest) = line.split_once("'h").expect("a literal");
            let (digits, rest) = rest.split_once(';').expect("a statement");
            let mut digits: Vec<u8> = digits.bytes().collect();
            edit.take().expect("one such word")(&mut digits);
            let digits = String::from_utf8(digits).expect("digits");
            format!("{head}'h{digits};{rest}")
        })
        .collect();
    assert!(edit.is_none(), "{}: no word {address}", path.display());
    fs::write(path, lines.join("\n") + "\n").expect("written");
}

/// Flips one bit of word `address` of a ROM.
fn flip(path: &Path, address: usize, bit: u32) {
    edit_rom(path, address, |digits| {
        let bit = usize::try_from(bit).expect("a bit");
        let at = digits.len() - 1 - bit / 4;
        let digit = char::from(digits[at]).to_digit(16).expect("a digit");
        let flipped = char::from_digit(digit ^ 1 << (bit % 4), 16).expect("a digit");
        digits[at] = u8::try_from(flipped).expect("ASCII");
    });
}

/// The first difference, which there must be.
fn first_difference(bundle: &Path, source: &Source, what: &str) -> FirstDifference {
    let report = check_source(bundle, source, &ICARUS).expect(what);
    assert!(!report.verified, "{what}: survived");
    report.first_difference.expect(what)
}

/// The first clock at which a ROM shows word `address`: one behind its counter.
fn first_read(design: &Design, counter: &str, address: usize) -> usize {
    let pins = &segments(design, &[], RANDOM, SEED, Effort::Quick)[0];
    let pins = session::run(design, pins).pins;
    let mut model = Model::new(design);
    let at: usize = {
        let registers = model.registers();
        let register = registers.iter().position(|r| r.path == counter);
        let register = register.expect(counter);
        registers[..register].iter().map(|r| r.lanes.len()).sum()
    };
    let address = i64::try_from(address).expect("an address");
    // At power-up every counter is zero.
    let mut before = 0;
    for (clock, pins) in pins.iter().enumerate() {
        if before == address {
            return clock;
        }
        model.step(pins);
        let mut row = Vec::new();
        model.values(&mut row);
        before = row[at];
    }
    panic!("{counter} never shows {address}");
}

fn layer_of<'a>(design: &'a Design, name: &str) -> &'a Layer {
    let mut layers = design.perceptron().layers();
    layers.find(|l| l.quant.name == name).expect(name)
}

/// The last weight of each layer where nothing stands between a ROM and the multipliers.
#[test]
fn a_weight_bit_is_named_without_copies_of_the_address() {
    let directory = tempfile::tempdir().expect("a directory");
    let (net, mut options) = fixture();
    options.device = Some("ice40-up5k".into());
    let design = Design::new(&net, &options).expect("legal");
    let layers: Vec<&Layer> = design.perceptron().layers().collect();
    in_parallel(&layers, |layer| {
        let name = &layer.quant.name;
        let bundle = emit(&net, &options, &directory.path().join(name));
        let source = Source::read(&bundle).expect("a bundle as it was emitted");
        let (neuron, input) = (layer.quant.outputs() - 1, layer.quant.inputs() - 1);
        let pe = neuron % layer.fold.pe;
        let bits = layer.quant.weight_format.width();
        let bit = u32::try_from(input % layer.fold.simd).expect("small") * bits + 2;
        let rom = bundle.join(format!("rtl/mutant__{name}_w{pe}.v"));
        // Whatever the order of folds, the last weight stands in the last word.
        flip(&rom, layer.folds() - 1, bit);
        let found = first_difference(&bundle, &source, name);
        let signal = format!("mutant.u_mlp.u_{name}.u_w{pe}.data_q");
        assert_eq!(found.signal, signal);
        assert_eq!(
            (found.neuron, found.input),
            (Some(neuron), Some(input)),
            "{name}"
        );
    });
}

#[test]
fn a_weight_bit_is_named_by_layer_neuron_input_and_cycle() {
    let directory = tempfile::tempdir().expect("a directory");
    let (net, options) = fixture();
    let design = Design::new(&net, &options).expect("legal");
    let layers: Vec<&Layer> = design.perceptron().layers().collect();
    in_parallel(&layers, |layer| {
        let name = &layer.quant.name;
        let (bundle, source) = bundle(directory.path(), name);
        let design = &source.design;
        // The last neuron and input that have a weight of their own.
        let (neuron, input) = (layer.quant.outputs() - 1, layer.quant.inputs() - 1);
        let pe = neuron % layer.fold.pe;
        let group = neuron / layer.fold.pe * layer.synapse_folds();
        let address = group + input / layer.fold.simd;
        let simd = input % layer.fold.simd;
        let bits = layer.quant.weight_format.width();
        let bit = u32::try_from(simd).expect("small") * bits + 2;
        flip(
            &bundle.join(format!("rtl/mutant__{name}_w{pe}.v")),
            address,
            bit,
        );

        let found = first_difference(&bundle, &source, name);
        let counter = format!("u_mlp.u_{name}.u_w{pe}.address_q2");
        assert_eq!(
            found.signal,
            format!("mutant.u_mlp.u_{name}.u_w{pe}.data_q")
        );
        assert_eq!(found.simulator, "icarus");
        assert_eq!(found.segment, "corners x continuous");
        assert_eq!(found.cycle, first_read(design, &counter, address), "{name}");
        assert_eq!(found.network.as_deref(), Some(layer.quant.network.as_str()));
        assert_eq!(found.layer.as_ref(), Some(name));
        assert_eq!(
            (found.neuron, found.input),
            (Some(neuron), Some(input)),
            "{name}"
        );
        assert_eq!(found.lane, simd);
        let weight = layer.quant.weights[neuron][input];
        assert_eq!(found.model, weight, "{name}");
        assert_eq!(found.rtl, (weight ^ 4).to_string(), "{name}");
        let fraction =
            layer.quant.weight_format.fraction() + layer.quant.extra_shift[neuron].cast_signed();
        assert_eq!(
            found.model_real,
            Some((weight as f64) * 2f64.powi(-fraction))
        );
        the_files_are_there(&found);
        the_window_is_right(&found);
    });
}

/// A dump of the simulator, one of the model, and a save file that shows the signal.
fn the_files_are_there(found: &FirstDifference) {
    let [dump, model, save] = &found.files[..] else {
        panic!("three files: {:?}", found.files);
    };
    assert!(fs::metadata(dump).expect("a dump").len() > 0);
    let model = fs::read_to_string(model).expect("the model's dump");
    let name = found.signal.rsplit('.').next().expect("a name");
    assert!(model.contains("$enddefinitions"));
    assert!(model.contains(&format!(" {name} ")), "{name}");
    let save = fs::read_to_string(save).expect("a save file");
    let dump = dump.file_name().expect("a name").to_string_lossy();
    assert!(save.contains(&*dump), "{save}");
    let path = found.signal.split_once('.').expect("a path").1;
    assert!(
        save.contains(&format!("mutant_tb_icarus.u_tb.u_dut.{path}")),
        "{save}"
    );
    // The marker stands on the rising edge.
    let marker = 5_000 + 10_000 * found.cycle;
    assert!(save.contains(&format!(" {marker} ")), "{save}");
}

/// A line a cycle; equal before the one that is marked.
fn the_window_is_right(found: &FirstDifference) {
    let first = found.cycle.saturating_sub(6);
    for (i, line) in found.window.iter().enumerate() {
        let cycle = first + i;
        let mark = if cycle == found.cycle { '>' } else { ' ' };
        let values = line.strip_prefix(&format!("{mark} cycle {cycle}: model "));
        let (model, rtl) = values
            .and_then(|v| v.split_once(", icarus "))
            .unwrap_or_else(|| panic!("cycle {cycle}: {line}"));
        if cycle < found.cycle {
            assert_eq!(model, rtl, "{line}");
        }
        if cycle == found.cycle {
            assert_eq!((model, rtl), (&*found.model.to_string(), &*found.rtl));
        }
    }
    assert_eq!(found.window.len(), found.cycle - first + 7);
}

#[test]
fn a_bias_bit_a_shift_bit_and_a_missing_half_are_named() {
    let directory = tempfile::tempdir().expect("a directory");
    let (net, options) = fixture();
    let design = Design::new(&net, &options).expect("legal");
    // Layer, neuron, and the bit of its entry.
    let tanh = layer_of(&design, "a_l0");
    let shifted = tanh.quant.extra_shift.iter().rposition(|s| *s > 0);
    let shifted = shifted.expect("a neuron with a shift");
    let faults = [
        ("bias", "a_l0", 3, 5),
        ("bias", "b_l0", 2, 0),
        ("bias", "a_l1", 2, 1),
        ("half", "shared_l0", 4, 0),
        ("half", "b_l1", 1, 0),
        ("shift", "a_l0", shifted, tanh.quant.biased_width),
    ];
    in_parallel(&faults, |(kind, name, neuron, bit)| {
        let (bundle, source) = bundle(directory.path(), &format!("{kind}_{name}"));
        let layer = layer_of(&design, name);
        let entry = bias_rom_width(&layer.quant);
        let (address, lane) = (neuron / layer.lanes, neuron % layer.lanes);
        let lowest = u32::try_from(lane).expect("small") * entry;
        let rom = bundle.join(format!("rtl/mutant__{name}_bias.v"));
        if *kind == "half" {
            // A word that is cut instead of rounded: its half is not in the bias.
            let shift = layer.quant.base_shift + layer.quant.extra_shift[*neuron];
            edit_rom(&rom, address, |digits| {
                let text = std::str::from_utf8(digits).expect("digits");
                let word = u128::from_str_radix(text, 16).expect("a word");
                let field = (1u128 << layer.quant.biased_width) - 1;
                let old = word >> lowest & field;
                let half = 1u128 << (shift - 1);
                let new = old.wrapping_sub(half) & field;
                let word = word & !(field << lowest) | new << lowest;
                *digits = format!("{word:0>width$x}", width = digits.len()).into_bytes();
            });
        } else {
            flip(&rom, address, lowest + bit);
        }
        let what = format!("{kind} {name}");
        let found = first_difference(&bundle, &source, &what);
        let counter = format!("u_mlp.u_{name}.u_requant.beat_q");
        assert_eq!(found.signal, format!("mutant.u_mlp.u_{name}.u_bias.data_q"));
        assert_eq!(
            found.cycle,
            first_read(&design, &counter, address),
            "{what}"
        );
        assert_eq!(found.layer.as_deref(), Some(*name));
        assert_eq!(found.neuron, Some(*neuron), "{what}");
        the_window_is_right(&found);
    });
}

#[test]
fn a_bit_of_a_segment_is_named() {
    let directory = tempfile::tempdir().expect("a directory");
    let (bundle, source) = bundle(directory.path(), "segment");
    let table = layer_of(&source.design, "a_l0").quant.table.clone();
    let table = table.expect("a table");
    let rom = format!("rtl/mutant__tanh{}.v", table.fraction());
    flip(&bundle.join(rom), 2, 0);
    let found = first_difference(&bundle, &source, "segment");
    // The lane whose argument comes first to that segment.
    let path = found.signal.strip_prefix("mutant.u_mlp.u_a_l0.g_act[");
    let path = path.unwrap_or_else(|| panic!("{}", found.signal));
    assert!(path.ends_with("].u_segments.data_q"), "{path}");
    assert_eq!(found.layer.as_deref(), Some("a_l0"));
    assert!(found.neuron.is_some());
    the_window_is_right(&found);
}

/// Runs the binary and returns what it printed as JSON.
fn hwgen(place: &Path, arguments: &[&str]) -> (Option<i32>, serde_json::Value) {
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_hwgen"))
        .args(arguments)
        .arg("--json")
        .current_dir(place)
        .env("XDG_CACHE_HOME", place.join("cache"))
        .output()
        .expect("starts");
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    let value = serde_json::from_str(&text).unwrap_or_else(|e| panic!("{e}: {text}"));
    (output.status.code(), value)
}

/// As a user would do it: emit, flip one bit of one ROM word, renew its digest, verify.
#[test]
fn a_weight_bit_of_the_landing_design_is_named_on_the_command_line() {
    let directory = tempfile::tempdir().expect("a directory");
    let place = directory.path();
    let weights = Path::new(env!("CARGO_MANIFEST_DIR")).join("designs/landing-wide/weights.json");
    let weights = weights.to_str().expect("UTF-8");
    let (code, _) = hwgen(place, &["emit", "--weights", weights, "--out", "landing"]);
    assert_eq!(code, Some(0));

    // Neuron 4 * 62 + 3 is computed by element 3 in clock 62 of a frame; 16 bits a weight.
    let (neuron, input, element, clock) = (251, 7, 3, 62);
    let name = format!("rtl/landing__position_l0_w{element}.v");
    let rom = place.join("landing").join(&name);
    let old = hwgen_gen::sha256(&fs::read_to_string(&rom).expect("a ROM"));
    flip(&rom, clock, 16 * input + 9);
    let new = hwgen_gen::sha256(&fs::read_to_string(&rom).expect("a ROM"));
    let verify = [
        "verify",
        "landing",
        "--random",
        "0",
        "--simulators",
        "icarus",
    ];
    let (code, json) = hwgen(place, &verify);
    assert_eq!((code, &json["ok"]), (Some(2), &false.into()), "{json}");

    edit(&place.join("landing/manifest.json"), &old, &new);
    let (code, json) = hwgen(place, &verify);
    assert_eq!(code, Some(1), "{json}");
    assert_eq!(json["verified"], false);
    assert_eq!(json["error"]["code"], "difference");
    let found = &json["first_difference"];
    let signal = format!("landing.u_mlp.u_position_l0.u_w{element}.data_q");
    assert_eq!(found["signal"], signal);
    assert_eq!(found["network"], "position");
    assert_eq!(found["layer"], "position_l0");
    assert_eq!(found["neuron"], neuron);
    assert_eq!(found["input"], input);
    // Five cycles of reset and two until the core is ready; the array's first operand
    // 78 clocks after the first beat (docs/microarchitecture.md, worked example), its weight three
    // later.
    assert_eq!(found["cycle"], 7 + 78 + clock + 3);
    assert_eq!(found["segment"], "corners x continuous");
    let files = found["files"].as_array().expect("files");
    assert_eq!(files.len(), 3);
    for file in files {
        assert!(
            place.join(file.as_str().expect("a path")).is_file(),
            "{file}"
        );
    }
}
