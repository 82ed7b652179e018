//! Wires: what drives them, and what comes of them.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet, VecDeque};

use serde_json::Value;

use super::{Block, Cell, Extra, Module, bits_of, is_state, live_bits, number, parameter};
use crate::trace::CLOCK;

/// Cells each bit of whose result comes of the same bit of each operand.
const BITWISE: [&str; 7] = ["$and", "$mux", "$not", "$or", "$pos", "$xnor", "$xor"];

/// Cells that make unknown bits of known ones: of a division by zero, of a bit beyond the last.
const UNSAFE: [&str; 7] = [
    "$div",
    "$divfloor",
    "$mod",
    "$modfloor",
    "$pow",
    "$shift",
    "$shiftx",
];

/// A wire that nothing drives, an unknown bit, the clock among data, or a loop of gates, which can keep
/// a value as a register does.
pub(super) fn fault(module: &Module, blocks: &[Block]) -> Option<Extra> {
    Wires::of(module, blocks).fault()
}

struct Wires<'a> {
    module: &'a Module,
    blocks: &'a [Block],
    /// Of each bit, the first of its names that is in the source.
    names: HashMap<u64, &'a str>,
    /// What reads a bit.
    readers: HashMap<u64, Vec<&'a Cell>>,
}

impl<'a> Wires<'a> {
    fn of(module: &'a Module, blocks: &'a [Block]) -> Self {
        let mut wires = Self {
            module,
            blocks,
            names: HashMap::new(),
            readers: HashMap::new(),
        };
        for (name, net) in module.netnames.iter().filter(|(_, net)| net.hide_name == 0) {
            for bit in bits_of(&net.bits) {
                wires.names.entry(bit).or_insert(name);
            }
        }
        for cell in module.cells.values() {
            let read: Vec<u64> = wires
                .inputs(cell)
                .flat_map(|(_, bits)| bits_of(bits))
                .collect();
            for bit in read {
                wires.readers.entry(bit).or_default().push(cell);
            }
        }
        wires
    }

    fn is_output(&self, cell: &Cell, port: &str) -> bool {
        match cell.port_directions.get(port) {
            Some(direction) => direction == "output",
            None => self
                .block(cell)
                .is_some_and(|block| block.outputs.contains(port)),
        }
    }

    fn block(&self, cell: &Cell) -> Option<&Block> {
        self.blocks.iter().find(|block| block.name == cell.kind)
    }

    fn inputs<'b>(&'b self, cell: &'b Cell) -> impl Iterator<Item = (&'b str, &'b Vec<Value>)> {
        let ports = cell.connections.iter();
        let inputs = ports.filter(|(port, _)| !self.is_output(cell, port));
        inputs.map(|(port, bits)| (&**port, bits))
    }

    /// The bits that a cell drives.
    fn made(&self, cell: &Cell) -> Vec<u64> {
        let ports = cell.connections.iter();
        let outputs = ports.filter(|(port, _)| self.is_output(cell, port));
        outputs.flat_map(|(_, bits)| bits_of(bits)).collect()
    }

    fn fault(&self) -> Option<Extra> {
        let ports = |direction: &'static str| {
            let ports = self.module.ports.values();
            let ports = ports.filter(move |port| port.direction == direction);
            ports.flat_map(|port| bits_of(&port.bits))
        };
        let cells = || self.module.cells.values();
        let driven: HashSet<u64> = ports("input")
            .chain(cells().flat_map(|c| self.made(c)))
            .collect();
        if let Some(bit) = ports("output").find(|bit| !driven.contains(bit)) {
            return self.at([bit], "an output that nothing drives");
        }
        // First: what follows walks from gate to gate.
        if let Some(bits) = loop_in(&self.sources()) {
            return self.at(bits, "a loop of gates");
        }
        let live = live_bits(self.module);
        let clock = self
            .module
            .ports
            .get(CLOCK)
            .and_then(|p| bits_of(&p.bits).next());
        for cell in cells() {
            // What reaches no output can do no harm, as a variable of a loop, which keeps what it is not
            // given.
            let is_live = self.made(cell).iter().any(|bit| live.contains(bit));
            let reads_beyond = cell.kind.starts_with("$mem") && number(cell, "WR_PORTS") == 0 && {
                let words =
                    1_u64.checked_shl(u32::try_from(number(cell, "ABITS")).unwrap_or(u32::MAX));
                words != Some(number(cell, "SIZE")) || parameter(cell, "INIT").contains('x')
            };
            if is_live && (UNSAFE.contains(&&*cell.kind) || reads_beyond) {
                return self.at(self.behind(cell), "a cell that makes unknown bits");
            }
            for (port, bits) in self.inputs(cell) {
                if let Some(bit) = bits_of(bits).find(|bit| !driven.contains(bit)) {
                    return self.at([bit], "a wire that nothing drives");
                }
                // What is chosen in no case may be unknown: of a case that has all, of a memory that is
                // not written.
                let may = port.starts_with("RD_CLK")
                    || port == "A" && cell.kind == "$pmux"
                    || port == "A" && cell.kind == "$mux" && self.is_for_writes(cell, &live);
                let unknown = bits.iter().any(|bit| bit.as_str() == Some("x"));
                if unknown && !may && is_live {
                    return self.at(self.behind(cell), "an unknown bit among what it is made of");
                }
                // A flip-flop takes what is there before the clock rises, a simulator maybe not.
                if bits_of(bits).any(|bit| Some(bit) == clock) && !port.contains("CLK") {
                    return self.at(
                        self.behind(cell),
                        "the clock among the data that it is made of",
                    );
                }
            }
        }
        None
    }

    /// Whether a choice is read by write ports of memories alone, whose address and data are unknown while
    /// they are not written.
    fn is_for_writes(&self, cell: &Cell, live: &HashSet<u64>) -> bool {
        let (mut left, mut seen) = (self.made(cell), HashSet::new());
        while let Some(bit) = left.pop() {
            for reader in self.readers.get(&bit).into_iter().flatten() {
                let made = self.made(reader);
                if reader.kind.starts_with("$mem") || !made.iter().any(|bit| live.contains(bit)) {
                    continue;
                }
                if reader.kind != "$mux" {
                    return false;
                }
                if seen.insert(std::ptr::from_ref(*reader)) {
                    left.extend(made);
                }
            }
        }
        true
    }

    /// What is wrong, at the first of the bits that has a name.
    fn at(&self, bits: impl IntoIterator<Item = u64>, what: &str) -> Option<Extra> {
        let name = bits.into_iter().find_map(|bit| self.names.get(&bit));
        Some(Extra {
            path: name.map_or("", |name| name).to_owned(),
            what: what.to_owned(),
        })
    }

    /// The bits that come of a cell, the nearest first.
    fn behind(&self, cell: &Cell) -> Vec<u64> {
        let (mut left, mut seen) = (VecDeque::from(self.made(cell)), HashSet::new());
        let mut all = Vec::new();
        while let Some(bit) = left.pop_front() {
            if seen.insert(bit) {
                all.push(bit);
                let readers = self.readers.get(&bit).into_iter().flatten();
                left.extend(readers.flat_map(|cell| self.made(cell)));
            }
        }
        all
    }

    /// Of each bit that comes of gates: the bits that it comes of.
    fn sources(&self) -> BTreeMap<u64, Vec<u64>> {
        let mut sources = BTreeMap::new();
        for cell in self.module.cells.values() {
            if is_state(&cell.kind) || self.block(cell).is_some_and(|block| block.clocked) {
                continue;
            }
            if BITWISE.contains(&&*cell.kind) {
                for (i, bit) in cell.connections["Y"].iter().enumerate() {
                    let of_bit = self.inputs(cell).flat_map(|(port, bits)| match port {
                        "S" => &bits[..],
                        // An operand of fewer bits is extended by its last.
                        _ => std::slice::from_ref(&bits[i.min(bits.len() - 1)]),
                    });
                    let of_bit = of_bit.filter_map(Value::as_u64).collect();
                    sources.extend(bit.as_u64().map(|bit| (bit, of_bit)));
                }
                continue;
            }
            // What is written to a memory does not pass it.
            let passes = |port: &str| !cell.kind.starts_with("$mem") || port == "RD_ADDR";
            let inputs = self.inputs(cell).filter(|(port, _)| passes(port));
            let read: Vec<u64> = inputs.flat_map(|(_, bits)| bits_of(bits)).collect();
            sources.extend(self.made(cell).into_iter().map(|bit| (bit, read.clone())));
        }
        sources
    }
}

/// The bits of a loop: each comes of the one behind it, and the last of the first.
fn loop_in(sources: &BTreeMap<u64, Vec<u64>>) -> Option<Vec<u64>> {
    let mut done = HashSet::new();
    for start in sources.keys() {
        // The way to where the search is, with the next source to look at of each bit.
        let mut way: Vec<(u64, usize)> = vec![(*start, 0)];
        let mut on_way = BTreeSet::from([*start]);
        while let Some((bit, next)) = way.last_mut() {
            let (bit, at) = (*bit, *next);
            *next += 1;
            let source = sources.get(&bit).and_then(|all| all.get(at)).copied();
            match source.filter(|_| !done.contains(&bit)) {
                Some(source) if on_way.contains(&source) => {
                    let bits = way.iter().map(|(bit, _)| *bit);
                    return Some(bits.skip_while(|bit| *bit != source).collect());
                }
                Some(source) => {
                    way.push((source, 0));
                    on_way.insert(source);
                }
                None => {
                    done.insert(bit);
                    on_way.remove(&bit);
                    way.pop();
                }
            }
        }
    }
    None
}
