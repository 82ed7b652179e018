//! What the default formats cost on the landing networks, and what narrower ones do.

use hwgen_spec::design::Design;
use hwgen_spec::options::{Options, WidthSetting};
use hwgen_spec::weights;

mod support;

/// Mean relative errors of position and orientation against truth, in per cent.
#[derive(Clone, Copy, Debug)]
struct Errors {
    position: f64,
    orientation: f64,
}

impl Errors {
    /// Of answers `[x y z rx ry rz]` for truths.
    fn of(rows: &[([f64; 6], [f64; 6])]) -> Self {
        let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let mean = |part: std::ops::Range<usize>| {
            let relative = rows.iter().map(|(truth, answer)| {
                let error: Vec<f64> = part.clone().map(|i| answer[i] - truth[i]).collect();
                norm(&error) / norm(&truth[part.clone()])
            });
            #[expect(clippy::cast_precision_loss, reason = "hundreds")]
            let count = rows.len() as f64;
            100.0 * relative.sum::<f64>() / count
        };
        Self {
            position: mean(0..3),
            orientation: mean(3..6),
        }
    }

    /// By how many per cent these are worse than others.
    fn beyond(self, other: Self) -> [f64; 2] {
        let percent = |a: f64, b: f64| 100.0 * (a / b - 1.0);
        [
            percent(self.position, other.position),
            percent(self.orientation, other.orientation),
        ]
    }
}

struct Row {
    noise_px: f64,
    pixels: Vec<f64>,
    truth: [f64; 6],
    float: [f64; 6],
}

fn rows() -> Vec<Row> {
    let text = String::from_utf8(support::landing("vectors.csv")).expect("text");
    let six = |row: &[f64], first: usize| row[first..first + 6].try_into().expect("six");
    text.lines()
        .skip(1)
        .map(|line| {
            let row: Vec<f64> = line
                .split(',')
                .map(|v| v.parse().expect("a number"))
                .collect();
            Row {
                noise_px: row[0],
                pixels: row[1..11].to_vec(),
                truth: six(&row, 11),
                float: six(&row, 17),
            }
        })
        .collect()
}

/// What quantization adds to the float networks' errors at a noise level, in per cent of them, and
/// the number of frames with a clipped input and with a saturated word.
fn cost(options: &Options, noise_px: f64) -> ([f64; 2], usize, usize) {
    let float = weights::read(&support::landing("weights.json")).expect("a weights file");
    let design = Design::new(&float, options).expect("a design");
    let rows: Vec<Row> = rows()
        .into_iter()
        .filter(|r| r.noise_px == noise_px)
        .collect();
    assert_eq!(rows.len(), 100, "frames with {noise_px} px of noise");
    let frames: Vec<Vec<i64>> = rows
        .iter()
        .map(|r| design.input().codes(&r.pixels))
        .collect();
    let answers = design.net().evaluate_batch(&frames);
    let found: Vec<([f64; 6], [f64; 6])> = rows
        .iter()
        .zip(&answers)
        .map(|(row, answer)| {
            let real = design.net().real_outputs(&answer.codes);
            (row.truth, real.try_into().expect("six"))
        })
        .collect();
    let reference: Vec<_> = rows.iter().map(|r| (r.truth, r.float)).collect();
    let cost = Errors::of(&found).beyond(Errors::of(&reference));
    println!(
        "{noise_px} px: position {:+.2} %, orientation {:+.2} %",
        cost[0], cost[1]
    );
    (
        cost,
        answers.iter().filter(|a| a.input_clipped).count(),
        answers.iter().filter(|a| a.saturated).count(),
    )
}

fn widths(weights: u32, activations: u32) -> Options {
    let all = |bits| vec![WidthSetting { layer: None, bits }];
    Options {
        weight_bits: all(weights),
        activation_bits: all(activations),
        ..Options::default()
    }
}

#[test]
fn default_formats_cost_less_than_a_hundredth() {
    for noise_px in [0.0, 1.0] {
        let (cost, clipped, saturated) = cost(&Options::default(), noise_px);
        assert!(cost.iter().all(|c| *c < 1.0), "{noise_px} px: {cost:?} %");
        assert_eq!((clipped, saturated), (0, 0), "{noise_px} px");
    }
}

#[test]
fn no_frame_of_the_file_is_clipped_or_saturated() {
    let mut levels: Vec<f64> = rows().iter().map(|r| r.noise_px).collect();
    levels.dedup();
    assert_eq!(levels.len(), 5);
    for noise_px in levels {
        let (_, clipped, saturated) = cost(&Options::default(), noise_px);
        assert_eq!((clipped, saturated), (0, 0), "{noise_px} px");
    }
}

#[test]
fn narrow_words_cost_what_they_should() {
    let (wide, ..) = cost(&widths(18, 18), 0.0);
    let (twelve, ..) = cost(&widths(12, 12), 0.0);
    let (eight, ..) = cost(&widths(8, 8), 0.0);
    // What is left is the rounding of the pixels.
    assert!(wide.iter().all(|c| *c < 1.0), "W18/A18: {wide:?} %");
    assert!(
        twelve.iter().all(|c| *c > 10.0 && *c < 200.0),
        "W12/A12: {twelve:?} %"
    );
    assert!(eight.iter().all(|c| *c > 100.0), "W8/A8: {eight:?} %");
}

/// The worked conversion of docs/interface.md is the first row of the file.
#[test]
fn the_documented_conversion_is_what_the_core_says() {
    let float = weights::read(&support::landing("weights.json")).expect("a weights file");
    let design = Design::new(&float, &Options::default()).expect("a design");
    let row = &rows()[0];
    let codes = design.input().codes(&row.pixels);
    let answer = design.net().evaluate(&codes);
    let metres = design.net().real_outputs(&answer.codes)[0];
    let input = design.input().formats[0];
    let output = design.perceptron().networks[0].last().quant.output;
    let line = format!(
        "/* u0 = {:.4} px in {input} is {}.  position.x = {} in {output} is {metres:.6} m. */",
        row.pixels[0], codes[0], answer.codes[0]
    );
    let page = String::from_utf8(support::landing("../../docs/interface.md")).expect("text");
    assert!(page.contains(&line), "docs/interface.md: expected {line}");
}
