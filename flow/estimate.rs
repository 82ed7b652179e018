//! What a core will take of a device, from the design alone.
//!
//! Flip-flops are the registers that the cycle model has, but for those inside the device's blocks.
//! Look-up tables are counted from what stands in front of the registers: an adder takes one a bit, a
//! ROM in logic one for as many words as it holds, of each bit that no other bit repeats. What the rules
//! leave out is stated beside the measured numbers in docs/measurements.md.

use std::collections::{BTreeMap, HashSet};

use hwgen_sim::model::Model;
use hwgen_spec::design::{Design, Feed, Layer, extra_shift_width};
use hwgen_spec::device::{Device, Sites};

use crate::synth::netlist::{Part, place};

/// Words of a small memory.
const MEMORY_WORDS: usize = 16;

/// Look-up tables that a memory of sixteen words of four bits takes the place of.
const LUTS_OF_MEMORY: u64 = 6;

/// Sites by part, named as in a netlist, but for the shell.
pub fn parts(design: &Design, device: &Device) -> Vec<Part> {
    let mut parts: BTreeMap<(String, String), Sites> = BTreeMap::new();
    let mut add = |path: &str, sites: Sites| {
        *parts.entry(place(&format!("u_core.{path}"))).or_default() += sites;
    };
    let wide = wide_multipliers(design, device);
    let in_block = |path: &str| {
        let (layer, piece) = place(&format!("u_core.{path}"));
        !wide.contains(&(layer.as_str(), piece == "act"))
    };
    for register in Model::new(design).registers() {
        let name = register.path.rsplit('.').next().unwrap_or_default();
        let bits: u64 = register.lanes.iter().map(|bits| u64::from(*bits)).sum();
        let bits = bits.saturating_sub(constant_bits(design, &register.path, register.lanes.len()));
        let held = device.multiplier_registers > if name == "r_q" { 2 } else { 0 };
        if register.path.contains("u_mul.") && held && in_block(&register.path) {
            continue;
        }
        // ROMs are counted by their contents, queues by their words; ports are none.
        if name == "data_q" || name == "word" || register.path.contains("_axis_") {
            continue;
        }
        // Control bits are masked by the reset.
        if name == "pipe_q" {
            add(&register.path, luts(bits));
        }
        let sites = Sites {
            ff: bits,
            ..Sites::default()
        };
        add(&register.path, sites);
    }
    // Bounds, slices and the turning of words into beats.
    for ((name, _), sites) in &mut parts {
        if ["ingress", "egress", "core"].contains(&name.as_str()) {
            sites.lut4 += sites.ff * 8 / 10;
        }
    }
    let mut add = |path: &str, sites: Sites| {
        *parts.entry(place(&format!("u_core.{path}"))).or_default() += sites;
    };
    for network in &design.perceptron().networks {
        let last = &network.last().quant;
        let frame = u64::from(last.output.width()) * last.outputs() as u64 + 1;
        add(
            &format!("u_mlp.u_{}_answers.x", network.name),
            queue(frame, design.schedule().fifo_depth),
        );
    }
    add("u_mlp.u_frames.x", queue(2, design.schedule().fifo_depth));
    for layer in design.perceptron().layers() {
        let name = &layer.quant.name;
        for (piece, sites) in pieces(layer, device) {
            add(&format!("u_mlp.u_{name}.{piece}.x"), sites);
        }
    }
    parts
        .into_iter()
        .map(|((name, piece), sites)| Part { name, piece, sites })
        .collect()
}

/// Bits of a register of sums that synthesis drops: no weight has a digit there, or nothing of them
/// reaches a word.
fn constant_bits(design: &Design, path: &str, lanes: usize) -> u64 {
    let Some((layer, register)) = path
        .strip_prefix("u_mlp.u_")
        .and_then(|path| path.split_once('.'))
    else {
        return 0;
    };
    let mut layers = design.perceptron().layers();
    let Some(layer) = layers.find(|l| l.quant.name == layer) else {
        return 0;
    };
    let dropped = dropped_bits(layer);
    let bits = match register.rsplit('.').next().unwrap_or_default() {
        "biased_q" | "shifted_q" => dropped,
        "sum_q" if register.starts_with("u_requant.") => sum_bits(layer, dropped),
        "word_q" if register.starts_with("u_drain.") => sum_bits(layer, dropped),
        _ => 0,
    };
    u64::from(bits) * lanes as u64
}

/// Lowest bits of a biased sum that come to nothing.
fn dropped_bits(layer: &Layer) -> u32 {
    let zeros = layer.adders().map_or(0, |_| layer.quant.trailing_zeros());
    let most = layer.quant.biased_width - layer.quant.pre.width();
    layer.quant.dropped_bits().max(zeros).min(most)
}

/// The same of a sum, which is moved up before the bias is added.
fn sum_bits(layer: &Layer, dropped: u32) -> u32 {
    dropped.saturating_sub(layer.quant.product_shift)
}

/// The layers whose multipliers no block holds: those of the array, and of the activation (true).
fn wide_multipliers<'a>(design: &'a Design, device: &Device) -> HashSet<(&'a str, bool)> {
    let mut wide = HashSet::new();
    for layer in design.perceptron().layers() {
        let quant = &layer.quant;
        let (x, w) = (quant.input.width(), quant.weight_format.width());
        let (distance, slope) = layer.activation_operands();
        for (a, b, activation) in [(x, w, false), (distance, slope, true)] {
            let in_logic = activation && layer.activation_in_logic;
            if in_logic || !device.holds(a, b) {
                wide.insert((quant.name.as_str(), activation));
            }
        }
    }
    wide
}

/// Tables for each two bits that meet in a multiplier which synthesis makes of logic.
const LUTS_OF_PRODUCT: u64 = 3;

/// A multiplier of so many bits: blocks and tables beside them, or nothing but tables.
fn multiplier(device: &Device, a: u32, b: u32) -> Sites {
    if !device.has_multipliers() {
        return own_multiplier(a, b);
    }
    match device.product(a, b) {
        Some(product) => Sites {
            lut4: product.lut4,
            multipliers: u64::from(product.multipliers),
            ..Sites::default()
        },
        None => luts(LUTS_OF_PRODUCT * u64::from(a * b)),
    }
}

/// `hwg_mul` of a device without blocks: words of two bits of the second operand, of four, of all.
fn own_multiplier(a: u32, b: u32) -> Sites {
    let pairs = b.div_ceil(2);
    let quads = pairs.div_ceil(2);
    let (words, wide) = (pairs * (a + 2), quads * (a + 4));
    Sites {
        lut4: u64::from(2 * words + wide + (quads - 1) * (a + 6)),
        ff: u64::from(words + wide),
        ..Sites::default()
    }
}

/// `hwg_mul_logic`: for each two bits of the second operand a sum of two words that these let through,
/// then sums of these.
fn logic_multiplier(a: u32, b: u32) -> Sites {
    let pairs = b.div_ceil(2);
    let quads = pairs.div_ceil(2);
    let even = |bits: u32| bits.next_multiple_of(2);
    let products = pairs * (2 * a + even(a + 2));
    let sums = (pairs - quads) * even(a + 4) + (quads - 1) * even(a + 4);
    luts(u64::from(products + sums))
}

fn luts(lut4: u64) -> Sites {
    Sites {
        lut4,
        ..Sites::default()
    }
}

/// A queue in memories of sixteen words of four bits, with the choice among these.
fn queue(bits: u64, depth: usize) -> Sites {
    let rows = depth.div_ceil(MEMORY_WORDS) as u64;
    luts(rows * bits.div_ceil(4) * LUTS_OF_MEMORY + bits * rows / 2 + 16)
}

/// What a layer takes beside its flip-flops, and those of its ROMs.
fn pieces(layer: &Layer, device: &Device) -> Vec<(&'static str, Sites)> {
    let quant = &layer.quant;
    let (pe, lanes) = (layer.fold.pe as u64, layer.lanes as u64);
    let bits = |bits: u32| u64::from(bits);
    let sum = bits(quant.sum_width);
    let (x, w) = (bits(quant.input.width()), bits(quant.weight_format.width()));

    // Chains of carries take two bits at a time.
    let adder = |bits: u64| bits.next_multiple_of(2);
    let mut words = layer.fold.simd as u64;
    let mut array = 0;
    for level in 1..=layer.tree_levels() as u64 {
        array += words / 2 * adder((x + w + level).min(sum));
        words = words.div_ceil(2);
    }
    if layer.accumulates() {
        // The first word of a group clears what was there, in tables of its own where the chain's don't.
        let clears = if device.clears_in_chain { 0 } else { sum };
        array += adder(sum) + clears;
    }
    let own = multiplier(device, quant.input.width(), quant.weight_format.width());
    let array = match layer.adders() {
        Some(sums) => luts(sums.adders.iter().map(|a| adder(bits(a.width))).sum()),
        None => luts(pe * array) + own * layer.multipliers() as u64,
    };

    let elements = if layer.adders().is_some() {
        0
    } else {
        layer.fold.pe
    };
    let weights = (0..elements)
        .map(|p| rom(device, &codes(layer, p), quant.weight_format.width()))
        .fold(Sites::default(), |sum, rom| sum + rom);
    let biased = quant.biased_width;
    let bias = (0..layer.array_beats())
        .map(|beat| {
            let entries = layer.bias_word(beat).into_iter();
            entries
                .flat_map(|(bias, shift)| [bias, i64::from(shift)])
                .collect()
        })
        .collect::<Vec<Vec<i64>>>();
    let bias = rom(device, &bias, biased);

    let zeros = dropped_bits(layer);
    // Sum of bias, shift of the neuron, comparison and saturation.
    let shift = bits(extra_shift_width(quant)) * bits(biased - zeros) * 9 / 10;
    let requant = lanes * (adder(bits(biased - zeros)) + shift + 2 * bits(quant.pre.width()));
    let replay = match layer.feed {
        Feed::Replay if layer.accumulates() => x * quant.inputs() as u64,
        _ => 0,
    };
    let drain = (pe - lanes) * sum.saturating_sub(bits(sum_bits(layer, zeros)));
    let mut pieces = vec![
        ("u_pe0", array),
        ("u_w0", weights),
        ("u_bias", bias),
        ("u_requant", luts(requant)),
        ("u_replay", luts(replay + 16)),
        ("u_drain", luts(drain)),
    ];
    if let Some(table) = &quant.table {
        let lines: Vec<Vec<i64>> = table.lines().map(|(a, b)| vec![a, b]).collect();
        let mut segments = rom(device, &lines, table.offset_width());
        let sum = adder(bits(table.fraction() + table.slope_bits()));
        segments.lut4 += sum + 2 * bits(quant.output.width());
        let (distance, slope) = layer.activation_operands();
        segments += if layer.activation_in_logic {
            logic_multiplier(slope - 1, distance - 1)
        } else {
            multiplier(device, distance, slope)
        };
        pieces.push(("g_act[0]", segments * lanes));
    }
    pieces
}

fn codes(layer: &Layer, p: usize) -> Vec<Vec<i64>> {
    (0..layer.folds())
        .map(|fold| layer.weight_word(p, fold))
        .collect()
}

/// A ROM whose words have several fields of at most so many bits.
///
/// Bits that are zero in every word, or the same as another bit, take nothing.
fn rom(device: &Device, words: &[Vec<i64>], width: u32) -> Sites {
    let mut columns: HashSet<Vec<bool>> = HashSet::new();
    for field in 0..words[0].len() {
        for bit in 0..width {
            let column: Vec<bool> = words
                .iter()
                .map(|word| word[field] >> bit & 1 == 1)
                .collect();
            if column.contains(&true) {
                columns.insert(column);
            }
        }
    }
    let kept = columns.len();
    if !device.rom_in_logic(words.len()) {
        let block = device.block_ram_bits.unwrap_or(u32::MAX) as usize;
        let pieces = device.pieces_of_rom(words.len());
        let wanted = |depth: &usize| (kept * depth.next_power_of_two()).div_ceil(block) as u64;
        return Sites {
            block_rams: pieces.iter().map(wanted).sum(),
            // Of several memories one is chosen.
            lut4: (kept * (pieces.len() - 1)) as u64,
            ..Sites::default()
        };
    }
    // A table for so many words of a bit, where they are not all equal; bits may have one together.
    let mut tables: HashSet<(usize, &[bool])> = HashSet::new();
    for column in &columns {
        for (place, part) in column.chunks(1 << device.lut_inputs).enumerate() {
            if part.contains(&true) && part.contains(&false) {
                tables.insert((place, part));
            }
        }
    }
    // Synthesis builds a whole power of two of them, each address bit choosing between halves.
    let parts = words.len().div_ceil(1 << device.lut_inputs);
    let built = match device.pieces_of_rom(words.len()).len() {
        1 => tables.len() * parts.next_power_of_two() / parts,
        _ => tables.len(),
    };
    // Of several tables one is chosen a clock later.
    let chosen = kept * (device.pieces_of_rom(words.len()).len() - 1) * 2 / 3;
    Sites {
        lut4: (built + chosen) as u64,
        ff: kept as u64,
        ..Sites::default()
    }
}
