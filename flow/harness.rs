//! What is simulated around the core of a bundle.

use hwgen_gen::Source;
use hwgen_sim::simulator::Text;
use hwgen_sim::verify::Harness;

/// Bench, program and models around a core: generated, whatever lies in the bundle.
pub fn harness(source: &Source) -> Harness {
    let texts = |folder| {
        let files = source.generated(folder).into_iter();
        files.map(|(name, text)| Text { name, text })
    };
    let file = |name: String| {
        let found = texts("tb").find(|file| file.name == name);
        found.unwrap_or_else(|| unreachable!("every bundle has {name}"))
    };
    let design = source.design.name();
    Harness {
        bench: file(format!("{design}_tb.v")),
        bench_icarus: file(format!("{design}_tb_icarus.v")),
        main_cpp: file("sim_main.cpp".into()),
        models: texts("sim").collect(),
    }
}
