//! What a user may set when a design is made from weights.

use serde::{Deserialize, Serialize};

use crate::device;

/// A width for every layer, or for the layer that is named.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct WidthSetting {
    /// Name of a layer such as `position_l0`; every layer where absent.
    pub layer: Option<String>,
    /// Bits of the word, sign included.
    pub bits: u32,
}

/// How much hardware to spend.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Budget {
    /// At most so many clock cycles between two frames.
    Interval(u32),
    /// At most so many multipliers in the arrays.
    Multipliers(u32),
    /// As many multipliers, those of activations included, as the device has.
    Device,
}

impl Default for Budget {
    /// 64 cycles a frame.
    fn default() -> Self {
        Self::Interval(64)
    }
}

/// Choices that turn one weights file into one design.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Options {
    /// Name of the device, [`crate::device`]; portable Verilog if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub device: Option<String>,
    /// Interval or multipliers.
    #[serde(default)]
    pub budget: Budget,
    /// Weight widths, later settings winning; see [`DEFAULT_WEIGHT_BITS`] and
    /// [`DEFAULT_FINE_WEIGHT_BITS`].
    #[serde(default)]
    pub weight_bits: Vec<WidthSetting>,
    /// Widths of hidden words; see [`DEFAULT_BOUNDED_BITS`], [`DEFAULT_DEEP_BOUNDED_BITS`] and
    /// [`DEFAULT_UNBOUNDED_BITS`].
    #[serde(default)]
    pub activation_bits: Vec<WidthSetting>,
    /// Segments of the activation table; as many as keep it below two output steps if absent.
    #[serde(default)]
    pub segments: Option<u32>,
    /// Bits of a beat of either stream, at least, if the words are as many; the device's if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stream_bits: Option<u32>,
    /// Width of the output words; [`DEFAULT_OUTPUT_BITS`] if absent.
    #[serde(default)]
    pub output_bits: Option<u32>,
    /// What the names of all modules but the top begin with; the design's name if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prefix: Option<String>,
}

impl Options {
    /// Bits of an operand that a multiplier of the device takes; no limit where none is known.
    pub fn multiplier_bits(&self) -> u32 {
        let device = self.device.as_deref().map(device::find);
        let bits = device.and_then(|device| device.ok()?.multiplier_bits);
        bits.unwrap_or(u32::MAX)
    }
}

/// Width of weights.
pub const DEFAULT_WEIGHT_BITS: u32 = 16;
/// Width of the weights of layers whose errors are amplified behind them: hidden linear ones, and
/// all in designs with several tanh or sigmoid layers one behind the other.
pub const DEFAULT_FINE_WEIGHT_BITS: u32 = 18;
/// Width of the words behind tanh and sigmoid.
pub const DEFAULT_BOUNDED_BITS: u32 = 13;
/// The same in designs with several such layers one behind the other.
pub const DEFAULT_DEEP_BOUNDED_BITS: u32 = 14;
/// Width of the words behind hidden linear and ReLU layers: the operand of most DSP blocks.
pub const DEFAULT_UNBOUNDED_BITS: u32 = 18;
/// Width of the output words.
pub const DEFAULT_OUTPUT_BITS: u32 = 24;
/// Width of the input words where the file gives no resolution.
pub const DEFAULT_INPUT_BITS: u32 = 16;
/// Widths that may be set for weights and hidden words.
pub const OPERAND_BITS: std::ops::RangeInclusive<u32> = 3..=24;
/// Widths that may be set for output words.
pub const OUTPUT_BITS: std::ops::RangeInclusive<u32> = 4..=32;

/// The last setting that speaks of `layer`, a named one before a general one.
pub fn width_of(settings: &[WidthSetting], layer: &str) -> Option<u32> {
    let named = settings
        .iter()
        .rev()
        .find(|s| s.layer.as_deref() == Some(layer));
    let general = || settings.iter().rev().find(|s| s.layer.is_none());
    named.or_else(general).map(|s| s.bits)
}
