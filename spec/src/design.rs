//! A design: integers plus architecture, with every derived number derived once.
//!
//! A design is a pipeline of stages with frame streams between them; the AXI4-Stream ports are
//! its ends. Today there is one kind of stage, the [`Perceptron`].

use std::sync::Arc;

use serde::Serialize;

use crate::adders::Adders;
use crate::device::{self, Device, UnknownDevice};
use crate::folding::{self, Fold};
use crate::network::FloatNet;
use crate::options::{Budget, Options};
use crate::quantize::{InputFormat, QuantLayer, QuantNet, QuantizeError, quantize};
use crate::schedule::Schedule;
use crate::weights;

/// The widest TDATA that AXI4-Stream recommends.
const MAX_STREAM_BITS: u32 = 1024;

/// Why a float network can't become a design.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DesignError {
    /// A format or an option can't be met.
    #[error(transparent)]
    Quantize(#[from] QuantizeError),
    /// The budget is beyond what any folding reaches.
    #[error("{option}: at least {least} expected, {found} found")]
    Budget {
        /// The option's name.
        option: &'static str,
        /// The least that can be met.
        least: u32,
        /// What was asked for.
        found: u32,
    },
    /// A stream of a width that no bus has.
    #[error("stream-bits: a power of two from 8 to {MAX_STREAM_BITS} expected, {0} found")]
    StreamBits(u32),
    /// There is no such device.
    #[error(transparent)]
    UnknownDevice(#[from] UnknownDevice),
    /// The device has too few multipliers for the design, or none that are known.
    #[error(
        "device: at least {least} multipliers expected, those of one product a layer and activation, \
         {found} found in {device}"
    )]
    TooSmall {
        /// Its name.
        device: String,
        /// What the slowest folding takes.
        least: u32,
        /// What it has.
        found: u32,
    },
    /// A name that the design, or a prefix that its modules, cannot have.
    #[error("{option}: {told}")]
    Name {
        /// The option that sets it.
        option: &'static str,
        /// What was expected and found.
        told: String,
    },
}

impl DesignError {
    /// One line that says how to mend it.
    pub fn help(&self) -> String {
        match self {
            Self::Quantize(e) => e.help(),
            Self::Budget { option, least, .. } => format!("give --{option} {least} or more"),
            Self::StreamBits(_) => "choose such a power, or leave the option out".into(),
            Self::UnknownDevice(e) => e.help(),
            Self::TooSmall { .. } => {
                "say --interval or --multipliers: what is beyond the device's multipliers is \
                 made of logic"
                    .into()
            }
            Self::Name { option, .. } => format!("choose another --{option}"),
        }
    }
}

/// How a layer's array gets its operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Feed {
    /// A register holds the whole vector and replays it for each group of neurons.
    Replay,
    /// The beats of the layer before are consumed as they come.
    Direct,
    /// Each beat of the layer before is held for a clock a group of neurons, whose sums take turns in
    /// the accumulators.
    Hold,
    /// The whole vector goes into adders of shifted words at once: there are no multipliers.
    Adders,
}

/// A layer with its array.
///
/// The array computes `fold.pe` neurons in parallel with `fold.simd` inputs a cycle each, in
/// `neuron_folds * synapse_folds` cycles a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// The integers.
    pub quant: Arc<QuantLayer>,
    /// Parallelism.
    pub fold: Fold,
    /// Words of a beat that the layer puts out: requantizers and activation units.
    pub lanes: usize,
    /// Where the operands come from.
    pub feed: Feed,
    /// Clocks that operands and addresses take on their way to an element.
    pub copy_latency: usize,
    /// Clocks from a weight ROM's address to its registered word.
    pub rom_latency: usize,
    /// The same of the activation's segments.
    pub segment_latency: usize,
    /// Clocks from a beat to its place in a vector.
    pub gather_latency: usize,
    /// Whether the multipliers of the activation units are made of logic.
    pub activation_in_logic: bool,
}

/// Bits of a ring that one copy of the signal to load it reaches.
const START_REACH: usize = 64;

/// Beats of a vector whose places one register of their words reaches; the words of more take a clock to
/// a copy, where distance counts.
const NEAR_BEATS: usize = 8;

impl Layer {
    /// Groups of `pe` neurons.
    pub fn neuron_folds(&self) -> usize {
        self.quant.outputs().div_ceil(self.fold.pe)
    }

    /// Groups of `simd` inputs.
    pub fn synapse_folds(&self) -> usize {
        self.quant.inputs().div_ceil(self.fold.simd)
    }

    /// Words of each weight ROM, cycles of a frame in the array.
    pub fn folds(&self) -> usize {
        self.neuron_folds() * self.synapse_folds()
    }

    /// Beats that hold the layer's outputs.
    pub fn output_beats(&self) -> usize {
        self.quant.outputs().div_ceil(self.lanes)
    }

    /// Beats that the array brings forth, those that are padding alone included.
    pub fn array_beats(&self) -> usize {
        self.neuron_folds() * self.fold.pe / self.lanes
    }

    /// Beats of one group of neurons.
    pub fn drain_beats(&self) -> usize {
        self.fold.pe / self.lanes
    }

    /// Whether partial sums are accumulated over several cycles.
    pub fn accumulates(&self) -> bool {
        self.synapse_folds() > 1
    }

    /// Levels of the adder tree behind `simd` multipliers.
    pub fn tree_levels(&self) -> usize {
        usize::try_from(self.fold.simd.next_power_of_two().ilog2()).expect("a small number")
    }

    /// Groups of neurons whose sums an element forms in turns, a clock each.
    pub fn turns(&self) -> usize {
        match self.feed {
            Feed::Replay | Feed::Direct | Feed::Adders => 1,
            Feed::Hold => self.neuron_folds(),
        }
    }

    /// Clocks between two output beats, at least, where `before` are those between two input beats
    /// that are used as they come.
    pub fn output_gap(&self, before: usize) -> usize {
        match self.feed {
            _ if self.drain_beats() > 1 => 1,
            Feed::Replay => self.synapse_folds(),
            Feed::Direct => before * self.synapse_folds(),
            Feed::Hold | Feed::Adders => 1,
        }
    }

    /// Groups of neurons and of inputs that are worked on in cycle `fold` of a frame.
    fn groups(&self, fold: usize) -> (usize, usize) {
        match self.feed {
            Feed::Replay | Feed::Direct | Feed::Adders => {
                (fold / self.synapse_folds(), fold % self.synapse_folds())
            }
            Feed::Hold => (fold % self.neuron_folds(), fold / self.neuron_folds()),
        }
    }

    /// The neuron whose sum is formed by `pe` in cycle `fold` of a frame; `None` for padding.
    pub fn neuron(&self, pe: usize, fold: usize) -> Option<usize> {
        let neuron = self.groups(fold).0 * self.fold.pe + pe;
        (neuron < self.quant.outputs()).then_some(neuron)
    }

    /// The input read by multiplier `simd` in cycle `fold` of a frame; `None` for padding.
    pub fn input(&self, simd: usize, fold: usize) -> Option<usize> {
        let input = self.groups(fold).1 * self.fold.simd + simd;
        (input < self.quant.inputs()).then_some(input)
    }

    /// Clocks from the layer's operands to an element's multipliers, in registers of the element.
    pub fn operand_latency(&self) -> usize {
        self.copy_latency + self.rom_latency - 1
    }

    /// Copies of the address in each weight ROM: one, or where the device wants it one for each weight,
    /// if a word's bit takes more than one look-up table of four inputs.
    pub fn address_copies(&self, device: &Device) -> usize {
        own_addresses(device, self.folds(), self.fold.simd)
    }

    /// Copies of the address of the bias ROM: one, or likewise one for each lane.
    pub fn bias_address_copies(&self, device: &Device) -> usize {
        own_addresses(device, self.array_beats(), self.lanes)
    }

    /// The adders that take the place of the array.
    pub fn adders(&self) -> Option<&Adders> {
        let adders = self.quant.adders.as_deref();
        adders.filter(|_| self.feed == Feed::Adders)
    }

    /// Whether the layer reads its whole vector at once.
    pub fn reads_whole(&self) -> bool {
        matches!(self.feed, Feed::Replay | Feed::Adders)
    }

    /// Copies of the signal that the layer's vector is whole: one for so many bits of the ring that it
    /// loads, or one that goes with the sums.
    pub fn start_copies(&self) -> usize {
        if self.feed == Feed::Adders {
            return 1;
        }
        let bits = self.quant.inputs() * to_usize(self.quant.input.width());
        bits.div_ceil(START_REACH)
    }

    /// Copies of the signal that a group's sums are done: one for so many bits of the drain that they are
    /// loaded into.
    pub fn load_copies(&self) -> usize {
        if !self.accumulates() || self.drain_beats() == 1 {
            return 1;
        }
        (self.fold.pe * to_usize(self.quant.sum_width)).div_ceil(START_REACH)
    }

    /// Copies of the signal that a layer's vector is whole, for those who take it whole: layers
    /// that replay it, or where `readers` is empty a queue of answers and who counts these.
    pub fn gather_starts(readers: &[&Layer]) -> usize {
        if readers.is_empty() {
            return 2;
        }
        let replays = readers.iter().filter(|r| r.reads_whole());
        replays.map(|r| r.start_copies()).sum()
    }

    /// Weight codes of `pe` in cycle `fold`, one a multiplier, zero for padding.
    pub fn weight_word(&self, pe: usize, fold: usize) -> Vec<i64> {
        (0..self.fold.simd)
            .map(
                |simd| match (self.neuron(pe, fold), self.input(simd, fold)) {
                    (Some(n), Some(i)) => self.quant.weights[n][i],
                    _ => 0,
                },
            )
            .collect()
    }

    /// Bias and extra shift of output beat `beat`, one a lane, zero for padding.
    pub fn bias_word(&self, beat: usize) -> Vec<(i64, u32)> {
        (beat * self.lanes..(beat + 1) * self.lanes)
            .map(|n| match self.quant.bias.get(n) {
                Some(bias) => (*bias, self.quant.extra_shift[n]),
                None => (0, 0),
            })
            .collect()
    }

    /// Multipliers of the array.
    pub fn multipliers(&self) -> usize {
        match self.feed {
            Feed::Adders => 0,
            _ => self.fold.pe * self.fold.simd,
        }
    }

    /// Multipliers of its activation units, one a lane, those made of logic left out.
    pub fn activation_multipliers(&self) -> usize {
        let table = self.quant.table.as_ref();
        let blocks = table.filter(|_| !self.activation_in_logic);
        blocks.map_or(0, |_| self.lanes)
    }

    /// Multipliers of array and activation units.
    pub fn all_multipliers(&self) -> usize {
        self.multipliers() + self.activation_multipliers()
    }

    /// A device's blocks that the multipliers of its array take.
    pub fn array_blocks(&self, device: &Device) -> usize {
        let (x, w) = (self.quant.input.width(), self.quant.weight_format.width());
        self.multipliers() * device.blocks(x, w)
    }

    /// The same of array and activation units.
    pub fn all_blocks(&self, device: &Device) -> usize {
        let (distance, slope) = self.activation_operands();
        self.array_blocks(device) + self.activation_multipliers() * device.blocks(distance, slope)
    }

    /// Bits of distance and slope, as the multiplier of an activation unit has them; none where there is none.
    pub fn activation_operands(&self) -> (u32, u32) {
        let table = self.quant.table.as_ref();
        table.map_or((0, 0), |table| {
            (table.distance_bits() + 1, table.slope_width() + 1)
        })
    }

    /// Multiplications of a frame.
    pub fn macs(&self) -> usize {
        match self.feed {
            Feed::Adders => 0,
            _ => self.quant.inputs() * self.quant.outputs(),
        }
    }
}

/// One network of a perceptron stage.
#[derive(Clone, Debug, PartialEq)]
pub struct NetworkPlan {
    /// Its name.
    pub name: String,
    /// Its own layers.
    pub layers: Vec<Layer>,
    /// Names of its outputs.
    pub output_names: Vec<String>,
    /// Unit of its outputs.
    pub unit: String,
}

impl NetworkPlan {
    /// The layer whose words leave the network.
    pub fn last(&self) -> &Layer {
        self.layers.last().expect("a network has a layer")
    }
}

/// A stage of multilayer perceptrons that read the same frame.
///
/// Inside there is no back-pressure: a frame is let in when `interval` cycles have passed since
/// the one before and fewer than `credits` are under way; the queues of answers hold that many.
#[derive(Clone, Debug, PartialEq)]
pub struct Perceptron {
    /// Layers that all networks read.
    pub shared: Vec<Layer>,
    /// The networks.
    pub networks: Vec<NetworkPlan>,
    /// Frames under way at most.
    pub credits: usize,
}

impl Perceptron {
    /// All layers, shared ones first, then network by network.
    pub fn layers(&self) -> impl Iterator<Item = &Layer> {
        self.shared
            .iter()
            .chain(self.networks.iter().flat_map(|n| &n.layers))
    }

    fn layers_mut(&mut self) -> impl Iterator<Item = &mut Layer> {
        let own = self.networks.iter_mut().flat_map(|n| &mut n.layers);
        self.shared.iter_mut().chain(own)
    }
}

/// A stage of the pipeline.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Stage {
    /// Multilayer perceptrons.
    Perceptron(Perceptron),
}

/// One of the two AXI4-Streams.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Port {
    /// Words of a frame.
    pub words: usize,
    /// Words of a beat; word 0 of a beat stands in the lowest lane.
    pub words_per_beat: usize,
    /// Bits of a lane, whole bytes; words are sign-extended to it.
    pub lane_bits: u32,
}

impl Port {
    /// As many words a beat as the interval asks for, or as `bits` hold, if these are more.
    fn new(words: usize, widest: u32, interval: usize, bits: u32) -> Self {
        let lane_bits = widest.next_power_of_two().max(8);
        let wanted = words.div_ceil(interval);
        Self {
            words,
            words_per_beat: wanted.max(to_usize(bits / lane_bits)).min(words),
            lane_bits,
        }
    }

    /// Beats of a frame.
    pub fn beats(&self) -> usize {
        self.words.div_ceil(self.words_per_beat)
    }

    /// Bits of TDATA.
    pub fn data_bits(&self) -> usize {
        self.words_per_beat * usize::try_from(self.lane_bits).expect("a small number")
    }
}

/// Everything that the generator and the models need to know. A `Design` that exists is valid.
///
/// ```
/// use hwgen_spec::{design::Design, options::Options, weights};
/// let file = br#"{"format": "hwgen-weights/1", "name": "tiny",
///   "inputs": {"min": [-1, -1], "max": [1, 1]},
///   "networks": [{"name": "net", "layers": [
///     {"activation": "tanh", "weights": [[1, 0.5], [0.25, -1]]},
///     {"activation": "linear", "weights": [[1, 1]]}]}]}"#;
/// let design = Design::new(&weights::read(file)?, &Options::default())?;
/// let answer = design.net().evaluate(&design.input().codes(&[0.5, 0.25]));
/// let y = design.net().real_outputs(&answer.codes)[0];
/// assert!((y - (0.625f64.tanh() + (-0.125f64).tanh())).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Design {
    name: String,
    input_names: Vec<String>,
    input_unit: String,
    options: Options,
    device: &'static Device,
    net: QuantNet,
    stages: Vec<Stage>,
    source: Port,
    sink: Port,
    schedule: Schedule,
}

/// A shorter latency may take one register bit for so many look-up tables of the device.
const PART_FOR_LATENCY: u32 = 16;

/// The least interval that so many multipliers allow, and what shared layers may take of it.
fn fastest(
    net: &QuantNet,
    multipliers: u32,
    count: impl Fn(&Layer) -> usize,
    device: &Device,
) -> Result<(u32, u32), u32> {
    let interval = folding::interval_for(net, multipliers, &count)?;
    let spare = device
        .lut4
        .map_or(usize::MAX, |lut4| to_usize(lut4 / PART_FOR_LATENCY));
    let shared = folding::shared_interval_for(net, multipliers, interval, &count, spare);
    Ok((shared, interval))
}

/// The same for all that a device has.
///
/// Multipliers of activations are narrow; where the array can use their blocks, they are made of
/// logic.
fn fastest_on(net: &QuantNet, device: &Device) -> Result<(u32, u32), u32> {
    let multipliers = device.multiplier_budget();
    let blocks = fastest(net, multipliers, |l| l.all_blocks(device), device);
    if !device.activation_in_logic {
        return blocks;
    }
    let logic = fastest(net, multipliers, |l| l.array_blocks(device), device);
    match (&blocks, &logic) {
        (Ok((_, with_blocks)), Ok((_, with_logic))) if with_logic >= with_blocks => blocks,
        _ => logic,
    }
}

impl Design {
    /// Quantizes, folds and schedules a network.
    ///
    /// # Errors
    /// [`DesignError`] where an option can't be met.
    pub fn new(net: &FloatNet, options: &Options) -> Result<Self, DesignError> {
        let prefix = options.prefix.as_deref().map(|prefix| ("prefix", prefix));
        for (option, name) in [("name", &*net.name)].into_iter().chain(prefix) {
            weights::check_name(name).map_err(|told| DesignError::Name { option, told })?;
        }
        let device = device::find(options.device.as_deref().unwrap_or(device::GENERIC))?;
        let wide = |bits: &u32| !bits.is_power_of_two() || !(8..=MAX_STREAM_BITS).contains(bits);
        if let Some(bits) = options.stream_bits.filter(wide) {
            return Err(DesignError::StreamBits(bits));
        }
        let mut quant = quantize(net, options)?;
        if device.no_adders {
            let own = quant.networks.iter_mut().flat_map(|n| &mut n.layers);
            for layer in quant.shared.iter_mut().chain(own) {
                layer.adders = None;
            }
        }
        let (shared, allowed) = match options.budget {
            Budget::Interval(0) => {
                return Err(DesignError::Budget {
                    option: "interval",
                    least: 1,
                    found: 0,
                });
            }
            Budget::Interval(interval) => (interval, interval),
            Budget::Multipliers(found) => {
                let counted = Layer::multipliers;
                fastest(&quant, found, counted, device).map_err(|least| DesignError::Budget {
                    option: "multipliers",
                    least,
                    found,
                })?
            }
            Budget::Device => {
                fastest_on(&quant, device).map_err(|least| DesignError::TooSmall {
                    device: device.name.clone(),
                    least,
                    found: device.multiplier_budget(),
                })?
            }
        };
        let mut perceptron = folding::fold(&quant, to_usize(shared), to_usize(allowed));
        let wanted: usize = perceptron.layers().map(|l| l.all_blocks(device)).sum();
        let short = wanted > to_usize(device.multiplier_budget());
        for layer in perceptron.layers_mut() {
            layer.activation_in_logic = device.activation_in_logic && short;
            layer.copy_latency = device.copy_latency;
            layer.rom_latency = device.rom_latency(layer.folds());
            let segments = layer.quant.table.as_ref().map_or(1, |t| t.segments());
            layer.segment_latency = device.rom_latency(segments);
            let far = device.copy_latency > 0 && layer.output_beats() > NEAR_BEATS;
            layer.gather_latency = 1 + usize::from(far);
        }
        let interval = perceptron
            .layers()
            .map(|l| l.folds().max(l.array_beats()))
            .max()
            .expect("there is a layer");
        let words: usize = quant.networks.iter().map(|n| n.output_names.len()).sum();
        let widest = perceptron
            .networks
            .iter()
            .map(|n| n.last().quant.output.width())
            .max();
        let bits = options.stream_bits.unwrap_or(device.stream_bits);
        let port = |words, widest| Port::new(words, widest, interval, bits);
        let source = port(quant.input.low.len(), quant.input.format.width());
        let sink = port(words, widest.expect("there is a network"));
        let schedule = Schedule::of(&perceptron, &source, &sink);
        perceptron.credits = schedule.credits;
        Ok(Self {
            name: net.name.clone(),
            input_names: net.inputs.names.clone(),
            input_unit: net.inputs.unit.clone(),
            options: options.clone(),
            device,
            net: quant,
            stages: vec![Stage::Perceptron(perceptron)],
            source,
            sink,
            schedule,
        })
    }

    /// Name of the top module.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What the names of all modules but the top begin with, `__` behind it.
    pub fn prefix(&self) -> &str {
        self.options.prefix.as_deref().unwrap_or(&self.name)
    }

    /// Names of the inputs in stream order.
    pub fn input_names(&self) -> &[String] {
        &self.input_names
    }

    /// Unit of the raw inputs, possibly empty.
    pub fn input_unit(&self) -> &str {
        &self.input_unit
    }

    /// The choices that the design was made with.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// What it is made for.
    pub fn device(&self) -> &'static Device {
        self.device
    }

    /// The integers without architecture.
    pub fn net(&self) -> &QuantNet {
        &self.net
    }

    /// The input words.
    pub fn input(&self) -> &InputFormat {
        &self.net.input
    }

    /// The stages in stream order.
    pub fn stages(&self) -> &[Stage] {
        &self.stages
    }

    /// The perceptron stage.
    pub fn perceptron(&self) -> &Perceptron {
        let Stage::Perceptron(perceptron) = &self.stages[0];
        perceptron
    }

    /// The stream of inputs.
    pub fn source(&self) -> &Port {
        &self.source
    }

    /// The stream of outputs.
    pub fn sink(&self) -> &Port {
        &self.sink
    }

    /// When what happens.
    pub fn schedule(&self) -> &Schedule {
        &self.schedule
    }

    /// Whether frames follow each other as fast as their beats leave, so that the last beat of one makes
    /// room for the next in the clock in which it goes.
    pub fn sink_is_eager(&self) -> bool {
        self.sink.beats() >= self.schedule.interval
    }

    /// Cycles between two frames in continuous flow.
    pub fn interval_cycles(&self) -> usize {
        self.schedule.interval
    }

    /// Clock cycles from the edge that takes the first input beat to the edge that hands over
    /// the last output beat, in an idle core.
    pub fn latency_cycles(&self) -> usize {
        self.schedule.latency
    }

    /// Multipliers of the arrays.
    pub fn multipliers(&self) -> usize {
        self.perceptron().layers().map(Layer::multipliers).sum()
    }

    /// Multipliers of the activation units.
    pub fn activation_multipliers(&self) -> usize {
        let layers = self.perceptron().layers();
        layers.map(Layer::activation_multipliers).sum()
    }

    /// Multiplications of a frame in the arrays.
    pub fn macs(&self) -> usize {
        self.perceptron().layers().map(Layer::macs).sum()
    }

    /// Share of the multipliers' cycles that does useful work; none where there are no multipliers.
    pub fn mac_utilization(&self) -> f64 {
        if self.multipliers() == 0 {
            return 0.0;
        }
        #[expect(clippy::cast_precision_loss, reason = "counts far below 2^53")]
        let ratio = |a: usize, b: usize| a as f64 / b as f64;
        ratio(self.macs(), self.multipliers() * self.interval_cycles())
    }

    /// Bits of all ROMs: weights, biases with shifts, segments.
    pub fn rom_bits(&self) -> usize {
        self.perceptron()
            .layers()
            .map(|l| {
                let weights = l.folds() * l.multipliers() * to_usize(l.quant.weight_format.width());
                let bias = l.array_beats() * l.lanes * to_usize(bias_rom_width(&l.quant));
                let table = l.quant.table.as_ref().map_or(0, |t| {
                    l.lanes * t.segments() * to_usize(t.offset_width() + t.slope_width())
                });
                weights + bias + table
            })
            .sum()
    }
}

/// Copies of the address of a ROM: one, or where the device wants it one for each of `parts` of a
/// word, if a bit takes more than one look-up table of four inputs.
fn own_addresses(device: &Device, words: usize, parts: usize) -> usize {
    if device.address_per_weight && device.rom_in_logic(words) && words > 16 {
        parts
    } else {
        1
    }
}

/// Bits of one neuron's entry in the bias ROM: the bias and its extra shift.
pub fn bias_rom_width(layer: &QuantLayer) -> u32 {
    layer.biased_width + extra_shift_width(layer)
}

/// Bits of a neuron's extra shift, zero where no neuron has one.
pub fn extra_shift_width(layer: &QuantLayer) -> u32 {
    match layer.max_extra_shift() {
        0 => 0,
        most => crate::format::unsigned_width(most.into()),
    }
}

pub(crate) fn to_usize(value: u32) -> usize {
    usize::try_from(value).expect("usize has at least 32 bits")
}
