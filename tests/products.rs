//! What a family's table says that synthesis makes of multipliers is what Yosys makes of them.

use std::fs;
use std::path::Path;
use std::process::Command;

use hwgen_gen::generate;
use hwgen_sim::tool::{Toolbox, YOSYS};
use hwgen_spec::design::Design;
use hwgen_spec::device::{self, Device};
use hwgen_spec::options::Options;
use hwgen_spec::weights;

/// The family's multiplier of so many bits, synthesised: sites, and types of cells that none are known of.
struct Synthesised {
    bits: [u32; 2],
    multipliers: u32,
    lut4: u64,
}

/// Yosys's own commands and the family's cells are those of a bundle.
fn synthesised(device: &Device, operands: &[[u32; 2]]) -> Vec<Synthesised> {
    let text = include_bytes!("../designs/tiny/weights.json");
    let net = weights::read(text).expect("readable");
    let options = Options {
        device: Some(device.name.clone()),
        ..Options::default()
    };
    let design = Design::new(&net, &options).expect("a legal design");
    let root = tempfile::tempdir().expect("a directory");
    let bundle = root.path().join("bundle");
    generate(&design, &net).write(&bundle).expect("written");

    let black_boxes = device.synthesis.library.clone().unwrap_or_else(|| {
        let models = fs::read_dir(bundle.join("sim"));
        let paths = models.into_iter().flatten().map(|e| e.expect("an entry"));
        let names = paths.map(|e| format!("sim/{}", e.file_name().to_str().expect("UTF-8")));
        names.collect::<Vec<_>>().join(" ")
    });
    let mul = format!("{}__hwg_mul", design.name());
    let script: String = operands
        .iter()
        .map(|[a, b]| {
            let boxes: String = black_boxes
                .split_whitespace()
                .map(|path| format!("read_verilog -lib {path}\n"))
                .collect();
            format!(
                "design -reset\n{boxes}read_verilog rtl/{mul}.v\n\
                 chparam -set A_WIDTH {a} -set B_WIDTH {b} {mul}\n\
                 tee -o log.txt {} -top {mul}\n\
                 tee -a cells.txt log @ {a} {b}\ntee -a cells.txt stat\n",
                device.synthesis.command
            )
        })
        .collect();
    fs::write(bundle.join("mul.ys"), script).expect("written");
    let tool = Toolbox::new(Path::new(env!("CARGO_MANIFEST_DIR")))
        .find(&YOSYS)
        .expect("installed");
    let ran = Command::new(tool.path)
        .args(["-q", "mul.ys"])
        .current_dir(&bundle)
        .output()
        .expect("it runs");
    assert!(ran.status.success(), "{ran:?}");

    let cells = fs::read_to_string(bundle.join("cells.txt")).expect("written");
    let parts: Vec<&str> = cells.split("@ ").skip(1).collect();
    assert_eq!(parts.len(), operands.len());
    let sites = |(part, bits): (&str, &[u32; 2])| {
        let counts = part.lines().filter_map(|line| {
            let (kind, count) = line.trim().split_once(char::is_whitespace)?;
            let sites = device.synthesis.cells.get(kind)?;
            Some((sites, count.trim().parse::<u64>().ok()?))
        });
        let sum = counts.fold((0, 0), |(multipliers, lut4), (sites, count)| {
            (
                multipliers + count * sites.multipliers,
                lut4 + count * sites.lut4,
            )
        });
        Synthesised {
            bits: *bits,
            multipliers: u32::try_from(sum.0).expect("few"),
            lut4: sum.1,
        }
    };
    parts.into_iter().zip(operands).map(sites).collect()
}

/// The widest operands of each line of the table, and the narrowest that are beyond a line before it.
fn every_line_is_true(name: &str) {
    let device = device::find(name).expect("a device");
    let mut operands = Vec::new();
    for (at, product) in device.products.iter().enumerate() {
        let [a, b] = product.bits.map(|bits| bits.min(MOST));
        let before = device.products[..at].iter().map(|p| p.bits);
        let least = before.flat_map(|[x, y]| [[a.min(x + 1), b], [a, b.min(y + 1)]]);
        let own = |[a, b]: &[u32; 2]| device.product(*a, *b) == Some(product);
        operands.extend(least.chain([[a, b]]).filter(own));
    }
    operands.sort_unstable();
    operands.dedup();
    assert!(operands.len() >= device.products.len());
    for found in synthesised(device, &operands) {
        let [a, b] = found.bits;
        let told = device.product(a, b).expect("a line");
        assert_eq!(found.multipliers, told.multipliers, "{name}: {a} by {b}");
        let widest = [a, b] == told.bits.map(|bits| bits.min(MOST));
        let error = found.lut4.abs_diff(told.lut4);
        assert!(
            !widest || error <= 8 + found.lut4 * 6 / 10,
            "{name}: {a} by {b}: {} tables, {} told",
            found.lut4,
            told.lut4
        );
    }
}

/// Operands have no more bits.
const MOST: u32 = 25;

#[test]
fn of_ecp5() {
    every_line_is_true("ecp5-25k");
}

#[test]
fn of_nexus() {
    every_line_is_true("nexus-40k");
}

#[test]
fn of_gowin() {
    every_line_is_true("gw2a-18");
}

#[test]
fn of_ice40_and_beyond() {
    every_line_is_true("ice40-up5k");
    let device = device::find("ice40-up5k").expect("a device");
    assert_eq!(device.product(13, 17), None);
    let [found] = &synthesised(device, &[[13, 17]])[..] else {
        panic!("one");
    };
    assert_eq!(found.multipliers, 0);
    assert!(
        found.lut4.abs_diff(3 * 13 * 17) < found.lut4 / 6,
        "{}",
        found.lut4
    );
}

#[test]
fn of_7_series() {
    every_line_is_true("xc7a35t");
}

#[test]
fn of_ultrascale_plus() {
    every_line_is_true("xczu3eg");
}

#[test]
fn of_cyclone_v() {
    every_line_is_true("5csema5");
}

/// No line is hidden by one before it, and every multiplier has one where not all of it goes to tables.
#[test]
fn every_line_is_reached() {
    for device in device::all() {
        assert_eq!(device.products.is_empty(), device.multiplier_bits.is_none());
        if !device.has_multipliers() {
            continue;
        }
        for product in &device.products {
            let [a, b] = product.bits;
            assert_eq!(device.product(a, b), Some(product), "{}", device.name);
        }
        let most = if device.family == "ice40" { 16 } else { MOST };
        assert!(device.product(most, most).is_some(), "{}", device.name);
    }
}
