//! Devices that a core may be made for: what they hold.
//!
//! A family is a file in `spec/devices`; what its cells look like is the generator's matter.

use std::collections::BTreeMap;
use std::ops::{Add, AddAssign, Mul};
use std::sync::OnceLock;

use include_dir::{Dir, include_dir};
use serde::{Deserialize, Serialize};

/// The files, one a family.
static FAMILIES: Dir = include_dir!("$CARGO_MANIFEST_DIR/devices");

/// One device.
#[derive(Clone, Debug, PartialEq)]
pub struct Device {
    /// `<family>-<size>`, or `generic`.
    pub name: String,
    /// Devices with the same cells, by the name of their file.
    pub family: String,
    /// What people call the family.
    pub title: String,
    /// How Yosys synthesises for it.
    pub synthesis: Synthesis,
    /// Vendors' tools that scripts are written for.
    pub vendors: Vec<Vendor>,
    /// What vendors' tools call it.
    pub part: Option<String>,
    /// Look-up tables of four inputs, or of as many as the family's have; none for `generic`, whose size is
    /// not known.
    pub lut4: Option<u32>,
    /// Inputs of a look-up table.
    pub lut_inputs: u32,
    /// Flip-flops.
    pub flip_flops: Option<u32>,
    /// Multipliers.
    pub multipliers: Option<u32>,
    /// Multipliers of logic that a design may have where it is not said how many, on a device that has no
    /// other.
    pub logic_multipliers: u32,
    /// Bits of either operand of a multiplier, sign included.
    pub multiplier_bits: Option<u32>,
    /// What synthesis makes of a multiplier, by the bits of its operands: the first that has room for both is
    /// taken.
    pub products: Vec<Product>,
    /// Registers of a multiplier that synthesis uses, of the three that follow each other: operands, product,
    /// output.
    pub multiplier_registers: u32,
    /// Whether a multiplier shows what its inner registers hold.
    pub multiplier_shows_operands: bool,
    /// Whether an accumulator's carry chain clears its sum too, with no tables in front of it.
    pub clears_in_chain: bool,
    /// Whether cells are too few for adders in the place of multipliers.
    pub no_adders: bool,
    /// Bits of a beat of a stream, at least: a wide one makes the latency shorter.
    pub stream_bits: u32,
    /// Whether the narrow multipliers of activations may be made of logic, so that arrays have all
    /// blocks.
    pub activation_in_logic: bool,
    /// Most words of a ROM that goes to logic; deeper ones go to block memories.
    pub logic_rom_words: u32,
    /// Most words of a ROM in logic that is read in one clock; deeper ones take a second, in which one of
    /// several tables is chosen.
    pub logic_rom_words_a_clock: u32,
    /// Whether registers of ROMs in logic start with the bits that all words have. A register that rises once
    /// and for all is a constant to no tool, and synthesis makes one of all those of a core; but one that
    /// starts with a one goes into no block.
    pub roms_start: bool,
    /// Whether each weight of a ROM in logic has a copy of the address for itself, where a bit of it
    /// takes more than a table of four inputs.
    pub address_per_weight: bool,
    /// Clocks that operands and addresses take on their way to a processing element, in copies of its
    /// own: none where the way is short beside a clock.
    pub copy_latency: usize,
    /// Block memories.
    pub block_rams: Option<u32>,
    /// Bits of a block memory.
    pub block_ram_bits: Option<u32>,
    /// Depths of the memories that a ROM is built of, falling powers of two; empty if that is left to
    /// synthesis.
    pub rom_pieces: Vec<u32>,
    /// How open tools place and route on it; none where they can't.
    pub place: Option<Place>,
}

impl Device {
    /// What a look-up table is called.
    pub fn lut_name(&self) -> String {
        format!("LUT{}", self.lut_inputs)
    }

    /// Whether a ROM of so many words goes to logic, not to block memories.
    pub fn rom_in_logic(&self, words: usize) -> bool {
        words <= crate::design::to_usize(self.logic_rom_words)
    }

    /// Whether multipliers are blocks; else they are made of logic.
    pub fn has_multipliers(&self) -> bool {
        self.multipliers.is_some_and(|multipliers| multipliers > 0)
    }

    /// What synthesis makes of a multiplier of operands of so many bits; none if nothing but tables, whose
    /// number is not listed.
    pub fn product(&self, a: u32, b: u32) -> Option<&Product> {
        let fits = |product: &&Product| a <= product.bits[0] && b <= product.bits[1];
        let products = self.products.iter().filter(|_| self.has_multipliers());
        products.into_iter().find(fits)
    }

    /// Whether one block takes operands of so many bits, with its own registers.
    pub fn holds(&self, a: u32, b: u32) -> bool {
        let product = self.product(a, b);
        product.is_some_and(|product| product.multipliers == 1 && product.lut4 == 0)
    }

    /// Multipliers that one of operands of so many bits counts as: the blocks that it takes, and one if it is
    /// made of logic.
    ///
    /// ```
    /// let blocks = |device, bits: [(u32, u32); 4]| {
    ///     let device = hwgen_spec::device::find(device).unwrap();
    ///     bits.map(|(a, b)| device.blocks(a, b))
    /// };
    /// let bits = [(18, 18), (19, 18), (18, 24), (24, 24)];
    /// assert_eq!(blocks("ecp5-85k", bits), [1, 1, 2, 4]);
    /// // A block takes 25 by 18 bits.
    /// assert_eq!(blocks("xc7a35t", bits), [1, 1, 1, 2]);
    /// assert_eq!(blocks("ice40-up5k", bits), [1; 4]);
    /// ```
    pub fn blocks(&self, a: u32, b: u32) -> usize {
        let product = self.product(a, b);
        product.map_or(1, |product| {
            crate::design::to_usize(product.multipliers.max(1))
        })
    }

    /// Multipliers that a design may have where it is not said how many.
    pub fn multiplier_budget(&self) -> u32 {
        let blocks = self.multipliers.filter(|&blocks| blocks > 0);
        blocks.unwrap_or(self.logic_multipliers)
    }

    /// Whether what is inside a multiplier can't be seen, its result alone: that of a block, or of one of
    /// logic for a device without blocks.
    pub fn hides_operands(&self) -> bool {
        self.multipliers.is_some() && !self.multiplier_shows_operands
    }

    /// What a register of a ROM holds before the first edge, that of all its words or of a table of them, a
    /// field of each: the bits that all words of it have, if the ROM of so many words is of logic and there is
    /// a word for each address; else zero.
    ///
    /// ```
    /// let device = hwgen_spec::device::find("ecp5-85k").unwrap();
    /// assert_eq!(device.rom_start(&[0b110, 0b011], 2), 0b010);
    /// assert_eq!(device.rom_start(&[0b110, 0b011, 0b111], 3), 0);
    /// // The last of two tables of 64 words holds 32 of 96.
    /// assert_eq!(device.rom_start(&[-1; 64], 96), -1);
    /// assert_eq!(device.rom_start(&[-1; 32], 96), 0);
    /// // More than 64 words are in a memory there.
    /// let device = hwgen_spec::device::find("ice40-up5k").unwrap();
    /// assert_eq!(device.rom_start(&[-1; 32], 288), 0);
    /// ```
    pub fn rom_start(&self, words: &[i64], rom_words: usize) -> i64 {
        let depth = match words.len() == rom_words {
            true => rom_words.next_power_of_two().max(2),
            false => self.pieces_of_rom(rom_words)[0],
        };
        if !self.roms_start || words.len() != depth || !self.rom_in_logic(rom_words) {
            return 0;
        }
        words.iter().fold(-1, |bits, word| bits & word)
    }

    /// Clocks from an address to its registered word, for a ROM of so many words.
    pub fn rom_latency(&self, words: usize) -> usize {
        let at_once = crate::design::to_usize(self.logic_rom_words_a_clock);
        1 + usize::from(self.rom_in_logic(words) && words > at_once)
    }

    /// Depths of the tables or memories that a ROM of so many words is built of, one behind the other;
    /// one if that is left to synthesis.
    pub fn pieces_of_rom(&self, words: usize) -> Vec<usize> {
        if self.rom_latency(words) > 1 {
            let depth = crate::design::to_usize(self.logic_rom_words_a_clock);
            return vec![depth; words.div_ceil(depth)];
        }
        let depths: Vec<usize> = self
            .rom_pieces
            .iter()
            .map(|depth| crate::design::to_usize(*depth))
            .collect();
        let Some(least) = depths.last().filter(|_| !self.rom_in_logic(words)) else {
            return vec![words];
        };
        let mut pieces = Vec::new();
        let mut left = words;
        while left > 0 {
            let fitting = depths.iter().find(|depth| **depth <= left);
            let depth = *fitting.unwrap_or(least);
            pieces.push(depth);
            left = left.saturating_sub(depth);
        }
        pieces
    }
}

/// What Yosys needs to know of a family.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Synthesis {
    /// Yosys's file of the blocks that are instantiated; where it has none, our models of them serve.
    pub library: Option<String>,
    /// The command.
    pub command: String,
    /// What is to be done after it.
    #[serde(default)]
    pub after: Vec<String>,
    /// Sites that a cell of the netlist takes, by its type. Empty where there is no device.
    #[serde(default)]
    pub cells: BTreeMap<String, Sites>,
    /// Types of cells that take no site: multiplexers beside tables, chains of carries, pads.
    #[serde(default)]
    pub free: Vec<String>,
}

impl Synthesis {
    /// What is read as black boxes, of the models of a bundle or instead of them.
    pub fn black_boxes<'a>(&'a self, models: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
        match &self.library {
            Some(library) => vec![library],
            None => models.collect(),
        }
    }
}

/// A vendor's tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Vendor {
    /// AMD Vivado.
    Vivado,
    /// Intel Quartus Prime.
    Quartus,
    /// Lattice Radiant.
    Radiant,
    /// Gowin EDA.
    Gowin,
}

/// What nextpnr needs to know of a device.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// Which program places and routes.
    pub tool: PlaceTool,
    /// Arguments of nextpnr: the device, its package, the router.
    pub arguments: Vec<String>,
    /// A pin with a way of its own into the clock network.
    pub clock_pin: String,
    /// Pins for the ports of the shell, input and output, where the program wants each to have one.
    #[serde(default)]
    pub other_pins: Vec<String>,
    /// The clock that a placement is made for.
    ///
    /// # Units
    /// MHz
    pub sought_mhz: f64,
    /// What whole cores came to that were placed here: an estimate for others.
    ///
    /// # Units
    /// MHz
    pub core_mhz: f64,
    /// After so many rounds a router that tears up late routes is stopped; none if it never does, and so
    /// comes to an end whatever clock it is asked for.
    pub most_rounds: Option<u32>,
    /// What a multiplier reaches alone: the limit of any core.
    ///
    /// # Units
    /// MHz
    pub multiplier_mhz: f64,
    /// Sites of the multipliers, by nextpnr's names, row by row from one edge of the device to the other;
    /// none if they are left to nextpnr.
    #[serde(skip)]
    pub multiplier_rows: Vec<Vec<String>>,
    /// A group of multipliers, as many times in each row as the device has columns of them.
    #[serde(default)]
    multiplier_group: Vec<GroupSite>,
    /// Names of the sites in nextpnr's report.
    pub sites: SiteNames,
}

/// A program that places and routes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum PlaceTool {
    /// For ECP5; pins in an LPF file.
    #[serde(rename = "nextpnr-ecp5")]
    Ecp5,
    /// For iCE40; pins in a PCF file.
    #[serde(rename = "nextpnr-ice40")]
    Ice40,
    /// For Nexus; pins in a PDC file.
    #[serde(rename = "nextpnr-nexus")]
    Nexus,
    /// For Gowin; pins in a CST file.
    #[serde(rename = "nextpnr-himbaechel-gowin")]
    Gowin,
}

/// A multiplier in a group of them.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct GroupSite {
    /// Columns from that of the group.
    column: u32,
    /// Its name there.
    name: String,
}

impl Place {
    fn of(family: &Self, entry: &Entry) -> Self {
        let row = |y: &u32| {
            let groups = entry.multiplier_columns.iter();
            groups
                .flat_map(|x| {
                    let sites = family.multiplier_group.iter();
                    sites.map(move |site| format!("X{}/Y{y}/{}", x + site.column, site.name))
                })
                .collect()
        };
        let arguments = entry.arguments.iter().chain(&family.arguments);
        let given = |own: &Option<String>, of_family: &String| {
            own.clone().unwrap_or_else(|| of_family.clone())
        };
        Self {
            arguments: arguments.cloned().collect(),
            clock_pin: given(&entry.clock_pin, &family.clock_pin),
            sought_mhz: entry.sought_mhz.unwrap_or(family.sought_mhz),
            core_mhz: entry.core_mhz.unwrap_or(family.core_mhz),
            multiplier_rows: entry.multiplier_rows.iter().map(row).collect(),
            ..family.clone()
        }
    }
}

/// Numbers of sites of each kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Sites {
    /// Look-up tables of four inputs, those of carry chains among them.
    pub lut4: u64,
    /// Flip-flops.
    pub ff: u64,
    /// Multipliers.
    pub multipliers: u64,
    /// Block memories.
    pub block_rams: u64,
}

impl Add for Sites {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            lut4: self.lut4 + other.lut4,
            ff: self.ff + other.ff,
            multipliers: self.multipliers + other.multipliers,
            block_rams: self.block_rams + other.block_rams,
        }
    }
}

impl Mul<u64> for Sites {
    type Output = Self;

    fn mul(self, times: u64) -> Self {
        Self {
            lut4: self.lut4 * times,
            ff: self.ff * times,
            multipliers: self.multipliers * times,
            block_rams: self.block_rams * times,
        }
    }
}

impl AddAssign for Sites {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

/// What synthesis makes of a multiplier.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Product {
    /// Most bits of the first operand, word or distance, and of the second, weight or slope.
    pub bits: [u32; 2],
    /// Blocks; none if it goes to tables.
    pub multipliers: u32,
    /// Tables beside them, about.
    #[serde(default)]
    pub lut4: u64,
}

/// What nextpnr calls the kinds of sites.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SiteNames {
    /// Look-up tables; with a plus between them the kinds of cells that take one each, of as many as there are
    /// of the first.
    pub lut4: String,
    /// Flip-flops; none if each table has one beside it that is not counted apart.
    pub ff: Option<String>,
    /// Multipliers.
    pub multipliers: String,
    /// Block memories.
    pub block_rams: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FamilyFile {
    title: String,
    synthesis: Synthesis,
    vendors: Vec<Vendor>,
    multiplier_bits: Option<u32>,
    #[serde(default)]
    products: Vec<Product>,
    #[serde(default)]
    multiplier_registers: u32,
    #[serde(default)]
    multiplier_shows_operands: bool,
    block_ram_bits: Option<u32>,
    #[serde(default = "four")]
    lut_inputs: u32,
    #[serde(default = "one")]
    flip_flops_per_lut: u32,
    #[serde(default)]
    no_adders: bool,
    #[serde(default)]
    clears_in_chain: bool,
    #[serde(default)]
    stream_bits: u32,
    #[serde(default)]
    activation_in_logic: bool,
    #[serde(default)]
    rom_pieces: Vec<u32>,
    logic_rom_words: u32,
    logic_rom_words_a_clock: Option<u32>,
    #[serde(default)]
    roms_start: bool,
    #[serde(default)]
    address_per_weight: bool,
    copy_latency: usize,
    place: Option<Place>,
    device: Vec<Entry>,
}

fn four() -> u32 {
    4
}

fn one() -> u32 {
    1
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: String,
    part: Option<String>,
    lut4: Option<u32>,
    /// Where it is not so many a table.
    flip_flops: Option<u32>,
    multipliers: Option<u32>,
    #[serde(default)]
    logic_multipliers: u32,
    block_rams: Option<u32>,
    #[serde(default)]
    arguments: Vec<String>,
    clock_pin: Option<String>,
    sought_mhz: Option<f64>,
    core_mhz: Option<f64>,
    /// Where groups of multipliers stand.
    #[serde(default)]
    multiplier_columns: Vec<u32>,
    #[serde(default)]
    multiplier_rows: Vec<u32>,
}

/// No device of a name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("device: one of {} expected, `{found}` found", names().join(", "))]
pub struct UnknownDevice {
    /// The name.
    pub found: String,
}

impl UnknownDevice {
    /// One line that says how to mend it.
    pub fn help(&self) -> String {
        let near = |name: &&str| strsim::jaro_winkler(name, &self.found);
        let nearest = names()
            .into_iter()
            .max_by(|a, b| near(a).total_cmp(&near(b)));
        let nearest = nearest.filter(|name| near(name) > 0.7 && *name != GENERIC);
        match nearest {
            Some(nearest) => format!("did you mean {nearest}? Portable Verilog is `{GENERIC}`"),
            None => format!("leave --device out, or say `{GENERIC}`, for portable Verilog"),
        }
    }
}

/// The device of portable Verilog.
pub const GENERIC: &str = "generic";

/// All devices.
pub fn all() -> &'static [Device] {
    static DEVICES: OnceLock<Vec<Device>> = OnceLock::new();
    DEVICES.get_or_init(|| {
        let mut files: Vec<_> = FAMILIES.files().collect();
        files.sort_by_key(|file| file.path());
        files
            .into_iter()
            .flat_map(|file| {
                let (name, text) = (file.path().file_stem(), file.contents_utf8());
                let name = name.and_then(|name| name.to_str()).expect("a plain name");
                let family: FamilyFile = toml::from_str(text.expect("text"))
                    .unwrap_or_else(|error| panic!("{name}: {error}"));
                family.device.into_iter().map(move |entry| Device {
                    place: family.place.as_ref().map(|place| Place::of(place, &entry)),
                    name: entry.name,
                    family: name.to_owned(),
                    title: family.title.clone(),
                    synthesis: family.synthesis.clone(),
                    vendors: family.vendors.clone(),
                    part: entry.part,
                    lut4: entry.lut4,
                    lut_inputs: family.lut_inputs,
                    flip_flops: entry
                        .flip_flops
                        .or(entry.lut4.map(|lut4| lut4 * family.flip_flops_per_lut)),
                    multipliers: entry.multipliers,
                    logic_multipliers: entry.logic_multipliers,
                    multiplier_bits: family.multiplier_bits,
                    products: family.products.clone(),
                    multiplier_registers: family.multiplier_registers,
                    multiplier_shows_operands: family.multiplier_shows_operands,
                    activation_in_logic: family.activation_in_logic,
                    clears_in_chain: family.clears_in_chain,
                    no_adders: family.no_adders,
                    stream_bits: family.stream_bits,
                    block_rams: entry.block_rams,
                    block_ram_bits: family.block_ram_bits,
                    rom_pieces: family.rom_pieces.clone(),
                    logic_rom_words: family.logic_rom_words,
                    logic_rom_words_a_clock: family
                        .logic_rom_words_a_clock
                        .unwrap_or(family.logic_rom_words),
                    roms_start: family.roms_start,
                    address_per_weight: family.address_per_weight,
                    copy_latency: family.copy_latency,
                })
            })
            .collect()
    })
}

/// The device of a name.
///
/// # Errors
/// If there is none.
pub fn find(name: &str) -> Result<&'static Device, UnknownDevice> {
    let device = all().iter().find(|device| device.name == name);
    device.ok_or_else(|| UnknownDevice { found: name.into() })
}

fn names() -> Vec<&'static str> {
    all().iter().map(|device| device.name.as_str()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_is_read_and_every_name_is_its_own() {
        let names = names();
        assert!(names.contains(&GENERIC) && names.contains(&"ecp5-85k"));
        for name in &names {
            assert_eq!(names.iter().filter(|other| *other == name).count(), 1);
            assert_eq!(find(name).unwrap().name, *name);
        }
    }

    #[test]
    fn multipliers_have_as_many_sites_as_are_counted() {
        for device in all() {
            let Some(place) = &device.place else { continue };
            let sites: Vec<&String> = place.multiplier_rows.iter().flatten().collect();
            if sites.is_empty() {
                // Left to nextpnr.
                continue;
            }
            assert_eq!(Some(sites.len()), device.multipliers.map(|n| n as usize));
            assert!(
                sites
                    .iter()
                    .collect::<std::collections::BTreeSet<_>>()
                    .len()
                    == sites.len()
            );
        }
        let place = find("ecp5-85k").unwrap().place.as_ref().unwrap();
        assert_eq!(place.multiplier_rows[2][51], "X119/Y58/MULT18_5");
    }

    #[test]
    fn a_rom_is_built_of_tables_that_hold_it_and_no_more_than_need_be() {
        let ice40 = find("ice40-up5k").unwrap();
        assert_eq!(ice40.pieces_of_rom(64), [64]);
        assert_eq!(ice40.pieces_of_rom(256), [256]);
        assert_eq!(ice40.pieces_of_rom(600), [512, 256]);
        assert_eq!(ice40.pieces_of_rom(2560), [2048, 512]);
        assert_eq!(ice40.pieces_of_rom(5000), [2048, 2048, 512, 256, 256]);
        assert_eq!(ice40.rom_latency(2560), 1);
        let ecp5 = find("ecp5-25k").unwrap();
        assert_eq!((ecp5.rom_latency(64), ecp5.rom_latency(65)), (1, 2));
        assert_eq!(ecp5.pieces_of_rom(224), [64; 4]);
        assert_eq!(
            (ecp5.rom_latency(513), ecp5.pieces_of_rom(513)),
            (1, vec![513])
        );
    }

    #[test]
    fn a_misspelt_name_is_answered_with_its_neighbour() {
        let error = find("ecp5-85").unwrap_err();
        assert!(error.to_string().contains("ecp5-25k, ecp5-45k, ecp5-85k"));
        assert!(
            error.help().contains("did you mean ecp5-85k?"),
            "{}",
            error.help()
        );
        assert!(
            find("flux")
                .unwrap_err()
                .help()
                .contains("leave --device out")
        );
    }
}
