//! Scripts for synthesis: Yosys for every family, and vendors' tools for portable Verilog.
//!
//! The vendors' tools can't be had here, so that their scripts were never run.

use askama::Template;
use hwgen_spec::device::Family;

use crate::bundle::File;
use crate::text::finish;

#[derive(Template)]
#[template(path = "synth.ys", syntax = "verilog")]
struct Yosys<'a> {
    module: &'a str,
    sources: &'a [&'a str],
    family: &'a str,
    cells: &'a str,
    synth: &'a str,
}

#[derive(Template)]
#[template(path = "vivado.tcl", syntax = "verilog")]
struct Vivado<'a> {
    module: &'a str,
    sources: &'a [&'a str],
}

#[derive(Template)]
#[template(path = "quartus.tcl", syntax = "verilog")]
struct Quartus<'a> {
    module: &'a str,
    sources: &'a [&'a str],
}

#[derive(Template)]
#[template(path = "radiant.tcl", syntax = "verilog")]
struct Radiant<'a> {
    module: &'a str,
    sources: &'a [&'a str],
}

#[derive(Template)]
#[template(path = "gowin.tcl", syntax = "verilog")]
struct Gowin<'a> {
    module: &'a str,
    sources: &'a [&'a str],
}

/// What Yosys is told for a family: a file of black boxes, empty for none, and the command.
pub fn yosys_commands(family: Family) -> (&'static str, &'static str) {
    match family {
        Family::Generic => ("", "synth"),
        Family::Ecp5 => ("+/ecp5/cells_bb.v", "synth_ecp5"),
        // Multipliers are instantiated: what is left is to be made of logic.
        Family::Ice40 => ("+/ice40/cells_sim.v", "synth_ice40"),
    }
}

/// All scripts for a core of some files.
pub(crate) fn all(module: &str, family: Family, sources: &[&str]) -> Vec<File> {
    let (cells, synth) = yosys_commands(family);
    let yosys = Yosys {
        module,
        sources,
        family: match family {
            Family::Generic => "generic",
            Family::Ecp5 => "ECP5",
            Family::Ice40 => "iCE40",
        },
        cells,
        synth,
    };
    let mut texts = vec![("ys", yosys.render())];
    if family == Family::Generic {
        texts.extend([
            ("vivado.tcl", Vivado { module, sources }.render()),
            ("quartus.tcl", Quartus { module, sources }.render()),
            ("radiant.tcl", Radiant { module, sources }.render()),
            ("gowin.tcl", Gowin { module, sources }.render()),
        ]);
    }
    let file = |(end, text)| File {
        path: format!("syn/{module}.{end}"),
        text: finish(text),
    };
    texts.into_iter().map(file).collect()
}
