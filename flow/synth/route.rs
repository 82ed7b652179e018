//! One placement and its routes, from the report that nextpnr wrote.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use hwgen_spec::device::{Place, Sites};
use serde::{Deserialize, Serialize};

use super::netlist::place;
use super::{SynthError, io};

/// A placement that was routed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Route {
    /// Seed of the placement.
    pub seed: u64,
    /// The clock that the router strove for.
    pub sought_mhz: f64,
    /// The fastest clock that every path between registers allows.
    pub fmax_mhz: f64,
    /// What it takes of the device.
    pub cells: Sites,
    /// What the device has.
    pub available: Sites,
    /// The slowest path.
    pub critical_path: SlowPath,
    /// The netlist with all places.
    #[serde(skip)]
    pub placed: PathBuf,
    /// What a bitstream is made of, if it is for a board.
    #[serde(skip)]
    pub configuration: Option<PathBuf>,
}

/// The slowest path of a placement.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SlowPath {
    /// The register that it begins at.
    pub from: String,
    /// The register that it ends at.
    pub to: String,
    /// The parts of the design that it goes through, in order: `position_l0/act`.
    pub through: Vec<String>,
    /// Time in cells, with the registers' own.
    pub logic_ns: f64,
    /// Time between them.
    pub routing_ns: f64,
}

#[derive(Deserialize)]
struct Report {
    fmax: BTreeMap<String, Clock>,
    critical_paths: Vec<TimedPath>,
    utilization: BTreeMap<String, Utilization>,
}

#[derive(Deserialize)]
struct Clock {
    achieved: f64,
}

#[derive(Deserialize)]
struct TimedPath {
    from: String,
    to: String,
    path: Vec<Hop>,
}

#[derive(Deserialize)]
struct Hop {
    #[serde(rename = "type")]
    kind: String,
    delay: f64,
    from: End,
    to: End,
}

#[derive(Deserialize)]
struct End {
    cell: String,
}

#[derive(Clone, Copy, Default, Deserialize)]
struct Utilization {
    used: u64,
    available: u64,
}

impl Route {
    /// Reads the report of a placement.
    ///
    /// # Errors
    /// If it cannot be read, or says nothing of a clock or its slowest path.
    pub fn read(
        path: &Path,
        seed: u64,
        sought_mhz: f64,
        known: &Place,
    ) -> Result<Self, SynthError> {
        let strange = |expected: &str, found: String| SynthError::Strange {
            path: path.to_owned(),
            expected: expected.to_owned(),
            found,
        };
        let text = fs::read_to_string(path).map_err(io(path))?;
        let report: Report = serde_json::from_str(&text)
            .map_err(|error| strange("a report as nextpnr writes it", error.to_string()))?;
        let [clock] = report.fmax.values().collect::<Vec<_>>()[..] else {
            let found = format!("{} of them", report.fmax.len());
            return Err(strange("the speed of one clock", found));
        };
        // Paths from or to a pin that no clock belongs to are called asynchronous.
        let inside = |path: &&TimedPath| path.from == path.to && !path.path.is_empty();
        let slowest = report.critical_paths.iter().find(inside);
        let slowest =
            slowest.ok_or_else(|| strange("a path from register to register", "none".into()))?;
        let tables: Vec<&str> = known.sites.lut4.split('+').collect();
        let count = |of: fn(Utilization) -> u64, tables: &[&str]| {
            let named = |name: &str| of(report.utilization.get(name).copied().unwrap_or_default());
            Sites {
                lut4: tables.iter().copied().map(named).sum(),
                ff: known.sites.ff.as_deref().map_or(0, named),
                multipliers: named(&known.sites.multipliers),
                block_rams: named(&known.sites.block_rams),
            }
        };
        Ok(Self {
            seed,
            sought_mhz,
            fmax_mhz: clock.achieved,
            cells: count(|site| site.used, &tables),
            available: count(|site| site.available, &tables[..1]),
            critical_path: SlowPath::of(slowest),
            placed: PathBuf::new(),
            configuration: None,
        })
    }
}

impl SlowPath {
    fn of(timed: &TimedPath) -> Self {
        let mut through: Vec<String> = Vec::new();
        // What nextpnr adds, as where a chain of carries ends, has no place in the design.
        let own = |hop: &&Hop| !hop.to.cell.starts_with("$nextpnr");
        for hop in timed.path.iter().filter(own) {
            let (name, piece) = place(&hop.to.cell);
            let part = if piece.is_empty() {
                name
            } else {
                format!("{name}/{piece}")
            };
            if through.last() != Some(&part) {
                through.push(part);
            }
        }
        let time = |routing: bool| {
            let hops = timed.path.iter();
            hops.filter(|hop| (hop.kind == "routing") == routing)
                .map(|hop| hop.delay)
                .sum()
        };
        let end = |hop: Option<&Hop>, of: fn(&Hop) -> &End| {
            hop.map_or_else(String::new, |hop| of(hop).cell.clone())
        };
        Self {
            from: end(timed.path.first(), |hop| &hop.from),
            to: end(timed.path.last(), |hop| &hop.to),
            through,
            logic_ns: time(false),
            routing_ns: time(true),
        }
    }
}
