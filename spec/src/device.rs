//! Devices that a core may be made for: what they hold.
//!
//! A family is a file in `spec/devices`; what its cells look like is the generator's matter.

use std::sync::OnceLock;

use serde::Deserialize;

/// The files, one a family.
const FAMILIES: [&str; 2] = [
    include_str!("../devices/generic.toml"),
    include_str!("../devices/ecp5.toml"),
];

/// Devices with the same cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Family {
    /// Portable Verilog.
    Generic,
    /// Lattice ECP5.
    Ecp5,
}

/// One device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Device {
    /// `<family>-<size>`, or `generic`.
    pub name: String,
    /// Its family.
    pub family: Family,
    /// Look-up tables of four inputs; none for `generic`, whose size is not known.
    pub lut4: Option<u32>,
    /// Multipliers.
    pub multipliers: Option<u32>,
    /// Bits of either operand of a multiplier, sign included.
    pub multiplier_bits: Option<u32>,
    /// Block memories.
    pub block_rams: Option<u32>,
    /// Bits of a block memory.
    pub block_ram_bits: Option<u32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FamilyFile {
    family: Family,
    multiplier_bits: Option<u32>,
    block_ram_bits: Option<u32>,
    device: Vec<Entry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: String,
    lut4: Option<u32>,
    multipliers: Option<u32>,
    block_rams: Option<u32>,
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
        let families = FAMILIES.map(|text| toml::from_str(text).expect("a family's file"));
        families
            .into_iter()
            .flat_map(|family: FamilyFile| {
                family.device.into_iter().map(move |entry| Device {
                    name: entry.name,
                    family: family.family,
                    lut4: entry.lut4,
                    multipliers: entry.multipliers,
                    multiplier_bits: family.multiplier_bits,
                    block_rams: entry.block_rams,
                    block_ram_bits: family.block_ram_bits,
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
