//! What `emit` and `estimate` are asked for: weights, and what is to be made of them.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use hwgen_spec::design::Design;
use hwgen_spec::device;
use hwgen_spec::network::FloatNet;
use hwgen_spec::options::{Budget, Options, WidthSetting};
use hwgen_spec::weights;

use crate::failure::Failure;

/// Weights and options.
#[derive(Debug, clap::Args)]
pub struct Request {
    /// The weights file, format hwgen-weights/1
    #[arg(long, value_name = "W.json")]
    pub weights: PathBuf,
    /// What it is to run on: `ecp5-85k` and its like, `generic` for portable Verilog, which
    /// `emit` makes without this
    #[arg(long, value_name = "D")]
    pub device: Option<String>,
    /// At most N clock cycles between two frames [default: 64, or what the device's multipliers
    /// allow]
    #[arg(long, value_name = "N", conflicts_with = "multipliers")]
    pub interval: Option<u32>,
    /// At most N multipliers in the arrays
    #[arg(long, value_name = "N")]
    pub multipliers: Option<u32>,
    /// Bits of weights, of every layer or of the one named [default: 16; 18 if hidden and
    /// linear, and in networks of several tanh or sigmoid layers]
    #[arg(long, value_name = "[LAYER=]B", value_parser = width_setting)]
    pub weight_bits: Vec<WidthSetting>,
    /// Bits of hidden words, of every layer or of the one named [default: 13; 18 if linear or
    /// ReLU; 14 in networks of several tanh or sigmoid layers]
    #[arg(long, value_name = "[LAYER=]B", value_parser = width_setting)]
    pub activation_bits: Vec<WidthSetting>,
    /// Bits of output words [default: 24]
    #[arg(long, value_name = "B")]
    pub output_bits: Option<u32>,
    /// Bits of a beat of either stream, at least, where there are as many words: a power of two
    /// [default: a word, or 64 on ECP5]
    #[arg(long, value_name = "B")]
    pub stream_bits: Option<u32>,
    /// Segments of the activation tables, a power of two [default: enough for 2 output steps]
    #[arg(long, value_name = "S")]
    pub segments: Option<u32>,
}

fn width_setting(text: &str) -> Result<WidthSetting, String> {
    let (layer, bits) = match text.rsplit_once('=') {
        Some((layer, bits)) => (Some(layer.to_owned()), bits),
        None => (None, text),
    };
    match bits.parse() {
        Ok(bits) => Ok(WidthSetting { layer, bits }),
        Err(_) => Err("a number of bits, or <layer>=<bits>, expected".into()),
    }
}

impl Request {
    /// The network, and the design that it leads to.
    ///
    /// # Errors
    /// If weights or options are refused.
    pub fn design(&self) -> Result<(FloatNet, Design), Failure> {
        self.design_called(None, None)
    }

    /// The same of another name than the file's, or with another prefix of its modules than the name.
    ///
    /// # Errors
    /// If weights or options are refused.
    pub fn design_called(
        &self,
        name: Option<&str>,
        prefix: Option<&str>,
    ) -> Result<(FloatNet, Design), Failure> {
        let mut net = read_weights(&self.weights)?;
        if let Some(name) = name {
            name.clone_into(&mut net.name);
        }
        let options = Options {
            prefix: prefix.map(str::to_owned),
            ..self.options()
        };
        let design = Design::new(&net, &options)?;
        Ok((net, design))
    }

    fn options(&self) -> Options {
        let interval = self.interval.map(Budget::Interval);
        let multipliers = self.multipliers.map(Budget::Multipliers);
        let device = self.device.clone().filter(|name| name != device::GENERIC);
        let default = match device {
            Some(_) => Budget::Device,
            None => Budget::default(),
        };
        Options {
            device,
            budget: interval.or(multipliers).unwrap_or(default),
            weight_bits: self.weight_bits.clone(),
            activation_bits: self.activation_bits.clone(),
            segments: self.segments,
            stream_bits: self.stream_bits,
            output_bits: self.output_bits,
            prefix: None,
        }
    }
}

/// Reads a weights file.
///
/// # Errors
/// If it can't be read or is refused.
pub fn read_weights(path: &Path) -> Result<FloatNet, Failure> {
    let mut text = Vec::new();
    // One byte more than is allowed is enough to refuse it.
    let most = u64::try_from(weights::MAX_BYTES).map_or(u64::MAX, |most| most + 1);
    File::open(path)
        .and_then(|file| file.take(most).read_to_end(&mut text))
        .map_err(|e| Failure::io(path, &e))?;
    weights::read(&text).map_err(|e| Failure::weights(path, &e))
}
