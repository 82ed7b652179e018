//! What was driven, counted.

use hwgen_spec::design::Design;

use super::report::Stimulus;
use crate::model::Model;
use crate::session::Session;
use crate::stimulus::{Flow, Pairs, Segment, tables};

/// Counts pairs of conditions and resets; what should have occurred and did not is named.
pub fn summary(design: &Design, segments: &[Segment], sessions: &[Session]) -> Stimulus {
    let mut pairs = Pairs::default();
    let mut missing = Vec::new();
    let mut registers_reset = 0;
    let changed = |lane: usize| {
        let mut runs = sessions.iter();
        runs.any(|session| session.reset_lanes.get(lane) == Some(&true))
    };
    for (segment, session) in segments.iter().zip(sessions) {
        pairs.add(&session.pairs);
        let lanes = segment.reset_lanes.iter();
        let never: Vec<usize> = lanes
            .enumerate()
            .filter(|(lane, wanted)| **wanted && !changed(*lane))
            .map(|(lane, _)| lane)
            .collect();
        registers_reset += segment.reset_lanes.iter().filter(|lane| **lane).count() - never.len();
        if let Some(lane) = never.first() {
            missing.push(format!("a reset of {}", register_of(design, *lane)));
        }
    }
    // A quick look does not cross them.
    let crossed = segments.iter().any(|s| s.flow == Flow::Crossed);
    let never = pairs.missing(design).into_iter().filter(|_| crossed);
    missing.extend(never.map(|(a, b)| format!("a frame that is {a:?} and {b:?}")));
    let (kinds, least) = pairs.summary();
    let whole = segments.iter().flat_map(|segment| &segment.frames);
    let inputs = design.input().low.len();
    let whole = whole.filter(|frame| frame.beats == design.source().beats());
    let codes = whole.map(|frame| frame.lanes[..inputs].to_vec());
    let (segments_read, all_segments) = tables::coverage(design, codes);
    Stimulus {
        pairs: kinds,
        least_of_a_pair: least,
        resets: sessions.iter().map(|s| s.resets).sum(),
        words_reset: registers_reset,
        segments_read,
        segments: all_segments,
        missing,
    }
}

/// Path of the register that a lane belongs to.
fn register_of(design: &Design, lane: usize) -> String {
    let mut end = 0;
    let registers = Model::new(design).registers().into_iter();
    let mut registers = registers.skip_while(|register| {
        end += register.lanes.len();
        end <= lane
    });
    registers.next().map_or_else(String::new, |r| r.path)
}
