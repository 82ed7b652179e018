//! Reads what a simulator dumped: the value of registers after each rising edge of the clock.
//!
//! A dump is read as a stream in the order of time, so memory does not grow with its length,
//! and reading ends as soon as the reader has seen enough.

use std::collections::HashMap;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use hwgen_spec::format::from_bits;
use wellen::stream::{Filter, StreamError, StreamingWaveform};
use wellen::{BitVecRef, LoadOptions, ScopeRef, SignalRef, SignalValueRef};

use crate::error::TraceError;
use crate::record::{Register, offsets};

/// Time of rising edge 0.
pub const FIRST_EDGE_PS: u64 = 5_000;
/// Time from one rising edge to the next.
pub const PERIOD_PS: u64 = 10_000;

/// Name that the bench gives the core.
const DUT: &str = "u_dut";
/// Name of the number that the bench was given.
const NONCE: &str = "nonce_q";
/// Name of the core's clock.
pub(crate) const CLOCK: &str = "aclk";

/// The time of rising edge `clock` in every dump.
///
/// # Units
/// Picoseconds.
pub fn edge_time_ps(clock: usize) -> u64 {
    FIRST_EDGE_PS + PERIOD_PS * u64::try_from(clock).unwrap_or(u64::MAX / PERIOD_PS / 2)
}

/// What one lane of a register held in the simulator.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RtlValue {
    /// All bits 0 or 1: the code, read as a signed word.
    Known(i64),
    /// Some bit X or Z: the bits, highest first, as `1x0z`.
    Unknown(String),
}

/// All lanes after one rising edge: `unknown` marks bits that are X or Z.
#[derive(Clone, Copy, Debug)]
pub struct Row<'a> {
    bits: &'a [u64],
    unknown: &'a [u64],
}

impl<'a> Row<'a> {
    /// The bits of each lane; for an unknown bit 0 if it is X and 1 if it is Z.
    pub fn bits(&self) -> &'a [u64] {
        self.bits
    }

    /// For each lane a mask of the bits that are X or Z.
    pub fn unknown(&self) -> &'a [u64] {
        self.unknown
    }

    /// One lane, `lane_bits` wide.
    pub fn value(&self, lane: usize, lane_bits: u32) -> RtlValue {
        let (bits, unknown) = (self.bits[lane], self.unknown[lane]);
        if unknown == 0 {
            return RtlValue::Known(from_bits(bits, lane_bits));
        }
        let letter = |bit: u32| match ((unknown >> bit) & 1, (bits >> bit) & 1) {
            (0, 0) => '0',
            (0, _) => '1',
            (_, 0) => 'x',
            (_, _) => 'z',
        };
        RtlValue::Unknown((0..lane_bits).rev().map(letter).collect())
    }
}

/// When lanes are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moment {
    /// After rising edge so and so, from 0.
    Edge(usize),
    /// Later, before the next rising edge: what a flip-flop behind the core samples.
    Between(usize),
}

/// An opened dump, VCD or FST.
pub struct Dump {
    path: PathBuf,
    waveform: StreamingWaveform<std::io::BufReader<std::fs::File>>,
    signals: HashMap<String, Signal>,
    clock: SignalRef,
    nonce: Option<SignalRef>,
    /// Picoseconds in a time unit of the dump, as a fraction.
    unit_ps: (u64, u64),
}

#[derive(Clone, Copy)]
struct Signal {
    reference: SignalRef,
    bits: u64,
}

/// Where the bits of a signal go.
struct Target {
    offset: usize,
    lanes: Vec<u32>,
}

impl Dump {
    /// Opens a dump and reads its names.
    ///
    /// # Errors
    /// If it is no dump, or not one of a core in the bench.
    pub fn open(path: &Path) -> Result<Self, TraceError> {
        let unreadable = |reason: String| TraceError::Unreadable {
            path: path.to_owned(),
            reason,
        };
        // The reader panics on a file it cannot open, and on some malformed ones.
        std::fs::File::open(path).map_err(|e| unreadable(e.to_string()))?;
        let waveform = guarded(|| {
            wellen::stream::read_from_file(path, &LoadOptions::default())
                .map_err(|e| unreadable(e.to_string()))
        })
        .map_err(&unreadable)??;

        let hierarchy = waveform.hierarchy();
        let unit_ps = hierarchy
            .timescale()
            .and_then(|t| {
                let exponent = i32::from(t.unit.to_exponent()?) + 12;
                let power = 10u64.checked_pow(exponent.unsigned_abs())?;
                Some(if exponent < 0 {
                    (u64::from(t.factor), power)
                } else {
                    (u64::from(t.factor).checked_mul(power)?, 1)
                })
            })
            .ok_or_else(|| unreadable("it states no time scale".to_owned()))?;

        let no_dut = || TraceError::NoDut {
            path: path.to_owned(),
        };
        let dut = find_dut(&waveform).ok_or_else(no_dut)?;
        let mut signals = HashMap::new();
        collect_signals(&waveform, dut, "", &mut signals);
        let clock = signals.get(CLOCK).ok_or_else(no_dut)?.reference;
        let nonce = find_nonce(&waveform);
        Ok(Self {
            path: path.to_owned(),
            waveform,
            signals,
            clock,
            nonce,
            unit_ps,
        })
    }

    /// Paths of all signals in the core, in no particular order.
    pub fn paths(&self) -> impl Iterator<Item = &str> {
        self.signals.keys().map(String::as_str)
    }

    /// Calls `visit` with the number of each rising edge and all lanes after all events of its
    /// time, and again after all events of each time until the next one, in the order of time,
    /// until it breaks. Returns the number of edges visited.
    ///
    /// # Errors
    /// If a register is missing or has another width, the dump is malformed, an edge is not where
    /// the bench makes it, or there are not exactly `edges` of them and `visit` did not break.
    pub fn replay(
        &mut self,
        registers: &[Register],
        edges: usize,
        mut visit: impl FnMut(Moment, Row<'_>) -> ControlFlow<()>,
    ) -> Result<usize, TraceError> {
        let mut targets: HashMap<SignalRef, Vec<Target>> = HashMap::new();
        for (register, offset) in registers.iter().zip(offsets(registers)) {
            let signal = self.find(register)?;
            targets.entry(signal).or_default().push(Target {
                offset,
                lanes: register.lanes.clone(),
            });
        }
        let mut filter: Vec<SignalRef> = targets.keys().copied().collect();
        if !targets.contains_key(&self.clock) {
            filter.push(self.clock);
        }
        filter.sort();
        let size = filter.iter().map(|s| s.index() + 1).max().unwrap_or(0);
        let mut table: Vec<Vec<Target>> = (0..size).map(|_| Vec::new()).collect();
        for (signal, list) in targets {
            table[signal.index()] = list;
        }

        let mut state = State {
            unit_ps: self.unit_ps,
            bits: vec![0; registers.iter().map(|r| r.lanes.len()).sum()],
            unknown: registers
                .iter()
                .flat_map(|r| r.lanes.iter().map(|bits| ones(*bits)))
                .collect(),
            clock_now: None,
            clock_before: None,
            time: 0,
            edges: 0,
            expected: edges,
        };
        let (clock, waveform) = (self.clock, &mut self.waveform);
        let outcome = guarded(|| {
            waveform.stream_changes(
                Filter::include_signals(&filter),
                |time, signal, value: SignalValueRef<'_>| {
                    if time != state.time {
                        state.end_step(&mut visit)?;
                        state.time = time;
                    }
                    let SignalValueRef::BitVec(vector) = value else {
                        return Ok(());
                    };
                    if signal == clock {
                        state.clock_now = vector.be_bytes().map(|b| b.last() == Some(&1));
                    }
                    for target in &table[signal.index()] {
                        state.store(target, &vector);
                    }
                    Ok(())
                },
            )
        });
        let unreadable = |reason| TraceError::Unreadable {
            path: self.path.clone(),
            reason,
        };
        let ended = match outcome.map_err(unreadable)? {
            Ok(()) => state.end_step(&mut visit),
            Err(StreamError::Callback(stop)) => Err(stop),
            Err(StreamError::Wellen(error)) => return Err(unreadable(error.to_string())),
        };
        match ended {
            Ok(()) if state.edges == edges => Ok(edges),
            Ok(()) => Err(TraceError::EdgeCount {
                expected: edges,
                found: state.edges,
            }),
            Err(Stop::Enough) => Ok(state.edges),
            Err(Stop::Error(error)) => Err(error),
        }
    }

    /// Makes sure that the dump is of the run that was given this number.
    ///
    /// # Errors
    /// [`TraceError::Nonce`] if it has another one, or none.
    pub fn demand_nonce(&mut self, expected: u64) -> Result<(), TraceError> {
        let wrong = |found: String| TraceError::Nonce { expected, found };
        let nonce = self.nonce.ok_or_else(|| wrong("none".into()))?;
        let waveform = &mut self.waveform;
        let mut found: Option<u64> = None;
        let outcome = guarded(|| {
            waveform.stream_changes(
                Filter::include_signals(&[nonce]),
                |_, _, value: SignalValueRef<'_>| {
                    if let SignalValueRef::BitVec(vector) = value {
                        found = vector.be_bytes().map(|bytes| {
                            bytes
                                .iter()
                                .fold(0, |word, byte| word << 8 | u64::from(*byte))
                        });
                    }
                    // It is set before the first edge; what it is later does not matter.
                    if found == Some(expected) {
                        Err(())
                    } else {
                        Ok(())
                    }
                },
            )
        });
        match outcome {
            _ if found == Some(expected) => Ok(()),
            Err(reason) => Err(TraceError::Unreadable {
                path: self.path.clone(),
                reason,
            }),
            Ok(_) => Err(wrong(found.map_or("none".into(), |n| format!("{n:016x}")))),
        }
    }

    /// The lanes of one register after each rising edge.
    ///
    /// # Errors
    /// As [`Dump::replay`].
    ///
    /// # Shape
    /// `[clock][lane]`
    pub fn values(
        &mut self,
        register: &Register,
        edges: usize,
    ) -> Result<Vec<Vec<RtlValue>>, TraceError> {
        let mut rows = Vec::new();
        self.replay(std::slice::from_ref(register), edges, |moment, row| {
            let lanes = register.lanes.iter().enumerate();
            if let Moment::Edge(_) = moment {
                rows.push(lanes.map(|(l, bits)| row.value(l, *bits)).collect());
            }
            ControlFlow::Continue(())
        })?;
        Ok(rows)
    }

    fn find(&self, register: &Register) -> Result<SignalRef, TraceError> {
        let Some(signal) = self.signals.get(&register.path) else {
            return Err(TraceError::MissingRegister {
                register: register.path.clone(),
                nearest: self.nearest(&register.path),
            });
        };
        if signal.bits != register.bits() {
            return Err(TraceError::Width {
                register: register.path.clone(),
                expected: register.bits(),
                found: signal.bits,
            });
        }
        Ok(signal.reference)
    }

    fn nearest(&self, path: &str) -> Vec<String> {
        let mut names: Vec<(usize, &String)> = self
            .signals
            .keys()
            .map(|name| (strsim::damerau_levenshtein(path, name), name))
            .collect();
        names.sort();
        names.iter().take(3).map(|(_, n)| (*n).clone()).collect()
    }
}

enum Stop {
    Enough,
    Error(TraceError),
}

struct State {
    unit_ps: (u64, u64),
    bits: Vec<u64>,
    unknown: Vec<u64>,
    clock_now: Option<bool>,
    clock_before: Option<bool>,
    time: u64,
    edges: usize,
    expected: usize,
}

impl State {
    /// After the last event of a time: was there a rising edge?
    fn end_step(
        &mut self,
        visit: &mut impl FnMut(Moment, Row<'_>) -> ControlFlow<()>,
    ) -> Result<(), Stop> {
        // From X to 1 is no edge: the bench starts at 0.
        let rises = self.clock_before == Some(false) && self.clock_now == Some(true);
        self.clock_before = self.clock_now;
        if !rises {
            let Some(clock) = self.edges.checked_sub(1).filter(|c| *c < self.expected) else {
                return Ok(());
            };
            return self.show(Moment::Between(clock), visit);
        }
        let clock = self.edges;
        let found_ps = self.time.saturating_mul(self.unit_ps.0) / self.unit_ps.1;
        let expected_ps = edge_time_ps(clock);
        if found_ps != expected_ps {
            return Err(Stop::Error(TraceError::EdgeTime {
                clock,
                expected_ps,
                found_ps,
            }));
        }
        self.edges += 1;
        if self.edges > self.expected {
            // Counted on, for the message.
            return Ok(());
        }
        self.show(Moment::Edge(clock), visit)
    }

    fn show(
        &self,
        moment: Moment,
        visit: &mut impl FnMut(Moment, Row<'_>) -> ControlFlow<()>,
    ) -> Result<(), Stop> {
        let row = Row {
            bits: &self.bits,
            unknown: &self.unknown,
        };
        match visit(moment, row) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Stop::Enough),
        }
    }

    fn store(&mut self, target: &Target, vector: &BitVecRef<'_>) {
        let lanes = target.offset..target.offset + target.lanes.len();
        let (bits, unknown) = (&mut self.bits[lanes.clone()], &mut self.unknown[lanes]);
        if let Some(bytes) = vector.be_bytes() {
            unpack(bytes, &target.lanes, bits);
            unknown.fill(0);
            return;
        }
        bits.fill(0);
        unknown.fill(0);
        let mut letters = vector.iter_lsb_to_msb();
        for ((bits, unknown), lane_bits) in bits.iter_mut().zip(unknown).zip(&target.lanes) {
            for place in 0..*lane_bits {
                match letters.next().map(|bit| bit.as_ascii()) {
                    Some('0') => {}
                    Some('1') => *bits |= 1 << place,
                    Some('z') => {
                        *bits |= 1 << place;
                        *unknown |= 1 << place;
                    }
                    _ => *unknown |= 1 << place,
                }
            }
        }
    }
}

/// Cuts big-endian bytes into words of so many bits, the lowest first.
fn unpack(bytes: &[u8], widths: &[u32], lanes: &mut [u64]) {
    let mut low_first = bytes.iter().rev();
    let (mut window, mut filled) = (0u128, 0u32);
    for (lane, bits) in lanes.iter_mut().zip(widths) {
        while filled < *bits {
            window |= u128::from(low_first.next().copied().unwrap_or(0)) << filled;
            filled += 8;
        }
        *lane = u64::try_from(window & u128::from(ones(*bits))).unwrap_or(0);
        window >>= bits;
        filled -= bits;
    }
}

fn ones(bits: u32) -> u64 {
    u64::MAX >> (64 - bits)
}

/// The number that the bench was given, wherever the bench is.
fn find_nonce<R: std::io::BufRead + std::io::Seek>(
    waveform: &StreamingWaveform<R>,
) -> Option<SignalRef> {
    let hierarchy = waveform.hierarchy();
    let mut level: Vec<ScopeRef> = hierarchy.scopes().collect();
    while !level.is_empty() {
        // Not in the core: a core could claim anything.
        level.retain(|s| hierarchy[*s].name(hierarchy) != DUT);
        for scope in &level {
            for var in hierarchy[*scope].vars(hierarchy) {
                if hierarchy[var].name(hierarchy) == NONCE {
                    return Some(hierarchy[var].signal_ref());
                }
            }
        }
        level = level
            .iter()
            .flat_map(|s| hierarchy[*s].scopes(hierarchy))
            .collect();
    }
    None
}

/// The outermost instance of that name.
fn find_dut<R: std::io::BufRead + std::io::Seek>(
    waveform: &StreamingWaveform<R>,
) -> Option<ScopeRef> {
    let hierarchy = waveform.hierarchy();
    let mut level: Vec<ScopeRef> = hierarchy.scopes().collect();
    while !level.is_empty() {
        if let Some(dut) = level.iter().find(|s| hierarchy[**s].name(hierarchy) == DUT) {
            return Some(*dut);
        }
        level = level
            .iter()
            .flat_map(|s| hierarchy[*s].scopes(hierarchy))
            .collect();
    }
    None
}

fn collect_signals<R: std::io::BufRead + std::io::Seek>(
    waveform: &StreamingWaveform<R>,
    scope: ScopeRef,
    prefix: &str,
    signals: &mut HashMap<String, Signal>,
) {
    let hierarchy = waveform.hierarchy();
    // An index of an array arrives as a scope or a name of its own, `[3]`: no dot before it.
    let join = |name: &str| match (prefix, name.starts_with('[')) {
        ("", _) => name.to_owned(),
        (_, true) => format!("{prefix}{name}"),
        (_, false) => format!("{prefix}.{name}"),
    };
    for var in hierarchy[scope].vars(hierarchy) {
        let var = &hierarchy[var];
        if let Some(bits) = var.length(hierarchy).filter(|bits| *bits > 0) {
            let signal = Signal {
                reference: var.signal_ref(),
                bits: u64::from(bits),
            };
            signals.insert(join(var.name(hierarchy)), signal);
        }
    }
    for inner in hierarchy[scope].scopes(hierarchy) {
        let path = join(hierarchy[inner].name(hierarchy));
        collect_signals(waveform, inner, &path, signals);
    }
}

thread_local! {
    /// Whether the dump's reader is at work in this thread.
    static READING: std::cell::Cell<bool> = const { std::cell::Cell::new(false) };
}

/// Runs the dump's reader; it panics on some malformed files, which is not a bug of ours: the panic
/// becomes an error, and is not printed.
fn guarded<T>(read: impl FnOnce() -> T) -> Result<T, String> {
    static HOOK: std::sync::Once = std::sync::Once::new();
    HOOK.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if !READING.get() {
                before(panic);
            }
        }));
    });
    READING.set(true);
    let outcome = catch_unwind(AssertUnwindSafe(read));
    READING.set(false);
    outcome.map_err(|panic| {
        panic
            .downcast_ref::<String>()
            .cloned()
            .or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned()))
            .unwrap_or_else(|| "malformed".to_owned())
    })
}
