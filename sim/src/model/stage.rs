//! The perceptron stage: `<design>_mlp`.

use hwgen_spec::design::{Layer, Perceptron};
use hwgen_spec::device::Device;
use hwgen_spec::schedule::Schedule;

use super::feed::Gather;
use super::layer::{Beat, LayerModel};
use super::probe::{Probe, within};
use super::stream::{Admit, Count, Queue};

/// A layer and, where a whole vector is wanted behind it, its gathering.
#[derive(Clone, Debug)]
struct Node {
    name: String,
    layer: LayerModel,
    gather: Option<Gather>,
    /// Whether the layer takes beats, not whole vectors.
    streams: bool,
    /// The node in front; `None` reads the input frame.
    before: Option<usize>,
}

/// What enters the stage in a clock.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry<'a> {
    pub(super) valid: bool,
    pub(super) words: &'a [i64],
    pub(super) clipped: bool,
    pub(super) error: bool,
}

#[derive(Clone, Debug)]
pub(super) struct StageModel {
    admit: Admit,
    frames: Queue,
    nodes: Vec<Node>,
    answers: Vec<Answers>,
}

/// What a network has answered.
#[derive(Clone, Debug)]
struct Answers {
    network: String,
    /// Its last node.
    last: usize,
    queue: Queue,
    /// How many wait.
    known: Count,
}

impl StageModel {
    pub(super) fn new(stage: &Perceptron, schedule: &Schedule, device: &Device) -> Self {
        let mut nodes: Vec<Node> = Vec::new();
        let mut answers = Vec::new();
        let mut push = |layer: &Layer, before, readers: &[&Layer]| {
            let quant = &layer.quant;
            let starts = Layer::gather_starts(readers);
            nodes.push(Node {
                name: quant.name.clone(),
                layer: LayerModel::new(layer, device),
                gather: (starts > 0).then(|| Gather::new(layer, starts)),
                streams: !layer.reads_whole(),
                before,
            });
            nodes.len() - 1
        };
        let mut shared = None;
        for (i, layer) in stage.shared.iter().enumerate() {
            let readers: Vec<&Layer> = match stage.shared.get(i + 1) {
                Some(next) => vec![next],
                None => stage.networks.iter().map(|n| &n.layers[0]).collect(),
            };
            shared = Some(push(layer, shared, &readers));
        }
        for network in &stage.networks {
            let mut before = shared;
            for (i, layer) in network.layers.iter().enumerate() {
                let readers: Vec<&Layer> = network.layers.get(i + 1).into_iter().collect();
                before = Some(push(layer, before, &readers));
            }
            let last = &network.last().quant;
            let mut widths = vec![last.output.width(); last.outputs()];
            widths.push(1);
            answers.push(Answers {
                network: network.name.clone(),
                last: before.expect("a layer"),
                queue: Queue::new(&widths, schedule.fifo_depth),
                known: Count::new(schedule.fifo_depth, 0),
            });
        }
        Self {
            admit: Admit::new(schedule.interval, schedule.credits),
            frames: Queue::new(&[1, 1], schedule.fifo_depth),
            nodes,
            answers,
        }
    }

    /// Whether a frame that is offered starts.
    #[inline]
    pub(super) fn ready(&self) -> bool {
        self.admit.ready()
    }

    /// Whether an answer is offered.
    #[inline]
    pub(super) fn valid(&self) -> bool {
        self.answers.iter().all(|answers| answers.known.some())
    }

    /// Flags of the answer that is offered: error, saturated.
    #[inline]
    pub(super) fn user(&self) -> i64 {
        let (clipped, error) = (self.frames.head()[0], self.frames.head()[1]);
        let saturated = self
            .answers
            .iter()
            .any(|answers| answers.queue.head().last() == Some(&1));
        error << 1 | (clipped | i64::from(saturated))
    }

    /// Writes the words of the answer that is offered.
    #[inline]
    pub(super) fn answer(&self, words: &mut [i64]) {
        let codes = self.answers.iter().flat_map(|answers| {
            let head = answers.queue.head();
            &head[..head.len() - 1]
        });
        for (word, code) in words.iter_mut().zip(codes) {
            *word = *code;
        }
    }

    /// `leaves`: the answer that is offered is taken.
    #[inline]
    pub(super) fn step(&mut self, reset: bool, entry: Entry<'_>, leaves: bool) {
        let start = entry.valid && self.admit.ready();
        for answers in &mut self.answers {
            let gather = self.nodes[answers.last]
                .gather
                .as_ref()
                .expect("answers are gathered");
            answers.known.step(reset, gather.start(), leaves);
            answers.queue.step(reset, gather.start(), leaves, |slot| {
                let (flag, words) = slot.split_last_mut().expect("a flag");
                words.copy_from_slice(gather.vector());
                *flag = i64::from(gather.flag());
            });
        }
        for i in (0..self.nodes.len()).rev() {
            let (fore, rest) = self.nodes.split_at_mut(i);
            let node = &mut rest[0];
            if let Some(gather) = &mut node.gather {
                let beat = node.layer.beat();
                let next = node.layer.next();
                gather.step(reset, next, (beat.valid, beat.flag, beat.words));
            }
            let input = match node.before.map(|b| &fore[b]) {
                None => Beat {
                    valid: start,
                    flag: false,
                    words: entry.words,
                },
                Some(before) if node.streams => before.layer.beat(),
                Some(before) => {
                    let gather = before.gather.as_ref().expect("a vector is wanted");
                    Beat {
                        valid: gather.start(),
                        flag: gather.flag(),
                        words: gather.vector(),
                    }
                }
            };
            node.layer.step(reset, input);
        }
        self.frames.step(reset, start, leaves, |slot| {
            slot[0] = i64::from(entry.clipped);
            slot[1] = i64::from(entry.error);
        });
        self.admit.step(reset, start, leaves);
    }

    /// `reset`: the reset's copies; `starts`, `leaves`: whether a frame does so in this clock.
    pub(super) fn show<P: Probe>(&self, reset: bool, starts: bool, leaves: bool, probe: &mut P) {
        probe.bit("rst_q2", reset);
        for node in &self.nodes {
            probe.bit(&format!("{}_rst_q2", node.name), reset);
        }
        probe.bit("start_q", starts);
        probe.bit("leave_q", leaves);
        probe.bit("release_q", leaves);
        for Answers { network: name, .. } in &self.answers {
            probe.bit(&format!("{name}_leave_q"), leaves);
            probe.bit(&format!("{name}_rst_q2"), reset);
        }
        within(probe, format_args!("u_admit"), |p| self.admit.show(p));
        within(probe, format_args!("u_frames"), |p| self.frames.show(p));
        for node in &self.nodes {
            node.layer.show(probe);
            if let Some(gather) = &node.gather {
                within(probe, format_args!("u_{}_gather", node.name), |p| {
                    gather.show(p)
                });
            }
        }
        for answers in &self.answers {
            let name = &answers.network;
            within(probe, format_args!("u_{name}_answers"), |p| {
                answers.queue.show(p)
            });
            within(probe, format_args!("u_{name}_known"), |p| {
                answers.known.show(p)
            });
        }
    }
}
