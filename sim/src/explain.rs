//! What a register holds: layer, neuron, input, and the format of its word.

use hwgen_spec::design::{Design, Layer};

use crate::record::Recording;

/// The meaning of one lane of a register at one clock, as far as it can be told.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Meaning {
    /// The network.
    pub network: Option<String>,
    /// The layer.
    pub layer: Option<String>,
    /// The neuron.
    pub neuron: Option<usize>,
    /// The input whose operand or weight it is.
    pub input: Option<usize>,
    /// Fraction bits of the word.
    pub fraction: Option<i32>,
}

/// Explains lane `lane` of the register `path` after rising edge `clock`.
///
/// The group of neurons is read from the address and beat counters of the recording, as many
/// clocks back as the register is behind them.
pub fn explain(
    design: &Design,
    recording: &Recording,
    path: &str,
    lane: usize,
    clock: usize,
) -> Meaning {
    let mut meaning = Meaning::default();
    let Some((scope, rest)) = path
        .strip_prefix("u_mlp.u_")
        .and_then(|p| p.split_once('.'))
    else {
        if path == "u_ingress.word_q" {
            meaning.input = Some(lane);
            meaning.fraction = design.input().formats.get(lane).map(|f| f.fraction());
        }
        return meaning;
    };
    let waiting = ["_answers", "_known"];
    if let Some(network) = waiting.iter().find_map(|end| scope.strip_suffix(end)) {
        if let Some(plan) = design
            .perceptron()
            .networks
            .iter()
            .find(|n| n.name == network)
        {
            let last = &plan.last().quant;
            meaning.network = Some(network.to_owned());
            meaning.layer = Some(last.name.clone());
            if rest.starts_with("g_word[") && lane < last.outputs() {
                meaning.neuron = Some(lane);
                meaning.fraction = Some(last.output.fraction());
            }
        }
        return meaning;
    }
    let (name, gathered) = match scope.strip_suffix("_gather") {
        Some(name) => (name, true),
        None => (scope, false),
    };
    let Some(layer) = design.perceptron().layers().find(|l| l.quant.name == name) else {
        return meaning;
    };
    meaning.network = Some(layer.quant.network.clone());
    meaning.layer = Some(name.to_owned());
    if gathered {
        // What is beyond the last neuron is padding of the last beat.
        if rest == "slot_q" && lane < layer.quant.outputs() {
            meaning.neuron = Some(lane);
            meaning.fraction = Some(layer.quant.output.fraction());
        }
        return meaning;
    }
    let history = History {
        recording,
        scope,
        clock,
    };
    Place { layer, history }.explain(rest, lane, &mut meaning);
    meaning
}

/// Counters of a layer in the past.
struct History<'a> {
    recording: &'a Recording,
    scope: &'a str,
    clock: usize,
}

impl History<'_> {
    /// Value of a counter of the layer so many clocks ago.
    fn counter(&self, name: &str, clocks_ago: usize) -> Option<usize> {
        let path = format!("u_mlp.u_{}.{name}", self.scope);
        let register = self
            .recording
            .registers()
            .iter()
            .position(|r| r.path == path)?;
        // Before the first clock all registers are zero.
        let Some(clock) = self.clock.checked_sub(clocks_ago) else {
            return Some(0);
        };
        usize::try_from(self.recording.values(clock, register)[0]).ok()
    }

    fn fold(&self, clocks_ago: usize) -> Option<usize> {
        self.counter("u_replay.address_q", clocks_ago)
            .or_else(|| self.counter("u_beats.address_q", clocks_ago))
            .or_else(|| self.counter("u_hold.address_q", clocks_ago))
    }

    fn beat(&self, clocks_ago: usize) -> Option<usize> {
        self.counter("u_requant.beat_q", clocks_ago)
    }
}

struct Place<'a> {
    layer: &'a Layer,
    history: History<'a>,
}

/// The number in brackets behind `prefix`, and what follows the dot behind it.
fn indexed<'a>(path: &'a str, prefix: &str) -> Option<(usize, &'a str)> {
    let (number, rest) = path.strip_prefix(prefix)?.split_once("].")?;
    Some((number.parse().ok()?, rest))
}

impl Place<'_> {
    fn explain(&self, path: &str, lane: usize, meaning: &mut Meaning) {
        let quant = &self.layer.quant;
        let (x, w) = (quant.input.fraction(), quant.weight_format.fraction());
        let numbered = |prefix: &str| {
            let (number, rest) = path.strip_prefix(prefix)?.split_once('.')?;
            Some((number.parse::<usize>().ok()?, rest))
        };
        match path {
            "operands_q" => {
                meaning.input = self.history.fold(1).and_then(|f| self.layer.input(lane, f));
                meaning.fraction = Some(x);
                return;
            }
            "u_replay.slot_q" | "u_hold.word_q" => {
                meaning.fraction = Some(x);
                return;
            }
            _ => {}
        }
        // Adders take the words as they are, times integers: the binary point stays where it was.
        if let Some(word) = path.strip_prefix("u_adders.") {
            let input = word
                .strip_prefix('x')
                .and_then(|rest| rest.split_once("_q"));
            meaning.input = input.and_then(|(number, _)| number.parse().ok());
            meaning.fraction = Some(x);
            return;
        }
        // Clocks behind the address: those of the copies and of the ROM, then a clock a register.
        let data = self.layer.operand_latency() + 1;
        if let Some((pe, "data_q")) = numbered("u_w") {
            self.array(pe, Some(lane), data, w, meaning);
        } else if let Some((pe, rest)) = numbered("u_pe") {
            if let Some((simd, register)) = indexed(rest, "g_mul[") {
                match register {
                    "u_mul.a_q" => {
                        self.array(pe, Some(simd), data + 1, x, meaning);
                        meaning.fraction = Some(x);
                    }
                    "u_mul.b_q" => self.array(pe, Some(simd), data + 1, w, meaning),
                    "u_mul.p_q" => self.array(pe, Some(simd), data + 2, x + w, meaning),
                    _ => self.array(pe, Some(simd), data + 3, x + w, meaning),
                }
            } else if let Some(level) = rest.strip_prefix("u_level") {
                let level = level
                    .split('.')
                    .next()
                    .and_then(|l| l.parse::<usize>().ok());
                self.array(pe, None, data + 3 + level.unwrap_or(0), x + w, meaning);
            } else if let Some(behind) = match rest {
                "operands_q" => Some(2),
                "operands_q2" => Some(3),
                "operands_q3" => Some(4),
                _ => None,
            } {
                let fold = self.history.fold(behind);
                meaning.input = fold.and_then(|f| self.layer.input(lane, f));
                meaning.fraction = Some(x);
            } else if rest.starts_with("u_acc") {
                let fold = self.fold_of_sum(data + 4 + self.layer.tree_levels(), lane);
                self.of_fold(pe, None, fold, x + w, meaning);
            }
        } else if path == "u_bias.data_q" || path == "u_requant.sum_q" {
            let up = if path == "u_bias.data_q" {
                quant.product_shift.cast_signed()
            } else {
                0
            };
            // A bias stands with a shift beside it where neurons have one.
            let plain = path == "u_requant.sum_q" || quant.max_extra_shift() == 0;
            self.lane(lane, 1, plain.then_some(x + w + up), meaning);
        } else if let Some((lane, register)) = indexed(path, "u_requant.g_lane[") {
            let up = quant.product_shift.cast_signed();
            let own = usize::from(quant.max_extra_shift() > 0);
            match register {
                "biased_q" => self.lane(lane, 2, Some(x + w + up), meaning),
                "value_q" | "negative_q" | "beyond_q" => {
                    self.lane(lane, 3 + own, None, meaning);
                    meaning.fraction = (register == "value_q").then_some(quant.pre.fraction());
                }
                "word_q" => {
                    self.lane(lane, 4 + own, None, meaning);
                    meaning.fraction = Some(quant.pre.fraction());
                }
                _ => {
                    self.lane(lane, 3, None, meaning);
                    meaning.fraction = (register == "g_extra.shifted_q").then_some(x + w + up);
                }
            }
        } else if let Some((unit, register)) = indexed(path, "g_act[") {
            let own = usize::from(quant.max_extra_shift() > 0);
            // Clocks behind the argument: of the segments' ROM, then a clock a register.
            let rom = 1 + self.layer.segment_latency;
            let (behind, fraction) = match register {
                "u_pwl.magnitude_q" => (1, Some(quant.pre.fraction())),
                "u_pwl.distance_q" => (2 + lane, Some(quant.pre.fraction())),
                table if table.starts_with("u_segments.table") => (2, None),
                "u_segments.above_q" => (2, None),
                "u_segments.data_q" => (rom, None),
                "u_mul.a_q" | "u_mul.b_q" => (rom + 1, None),
                "u_mul.p_q" if self.layer.activation_in_logic => (rom + 3, None),
                "u_mul.p_q" => (rom + 2, None),
                "u_mul.r_q" => (rom + 3, None),
                pair if pair.starts_with("u_mul.g_pair[") => (rom + 1, None),
                quad if quad.starts_with("u_mul.g_quad[") => (rom + 2, None),
                "u_pwl.sum_q" => (rom + 4, None),
                "u_pwl.y_q" => (rom + 5, Some(quant.output.fraction())),
                _ => return,
            };
            self.lane(unit, 4 + own + behind, None, meaning);
            meaning.fraction = fraction;
        }
    }

    /// A register of the array, `behind` clocks behind the address.
    fn array(
        &self,
        pe: usize,
        simd: Option<usize>,
        behind: usize,
        fraction: i32,
        meaning: &mut Meaning,
    ) {
        self.of_fold(pe, simd, self.history.fold(behind), fraction, meaning);
    }

    /// The clock of a frame whose sum stands in word `lane` of an accumulator.
    ///
    /// Where neurons take turns each further word is of the turn before; while no beat is offered the
    /// address is that of the next one, and the newest sum of the turn before it.
    fn fold_of_sum(&self, behind: usize, lane: usize) -> Option<usize> {
        let address = self.history.fold(behind)?;
        let turns = self.layer.turns();
        if turns == 1 {
            return Some(address);
        }
        let offered = self.history.counter("u_hold.left_q", behind)?;
        let newest = address + turns - usize::from(offered == 0);
        Some((newest - lane) % turns)
    }

    /// A register of the array that belongs to a clock of a frame.
    fn of_fold(
        &self,
        pe: usize,
        simd: Option<usize>,
        fold: Option<usize>,
        fraction: i32,
        meaning: &mut Meaning,
    ) {
        let Some(fold) = fold else {
            return;
        };
        meaning.neuron = self.layer.neuron(pe, fold);
        meaning.input = simd.and_then(|s| self.layer.input(s, fold));
        let extra = meaning
            .neuron
            .map_or(0, |n| self.layer.quant.extra_shift[n]);
        meaning.fraction = Some(fraction + extra.cast_signed());
    }

    /// A register of an output lane, `behind` clocks behind the beat counter.
    fn lane(&self, lane: usize, behind: usize, fraction: Option<i32>, meaning: &mut Meaning) {
        let Some(beat) = self.history.beat(behind) else {
            return;
        };
        let neuron = beat * self.layer.lanes + lane;
        if neuron < self.layer.quant.outputs() {
            meaning.neuron = Some(neuron);
            let extra = self.layer.quant.extra_shift[neuron];
            meaning.fraction = fraction.map(|f| f + extra.cast_signed());
        }
    }
}
