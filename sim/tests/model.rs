//! The cycle model against the untimed values, over random designs and all flows.

use hwgen_sim::model::{Model, Pins};
use hwgen_sim::session;
use hwgen_sim::stimulus::{Effort, segments};
use hwgen_spec::design::Design;
use hwgen_spec::options::{Budget, Options};
use hwgen_spec::weights;

#[test]
fn the_landing_design_answers_as_the_untimed_model_does() {
    let text = include_bytes!("../../designs/landing/weights.json");
    let net = weights::read(text).expect("the project's own weights");
    let design = Design::new(&net, &Options::default()).expect("defaults work");
    for segment in segments(&design, &[], 40, 1, Effort::Usual) {
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

/// Registers in between are worked out when they are looked at: no step may depend on a look.
#[test]
fn values_do_not_depend_on_having_been_looked_at() {
    let text = include_bytes!("../../designs/landing/weights.json");
    let net = weights::read(text).expect("the project's own weights");
    let design = Design::new(&net, &Options::default()).expect("defaults work");
    let values = |model: &Model| {
        let mut row = Vec::new();
        model.values(&mut row);
        row
    };
    for segment in segments(&design, &[], 12, 1, Effort::Usual) {
        let pins = session::run(&design, &segment).pins;
        let (mut watched, mut alone) = (Model::new(&design), Model::new(&design));
        for (clock, pins) in pins.iter().enumerate() {
            // Now and then a reset in the middle of everything.
            let reset_n = pins.reset_n && clock % 211 != 210;
            let pins = Pins {
                reset_n,
                ..pins.clone()
            };
            watched.step(&pins);
            alone.step(&pins);
            let seen = values(&watched);
            // The other one is looked at now and then, and only as a copy.
            if clock < 40 || clock % 17 == 0 {
                let copy = alone.clone();
                assert_eq!(values(&copy), seen, "{}, edge {clock}", segment.name);
            }
        }
        assert_eq!(values(&alone), values(&watched), "{}", segment.name);
    }
}

/// 1025 inputs a clock, accumulated, behind ROMs that are read in two: 17 clocks of four control bits.
#[test]
fn the_widest_array_with_the_slowest_rom_has_room_for_its_control_bits() {
    let row = format!("[{}]", ["0.01"; 2050].join(","));
    let text = format!(
        r#"{{"format": "hwgen-weights/1", "name": "wide",
          "inputs": {{"min": [{}], "max": [{}]}},
          "networks": [{{"name": "net", "layers": [
            {{"activation": "linear", "weights": [{}]}}]}}]}}"#,
        ["-1"; 2050].join(","),
        ["1"; 2050].join(","),
        [row.as_str(); 33].join(","),
    );
    let options = Options {
        device: Some("ecp5-85k".into()),
        budget: Budget::Interval(66),
        ..Options::default()
    };
    let net = weights::read(text.as_bytes()).expect("readable");
    let design = Design::new(&net, &options).expect("a legal design");
    let layer = design.perceptron().layers().next().expect("a layer");
    assert_eq!((layer.rom_latency, layer.tree_levels()), (2, 11));
    assert!(layer.accumulates());
    let segment = &segments(&design, &[], 2, 1, Effort::Usual)[0];
    let session = session::run(&design, segment);
    assert_eq!(session.difference, None);
    assert!(session.frames > 0);
}

/// Resets of 1 to 8 cycles at every cycle of an interval of the full core: the frames behind each are
/// answered rightly, and none is lost.
#[test]
fn the_frame_behind_a_reset_is_answered_rightly_whatever_its_length_and_moment() {
    let text = include_bytes!("../../designs/landing/weights.json");
    let net = weights::read(text).expect("the project's own weights");
    let design = Design::new(&net, &Options::default()).expect("defaults work");
    let all = segments(&design, &[], 0, 1, Effort::Thorough);
    let sweep = all.iter().filter(|s| s.name.starts_with("sweep"));
    let mut resets = std::collections::BTreeSet::new();
    for segment in sweep {
        let session = session::run(&design, segment);
        assert_eq!(session.difference, None, "{}", segment.name);
        assert_eq!(session.resets, segment.resets.planned().len());
        let planned = segment.resets.planned().iter();
        resets.extend(planned.map(|r| (r.after % design.interval_cycles(), r.cycles)));
    }
    assert_eq!(resets.len(), 8 * design.interval_cycles());
}

/// At power-up the core is as behind a reset.
#[test]
fn a_core_that_was_never_reset_answers_rightly() {
    let text = include_bytes!("../../designs/tiny/weights.json");
    let net = weights::read(text).expect("the project's own weights");
    let design = Design::new(&net, &Options::default()).expect("defaults work");
    let mut core = Model::new(&design);
    let mut pins = Pins::idle(&design);
    let codes = design.input().codes(&[60.0, 1.0]);
    let beats = codes.chunks(design.source().words_per_beat);
    for (i, beat) in beats.enumerate() {
        pins.s_valid = true;
        pins.s_last = i + 1 == design.source().beats();
        pins.s_data[..beat.len()].copy_from_slice(beat);
        while !core.ready() {
            core.step(&pins);
        }
        core.step(&pins);
    }
    pins.s_valid = false;
    for _ in 0..design.latency_cycles() {
        if core.output().is_some() {
            break;
        }
        core.step(&pins);
    }
    let answer = core.output().expect("an answer").data.to_vec();
    assert_eq!(answer, design.net().evaluate(&codes).codes);
}
