//! The manifest: what a bundle holds, and all that a bench needs to drive the core.

use std::collections::BTreeMap;

use hwgen_spec::design::{Design, Layer, Port};
use hwgen_spec::format::QFormat;
use hwgen_spec::options::Options;
use serde::{Deserialize, Serialize};

use crate::bundle::File;
use crate::{VERSION, sha256};

/// What a reset does, in one sentence: the same in manifest, headers and pages.
pub const RESET_CONTRACT: &str = "After a rising edge that samples aresetn low, TVALID and TREADY \
    are low until the core can take a frame; the first frame after that is answered rightly, \
    whatever the length and the moment of the reset, one cycle included.";

/// Format of the manifest.
pub const BUNDLE_FORMAT: &str = "hwgen-bundle/1";

/// `manifest.json` of a bundle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// [`BUNDLE_FORMAT`].
    pub format: String,
    /// Version of the tool that wrote the bundle.
    pub hwgen: String,
    /// Name of the design and of its top module.
    pub design: String,
    /// Digest of weights, options and tool version.
    pub digest: String,
    /// The options that lead from `weights.json` to this design.
    pub options: Options,
    /// Bits of each network's output words: what `options.output_bits` and the file's formats
    /// came to.
    pub output_bits: BTreeMap<String, u32>,
    /// Clock input, rising edge.
    pub clock: String,
    /// Reset input.
    pub reset: String,
    /// Level at which it resets, `low`.
    pub reset_active: String,
    /// Whether it is read at the rising edge of the clock only.
    pub reset_synchronous: bool,
    /// Rising edges that must see it active.
    pub reset_least_cycles: u32,
    /// What a reset does, [`RESET_CONTRACT`].
    pub reset_contract: String,
    /// How a value becomes a code: `floor(value * 2^n + 1/2)`, then clipped to the word's range.
    pub value_to_code: String,
    /// The two streams.
    pub streams: Vec<Stream>,
    /// Clocks from the edge that takes the first input beat to the one that gives the last output
    /// beat, in an idle core.
    pub latency_cycles: usize,
    /// Clocks between frames in continuous flow.
    pub interval_cycles: usize,
    /// Frames under way at most.
    pub frames_in_flight: usize,
    /// Multipliers of the arrays.
    pub multipliers: usize,
    /// Multipliers of the activation units.
    pub activation_multipliers: usize,
    /// Multiplications of a frame.
    pub macs: usize,
    /// Share of the multipliers' cycles that does useful work.
    pub mac_utilization: f64,
    /// Bits of all ROMs.
    pub rom_bits: usize,
    /// The layers in order of computation.
    pub layers: Vec<LayerEntry>,
    /// All other files with their digests.
    pub files: Vec<ManifestFile>,
}

/// One AXI4-Stream port.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stream {
    /// Prefix of its signals, `s_axis` or `m_axis`.
    pub name: String,
    /// `in` or `out`, as seen from the core.
    pub direction: String,
    /// Bits of TDATA.
    pub data_bits: usize,
    /// Bits of TUSER, absent if there is none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub user: Vec<String>,
    /// Beats of a frame; TLAST marks the last.
    pub beats: usize,
    /// Words of a beat; lanes of the last beat that have no word are ignored or zero.
    pub words_per_beat: usize,
    /// Bits of a word's lane.
    pub lane_bits: u32,
    /// How a word stands in its lane: `two's complement, sign-extended`.
    pub lane_encoding: String,
    /// The words of a frame.
    pub words: Vec<Word>,
}

/// One word of a stream.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Word {
    /// Name: an input, or `<network>.<output>`.
    pub name: String,
    /// Unit of its value.
    pub unit: String,
    /// Its format `Qm.n`: the value is the code divided by 2^n.
    pub format: String,
    /// Bits of the word, sign included.
    pub bits: u32,
    /// Beat of the frame that carries it, from 0.
    pub beat: usize,
    /// Its lowest bit in TDATA.
    pub lsb: usize,
    /// First byte lane of TDATA.
    pub byte_lane: usize,
    /// Least code; inputs below are clipped to it.
    pub min_code: i64,
    /// Greatest code; inputs above are clipped to it.
    pub max_code: i64,
}

/// One layer, as built.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LayerEntry {
    /// Its name.
    pub name: String,
    /// Its network, `shared` for a shared layer.
    pub network: String,
    /// Its activation.
    pub activation: String,
    /// Number of inputs.
    pub inputs: usize,
    /// Number of neurons.
    pub outputs: usize,
    /// Neurons in parallel.
    pub pe: usize,
    /// Inputs a clock and neuron.
    pub simd: usize,
    /// Adders that form its sums in the place of an array, which would have a multiplier for each of its
    /// parallel neurons and inputs; none if it has an array.
    pub adders: Option<usize>,
    /// Words of a beat that it puts out.
    pub lanes: usize,
    /// Clocks of a frame in its array.
    pub clocks: usize,
    /// Format of its inputs; where inputs of the core differ in format, the coarsest of them.
    pub x: String,
    /// Format of its weights.
    pub w: String,
    /// Greatest extra fraction bits of a neuron's weights.
    pub extra_shift: u32,
    /// Bits of a sum.
    pub sum_bits: u32,
    /// Format of its outputs.
    pub y: String,
    /// Least and greatest weighted sum with bias over the input box.
    pub proved_range: (f64, f64),
    /// Greatest error of its activation table in output steps, over arguments of any magnitude.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub table_error_steps: Option<f64>,
    /// The same over arguments that are not clipped.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub table_range_error_steps: Option<f64>,
    /// Segments of its activation table.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub table_segments: Option<usize>,
}

/// A file of the bundle.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ManifestFile {
    /// Path below the bundle's directory.
    pub path: String,
    /// SHA-256 of its contents.
    pub sha256: String,
}

impl Manifest {
    pub(crate) fn of(design: &Design, digest: &str, files: &[File]) -> Self {
        let input = design.input();
        let networks = &design.perceptron().networks;
        let inputs = design
            .input_names()
            .iter()
            .zip(&input.formats)
            .zip(input.low.iter().zip(&input.high))
            .map(|((name, format), (low, high))| {
                (name.clone(), design.input_unit(), *format, (*low, *high))
            });
        let outputs = networks.iter().flat_map(|n| {
            let format = n.last().quant.output;
            n.output_names.iter().map(move |o| {
                let range = (format.min_code(), format.max_code());
                (format!("{}.{o}", n.name), n.unit.as_str(), format, range)
            })
        });
        let source = stream("s_axis", "in", design.source(), inputs);
        let mut sink = stream("m_axis", "out", design.sink(), outputs);
        sink.user = vec!["saturated".into(), "frame_error".into()];
        Self {
            format: BUNDLE_FORMAT.into(),
            hwgen: VERSION.into(),
            design: design.name().into(),
            digest: digest.into(),
            options: design.options().clone(),
            output_bits: networks
                .iter()
                .map(|n| (n.name.clone(), n.last().quant.output.width()))
                .collect(),
            clock: "aclk".into(),
            reset: "aresetn".into(),
            reset_active: "low".into(),
            reset_synchronous: true,
            reset_least_cycles: 1,
            reset_contract: RESET_CONTRACT.into(),
            value_to_code: "floor(value * 2^n + 1/2), clipped to min_code..max_code".into(),
            streams: vec![source, sink],
            latency_cycles: design.latency_cycles(),
            interval_cycles: design.interval_cycles(),
            frames_in_flight: design.schedule().credits,
            multipliers: design.multipliers(),
            activation_multipliers: design.activation_multipliers(),
            macs: design.macs(),
            mac_utilization: design.mac_utilization(),
            rom_bits: design.rom_bits(),
            layers: design.perceptron().layers().map(layer_entry).collect(),
            files: files
                .iter()
                .map(|f| ManifestFile {
                    path: f.path.clone(),
                    sha256: sha256(&f.text),
                })
                .collect(),
        }
    }

    /// The manifest as JSON text.
    pub fn to_json(&self) -> String {
        let mut text = serde_json::to_string_pretty(self).expect("a manifest is plain data");
        text.push('\n');
        text
    }
}

fn stream<'a>(
    name: &str,
    direction: &str,
    port: &Port,
    words: impl Iterator<Item = (String, &'a str, QFormat, (i64, i64))>,
) -> Stream {
    let lane = crate::bits(port.lane_bits);
    Stream {
        name: name.into(),
        direction: direction.into(),
        data_bits: port.data_bits(),
        user: Vec::new(),
        beats: port.beats(),
        words_per_beat: port.words_per_beat,
        lane_bits: port.lane_bits,
        lane_encoding: "two's complement, sign-extended".into(),
        words: words
            .enumerate()
            .map(|(i, (name, unit, format, (min_code, max_code)))| Word {
                name,
                unit: unit.into(),
                format: format.to_string(),
                bits: format.width(),
                beat: i / port.words_per_beat,
                lsb: i % port.words_per_beat * lane,
                byte_lane: i % port.words_per_beat * lane / 8,
                min_code,
                max_code,
            })
            .collect(),
    }
}

fn layer_entry(layer: &Layer) -> LayerEntry {
    let quant = &layer.quant;
    LayerEntry {
        name: quant.name.clone(),
        network: quant.network.clone(),
        activation: quant.activation.name().into(),
        inputs: quant.inputs(),
        outputs: quant.outputs(),
        pe: layer.fold.pe,
        simd: layer.fold.simd,
        adders: layer.adders().map(|sums| sums.adders.len()),
        lanes: layer.lanes,
        clocks: layer.folds(),
        x: quant.input.to_string(),
        w: quant.weight_format.to_string(),
        extra_shift: quant.max_extra_shift(),
        sum_bits: quant.sum_width,
        y: quant.output.to_string(),
        proved_range: quant.proved_range,
        table_error_steps: quant.table.as_ref().map(|t| t.max_error_lsb()),
        table_range_error_steps: quant.table.as_ref().map(|t| t.range_error_lsb()),
        table_segments: quant.table.as_ref().map(|t| t.segments()),
    }
}
