//! Scripts for synthesis: Yosys for every family, and vendors' tools for portable Verilog and their own
//! devices.
//!
//! The vendors' tools can't be had here, so that their scripts were never run.

use askama::Template;
use hwgen_spec::device::{Device, Vendor};

use crate::bundle::File;
use crate::text::finish;

#[derive(Template)]
#[template(path = "synth.ys", syntax = "verilog")]
struct Yosys<'a> {
    module: &'a str,
    sources: &'a [&'a str],
    family: &'a str,
    black_boxes: Vec<&'a str>,
    command: &'a str,
    after: &'a [String],
}

#[derive(Template)]
#[template(path = "vivado.tcl", syntax = "verilog")]
struct Vivado<'a> {
    module: &'a str,
    sources: &'a [&'a str],
    part: &'a str,
}

#[derive(Template)]
#[template(path = "quartus.tcl", syntax = "verilog")]
struct Quartus<'a> {
    module: &'a str,
    sources: &'a [&'a str],
    part: &'a str,
}

#[derive(Template)]
#[template(path = "radiant.tcl", syntax = "verilog")]
struct Radiant<'a> {
    module: &'a str,
    sources: &'a [&'a str],
    part: &'a str,
    /// Its grade of speed: the digit behind the last dash.
    grade: &'a str,
}

#[derive(Template)]
#[template(path = "gowin.tcl", syntax = "verilog")]
struct Gowin<'a> {
    module: &'a str,
    sources: &'a [&'a str],
    part: &'a str,
}

/// All scripts for a core of some files.
pub(crate) fn all(module: &str, device: &Device, sources: &[&str], models: &[&str]) -> Vec<File> {
    let yosys = Yosys {
        module,
        sources,
        family: &device.title,
        black_boxes: device.synthesis.black_boxes(models.iter().copied()),
        command: &device.synthesis.command,
        after: &device.synthesis.after,
    };
    let mut texts = vec![("ys", yosys.render())];
    for vendor in &device.vendors {
        let part = |of_portable| device.part.as_deref().unwrap_or(of_portable);
        texts.push(match vendor {
            Vendor::Vivado => ("vivado.tcl", {
                let part = part("xc7a35tcpg236-1");
                Vivado {
                    module,
                    sources,
                    part,
                }
                .render()
            }),
            Vendor::Quartus => ("quartus.tcl", {
                let part = part("5CSEMA5F31C6");
                Quartus {
                    module,
                    sources,
                    part,
                }
                .render()
            }),
            Vendor::Radiant => ("radiant.tcl", {
                let part = part("LIFCL-40-7BG400I");
                let (_, package) = part
                    .rsplit_once('-')
                    .expect("LIFCL-<size>-<grade><package>");
                Radiant {
                    module,
                    sources,
                    part,
                    grade: &package[..1],
                }
                .render()
            }),
            Vendor::Gowin => ("gowin.tcl", {
                let part = part("GW2A-LV18PG256C8/I7");
                Gowin {
                    module,
                    sources,
                    part,
                }
                .render()
            }),
        });
    }
    let file = |(end, text)| File {
        path: format!("syn/{module}.{end}"),
        text: finish(text),
    };
    texts.into_iter().map(file).collect()
}
