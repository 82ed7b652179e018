//! Several designs in one chip: no module of one is called like one of another.
//!
//! Needs Icarus, Verilator, Yosys and FuseSoC (`tools/setup --place`); a tool that is missing is a failure.

#[path = "support/random.rs"]
mod random;
#[path = "support/mod.rs"]
#[expect(dead_code, reason = "the other tests use the rest")]
mod support;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use hwgen_gen::{Bundle, Source, generate};
use hwgen_sim::simulator::Simulator;
use hwgen_sim::stimulus::Effort;
use hwgen_sim::tool::{ICARUS, Tool, Toolbox, VERILATOR, YOSYS};
use hwgen_spec::design::Design;
use hwgen_spec::network::FloatNet;
use hwgen_spec::options::Options;
use hwgen_spec::weights;

use random::random_design;
use support::{Check, assert_verified, check_source};

/// Builds chips of packages.
const FUSESOC: Tool = Tool {
    name: "FuseSoC",
    names: &["fusesoc"],
    version_argument: "--version",
    version_marker: "",
    minimum: "2.4",
    enables: "the test of packages",
    install: "tools/setup --place",
};

fn program(tool: &Tool) -> PathBuf {
    let toolbox = Toolbox::new(Path::new(env!("CARGO_MANIFEST_DIR")));
    let found = toolbox.find(tool);
    let missing = |error| panic!("{error}; it is installed by: {}", tool.install);
    found.unwrap_or_else(missing).path
}

/// Runs a tool in a directory; what it printed, and whether it ended well.
fn run(tool: &Tool, arguments: &[&str], directory: &Path) -> (String, bool) {
    let output = Command::new(program(tool))
        .args(arguments)
        .current_dir(directory)
        // FuseSoC reads and writes files of its user.
        .env("HOME", directory)
        .env_remove("XDG_CONFIG_HOME")
        .env_remove("XDG_DATA_HOME")
        .env_remove("XDG_CACHE_HOME")
        .output()
        .expect("it runs");
    let text = [output.stdout, output.stderr].concat();
    let text = String::from_utf8_lossy(&text).into_owned();
    (text, output.status.success())
}

/// How a design of the small network is to be called, and what it is for.
struct Wanted {
    name: &'static str,
    prefix: Option<&'static str>,
    device: Option<&'static str>,
}

/// Two designs of which one has the name of the other's stage, for devices with blocks of their own.
const OTHER_DEVICES: [Wanted; 2] = [
    Wanted {
        name: "tiny",
        prefix: None,
        device: Some("ecp5-25k"),
    },
    Wanted {
        name: "tiny_mlp",
        prefix: None,
        device: Some("ice40-up5k"),
    },
];

/// Two that are renamed, with models of the same block.
const OTHER_NAMES: [Wanted; 2] = [
    Wanted {
        name: "left",
        prefix: None,
        device: Some("ecp5-25k"),
    },
    Wanted {
        name: "right",
        prefix: Some("left_mlp"),
        device: Some("ecp5-25k"),
    },
];

/// Of portable Verilog and of multipliers of adders.
const OTHER_CELLS: [Wanted; 2] = [
    Wanted {
        name: "tiny",
        prefix: None,
        device: None,
    },
    Wanted {
        name: "tiny_hwg",
        prefix: None,
        device: Some("ice40-hx8k"),
    },
];

fn tiny(name: &str) -> FloatNet {
    let text = include_bytes!("../designs/tiny/weights.json");
    let mut net = weights::read(text).expect("readable");
    net.name = name.to_owned();
    net
}

fn design(wanted: &Wanted) -> (Design, Bundle) {
    let net = tiny(wanted.name);
    let options = Options {
        device: wanted.device.map(str::to_owned),
        prefix: wanted.prefix.map(str::to_owned),
        ..Options::default()
    };
    let design = Design::new(&net, &options).expect("a legal design");
    let bundle = generate(&design, &net);
    (design, bundle)
}

/// A directory with a bundle for each design, in directories of their names, and a chip of all.
struct Chip {
    directory: tempfile::TempDir,
    names: Vec<String>,
    rtl: Vec<String>,
    models: Vec<String>,
    /// What Yosys takes in place of the models.
    black_boxes: BTreeSet<String>,
}

impl Chip {
    fn of(wanted: &[Wanted]) -> Self {
        let directory = tempfile::tempdir().expect("a directory");
        let designs: Vec<_> = wanted.iter().map(design).collect();
        let (mut rtl, mut models) = (vec!["chip.v".to_owned()], Vec::new());
        let mut black_boxes = BTreeSet::new();
        for (design, bundle) in &designs {
            let name = design.name();
            bundle.write(&directory.path().join(name)).expect("written");
            let models_before = models.len();
            for file in bundle.files() {
                let path = format!("{name}/{}", file.path);
                match file.path.split('/').next() {
                    Some("rtl") => rtl.push(path),
                    Some("sim") => models.push(path),
                    _ => {}
                }
            }
            let own = models[models_before..].iter().map(String::as_str);
            let own = design.device().synthesis.black_boxes(own);
            black_boxes.extend(own.into_iter().map(str::to_owned));
        }
        let text = chip(designs.iter().map(|(design, _)| design));
        fs::write(directory.path().join("chip.v"), text).expect("written");
        Self {
            directory,
            names: wanted.iter().map(|w| w.name.to_owned()).collect(),
            rtl,
            models,
            black_boxes,
        }
    }

    fn path(&self) -> &Path {
        self.directory.path()
    }

    /// What the tools say of the chip; nothing if they are content.
    fn complaints(&self) -> Vec<String> {
        [self.icarus(), self.verilator(), self.yosys()]
            .into_iter()
            .flatten()
            .collect()
    }

    fn icarus(&self) -> Option<String> {
        let output = self.path().join("chip.vvp");
        let _ = fs::remove_file(&output);
        let mut arguments = vec!["-g2005", "-Wall", "-s", "chip", "-o", "chip.vvp"];
        arguments.extend(self.rtl.iter().chain(&self.models).map(String::as_str));
        let (text, good) = run(&ICARUS, &arguments, self.path());
        (!good || !text.is_empty() || !output.is_file()).then_some(text)
    }

    fn verilator(&self) -> Option<String> {
        let mut arguments = vec!["--lint-only", "-Wall", "--top-module", "chip"];
        arguments.extend(self.rtl.iter().chain(&self.models).map(String::as_str));
        let (text, good) = run(&VERILATOR, &arguments, self.path());
        (!good || !text.is_empty()).then_some(text)
    }

    fn yosys(&self) -> Option<String> {
        let boxes = self.black_boxes.iter();
        let boxes = boxes.map(|file| format!("read_verilog -lib {file}; "));
        let rtl = self.rtl.iter().map(|f| format!("read_verilog {f}; "));
        let mut script: String = boxes.chain(rtl).collect();
        script.push_str("hierarchy -check -top chip; proc; check -assert");
        let (text, good) = run(
            &YOSYS,
            &["-q", "-l", "yosys.log", "-p", &script],
            self.path(),
        );
        let log = fs::read_to_string(self.path().join("yosys.log")).unwrap_or_default();
        let verdict = log.contains("Found and reported 0 problems.");
        (!good || !verdict || !text.is_empty()).then_some(text)
    }
}

/// A module with one of each design, whose ports are all its own.
fn chip<'a>(designs: impl Iterator<Item = &'a Design>) -> String {
    let (mut ports, mut instances) = (Vec::new(), String::new());
    for design in designs {
        let name = design.name();
        let data = [design.source(), design.sink()].map(|port| port.data_bits() - 1);
        let own = [
            ("input  wire", "s_axis_tdata", data[0]),
            ("input  wire", "s_axis_tvalid", 0),
            ("output wire", "s_axis_tready", 0),
            ("input  wire", "s_axis_tlast", 0),
            ("output wire", "m_axis_tdata", data[1]),
            ("output wire", "m_axis_tvalid", 0),
            ("input  wire", "m_axis_tready", 0),
            ("output wire", "m_axis_tlast", 0),
            ("output wire", "m_axis_tuser", 1),
        ];
        let mut connected = vec![".aclk(aclk)".to_owned(), ".aresetn(aresetn)".to_owned()];
        for (way, port, high) in own {
            let range = match high {
                0 => String::new(),
                high => format!("[{high}:0] "),
            };
            ports.push(format!("  {way} {range}{name}_{port}"));
            connected.push(format!(".{port}({name}_{port})"));
        }
        let connected = connected.join(",\n    ");
        instances.push_str(&format!("  {name} u_{name} (\n    {connected}\n  );\n"));
    }
    format!(
        "module chip (\n  input  wire aclk,\n  input  wire aresetn,\n{}\n);\n{instances}endmodule\n",
        ports.join(",\n")
    )
}

#[test]
fn designs_for_two_devices_are_one_chip() {
    assert_eq!(Chip::of(&OTHER_DEVICES).complaints(), [""; 0]);
}

#[test]
fn renamed_designs_are_one_chip() {
    assert_eq!(Chip::of(&OTHER_NAMES).complaints(), [""; 0]);
}

#[test]
fn designs_of_other_cells_are_one_chip() {
    assert_eq!(Chip::of(&OTHER_CELLS).complaints(), [""; 0]);
}

/// The tools see a module that two bundles have, else the tests above prove nothing.
#[test]
fn a_module_that_two_bundles_have_is_seen() {
    let chip = Chip::of(&OTHER_CELLS);
    for path in &chip.rtl {
        let path = chip.path().join(path);
        let text = fs::read_to_string(&path).expect("read");
        let text = text.replace("tiny_hwg__hwg_slice", "tiny__hwg_slice");
        fs::write(path, text).expect("written");
    }
    for complaint in [chip.icarus(), chip.yosys()] {
        let complaint = complaint.expect("a complaint");
        assert!(complaint.contains("tiny__hwg_slice"), "{complaint}");
    }
}

/// Packages of two designs, and one of a chip that depends on both.
#[test]
fn fusesoc_makes_one_chip_of_two_packages() {
    let chip = Chip::of(&OTHER_DEVICES);
    let [a, b] = &chip.names[..] else {
        panic!("two designs");
    };
    // FuseSoC takes files from the directory of a package alone.
    fs::create_dir(chip.path().join("chip")).expect("made");
    let mut files = vec!["chip.v"];
    for path in chip.models.iter().map(String::as_str).chain(["chip.v"]) {
        let (_, name) = path.rsplit_once('/').unwrap_or(("", path));
        fs::copy(chip.path().join(path), chip.path().join("chip").join(name)).expect("copied");
        if name != "chip.v" {
            files.push(name);
        }
    }
    let package = format!(
        "CAPI=2:\nname: \"::chip:0\"\nfilesets:\n  rtl:\n    files: [{}]\n    \
         file_type: verilogSource-2005\n    depend: [\"::{a}:0\", \"::{b}:0\"]\n\
         targets:\n  default:\n    filesets: [rtl]\n    toplevel: chip\n    flow: sim\n    \
         flow_options: {{tool: icarus, iverilog_options: [-g2005]}}\n",
        files.join(", ")
    );
    fs::write(chip.path().join("chip/chip.core"), package).expect("written");
    let arguments = ["--cores-root", ".", "run", "--setup", "--build"];
    let arguments = [&arguments[..], &["--build-root", "out", "::chip:0"]].concat();
    let (text, good) = run(&FUSESOC, &arguments, chip.path());
    assert!(good && !text.contains("ERROR"), "{text}");
    let built = below(&chip.path().join("out"));
    let named = |end: &str| built.iter().find(|path| path.ends_with(end));
    for path in &chip.rtl {
        let (_, name) = path.rsplit_once('/').unwrap_or(("", path));
        assert!(named(&format!("/{name}")).is_some(), "{path}: {built:?}");
    }
    // Icarus names the module of each scope.
    let compiled = built
        .iter()
        .filter_map(|path| fs::read_to_string(path).ok())
        .find(|text| text.contains(":ivl_version"))
        .unwrap_or_else(|| panic!("expected what Icarus compiled, found {built:?}"));
    for module in [a, b, &format!("{a}__mlp"), &format!("{b}__mlp")] {
        assert!(compiled.contains(&format!("\"{module}\"")), "{module}");
    }
}

/// Paths of all files below a directory.
fn below(directory: &Path) -> Vec<String> {
    let mut files = Vec::new();
    for entry in fs::read_dir(directory).expect("a directory") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            files.extend(below(&path));
        } else {
            files.push(path.display().to_string());
        }
    }
    files
}

/// What a bundle with names of its own holds leads to the same bundle, and it is verified.
#[test]
fn a_renamed_bundle_is_read_back_and_verified() {
    let directory = tempfile::tempdir().expect("a directory");
    for wanted in &OTHER_NAMES {
        let (_, bundle) = design(wanted);
        let path = directory.path().join(wanted.name);
        bundle.write(&path).expect("written");
        let source = Source::read(&path).expect("a bundle as it was emitted");
        assert_eq!(source.design.prefix(), wanted.prefix.unwrap_or(wanted.name));
        assert_eq!(generate(&source.design, &source.net), bundle);
        let check = Check {
            random: 4,
            seed: 1,
            simulators: &[Simulator::Icarus],
            effort: Effort::Quick,
        };
        let report = check_source(&path, &source, &check).expect("Icarus runs");
        assert_verified(&report, wanted.name);
    }
}

/// Names that are like parts of others, and of cells.
const NAMES: [&str; 40] = [
    "a",
    "a_mlp",
    "a_net0",
    "a_net0_l0",
    "a_net0_l0_pe",
    "a_net0_l0_w0",
    "a_net0_l0_bias",
    "a_shared_l0",
    "a_shared_in",
    "a_tanh12",
    "a_hwg",
    "a_hwg_mul",
    "a_tb",
    "a_shell",
    "_a",
    "_a_mlp",
    "A",
    "mlp",
    "mlp_mlp",
    "net0",
    "net0_l0",
    "net0_l0_pe",
    "shared_l0",
    "shared_in",
    "tanh12",
    "tanh13",
    "hwg",
    "hwg_hwg",
    "hwg_mul",
    "hwg_mul_mlp",
    "hwg_slice",
    "hwg_slice_hwg_slice",
    "l0",
    "l0_pe",
    "pe",
    "w0",
    "bias",
    "_0",
    "a_0",
    "a_0_0",
];

/// The modules of a bundle, a file each.
fn modules(bundle: &Bundle) -> Vec<String> {
    let rtl = bundle.files().iter().filter_map(|file| {
        let name = file.path.strip_prefix("rtl/")?.strip_suffix(".v")?;
        Some((name, &file.text))
    });
    rtl.map(|(name, text)| {
        let mut found = text.lines().filter_map(|line| {
            let rest = line.strip_prefix("module ")?;
            rest.split([' ', '(', ';']).next()
        });
        assert_eq!(found.next(), Some(name));
        assert_eq!(found.next(), None, "{name}");
        name.to_owned()
    })
    .collect()
}

#[test]
fn no_two_of_forty_random_designs_have_a_module_in_common() {
    let mut owners: BTreeMap<String, &str> = BTreeMap::new();
    for (seed, name) in (0..).zip(NAMES) {
        let (mut net, options) = random_design(seed);
        net.name = name.to_owned();
        // Names of networks may hold what ends a prefix.
        let others = ["net0", "_mlp", "hwg_mul", "mlp__net0", "net0_"];
        let other = others[usize::try_from(seed).expect("small") % others.len()];
        net.networks[0].name = other.to_owned();
        let text = weights::to_json(&net);
        weights::read(text.as_bytes()).unwrap_or_else(|error| panic!("{name}: {error}"));
        let design = Design::new(&net, &options).expect("a legal design");
        let bundle = generate(&design, &net);
        let found = modules(&bundle);
        assert!(found.len() > 10, "{name}");
        for module in found {
            let own = module == name || module.starts_with(&format!("{name}__"));
            assert!(own, "{name}: {module}");
            if let Some(other) = owners.insert(module.clone(), name) {
                panic!("{module}: expected in one design, found in {other} and {name}");
            }
        }
    }
}
