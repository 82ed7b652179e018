//! Bundles, checked by the whole chain.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use hwgen::harness::harness;
use hwgen_gen::Source;
use hwgen_sim::error::SimError;
use hwgen_sim::simulator::Simulator;
use hwgen_sim::stimulus::Effort;
use hwgen_sim::tool::Toolbox;
use hwgen_sim::verify::{Report, VerifyPlan, verify};
use hwgen_spec::design::{Design, Feed};
use hwgen_spec::network::FloatNet;
use hwgen_spec::options::{Budget, Options};

/// How a bundle is checked.
pub struct Check<'a> {
    pub random: usize,
    pub seed: u64,
    pub simulators: &'a [Simulator],
    pub effort: Effort,
}

/// Writes the bundle of a design below `directory`.
pub fn emit(net: &FloatNet, options: &Options, directory: &Path) -> PathBuf {
    let design = Design::new(net, options).expect("a legal design");
    let out = directory.join(design.name());
    hwgen_gen::generate(&design, net)
        .write(&out)
        .expect("a new directory");
    out
}

/// Checks a bundle that was read with its digests.
pub fn check(bundle: &Path, check: &Check<'_>) -> Result<Report, SimError> {
    let source = Source::read(bundle).expect("a bundle as it was emitted");
    check_source(bundle, &source, check)
}

/// Checks a bundle whatever its digests.
pub fn check_source(bundle: &Path, source: &Source, check: &Check<'_>) -> Result<Report, SimError> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let plan = VerifyPlan {
        bundle: bundle.to_owned(),
        sources: source.rtl(),
        harness: harness(source),
        design: &source.design,
        net: &source.net,
        vectors: Vec::new(),
        random: check.random,
        seed: check.seed,
        effort: check.effort,
        simulators: check.simulators.to_vec(),
        toolbox: &Toolbox::new(root),
        work_dir: bundle.with_extension("work"),
        cache_dir: bundle.with_extension("cache"),
        timeout: Duration::from_secs(600),
    };
    verify(&plan, &mut |_| {})
}

/// A report that must say that everything is equal.
pub fn assert_verified(report: &Report, what: &str) {
    assert!(report.verified, "{what}: {report:#?}");
    for run in &report.runs {
        assert!(
            run.frames > 0 && run.edges > 0 && run.registers > 0,
            "{what}: {run:?}"
        );
    }
}

/// What a design has, of all that designs may have: the axes of the matrix.
pub fn axes(net: &FloatNet, design: &Design) -> BTreeSet<&'static str> {
    let mut axes = BTreeSet::new();
    let mut mark = |axis: &'static str, has: bool| {
        if has {
            axes.insert(axis);
        }
    };
    let plan = design.perceptron();
    mark("shared layers", !plan.shared.is_empty());
    mark("no shared layer", plan.shared.is_empty());
    let device = design.device();
    mark("multipliers in blocks", device.has_multipliers());
    mark("multipliers left to synthesis", !device.has_multipliers());
    mark(
        "multipliers that show their result alone",
        device.hides_operands(),
    );
    mark("several networks", plan.networks.len() > 1);
    let budget = design.options().budget;
    mark("the device's multipliers", budget == Budget::Device);
    mark("some multipliers", matches!(budget, Budget::Multipliers(_)));
    mark("interval 1", design.interval_cycles() == 1);
    for port in [design.source(), design.sink()] {
        let per_beat = port.words_per_beat;
        mark("a word a beat", per_beat == 1 && port.beats() > 1);
        mark("several words a beat", per_beat > 1 && port.beats() > 1);
        mark("lanes without a word", per_beat * port.beats() > port.words);
    }
    let floats = net.networks.iter().flat_map(|n| &n.layers);
    for layer in net.shared.iter().chain(floats) {
        mark("fixed weights", layer.format.weights.is_some());
        mark("fixed biases", layer.format.bias.is_some());
        mark("fixed words", layer.format.activations.is_some());
    }
    for layer in plan.layers() {
        let (quant, fold) = (&layer.quant, layer.fold);
        let sizes = [quant.inputs(), quant.outputs()];
        mark(quant.activation.name(), true);
        mark("replay feed", layer.feed == Feed::Replay);
        mark("direct feed", layer.feed == Feed::Direct);
        mark("hold feed", layer.feed == Feed::Hold);
        if let Some(adders) = layer.adders() {
            mark("sums by adders", true);
            mark("adders in levels", adders.levels > 1);
            mark("sums of nothing", adders.outputs.contains(&None));
        }
        mark(
            "activations' multipliers in logic",
            layer.activation_in_logic && quant.table.is_some(),
        );
        mark("words by way of a copy", layer.gather_latency > 1);
        mark("segments in several tables", layer.segment_latency > 1);
        mark(
            "neurons that take turns",
            layer.turns() > 1 && layer.accumulates(),
        );
        mark("no copies of operands", layer.copy_latency == 0);
        mark("registered tables of a ROM", layer.rom_latency > 1);
        let tables = device.pieces_of_rom(layer.folds()).len();
        mark(
            "several memories of a ROM",
            tables > 1 && layer.rom_latency == 1,
        );
        mark("accumulators", layer.accumulates());
        mark("no accumulators", !layer.accumulates());
        mark("drain", layer.drain_beats() > 1);
        mark(
            "beats of padding",
            layer.output_beats() < layer.array_beats(),
        );
        mark("1-wide layers", sizes.contains(&1));
        mark(
            "prime sizes",
            sizes.iter().any(|s| [7, 11, 13, 17].contains(s)),
        );
        mark(
            "PE does not divide the outputs",
            !quant.outputs().is_multiple_of(fold.pe),
        );
        mark(
            "SIMD does not divide the inputs",
            !quant.inputs().is_multiple_of(fold.simd),
        );
        mark("odd adder trees", fold.simd > 1 && fold.simd % 2 == 1);
        mark("three levels of a tree", layer.tree_levels() >= 3);
        mark("shifts per neuron", quant.max_extra_shift() > 0);
        mark("product shifts", quant.product_shift > 0);
        mark("shared_in", quant.name == "shared_in");
        mark("_out", quant.name.ends_with("_out"));
    }
    axes
}

/// Does the same for every item, as many at a time as there are cores; answers in order.
pub fn in_parallel<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let answers: Vec<Mutex<Option<R>>> = items.iter().map(|_| Mutex::new(None)).collect();
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                loop {
                    let at = next.fetch_add(1, Ordering::Relaxed);
                    let Some(item) = items.get(at) else {
                        return;
                    };
                    *answers[at].lock().expect("no panic yet") = Some(work(item));
                }
            });
        }
    });
    answers
        .into_iter()
        .map(|a| a.into_inner().expect("no panic").expect("all done"))
        .collect()
}
