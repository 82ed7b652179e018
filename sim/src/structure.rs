//! Which registers and memories the Verilog has, as Yosys reads it, beside those of the model.
//!
//! A dump shows that each register of the model is in the Verilog. That the Verilog has no other is
//! asked here: state that the model lacks could spoil an output after any number of cycles.

mod wires;

use std::collections::{BTreeMap, HashMap, HashSet};
use std::ffi::OsString;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::Deserialize;

use crate::error::ToolError;
use crate::record::Register;
use crate::simulator::{Text, place_sources, text};
use crate::tool::live::Scratch;
use crate::tool::run::{io, run_in};
use crate::tool::{Invocation, Toolbox, YOSYS};
use crate::trace::CLOCK;

const SCRIPT: &str = "structure.ys";
const NETLIST: &str = "structure.json";
/// What Yosys's `check` says.
const CHECKED: &str = "structure.check";
/// How `check` begins the report of a wire that two drive.
const CONFLICT: &str = "multiple conflicting drivers";

/// What Yosys is asked about.
#[derive(Clone, Debug)]
pub struct StructurePlan<'a> {
    /// The top module.
    pub top: &'a str,
    /// Verilog files of the core.
    pub sources: &'a [PathBuf],
    /// Models of the device's blocks that it may instantiate: the tool's own.
    pub models: &'a [Text],
    /// Ports of the core, with widths; those that are not among the registers are inputs.
    pub inputs: &'a [(&'a str, usize)],
    /// Where log and record are left.
    pub work_dir: &'a Path,
    /// How long it may take.
    pub timeout: Duration,
}

/// State of the Verilog that was compared with the model's.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Structure {
    /// Version of Yosys.
    pub version: String,
    /// Registers that the model has too.
    pub registers: usize,
    /// Memories that the model has too.
    pub memories: usize,
    /// The first thing that the model lacks.
    pub extra: Option<Extra>,
}

/// State that the model lacks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Extra {
    /// Its path from the core down.
    pub path: String,
    /// What it is: `a register of 7 bits`.
    pub what: String,
}

#[derive(Deserialize)]
struct Netlist {
    modules: BTreeMap<String, Module>,
}

#[derive(Deserialize)]
struct Module {
    cells: BTreeMap<String, Cell>,
    netnames: BTreeMap<String, Net>,
    #[serde(default)]
    ports: BTreeMap<String, Port>,
}

#[derive(Deserialize)]
struct Port {
    direction: String,
    bits: Vec<serde_json::Value>,
}

#[derive(Deserialize)]
struct Cell {
    #[serde(rename = "type")]
    kind: String,
    #[serde(default)]
    parameters: BTreeMap<String, serde_json::Value>,
    #[serde(default)]
    port_directions: BTreeMap<String, String>,
    #[serde(default)]
    connections: BTreeMap<String, Vec<serde_json::Value>>,
}

#[derive(Deserialize)]
struct Net {
    #[serde(default)]
    hide_name: u8,
    bits: Vec<serde_json::Value>,
}

/// Reads the Verilog with Yosys and compares its state with the registers of the model.
///
/// # Errors
/// If Yosys is missing, fails, or leaves no netlist behind.
pub fn compare(
    toolbox: &Toolbox,
    plan: &StructurePlan<'_>,
    registers: &[Register],
) -> Result<Structure, ToolError> {
    let yosys = toolbox.find(&YOSYS)?;
    let temporary = std::env::temp_dir();
    let scratch = Scratch::new("hwgen-structure-", &temporary).map_err(io(&temporary))?;
    let names = place_sources(plan.sources, scratch.path())?;
    let mut script = String::new();
    for name in names {
        script.push_str(&format!("read_verilog {}\n", name.to_string_lossy()));
    }
    // No optimization of registers: what is written has to be in the model, read or not.
    script.push_str(&format!(
        "hierarchy -top {}\nproc\nflatten\ntee -q -o {CHECKED} check\nmemory_collect\nwrite_json {NETLIST}\n",
        plan.top
    ));
    let script_path = scratch.path().join(SCRIPT);
    std::fs::write(&script_path, script).map_err(io(&script_path))?;
    let run = run_in(
        &Invocation {
            tool: yosys.name.clone(),
            version: yosys.version.to_string(),
            program: yosys.path.clone(),
            arguments: ["-q", "-s", SCRIPT].map(OsString::from).into(),
            directory: std::path::absolute(plan.work_dir).map_err(io(plan.work_dir))?,
            label: "structure".to_owned(),
            timeout: plan.timeout,
        },
        scratch.path(),
    )?;
    let path = scratch.path().join(NETLIST);
    let strange = || run.no_verdict(&yosys.name, "a netlist of the core");
    let file = File::open(&path).map_err(|_| strange())?;
    let netlist: Netlist = serde_json::from_reader(BufReader::new(file)).map_err(|_| strange())?;
    let module = netlist.modules.get(plan.top).ok_or_else(strange)?;
    let blocks: Vec<Block> = plan.models.iter().map(Block::read).collect();
    let (found, memories, mut extra) = state(module, registers, &blocks);
    extra = extra
        .or_else(|| wrong_port(module, registers, plan.inputs))
        .or_else(|| wires::fault(module, &blocks));
    let path = scratch.path().join(CHECKED);
    let checked = std::fs::read_to_string(&path).map_err(|_| strange())?;
    extra = extra.or_else(|| conflict(&checked));
    Ok(Structure {
        version: yosys.version.to_string(),
        registers: found,
        memories,
        extra,
    })
}

/// The first wire of which `check` says, in one line: `... drivers for top.\name [3]:`.
fn conflict(checked: &str) -> Option<Extra> {
    let line = checked.lines().find(|line| line.contains(CONFLICT))?;
    let name = line.rsplit('.').next().unwrap_or("");
    let name = line.split_once('\\').map_or(name, |(_, name)| name);
    Some(Extra {
        path: name
            .trim_end_matches(':')
            .split(' ')
            .next()
            .unwrap_or("")
            .to_owned(),
        what: "a wire with several drivers".to_owned(),
    })
}

/// Registers and memories that the model has, and the first state that it lacks.
fn state(
    module: &Module,
    registers: &[Register],
    blocks: &[Block],
) -> (usize, usize, Option<Extra>) {
    let model: HashMap<&str, u64> = registers.iter().map(|r| (&*r.path, r.bits())).collect();
    // Bits of the nets that are registers of the model.
    let mut known: HashMap<u64, &str> = HashMap::new();
    let mut names: HashMap<u64, &str> = HashMap::new();
    for (name, net) in &module.netnames {
        let in_model = model.get(&**name) == Some(&(net.bits.len() as u64));
        for bit in bits_of(&net.bits) {
            if in_model {
                known.insert(bit, name);
            }
            if net.hide_name == 0 {
                names.entry(bit).or_insert(name);
            }
        }
    }
    let live = live_bits(module);
    let in_block = |path: &str| {
        let place = ["a_q", "b_q", "p_q"]
            .iter()
            .find_map(|name| path.strip_suffix(name));
        place.is_some_and(|place| {
            place.ends_with("u_mul.")
                && module
                    .cells
                    .contains_key(&format!("{place}g_block.u_block"))
        })
    };
    let clock = module.ports.get(CLOCK).and_then(|port| port.bits.first());
    let mut found: HashSet<&str> = HashSet::new();
    let mut memories = 0;
    let mut extra: Vec<Extra> = Vec::new();
    for (name, cell) in &module.cells {
        if cell.kind.starts_with("$mem") {
            if number(cell, "WR_PORTS") == 0 {
                continue;
            }
            let size = number(cell, "SIZE");
            let path = parameter(cell, "MEMID").trim_start_matches('\\').to_owned();
            if number(cell, "WR_PORTS") != 1 || !is_clocked(cell, "WR_", clock) {
                let what = format!("a memory with another write port than one clocked by {CLOCK}");
                extra.push(Extra { path, what });
            } else if is_queue_memory(&model, &path, size, number(cell, "WIDTH")) {
                memories += 1;
            } else {
                let what = format!("a memory of {size} words");
                extra.push(Extra { path, what });
            }
        } else if is_state(&cell.kind) {
            let q = cell.connections.get("Q").map_or(&[][..], Vec::as_slice);
            let bits = || bits_of(q);
            // What reaches no output can do no harm: variables of loops, and the registers that Yosys
            // itself makes for the write ports of memories.
            if !bits().any(|bit| live.contains(&bit)) {
                continue;
            }
            let path = bits()
                .find_map(|bit| known.get(&bit))
                .map_or(&**name, |path| path);
            let mut report = |path: &str, what: String| {
                let path = path.to_owned();
                extra.push(Extra { path, what });
            };
            match bits().find(|bit| !known.contains_key(bit)) {
                // Beside a block, whose registers do not show, they would be free for anything.
                None if in_block(path) => {
                    report(path, "a register in place of one of the block".to_owned());
                }
                None if cell.kind != "$dff" || !is_clocked(cell, "", clock) => {
                    let what = "a register that changes at something else than a rising edge of";
                    report(path, format!("{what} {CLOCK}"));
                }
                None => found.extend(bits().filter_map(|bit| known.get(&bit).copied())),
                Some(bit) => {
                    let path = names.get(&bit).map_or(&**name, |name| name);
                    let kind = match cell.kind.contains("latch") {
                        true => "latch",
                        false => "register",
                    };
                    report(path, format!("a {kind} of {} bits", q.len()));
                }
            }
        } else if !cell.kind.starts_with('$') {
            let what = match blocks.iter().find(|block| block.name == cell.kind) {
                None => Some(format!(
                    "an instance of `{}`, which is not in the bundle",
                    cell.kind
                )),
                Some(block) => block.refuses(name, cell, &model),
            };
            extra.extend(what.map(|what| Extra {
                path: name.clone(),
                what,
            }));
        }
    }
    extra.sort_by(|a, b| a.path.cmp(&b.path));
    (found.len(), memories, extra.into_iter().next())
}

fn bits_of(bits: &[serde_json::Value]) -> impl Iterator<Item = u64> {
    bits.iter().filter_map(serde_json::Value::as_u64)
}

/// The bits that reach an output of the core, or a block, in whatever number of cycles.
fn live_bits(module: &Module) -> HashSet<u64> {
    let mut driver: HashMap<u64, &Cell> = HashMap::new();
    let mut left: Vec<u64> = Vec::new();
    for cell in module.cells.values() {
        for (port, wires) in &cell.connections {
            match cell.port_directions.get(port).map(String::as_str) {
                Some("output") => driver.extend(bits_of(wires).map(|bit| (bit, cell))),
                // A block: what it does with it is not known.
                None => left.extend(bits_of(wires)),
                Some(_) if !cell.kind.starts_with('$') => left.extend(bits_of(wires)),
                Some(_) => {}
            }
        }
    }
    let ports = module.ports.values().filter(|p| p.direction != "input");
    left.extend(ports.flat_map(|p| bits_of(&p.bits)));
    let mut live = HashSet::new();
    let mut seen: HashSet<*const Cell> = HashSet::new();
    while let Some(bit) = left.pop() {
        live.insert(bit);
        let Some(cell) = driver.get(&bit) else {
            continue;
        };
        if seen.insert(std::ptr::from_ref(*cell)) {
            let inputs = cell.connections.iter().filter(|(port, _)| {
                cell.port_directions
                    .get(*port)
                    .is_none_or(|d| d != "output")
            });
            left.extend(inputs.flat_map(|(_, wires)| bits_of(wires)));
        }
    }
    live
}

/// Whether each clock of a register or of a memory's write ports is the core's, and its rising edge
/// counts.
fn is_clocked(cell: &Cell, prefix: &str, clock: Option<&serde_json::Value>) -> bool {
    let all = |name: &str, bit: char| !parameter(cell, name).contains(bit);
    let port = format!("{prefix}CLK");
    let is_clock = |bits: &Vec<serde_json::Value>| bits.iter().all(|bit| Some(bit) == clock);
    cell.connections.get(&port).is_some_and(is_clock)
        && all(&format!("{port}_ENABLE"), '0')
        && number(cell, &format!("{port}_POLARITY")) % 2 == 1
}

/// A block of the device, as the text of its model has it.
struct Block {
    name: String,
    outputs: HashSet<String>,
    parameters: HashSet<String>,
    /// Whether its outputs come from registers.
    clocked: bool,
}

impl Block {
    fn read(model: &Text) -> Self {
        let (outputs, parameters, clocked) = text::interface(&model.text);
        Self {
            name: model.name.trim_end_matches(".v").to_owned(),
            outputs,
            parameters,
            clocked,
        }
    }

    /// What is wrong with an instance: a block with registers has its place in a multiplier.
    fn refuses(&self, name: &str, cell: &Cell, model: &HashMap<&str, u64>) -> Option<String> {
        let parameter = cell
            .parameters
            .keys()
            .find(|p| !self.parameters.contains(*p));
        if let Some(parameter) = parameter {
            return Some(format!(
                "the parameter `{parameter}` of `{}`, which its model lacks",
                self.name
            ));
        }
        let in_multiplier = place_of(name).is_some_and(|place| {
            let product = |register| model.contains_key(&*format!("{place}{register}"));
            product("r_q") || product("p_q")
        });
        (self.clocked && !in_multiplier).then(|| {
            format!(
                "an instance of `{}` that is no multiplier of the model",
                self.name
            )
        })
    }
}

/// Path of the multiplier that a block makes, alone or with others.
fn place_of(block: &str) -> Option<&str> {
    let end = block.rfind("u_mul.")? + "u_mul.".len();
    let (place, inside) = block.split_at(end);
    let of_several = inside.starts_with("g_wide.") && inside.ends_with(".u_block");
    (inside == "g_block.u_block" || of_several).then_some(place)
}

/// A port of the core that it should not have, or not like this.
fn wrong_port(module: &Module, registers: &[Register], inputs: &[(&str, usize)]) -> Option<Extra> {
    let is_input = |name: &str, bits| inputs.contains(&(name, bits));
    let is_output = |name: &str, bits: usize| {
        let of_this = |r: &&Register| r.path == name && r.bits() == bits as u64;
        registers.iter().any(|r| of_this(&r))
    };
    if let Some((name, _)) = inputs
        .iter()
        .find(|(name, _)| !module.ports.contains_key(*name))
    {
        return Some(Extra {
            path: (*name).to_owned(),
            what: "no such port".to_owned(),
        });
    }
    module.ports.iter().find_map(|(name, port)| {
        let bits = port.bits.len();
        let known = match &*port.direction {
            "input" => is_input(name, bits),
            "output" => is_output(name, bits),
            _ => false,
        };
        (!known).then(|| Extra {
            path: name.clone(),
            what: format!(
                "an {} of {bits} bits, which the core does not have",
                port.direction
            ),
        })
    })
}

/// Cells of Yosys that keep a value.
fn is_state(kind: &str) -> bool {
    kind.starts_with('$') && (kind.contains("ff") || kind.contains("latch") || kind == "$sr")
}

/// The memory of `hwg_queue`, which shows each of its words to the dump.
fn is_queue_memory(model: &HashMap<&str, u64>, path: &str, words: u64, bits: u64) -> bool {
    let Some(queue) = path.strip_suffix("memory") else {
        return false;
    };
    let word = |i: u64| format!("{queue}g_word[{i}].word");
    words > 0
        && (0..words).all(|i| model.get(&*word(i)) == Some(&bits))
        && !model.contains_key(&*word(words))
}

/// A parameter, which Yosys writes as its bits.
fn number(cell: &Cell, name: &str) -> u64 {
    match cell.parameters.get(name) {
        Some(serde_json::Value::Number(number)) => number.as_u64().unwrap_or(u64::MAX),
        Some(value) => u64::from_str_radix(value.as_str().unwrap_or("?"), 2).unwrap_or(u64::MAX),
        None => u64::MAX,
    }
}

fn parameter<'a>(cell: &'a Cell, name: &str) -> &'a str {
    cell.parameters
        .get(name)
        .and_then(|value| value.as_str())
        .unwrap_or("")
}
