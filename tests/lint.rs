//! Every emitted file and every library cell is read without a warning by five tools.
//!
//! A tool that is missing is a failure. Each tool has cases that it must not be silent about.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use hwgen_gen::{Bundle, generate};
use hwgen_sim::tool::{ICARUS, Tool, Toolbox, VERILATOR, YOSYS};
use hwgen_spec::design::Design;
use hwgen_spec::device;
use hwgen_spec::options::{Budget, Options, WidthSetting};
use hwgen_spec::weights;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn program(tool: &Tool) -> PathBuf {
    Toolbox::new(root()).find(tool).expect("installed").path
}

/// Runs a tool; all that it printed, and whether it ended well.
fn run(tool: &Tool, arguments: &[String], directory: &Path) -> (String, bool) {
    let output = Command::new(program(tool))
        .args(arguments)
        .current_dir(directory)
        .output()
        .expect("it runs");
    let text = [output.stdout, output.stderr].concat();
    (
        String::from_utf8_lossy(&text).into_owned(),
        output.status.success(),
    )
}

/// Complaints of Verilator, none if it is content.
fn verilator(directory: &Path, top: &str, flags: &[&str], files: &[String]) -> Option<String> {
    let mut arguments: Vec<String> = ["--lint-only", "-Wall", "--top-module", top]
        .iter()
        .chain(flags)
        .map(|f| (*f).to_owned())
        .collect();
    arguments.extend_from_slice(files);
    let (text, good) = run(&VERILATOR, &arguments, directory);
    (!good || !text.is_empty()).then_some(text)
}

fn icarus(directory: &Path, top: &str, flags: &[&str], files: &[String]) -> Option<String> {
    let mut arguments: Vec<String> = ["-g2005", "-Wall", "-s", top, "-o", "lint.vvp"]
        .iter()
        .chain(flags)
        .map(|f| (*f).to_owned())
        .collect();
    arguments.extend_from_slice(files);
    let output = directory.join("lint.vvp");
    let _ = fs::remove_file(&output);
    let (text, good) = run(&ICARUS, &arguments, directory);
    (!good || !text.is_empty() || !output.is_file()).then_some(text)
}

/// Its log is long: the verdict must be there, and no line with a warning.
fn yosys(directory: &Path, top: &str, files: &[String]) -> Option<String> {
    let script = format!(
        "read_verilog {}; hierarchy -check -top {top}; proc; check -assert",
        files.join(" ")
    );
    let log = directory.join("yosys.log");
    let _ = fs::remove_file(&log);
    let arguments = ["-q", "-l", "yosys.log", "-p", &script].map(str::to_owned);
    let (text, good) = run(&YOSYS, &arguments, directory);
    let log = fs::read_to_string(&log).unwrap_or_default();
    let verdict = log.contains("Found and reported 0 problems.");
    let warned = log
        .lines()
        .chain(text.lines())
        .find(|l| l.contains("Warning") || l.contains("ERROR"));
    (!good || !verdict || warned.is_some() || !text.is_empty())
        .then(|| format!("{text}\n{}", warned.unwrap_or("no verdict")))
}

/// What slang is not asked, and why.
const SLANG: [&str; 6] = [
    "-Weverything",
    // Words of several formats stand side by side in one vector, whose bits have no sign; the ports of
    // multipliers give them theirs. Widths are checked.
    "-Wno-sign-conversion",
    // A multiplier takes operands of two widths.
    "-Wno-arith-op-mismatch",
    // Outputs that nobody needs are called `unused_...`, which is Verilator's convention: it checks it.
    "-Wno-unused-net",
    "-Wno-unused-but-set-net",
    // Outputs of a device's block that nobody needs are left open, as its guide says.
    "-Wno-empty-output-connection",
];
/// Rules of Verible that are for SystemVerilog, or for names and lines of another taste.
const VERIBLE: &str = "--rules=-always-comb,-explicit-parameter-storage-type,\
    -unpacked-dimensions-range-ordering,-line-length,\
    parameter-name-style=localparam_style_regex:[A-Z][A-Z0-9_]*;parameter_style_regex:[A-Z][A-Z0-9_]*";

/// A program of the virtual environment that `tools/setup --place` makes.
fn of_environment(name: &str) -> PathBuf {
    let path = root().join(".eda/bin").join(name);
    assert!(
        path.is_file(),
        "{} is missing: run tools/setup --place",
        path.display()
    );
    path
}

fn slang(directory: &Path, top: &str, files: &[String]) -> Option<String> {
    ["1364-2005", "1800-2017"].iter().find_map(|standard| {
        let output = Command::new(of_environment("python"))
            .arg(root().join("tests/support/slang.py"))
            .args(SLANG)
            .args(["--std", standard, "--top", top])
            .args(files)
            .current_dir(directory)
            .output()
            .expect("it runs");
        let text = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
        let silent = text.contains("Build succeeded: 0 errors, 0 warnings");
        (!output.status.success() || !silent).then_some(text)
    })
}

fn verible(directory: &Path, files: &[String]) -> Option<String> {
    let output = Command::new(of_environment("verible-verilog-lint"))
        .arg(VERIBLE)
        .args(files)
        .current_dir(directory)
        .output()
        .expect("it runs");
    let text = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    (!output.status.success() || !text.is_empty()).then_some(text)
}

/// Bundle of a weights file, written.
fn emit(text: &str, options: &Options, root: &Path) -> (Bundle, PathBuf) {
    let net = weights::read(text.as_bytes()).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let design = Design::new(&net, options).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let bundle = generate(&design, &net);
    let directory = root.join(design.name());
    bundle.write(&directory).expect("written");
    (bundle, directory)
}

fn sources(bundle: &Bundle, folder: &str) -> Vec<String> {
    let verilog = |path: &&String| path.starts_with(folder) && path.ends_with(".v");
    let paths = bundle.files().iter().map(|f| &f.path);
    paths.filter(verilog).cloned().collect()
}

/// What the tools complain of in a bundle: the core, then the benches.
fn complaints(bundle: &Bundle, directory: &Path) -> Vec<String> {
    let (top, rtl) = (bundle.design(), sources(bundle, "rtl/"));
    let mut all = rtl.clone();
    all.extend(sources(bundle, "tb/"));
    let models = sources(bundle, "sim/");
    assert_eq!(all.len(), rtl.len() + 2, "two benches");
    let bench = format!("{top}_tb_icarus");
    // The time scale of the option is that of all modules that state none: the cells that are
    // synthesised carry none, the benches do.
    let timing = ["--timing", "--timescale", "1ns/1ps"];
    [
        ("verilator", verilator(directory, top, &[], &rtl)),
        (
            "verilator, bench",
            verilator(directory, &bench, &timing, &all),
        ),
        ("iverilog", icarus(directory, top, &[], &rtl)),
        (
            "iverilog, bench",
            icarus(directory, &bench, &["-Wno-timescale"], &all),
        ),
        ("yosys", yosys(directory, top, &rtl)),
        ("iverilog, 2012", icarus(directory, top, &["-g2012"], &rtl)),
        (
            "slang",
            slang(directory, top, &[&rtl[..], &models].concat()),
        ),
        ("verible", verible(directory, &all)),
    ]
    .into_iter()
    .filter_map(|(tool, text)| Some(format!("{top}, {tool}:\n{}", text?)))
    .collect()
}

/// Numbers that look trained: of either sign, of many sizes, the same every time.
struct Numbers(u32);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(self.0 >> 8) / f64::from(1 << 23) - 1.0
    }

    fn layer(&mut self, activation: &str, outputs: usize, inputs: usize, format: &str) -> String {
        let mut row = |k: usize, n: usize| {
            let scale = if format.is_empty() {
                0.3f64.powi(i32::try_from(k % 4).expect("small"))
            } else {
                1.0
            };
            let code = |v: f64| {
                if format.is_empty() {
                    v * scale
                } else {
                    (v * 7.0).round() / 8.0
                }
            };
            let values: Vec<String> = (0..n).map(|_| format!("{:?}", code(self.next()))).collect();
            format!("[{}]", values.join(", "))
        };
        let rows: Vec<String> = (0..outputs).map(|k| row(k, inputs)).collect();
        let bias = row(0, outputs);
        format!(
            r#"{{"activation": "{activation}", "weights": [{}], "bias": {bias}{format}}}"#,
            rows.join(",\n")
        )
    }
}

/// A design of networks that are lists of layers; the first list is that of the shared layers.
fn file(name: &str, inputs: usize, networks: &[&[(&str, usize)]], format: &str) -> String {
    let mut numbers = Numbers(7);
    let mut layers = |inputs: usize, sizes: &[(&str, usize)]| {
        let mut width = inputs;
        let texts: Vec<String> = sizes
            .iter()
            .map(|(activation, outputs)| {
                let text = numbers.layer(activation, *outputs, width, format);
                width = *outputs;
                text
            })
            .collect();
        (texts.join(",\n"), width)
    };
    let (shared, width) = layers(inputs, networks[0]);
    let own: Vec<String> = networks[1..]
        .iter()
        .enumerate()
        .map(|(n, sizes)| {
            format!(
                r#"{{"name": "net{n}", "layers": [{}]}}"#,
                layers(width, sizes).0
            )
        })
        .collect();
    let edge = |v: &str| vec![v; inputs].join(", ");
    format!(
        r#"{{"format": "hwgen-weights/1", "name": "{name}",
        "inputs": {{"min": [{}], "max": [{}]}}, "shared": [{shared}], "networks": [{}]}}"#,
        edge("-1"),
        edge("1.5"),
        own.join(", ")
    )
}

fn interval(cycles: u32) -> Options {
    Options {
        budget: Budget::Interval(cycles),
        ..Options::default()
    }
}

fn designs() -> Vec<(String, Options)> {
    let fixed = r#", "format": {"weights": "Q0.3", "bias": "Q1.6", "activations": "Q3.8"}"#;
    let narrow = r#", "format": {"weights": "Q0.3", "activations": "Q1.6"}"#;
    let coarse = r#", "format": {"weights": "Q0.3", "activations": "Q1.0"}"#;
    let bits = |weights: u32, activations: u32, cycles: u32| {
        let all = |bits| vec![hwgen_spec::options::WidthSetting { layer: None, bits }];
        Options {
            weight_bits: all(weights),
            activation_bits: all(activations),
            ..interval(cycles)
        }
    };
    vec![
        (file("one", 1, &[&[], &[("linear", 1)]], ""), interval(1)),
        (file("one_relu", 1, &[&[], &[("relu", 1)]], ""), interval(9)),
        (
            file("one_tanh", 1, &[&[("tanh", 1)], &[("tanh", 1)]], ""),
            interval(1),
        ),
        (
            file(
                "one_sigmoid",
                1,
                &[&[], &[("sigmoid", 1), ("sigmoid", 1)]],
                "",
            ),
            interval(5),
        ),
        (
            file("gate", 3, &[&[], &[("sigmoid", 7), ("sigmoid", 2)]], ""),
            interval(8),
        ),
        (
            file("parallel", 5, &[&[], &[("tanh", 4), ("linear", 3)]], ""),
            interval(1),
        ),
        (
            file(
                "wide",
                7,
                &[&[("relu", 5)], &[("sigmoid", 3)], &[("linear", 2)]],
                "",
            ),
            interval(2),
        ),
        (
            file(
                "prime",
                13,
                &[&[], &[("relu", 11), ("tanh", 7), ("linear", 3)]],
                "",
            ),
            interval(17),
        ),
        (
            file(
                "slow",
                5,
                &[&[], &[("tanh", 9), ("relu", 3), ("linear", 2)]],
                "",
            ),
            interval(500),
        ),
        (
            file(
                "many",
                4,
                &[
                    &[("linear", 3)],
                    &[("tanh", 5), ("linear", 1)],
                    &[("relu", 2)],
                    &[("sigmoid", 6), ("linear", 4)],
                ],
                "",
            ),
            interval(6),
        ),
        (
            file(
                "thin",
                3,
                &[
                    &[],
                    &[("linear", 1), ("relu", 1), ("tanh", 6), ("linear", 1)],
                ],
                "",
            ),
            interval(3),
        ),
        (
            file(
                "given",
                4,
                &[
                    &[("relu", 3)],
                    &[("linear", 3), ("tanh", 2)],
                    &[("sigmoid", 2)],
                ],
                fixed,
            ),
            interval(4),
        ),
        (
            file(
                "given_narrow",
                3,
                &[&[], &[("tanh", 5), ("relu", 2)]],
                narrow,
            ),
            interval(7),
        ),
        (
            file(
                "coarse",
                3,
                &[&[], &[("linear", 2)], &[("relu", 3)]],
                coarse,
            ),
            interval(2),
        ),
        (
            file(
                "least",
                3,
                &[&[], &[("tanh", 5), ("relu", 4), ("linear", 2)]],
                "",
            ),
            bits(3, 3, 4),
        ),
        (
            file(
                "most",
                3,
                &[&[("linear", 2)], &[("tanh", 3), ("relu", 4), ("linear", 2)]],
                "",
            ),
            bits(20, 16, 3),
        ),
        (
            file(
                "coarse_table",
                3,
                &[&[], &[("sigmoid", 3), ("tanh", 2)]],
                "",
            ),
            Options {
                segments: Some(4),
                ..bits(5, 5, 2)
            },
        ),
        (
            file(
                "even",
                16,
                &[&[], &[("relu", 24), ("relu", 16), ("linear", 5)]],
                "",
            ),
            interval(64),
        ),
    ]
}

fn assert_silent(found: &[String]) {
    assert!(
        found.is_empty(),
        "{} complaints\n{}",
        found.len(),
        found.join("\n")
    );
}

fn all_designs(part: usize) {
    let directory = tempfile::tempdir().expect("a directory");
    let designs: Vec<_> = designs().into_iter().skip(part).step_by(2).collect();
    assert!(designs.len() >= 6);
    let mut found = Vec::new();
    for (text, options) in designs {
        let (bundle, directory) = emit(&text, &options, directory.path());
        found.extend(complaints(&bundle, &directory));
    }
    assert_silent(&found);
}

#[test]
fn a_core_for_ecp5_is_clean_and_has_every_multiplier_in_a_block() {
    every_multiplier_is_in_a_block("ecp5-25k", &["CCU2C", "MULT18X18D"], &["MULT18X18D"]);
}

#[test]
fn a_core_for_ice40_is_clean_and_has_every_multiplier_in_a_block() {
    every_multiplier_is_in_a_block("ice40-up5k", &["SB_MAC16"], &["SB_MAC16"]);
}

#[test]
fn a_core_for_gowin_is_clean_and_has_every_multiplier_in_a_block() {
    every_multiplier_is_in_a_block("gw2a-18", &["MULT18X18"], &["MULT18X18"]);
    // Operands of more bits than a block has: each 18 of them fill one.
    let wide = WidthSetting {
        layer: None,
        bits: 24,
    };
    multipliers_are_in_blocks("gw2a-18", &["MULT18X18"], &["MULT18X18"], (vec![wide], 2));
}

#[test]
fn a_core_for_nexus_is_clean_and_has_every_multiplier_in_a_block() {
    every_multiplier_is_in_a_block("nexus-40k", &["MULT18X18"], &["MULT18X18"]);
}

/// Blocks that synthesis takes for the portable multiplier.
#[test]
fn a_core_for_other_families_has_every_multiplier_in_a_block() {
    every_multiplier_is_in_a_block("xc7a35t", &[], &["DSP48E1"]);
    every_multiplier_is_in_a_block("xczu3eg", &[], &["DSP48E2"]);
    every_multiplier_is_in_a_block("5csema5", &[], &["MISTRAL_MUL18X18", "MISTRAL_MUL9X9"]);
}

#[test]
fn a_core_for_a_device_without_multipliers_is_clean() {
    let text = file("adders", 5, &[&[], &[("tanh", 6), ("linear", 3)]], "");
    for bits in [3, 7, 16] {
        let root = tempfile::tempdir().expect("a directory");
        let options = Options {
            device: Some("ice40-hx8k".into()),
            weight_bits: vec![WidthSetting { layer: None, bits }],
            ..interval(8)
        };
        let (bundle, directory) = emit(&text, &options, root.path());
        let cells = sources(&bundle, "rtl/");
        assert!(
            cells.contains(&"rtl/adders__hwg_mul.v".to_owned()),
            "{cells:?}"
        );
        assert_silent(&complaints(&bundle, &directory));
    }
}

/// `models`: of the blocks that the bundle instantiates; `cells`: what holds a multiplier in the netlist.
fn every_multiplier_is_in_a_block(device: &str, models: &[&str], cells: &[&str]) {
    multipliers_are_in_blocks(device, models, cells, (Vec::new(), 1));
}

/// With weights of so many bits, for which an array's multiplier takes so many blocks.
fn multipliers_are_in_blocks(
    device: &str,
    models: &[&str],
    cells: &[&str],
    (weight_bits, blocks_each): (Vec<WidthSetting>, usize),
) {
    let root = tempfile::tempdir().expect("a directory");
    let options = Options {
        device: Some(device.into()),
        weight_bits,
        ..interval(8)
    };
    let text = file("blocks", 5, &[&[], &[("tanh", 6), ("linear", 3)]], "");
    let (bundle, directory) = emit(&text, &options, root.path());
    let mut simulated = sources(&bundle, "rtl/");
    simulated.extend(sources(&bundle, "sim/"));
    let wanted: Vec<String> = models.iter().map(|name| format!("sim/{name}.v")).collect();
    assert_eq!(sources(&bundle, "sim/"), wanted);
    assert_eq!(verilator(&directory, "blocks", &[], &simulated), None);
    assert_eq!(icarus(&directory, "blocks", &[], &simulated), None);

    let script = ["-s", "syn/blocks.ys"].map(str::to_owned);
    let (log, good) = run(&YOSYS, &script, &directory);
    assert!(good, "{log}");
    let net = weights::read(text.as_bytes()).expect("readable");
    let design = Design::new(&net, &options).expect("a legal design");
    let wanted = blocks_each * design.multipliers() + design.activation_multipliers();
    let stat = log.rsplit("Printing statistics").next().expect("it");
    let synthesis = &device::find(device).expect("a device").synthesis;
    let (_, counts) = stat.split_once("Number of cells:").expect("a table");
    for line in counts
        .lines()
        .skip(1)
        .take_while(|line| !line.trim().is_empty())
    {
        let kind = line.split_whitespace().next().expect("a type");
        let known = synthesis.cells.contains_key(kind) || synthesis.free.iter().any(|f| f == kind);
        assert!(known, "{device}: {kind}");
    }
    let blocks: usize = stat
        .lines()
        .filter_map(|line| line.trim().split_once(' '))
        .filter(|(name, _)| cells.contains(name))
        .filter_map(|(_, count)| count.trim().parse::<usize>().ok())
        .sum();
    assert_eq!(blocks, wanted, "{stat}");
}

#[test]
fn emitted_files_of_even_designs() {
    all_designs(0);
}

#[test]
fn emitted_files_of_odd_designs() {
    all_designs(1);
}

#[test]
fn emitted_files_of_landing() {
    let directory = tempfile::tempdir().expect("a directory");
    let text = fs::read_to_string(root().join("designs/landing/weights.json")).expect("weights");
    let (bundle, directory) = emit(&text, &Options::default(), directory.path());
    assert_silent(&complaints(&bundle, &directory));
}

#[test]
fn library_cells_with_their_own_parameters() {
    let library = root().join("rtl/lib");
    let directory = tempfile::tempdir().expect("a directory");
    let mut cells: Vec<String> = fs::read_dir(&library)
        .expect("the library")
        .map(|e| e.expect("an entry").path())
        .map(|p| {
            p.file_stem()
                .expect("a name")
                .to_str()
                .expect("UTF-8")
                .to_owned()
        })
        .collect();
    cells.sort();
    assert!(cells.len() >= 15, "{cells:?}");
    let path = |cell: &String| library.join(format!("{cell}.v")).display().to_string();
    let files: Vec<String> = cells.iter().map(path).collect();
    let search = library.display().to_string();
    let mut found = Vec::new();
    for cell in &cells {
        let own = [path(cell)];
        let results = [
            (
                "verilator",
                verilator(directory.path(), cell, &["-y", &search], &own),
            ),
            (
                "iverilog",
                icarus(directory.path(), cell, &["-y", &search], &own),
            ),
            ("yosys", yosys(directory.path(), cell, &files)),
        ];
        let texts = results
            .into_iter()
            .filter_map(|(tool, text)| Some(format!("{cell}, {tool}:\n{}", text?)));
        found.extend(texts);
    }
    assert_silent(&found);
}

/// A waiver says which of its kinds it waives, why on the next line, and where it ends.
#[test]
fn every_waiver_is_explained() {
    let mut waivers = 0;
    for folder in ["lib", "tpl", "tb"] {
        for entry in fs::read_dir(root().join("rtl").join(folder)).expect("a directory") {
            let path = entry.expect("an entry").path();
            let text = fs::read_to_string(&path).expect("text");
            let count = unexplained(&text).unwrap_or_else(|line| {
                panic!("{}:{line}: a waiver without its reason", path.display())
            });
            waivers += count;
        }
    }
    assert!(waivers > 0);
    for bad in [
        "// verilator lint_off UNUSED\nwire a;\n// verilator lint_on UNUSED\n",
        "// verilator lint_off UNUSED\n// The rest is dropped.\nwire a;\n",
        "// verilator lint_off\n// The rest is dropped.\nwire a;\n// verilator lint_on\n",
        "/* verilator lint_off UNUSED */ wire a; // The rest.\n",
        "// verilator lint_off UNUSED\n//\nwire a;\n// verilator lint_on UNUSED\n",
    ] {
        assert!(unexplained(bad).is_err(), "{bad}");
    }
}

/// Number of waivers, or the line of the first bad one.
fn unexplained(text: &str) -> Result<usize, usize> {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let mut count = 0;
    for (i, line) in lines.iter().enumerate() {
        if !["lint_off", "translate_off", "coverage_off"]
            .iter()
            .any(|w| line.contains(w))
        {
            continue;
        }
        let kind = line.strip_prefix("// verilator lint_off ").ok_or(i + 1)?;
        let reason = lines
            .get(i + 1)
            .and_then(|l| l.strip_prefix("// "))
            .unwrap_or("");
        let end = format!("// verilator lint_on {kind}");
        if reason.split(' ').count() < 3
            || reason.contains("verilator")
            || !lines[i..].contains(&&*end)
        {
            return Err(i + 1);
        }
        count += 1;
    }
    Ok(count)
}

/// Damage in the top module, by replacing a text in it or adding to its end.
fn damaged(damage: impl Fn(&str) -> String) -> (tempfile::TempDir, Bundle, PathBuf) {
    let root = tempfile::tempdir().expect("a directory");
    let (text, options) = designs().swap_remove(4);
    let (bundle, directory) = emit(&text, &options, root.path());
    let path = directory.join("rtl/gate.v");
    let before = fs::read_to_string(&path).expect("the top");
    let after = damage(&before);
    assert_ne!(before, after, "nothing was damaged");
    fs::write(&path, after).expect("written");
    (root, bundle, directory)
}

fn with(lines: &'static str) -> impl Fn(&str) -> String {
    move |top| top.replacen("endmodule", &format!("{lines}\nendmodule"), 1)
}

#[test]
fn verilator_sees_what_is_wrong() {
    for damage in [
        "  wire floating;",
        "  wire [3:0] narrow = 5'd3;",
        "  wire used_undriven; wire [1:0] unused_a = {2{used_undriven}};",
        "  reg latch; wire unused_l = latch; always @* if (in_valid) latch = in_ready;",
    ] {
        let (_root, bundle, directory) = damaged(with(damage));
        let found = verilator(&directory, "gate", &[], &sources(&bundle, "rtl/"));
        assert!(
            found.is_some_and(|t| t.contains("%Warning") || t.contains("%Error")),
            "{damage}"
        );
    }
}

#[test]
fn icarus_sees_what_is_wrong() {
    let too_narrow = |top: &str| top.replacen("wire in_clipped;", "wire [2:0] in_clipped;", 1);
    let (_root, bundle, directory) = damaged(too_narrow);
    let found = icarus(&directory, "gate", &[], &sources(&bundle, "rtl/"));
    assert!(found.is_some_and(|t| t.contains("in_clipped") || t.contains("clipped")));
    for damage in [
        "  wire implicit = never_declared;",
        "  gate__hwg_slice u_open (.clk_i(aclk), .no_port(aclk));",
    ] {
        let (_root, bundle, directory) = damaged(with(damage));
        assert!(
            icarus(&directory, "gate", &[], &sources(&bundle, "rtl/")).is_some(),
            "{damage}"
        );
    }
}

#[test]
fn slang_and_verible_see_what_is_wrong() {
    for damage in [
        "  wire early = late; wire late = aclk;",
        "  wire [3:0] narrow = {5{aclk}};",
        "  wire [0:0] moved = 1'b1 << 1;",
    ] {
        let (_root, bundle, directory) = damaged(with(damage));
        let found = slang(&directory, "gate", &sources(&bundle, "rtl/"));
        assert!(found.is_some(), "{damage}");
    }
    let (_root, bundle, directory) =
        damaged(with("  reg state; initial begin state = 1'b0; end  "));
    assert!(verible(&directory, &sources(&bundle, "rtl/")).is_some());
}

#[test]
fn yosys_sees_what_is_wrong() {
    for damage in [
        "  wire undriven; wire kept; gate__hwg_delay u_u (.clk_i(aclk), .rst_i(~aresetn), .data_i(undriven), .data_o(kept));",
        "  wire twice = in_ready; assign twice = in_valid;",
        "  wire loop_a; wire loop_b; assign loop_b = ~loop_a; assign loop_a = loop_b & in_ready;",
        "  no_such_module u_none (.clk_i(aclk));",
    ] {
        let (_root, bundle, directory) = damaged(with(damage));
        assert!(
            yosys(&directory, "gate", &sources(&bundle, "rtl/")).is_some(),
            "{damage}"
        );
    }
}
