//! ROM leaf modules with literal contents: weights, biases, segments.

use askama::Template;
use hwgen_spec::activation::OddTable;
use hwgen_spec::design::{Layer, bias_rom_width, extra_shift_width};
use hwgen_spec::device::Device;
use hwgen_spec::format::to_bits;

use crate::bundle::File;
use crate::text::finish;
use crate::{Header, address_width, bits, plural, range};

#[derive(Template)]
#[template(path = "rom.v", syntax = "verilog")]
struct Rom<'a> {
    module: &'a str,
    purpose: String,
    notes: Vec<String>,
    provenance: String,
    latency: &'static str,
    /// Whether it has a copy of the address of its own.
    own_address: bool,
    /// Copies of the address, and how they are filled.
    copies: usize,
    copies_range: String,
    copies_width: usize,
    copied: String,
    address_range: String,
    address_copy_range: String,
    address_width: usize,
    data_range: String,
    /// What the word's register starts with.
    start: String,
    /// Whether it, or that of a table, has a one.
    starts_with_ones: bool,
    rom_style: &'static str,
    rom_note: String,
    /// Tables that it is built of, if there are several.
    tables: Option<Tables>,
    blocks: Vec<Block>,
}

/// Several tables of which a ROM is built.
struct Tables {
    /// Registers of their words, each with what it starts with.
    registers: Vec<(String, String)>,
    /// Whether the word that is chosen is registered.
    registered: bool,
    /// Highest bits of the address, once for each copy of it.
    above: String,
    above_range: String,
    above_width: usize,
    choices: Vec<Choice>,
}

/// How a part of the word is chosen by a copy of the address.
struct Choice {
    data: String,
    word: String,
}

/// A part of the word that is read by an address of its own.
struct Block {
    address: String,
    data: String,
    width: usize,
    rows: Vec<Row>,
}

struct Row {
    address: String,
    word: String,
    comment: String,
}

/// Fields of a ROM word from the lowest: code and bits.
type Fields = Vec<(i64, u32)>;

/// A word, and what it is: a comment for each copy of the address.
type Word = (Fields, Vec<String>);

/// The weights of one processing element.
pub(crate) fn weights(module: &str, layer: &Layer, pe: usize, header: &Header) -> File {
    let width = layer.quant.weight_format.width();
    let copies = layer.address_copies(header.device);
    let rows = (0..layer.folds())
        .map(|fold| {
            let fields = layer
                .weight_word(pe, fold)
                .into_iter()
                .map(|w| (w, width))
                .collect();
            let simd = layer.fold.simd / copies;
            let comment = |copy: usize| {
                let own = copy * simd..(copy + 1) * simd;
                let inputs: Vec<usize> = own.filter_map(|s| layer.input(s, fold)).collect();
                match (layer.neuron(pe, fold), inputs.first(), inputs.last()) {
                    (Some(neuron), Some(first), Some(last)) if first != last => {
                        format!("neuron {neuron}, inputs {last}..{first}")
                    }
                    (Some(neuron), Some(first), _) => format!("neuron {neuron}, input {first}"),
                    _ => "padding".to_owned(),
                }
            };
            (fields, (0..copies).map(comment).collect())
        })
        .collect();
    let purpose = format!(
        "weights of layer {}, processing element {pe}",
        layer.quant.name
    );
    let notes = vec![
        format!(
            "Function:  word a holds the weights of clock a of a frame: {}.",
            inputs_of_word(layer)
        ),
        format!(
            "Format:    {} words of {width} bits, {}{}.",
            layer.fold.simd,
            layer.quant.weight_format,
            if layer.quant.max_extra_shift() > 0 {
                ", finer by the neuron's own shift"
            } else {
                ""
            }
        ),
    ];
    let given = match layer.copy_latency {
        0 => Address::Used(1),
        _ => Address::Copied(copies),
    };
    rom(module, purpose, notes, rows, (given, true), header)
}

/// Which inputs the weights of word `a` belong to.
fn inputs_of_word(layer: &Layer) -> String {
    match (layer.fold.simd, layer.synapse_folds()) {
        (1, 1) => "of input 0".to_owned(),
        (simd, 1) => format!("of inputs 0..{}, input 0 lowest", simd - 1),
        (1, folds) => format!("of input a % {folds}"),
        (simd, folds) => {
            format!("of {simd} inputs from {simd} * (a % {folds}) on, the first lowest")
        }
    }
}

/// Biases and shifts of a layer.
pub(crate) fn biases(module: &str, layer: &Layer, header: &Header) -> File {
    let quant = &layer.quant;
    let extra = extra_shift_width(quant);
    let copies = layer.bias_address_copies(header.device);
    let rows = (0..layer.array_beats())
        .map(|beat| {
            let word = layer.bias_word(beat);
            let mut fields = Fields::new();
            for (bias, shift) in word {
                fields.push((bias, quant.biased_width));
                if extra > 0 {
                    fields.push((i64::from(shift), extra));
                }
            }
            let lanes = layer.lanes / copies;
            let comment = |copy: usize| {
                let first = beat * layer.lanes + copy * lanes;
                let own = first..(first + lanes).min(quant.outputs());
                match own.len() {
                    0 => "padding".to_owned(),
                    1 => format!("neuron {first}"),
                    _ => format!("neurons {}..{first}", own.end - 1),
                }
            };
            (fields, (0..copies).map(comment).collect())
        })
        .collect();
    let entry = bias_rom_width(quant);
    let shape = if extra > 0 {
        format!(
            "{{shift of {extra} bits, bias of {} bits}}",
            quant.biased_width
        )
    } else {
        format!("a bias of {} bits", quant.biased_width)
    };
    let notes = vec![
        "Function:  word a holds the entries of output beat a, the lowest neuron lowest."
            .to_owned(),
        format!(
            "Format:    {} entr{} of {entry} bits: {shape};",
            layer.lanes,
            if layer.lanes == 1 { "y" } else { "ies" }
        ),
        "           the bias contains half a step of the word that it leads to.".to_owned(),
    ];
    rom(
        module,
        format!("biases of layer {}", quant.name),
        notes,
        rows,
        (Address::Used(copies), false),
        header,
    )
}

/// The segments of an activation table.
pub(crate) fn segments(module: &str, table: &OddTable, header: &Header) -> File {
    let (offset, slope) = (table.offset_width(), table.slope_width());
    let rows: Vec<Word> = table
        .lines()
        .enumerate()
        .map(|(k, (a, b))| {
            let start = f64::from(u32::try_from(k).expect("a small table"))
                * f64::from(1u32 << table.range_log2())
                / f64::from(u32::try_from(table.segments()).expect("a small table"));
            (vec![(b, slope), (a, offset)], vec![format!("from {start}")])
        })
        .collect();
    let notes = vec![
        format!(
            "Function:  word k is the line over segment k of {} on [0, {}), in tanh's argument.",
            table.segments(),
            1u32 << table.range_log2()
        ),
        format!(
            "Format:    {{offset of {offset} bits, {} of them fraction, with half an output step",
            table.fraction() + 2
        ),
        format!(
            "           (segment 0: so that zero leads to zero); slope of {slope} bits, {} of them fraction}}.",
            table.slope_bits()
        ),
        format!(
            "Error:     at most {:.3} output steps of 2^-{} up to the clip at {}, minimax per segment;",
            table.range_error_lsb(),
            table.fraction(),
            1u32 << table.range_log2()
        ),
        format!(
            "           at most {:.3} for arguments of any magnitude.",
            table.max_error_lsb()
        ),
    ];
    // Memories of which one is chosen in the same clock are for weights alone.
    let may_split = header.device.rom_latency(rows.len()) > 1;
    rom(
        module,
        "piecewise-linear tanh for magnitudes".to_owned(),
        notes,
        rows,
        (Address::Used(1), may_split),
        header,
    )
}

/// What a ROM does with the address that it is given.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Address {
    /// It is read in the same clock; so many are given, each for as many fields of the word.
    Used(usize),
    /// Many ROMs are given it: each takes so many copies first, each for as many fields of the word.
    Copied(usize),
}

fn rom(
    module: &str,
    purpose: String,
    notes: Vec<String>,
    words: Vec<Word>,
    (given, may_split): (Address, bool),
    header: &Header,
) -> File {
    let width: usize = words[0].0.iter().map(|(_, w)| bits(*w)).sum();
    let address = address_width(words.len());
    let digits = words.len().saturating_sub(1).to_string().len();
    let own_address = matches!(given, Address::Copied(_));
    let read = if own_address {
        "address_q2"
    } else {
        "address_i"
    };
    let copies = match given {
        Address::Used(copies) | Address::Copied(copies) => copies,
    };
    let fields = words[0].0.len() / copies;
    let mut low = 0;
    let blocks = (0..copies)
        .map(|copy| {
            let own = copy * fields..(copy + 1) * fields;
            let part: usize = words[0].0[own.clone()].iter().map(|(_, w)| bits(*w)).sum();
            let row = |(a, (fields, comments)): (usize, &Word)| Row {
                address: format!("{address}'d{a:<digits$}"),
                word: literal(&fields[own.clone()], part),
                comment: comments[copy].clone(),
            };
            let block = Block {
                address: match copies {
                    1 => read.to_owned(),
                    _ => format!("{read}[{} +: {address}]", copy * address),
                },
                data: if copies == 1 {
                    "data_q".to_owned()
                } else {
                    format!("data_q[{low} +: {part}]")
                },
                width: part,
                rows: words.iter().enumerate().map(row).collect(),
            };
            low += part;
            block
        })
        .collect();
    let start = |own: &[Word]| start(own, words.len(), width, header.device);
    let depths = header.device.pieces_of_rom(words.len());
    let registered = header.device.rom_latency(words.len()) > 1;
    let (tables, blocks) = if depths.len() > 1 && may_split {
        let (mut tables, blocks) = in_tables(&depths, registered, blocks, read, address);
        let mut rest = &words[..];
        for ((_, register), depth) in tables.registers.iter_mut().zip(&depths) {
            let (own, behind) = rest.split_at(rest.len().min(*depth));
            (*register, rest) = (start(own), behind);
        }
        (Some(tables), blocks)
    } else {
        (None, blocks)
    };
    let whole = start(&words);
    let zero = format!("{width}'h0");
    let mut of_tables = tables.iter().flat_map(|tables| &tables.registers);
    let starts_with_ones = whole != zero || of_tables.any(|(_, own)| *own != zero);
    let most = bits(header.device.logic_rom_words);
    let (rom_style, rom_note) = if header.device.rom_in_logic(words.len()) {
        ("logic", format!("up to {most} go to logic"))
    } else {
        ("block", format!("more than {most} go to block RAM"))
    };
    let text = Rom {
        module,
        purpose,
        notes,
        provenance: header.provenance(),
        own_address,
        copies,
        copies_range: range(copies * address),
        copies_width: copies * address,
        copied: if copies == 1 {
            "address_q".to_owned()
        } else {
            format!("{{{copies}{{address_q}}}}")
        },
        address_range: range(if own_address { 1 } else { copies } * address),
        address_copy_range: range(address),
        address_width: address,
        data_range: range(width),
        start: whole,
        starts_with_ones,
        rom_style,
        rom_note: format!(
            "{} word{}: {rom_note} (hwgen: docs/interface.md).",
            words.len(),
            plural(words.len())
        ),
        latency: match (own_address, tables.as_ref().is_some_and(|t| t.registered)) {
            (false, false) => "1 clock, the word is registered",
            (false, true) => "2 clocks: words of tables are registered, and one of them",
            (true, false) => "3 clocks: the address is registered twice, the word once",
            (true, true) => {
                "4 clocks: the address is registered twice, words of tables, and one of them"
            }
        },
        tables,
        blocks,
    };
    header.rtl(module, finish(text.render()))
}

/// The rows of a ROM, dealt to tables of falling depths, which are powers of two: the lowest bits of
/// the address are one of a table, those above say which.
fn in_tables(
    depths: &[usize],
    registered: bool,
    whole: Vec<Block>,
    read: &str,
    address: usize,
) -> (Tables, Vec<Block>) {
    let least = address_width(*depths.last().expect("there are tables"));
    let above = address - least;
    let copies = whole.len();
    // Bits of one of the copies of the address.
    let of_address = |copy: usize, low: usize, width: usize| {
        format!("{read}[{} +: {width}]", copy * address + low)
    };
    let registers = (0..depths.len()).map(|n| (format!("table{n}_q"), String::new()));
    let registers: Vec<(String, String)> = registers.collect();
    let (mut blocks, mut choices) = (Vec::new(), Vec::new());
    let mut low = 0;
    for (copy, block) in whole.into_iter().enumerate() {
        let slice = if copies == 1 {
            String::new()
        } else {
            format!("[{low} +: {}]", block.width)
        };
        let high = format!("above_q[{} +: {above}]", copy * above);
        let mut rows = block.rows.into_iter();
        let (mut first, mut word) = (0, String::new());
        for (depth, (register, _)) in depths.iter().zip(&registers) {
            let own = address_width(*depth);
            let numbered = |(at, row): (usize, Row)| Row {
                address: format!("{own}'d{at}"),
                ..row
            };
            blocks.push(Block {
                address: of_address(copy, 0, own),
                data: format!("{register}{slice}"),
                width: block.width,
                rows: rows
                    .by_ref()
                    .take(*depth)
                    .enumerate()
                    .map(numbered)
                    .collect(),
            });
            first += depth;
            word.push_str(&if rows.len() == 0 {
                format!("{register}{slice}")
            } else {
                format!(
                    "{high} < {above}'d{} ? {register}{slice} :\n      ",
                    first >> least
                )
            });
        }
        choices.push(Choice {
            data: format!("data_q{slice}"),
            word,
        });
        low += block.width;
    }
    let fields: Vec<String> = (0..copies)
        .rev()
        .map(|copy| of_address(copy, least, above))
        .collect();
    let tables = Tables {
        registers,
        registered,
        above: match &fields[..] {
            [field] => field.clone(),
            fields => format!("{{\n    {}}}", fields.join(",\n    ")),
        },
        above_range: range(copies * above),
        above_width: copies * above,
        choices,
    };
    (tables, blocks)
}

/// What a register of words starts with, of the ROM or of a table of it.
fn start(words: &[Word], rom_words: usize, width: usize, device: &Device) -> String {
    let field = |field: usize| {
        let codes: Vec<i64> = words.iter().map(|(fields, _)| fields[field].0).collect();
        (device.rom_start(&codes, rom_words), words[0].0[field].1)
    };
    let fields: Fields = (0..words[0].0.len()).map(field).collect();
    match fields.iter().all(|(code, _)| *code == 0) {
        true => format!("{width}'h0"),
        false => literal(&fields, width),
    }
}

/// A sized hexadecimal literal of the fields, the first lowest.
pub(crate) fn literal(fields: &[(i64, u32)], width: usize) -> String {
    let mut nibbles = vec![0u8; width.div_ceil(4)];
    let mut position = 0;
    for (code, field) in fields {
        let word = to_bits(*code, *field);
        for bit in 0..bits(*field) {
            if word >> bit & 1 == 1 {
                nibbles[(position + bit) / 4] |= 1 << ((position + bit) % 4);
            }
        }
        position += bits(*field);
    }
    let digits: String = nibbles.iter().rev().map(|n| format!("{n:x}")).collect();
    format!("{width}'h{digits}")
}
