//! What is driven: every pair of conditions and every reset that matters, on random designs.

#[path = "support/random.rs"]
mod random;

use hwgen_sim::session;
use hwgen_sim::stimulus::{Effort, segments};
use hwgen_sim::verify::summary;
use hwgen_spec::design::Design;
use rayon::prelude::*;

/// The model alone: no simulator is needed to see what is driven, nor whether its answers are right.
#[test]
fn every_pair_of_conditions_and_every_reset_occurs_in_a_hundred_random_designs() {
    let seeds: Vec<u64> = (0..100).collect();
    let failures = seeds.par_iter().map(|seed| {
        let (net, options) = random::random_design(*seed);
        let design = Design::new(&net, &options).expect("a legal design");
        let segments = segments(&design, &[], 4, *seed, Effort::Usual);
        let sessions: Vec<_> = segments.iter().map(|s| session::run(&design, s)).collect();
        let wrong = segments
            .iter()
            .zip(&sessions)
            .find_map(|(segment, session)| {
                let found = session.difference.as_ref()?;
                Some(format!("design {seed}: {}: {found:?}", segment.name))
            });
        let driven = summary(&design, &segments, &sessions);
        let missing = (!driven.missing.is_empty()).then(|| {
            format!(
                "design {seed}: {:?} of {} resets",
                driven.missing, driven.resets
            )
        });
        wrong.or(missing)
    });
    let failures: Vec<String> = failures.flatten().collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
