//! What the camera sees: horizon, deck and landmarks in some poses.

use hwgen_pose::frames::Pose;
use hwgen_pose::sample::{Sample, Sampler};
use hwgen_pose::scene::Scene;
use nalgebra::{Matrix3, Vector3};

use super::axis::Axis;
use super::svg::{Anchor, Font, Marker, Pen, Point, Svg};
use super::{BLACK, GREY, VERMILLION};

/// Poses shown, two a line.
const POSES: usize = 4;
/// Poses that they are chosen from.
const CANDIDATES: u64 = 64;

const WIDTH: f64 = 920.0;
const TOP: f64 = 62.0;
const LEFT: f64 = 58.0;
/// Room of an image with its axes and its caption.
const CELL_WIDTH: f64 = 446.0;
const IMAGE_WIDTH: f64 = 384.0;
const CAPTION: f64 = 74.0;

const SKY: &str = "#e8f1fa";
const SEA: &str = "#c3d4e0";
const DECK: &str = "#f2ead8";
const DECK_EDGE: Pen = Pen::new("#8a7a55", 1.0);
const SMALL: Font = Font::new(10.0, Anchor::Middle);

/// The images of four poses, from near to far, with noise of a size.
///
/// A square beside the landmarks shows the last one magnified, with and without noise.
pub fn picture(sampler: &Sampler<'_>, noise_px: f64) -> String {
    let camera = sampler.scene().camera();
    let scale = IMAGE_WIDTH / camera.width_px;
    let cell_height = camera.height_px * scale + CAPTION;
    #[expect(clippy::cast_precision_loss, reason = "two lines")]
    let height = TOP + POSES.div_ceil(2) as f64 * cell_height;
    let name = sampler.scene().name();
    let title = format!("Landmarks of the scene {name} as the camera sees them");
    let description = "Simulated camera images of four poses, from near to far: horizon, deck, \
                       landmarks with and without noise.";
    let mut svg = Svg::new(WIDTH, height, &title, description);
    let bold = Font::new(15.0, Anchor::Start).bold();
    svg.words((LEFT, 24.0), bold, &format!("{name}: what the camera sees"));
    legend(&mut svg, noise_px);
    for (i, sample) in samples(sampler).iter().enumerate() {
        #[expect(clippy::cast_precision_loss, reason = "two a line")]
        let (column, line) = ((i % 2) as f64, (i / 2) as f64);
        let corner = (LEFT + column * CELL_WIDTH, TOP + line * cell_height);
        let image = Image::new(sampler.scene(), &sample.pose, corner, scale);
        image.draw(&mut svg, sample, noise_px);
    }
    svg.finish()
}

/// Poses at the quantiles of distance.
fn samples(sampler: &Sampler<'_>) -> Vec<Sample> {
    let mut drawn: Vec<Sample> = (0..CANDIDATES).map(|index| sampler.draw(index)).collect();
    drawn.sort_by(|a, b| a.parameters[0].total_cmp(&b.parameters[0]));
    let step = (drawn.len() - 1) / (POSES - 1);
    drawn.into_iter().step_by(step).take(POSES).collect()
}

fn legend(svg: &mut Svg, noise_px: f64) {
    let y = 43.0;
    let font = Font::new(11.0, Anchor::Start);
    svg.marker(Marker::Circle, (LEFT + 6.0, y), 4.0, BLACK, false);
    svg.words((LEFT + 16.0, y + 4.0), font, "landmark");
    svg.marker(Marker::Cross, (LEFT + 92.0, y), 3.0, VERMILLION, true);
    let label = format!("as seen with noise of {noise_px} px");
    svg.words((LEFT + 102.0, y + 4.0), font, &label);
    svg.rectangle((LEFT + 270.0, y - 5.0), (18.0, 10.0), DECK, Some(DECK_EDGE));
    svg.words(
        (LEFT + 294.0, y + 4.0),
        font,
        "deck at the height of the landing site",
    );
}

/// One camera image on the page.
struct Image<'a> {
    scene: &'a Scene,
    /// `C_N^C` and the camera's position.
    turn: Matrix3<f64>,
    position_m: Vector3<f64>,
    right: Axis,
    up: Axis,
    corner: Point,
    size: Point,
}

impl<'a> Image<'a> {
    fn new(scene: &'a Scene, pose: &Pose, (left, top): Point, scale: f64) -> Self {
        let camera = scene.camera();
        let size = (camera.width_px * scale, camera.height_px * scale);
        Self {
            scene,
            turn: scene.camera_from_body().matrix() * pose.deck_from_body.matrix().transpose(),
            position_m: pose.position_m,
            right: Axis::linear((0.0, camera.width_px), (left, left + size.0)),
            // u points up.
            up: Axis::linear((0.0, camera.height_px), (top + size.1, top)),
            corner: (left, top),
            size,
        }
    }

    fn place(&self, u_px: f64, v_px: f64) -> Point {
        (self.right.at(v_px), self.up.at(u_px))
    }

    /// Where a point in camera coordinates is seen, if it is ahead.
    fn seen(&self, point_m: &Vector3<f64>) -> Option<Point> {
        let pixel = self.scene.camera().pixel(point_m)?;
        Some(self.place(pixel.x, pixel.y))
    }

    fn landmark(&self, landmark_m: &Vector3<f64>) -> Option<Point> {
        self.seen(&(self.turn * (landmark_m - self.position_m)))
    }

    fn draw(&self, svg: &mut Svg, sample: &Sample, noise_px: f64) {
        let caption = caption(sample);
        svg.begin_group(&caption);
        svg.begin_clip(self.corner, self.size.0, self.size.1);
        self.ground(svg);
        self.marks(svg, sample, noise_px);
        self.magnified(svg, sample, noise_px);
        svg.end_group();
        self.axes(svg, &caption);
        svg.end_group();
    }

    /// Sky, sea, deck, and the lines by which landmarks stand on it.
    fn ground(&self, svg: &mut Svg) {
        svg.rectangle(self.corner, self.size, SKY, None);
        let horizon = self.horizon();
        if let [first, .., last] = horizon[..] {
            // The sea goes on below the image.
            let below = self.corner.1 + 2.0 * self.size.1 + (first.1 - last.1).abs();
            let mut sea = horizon.clone();
            sea.extend([(last.0, below), (first.0, below)]);
            svg.area(&sea, SEA, 1.0);
            svg.curve(&horizon, Pen::new(GREY, 1.0));
        }
        let deck: Option<Vec<Point>> = self.deck().iter().map(|c| self.landmark(c)).collect();
        if let Some(deck) = deck {
            svg.area(&deck, DECK, 1.0);
            let mut edge = deck;
            edge.extend(edge.first().copied());
            svg.curve(&edge, DECK_EDGE);
        }
        for landmark in self.scene.landmarks_m() {
            let foot = Vector3::new(landmark.x, 0.0, landmark.z);
            if let (Some(top), Some(foot)) = (self.landmark(landmark), self.landmark(&foot)) {
                svg.line(top, foot, DECK_EDGE);
            }
        }
    }

    /// The directions without height over the deck, from left of the image to right of it.
    fn horizon(&self) -> Vec<Point> {
        const STEPS: u32 = 32;
        let camera = self.scene.camera();
        // A third of an image beyond each edge, so that it is cut by the frame.
        let end = 4.0 / 3.0 * camera.width_px / camera.focal_v_px;
        let up = self.turn.column(1);
        (0..=STEPS)
            .filter_map(|i| {
                let z = end * (2.0 * f64::from(i) / f64::from(STEPS) - 1.0) / 2.0;
                let y = -(up.x + up.z * z) / up.y;
                self.seen(&Vector3::new(1.0, y, z))
                    .filter(|(x, y)| x.is_finite() && y.is_finite())
            })
            .collect()
    }

    /// The rectangle below the landmarks, at height 0, a metre wider than they are.
    fn deck(&self) -> [Vector3<f64>; 4] {
        const MARGIN_M: f64 = 1.0;
        let (mut low, mut high) = (Vector3::zeros(), Vector3::zeros());
        for landmark in self.scene.landmarks_m() {
            (low, high) = (low.inf(landmark), high.sup(landmark));
        }
        let margin = Vector3::repeat(MARGIN_M);
        let (low, high) = (low - margin, high + margin);
        [
            Vector3::new(low.x, 0.0, low.z),
            Vector3::new(low.x, 0.0, high.z),
            Vector3::new(high.x, 0.0, high.z),
            Vector3::new(high.x, 0.0, low.z),
        ]
    }

    /// The landmarks with and without noise, and their numbers, away from the middle of all.
    fn marks(&self, svg: &mut Svg, sample: &Sample, noise_px: f64) {
        const APART: f64 = 11.0;
        let places = |pixels: &[f64]| -> Vec<Point> {
            let pixels = pixels.chunks_exact(2);
            pixels.map(|pixel| self.place(pixel[0], pixel[1])).collect()
        };
        let clean = places(&sample.clean_px);
        #[expect(clippy::cast_precision_loss, reason = "a few landmarks")]
        let count = clean.len() as f64;
        let middle = clean.iter().fold((0.0, 0.0), |(x, y), at| {
            (x + at.0 / count, y + at.1 / count)
        });
        let noisy = places(&sample.noisy_px(noise_px));
        for (number, (clean, noisy)) in clean.into_iter().zip(noisy).enumerate() {
            svg.marker(Marker::Circle, clean, 3.6, BLACK, false);
            svg.marker(Marker::Cross, noisy, 2.4, VERMILLION, true);
            let (dx, dy) = (clean.0 - middle.0, clean.1 - middle.1);
            let apart = APART / dx.hypot(dy).max(1.0);
            let beside = (clean.0 + apart * dx, clean.1 + apart * dy + 3.5);
            svg.words(beside, SMALL, &number.to_string());
        }
    }

    /// The surroundings of the last landmark, in the lower corner that is farther from it.
    fn magnified(&self, svg: &mut Svg, sample: &Sample, noise_px: f64) {
        const SIDE: f64 = 62.0;
        let last = self.scene.landmarks_m().len() - 1;
        let pixel = &sample.clean_px[2 * last..];
        let noisy = &sample.noisy_px(noise_px)[2 * last..];
        let bottom = self.corner.1 + self.size.1 - SIDE - 6.0;
        let middle = self.corner.0 + self.size.0 / 2.0;
        let left = if self.right.at(pixel[1]) > middle {
            self.corner.0 + 6.0
        } else {
            self.corner.0 + self.size.0 - SIDE - 6.0
        };
        let corner = (left, bottom);
        svg.rectangle(corner, (SIDE, SIDE), "#ffffff", Some(Pen::new(GREY, 1.0)));
        svg.begin_clip(corner, SIDE, SIDE);
        // Half of what the square shows, and the length of its scale.
        let unit_px = if noise_px > 0.0 { noise_px } else { 1.0 };
        let range = (-3.0 * unit_px, 3.0 * unit_px);
        let x = Axis::linear(range, (left, left + SIDE));
        let y = Axis::linear(range, (bottom + SIDE, bottom));
        svg.marker(Marker::Circle, (x.at(0.0), y.at(0.0)), 3.6, BLACK, false);
        let seen = (x.at(noisy[1] - pixel[1]), y.at(noisy[0] - pixel[0]));
        svg.marker(Marker::Cross, seen, 3.4, VERMILLION, true);
        let (middle, ruler) = (x.at(0.0), bottom + SIDE - 5.0);
        let pen = Pen::new(BLACK, 1.0);
        svg.line((middle, ruler), (x.at(unit_px), ruler), pen);
        let font = Font { size: 8.5, ..SMALL };
        let scale = Font {
            anchor: Anchor::End,
            ..font
        };
        svg.words((middle - 4.0, ruler + 2.0), scale, &format!("{unit_px} px"));
        svg.words((middle, bottom + 10.0), font, &format!("landmark {last}"));
        svg.end_group();
    }

    fn axes(&self, svg: &mut Svg, caption: &str) {
        let pen = Pen::new(BLACK, 1.0);
        let (left, bottom) = (self.corner.0, self.corner.1 + self.size.1);
        svg.rectangle(self.corner, self.size, "none", Some(pen));
        for tick in self.right.ticks(8) {
            let x = self.right.at(tick);
            svg.line((x, bottom), (x, bottom + 4.0), pen);
            svg.words((x, bottom + 14.0), SMALL, &tick.to_string());
        }
        for tick in self.up.ticks(5) {
            let y = self.up.at(tick);
            svg.line((left - 4.0, y), (left, y), pen);
            svg.words(
                (left - 7.0, y + 3.5),
                Font {
                    anchor: Anchor::End,
                    ..SMALL
                },
                &tick.to_string(),
            );
        }
        let middle = left + self.size.0 / 2.0;
        svg.words((middle, bottom + 28.0), SMALL, "v, px");
        let side = (left - 36.0, bottom - self.size.1 / 2.0);
        svg.words(side, SMALL.upright(), "u, px");
        svg.words(
            (middle, bottom + 46.0),
            Font {
                size: 11.0,
                ..SMALL
            },
            caption,
        );
    }
}

fn caption(sample: &Sample) -> String {
    let q = &sample.parameters;
    let deg = |i: usize| format!("{:.1}°", q[i].to_degrees() + 0.0).replace('-', "−");
    format!(
        "{:.1} m, elevation {}, azimuth {}; roll {}, pitch {}, yaw {}",
        q[0],
        deg(1),
        deg(2),
        deg(3),
        deg(4),
        deg(5),
    )
}
