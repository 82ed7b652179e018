//! The cycle model against the untimed values, over random designs and all flows.

use hwgen_sim::session;
use hwgen_sim::stimulus::segments;
use hwgen_spec::design::Design;
use hwgen_spec::options::Options;
use hwgen_spec::weights;

#[test]
fn the_landing_design_answers_as_the_untimed_model_does() {
    let text = include_bytes!("../../designs/landing/weights.json");
    let net = weights::read(text).expect("the project's own weights");
    let design = Design::new(&net, &Options::default()).expect("defaults work");
    for segment in segments(&design, &[], 40, 1) {
        let session = session::run(&design, &segment);
        assert_eq!(session.difference, None, "{}", segment.name);
        assert!(session.frames > 0, "{}", segment.name);
        if let Some((least, most)) = session.interval {
            assert_eq!(
                (least, most),
                (design.interval_cycles(), design.interval_cycles())
            );
            assert_eq!(
                session.latency,
                Some(design.latency_cycles()),
                "{}",
                segment.name
            );
        }
    }
}
