//! Shapes and words to SVG.

use std::fmt::{self, Display, Write};

/// A place on the page, from its upper left corner.
pub type Point = (f64, f64);

/// A picture that is being drawn.
#[derive(Clone, Debug)]
pub struct Svg {
    text: String,
    clips: usize,
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pen {
    pub colour: &'static str,
    pub width: f64,
    /// Lengths of dashes and gaps, or nothing.
    pub dashes: &'static str,
}

impl Pen {
    pub const fn new(colour: &'static str, width: f64) -> Self {
        Self {
            colour,
            width,
            dashes: "",
        }
    }

    pub const fn dashed(self, dashes: &'static str) -> Self {
        Self { dashes, ..self }
    }
}

impl Display for Pen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            r#"stroke="{}" stroke-width="{}""#,
            self.colour,
            Number(self.width)
        )?;
        if !self.dashes.is_empty() {
            write!(f, r#" stroke-dasharray="{}""#, self.dashes)?;
        }
        Ok(())
    }
}

/// Where the given point is in a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

/// How words are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Font {
    pub size: f64,
    pub anchor: Anchor,
    pub colour: &'static str,
    pub bold: bool,
    /// From bottom to top.
    pub upright: bool,
}

impl Font {
    pub const fn new(size: f64, anchor: Anchor) -> Self {
        Self {
            size,
            anchor,
            colour: super::BLACK,
            bold: false,
            upright: false,
        }
    }

    pub const fn bold(self) -> Self {
        Self { bold: true, ..self }
    }

    pub const fn upright(self) -> Self {
        Self {
            upright: true,
            ..self
        }
    }
}

/// A mark at a point of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    Circle,
    Square,
    Diamond,
    Triangle,
    Cross,
    Star,
}

/// A coordinate in hundredths, without superfluous digits.
struct Number(f64);

impl Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        debug_assert!(self.0.is_finite(), "a place on the page expected");
        let hundredths = (100.0 * self.0).round() / 100.0;
        // No minus zero.
        write!(f, "{}", hundredths + 0.0)
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

impl Svg {
    /// A white page; title and description are for those who do not see it.
    pub fn new(width: f64, height: f64, title: &str, description: &str) -> Self {
        let (w, h) = (Number(width), Number(height));
        let mut text = String::new();
        // Writing to memory does not fail.
        let _ = write!(
            text,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" \
             viewBox=\"0 0 {w} {h}\" role=\"img\" \
             font-family=\"Helvetica, Arial, 'DejaVu Sans', sans-serif\">\n\
             <title>{}</title>\n<desc>{}</desc>\n\
             <rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>\n",
            escaped(title),
            escaped(description),
        );
        Self { text, clips: 0 }
    }

    /// The picture.
    pub fn finish(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }

    fn put(&mut self, element: fmt::Arguments<'_>) {
        let _ = writeln!(self.text, "{element}");
    }

    /// Begins a group whose parts outside of a rectangle are not seen.
    pub fn begin_clip(&mut self, (x, y): Point, width: f64, height: f64) {
        self.clips += 1;
        let (id, x, y) = (self.clips, Number(x), Number(y));
        self.put(format_args!(
            r#"<clipPath id="clip{id}"><rect x="{x}" y="{y}" width="{}" height="{}"/></clipPath>"#,
            Number(width),
            Number(height)
        ));
        self.put(format_args!(r#"<g clip-path="url(#clip{id})">"#));
    }

    /// Begins a group with a name, for those who do not see it.
    pub fn begin_group(&mut self, title: &str) {
        self.put(format_args!("<g><title>{}</title>", escaped(title)));
    }

    /// Ends the last group.
    pub fn end_group(&mut self) {
        self.put(format_args!("</g>"));
    }

    pub fn rectangle(&mut self, (x, y): Point, size: Point, fill: &str, pen: Option<Pen>) {
        let pen = pen.map(|pen| format!(" {pen}")).unwrap_or_default();
        self.put(format_args!(
            r#"<rect x="{}" y="{}" width="{}" height="{}" fill="{fill}"{pen}/>"#,
            Number(x),
            Number(y),
            Number(size.0),
            Number(size.1)
        ));
    }

    pub fn line(&mut self, a: Point, b: Point, pen: Pen) {
        self.put(format_args!(
            r#"<line x1="{}" y1="{}" x2="{}" y2="{}" {pen}/>"#,
            Number(a.0),
            Number(a.1),
            Number(b.0),
            Number(b.1)
        ));
    }

    pub fn curve(&mut self, points: &[Point], pen: Pen) {
        self.put(format_args!(
            r#"<polyline points="{}" fill="none" stroke-linejoin="round" {pen}/>"#,
            places(points)
        ));
    }

    pub fn area(&mut self, points: &[Point], fill: &str, opacity: f64) {
        self.put(format_args!(
            r#"<polygon points="{}" fill="{fill}" fill-opacity="{}"/>"#,
            places(points),
            Number(opacity)
        ));
    }

    /// A mark of a half-width, hollow unless it is filled.
    pub fn marker(
        &mut self,
        marker: Marker,
        at: Point,
        size: f64,
        colour: &'static str,
        filled: bool,
    ) {
        let (x, y) = at;
        let fill = if filled { colour } else { "#ffffff" };
        let pen = Pen::new(colour, 1.6);
        let shape = |points: &[Point]| {
            let points: Vec<Point> = points
                .iter()
                .map(|(dx, dy)| (x + size * dx, y + size * dy))
                .collect();
            places(&points)
        };
        let polygon: &[Point] = match marker {
            Marker::Circle => {
                let (x, y, r) = (Number(x), Number(y), Number(size));
                return self.put(format_args!(
                    r#"<circle cx="{x}" cy="{y}" r="{r}" fill="{fill}" {pen}/>"#
                ));
            }
            Marker::Cross => {
                self.line((x - size, y - size), (x + size, y + size), pen);
                return self.line((x - size, y + size), (x + size, y - size), pen);
            }
            Marker::Star => &[
                (0.0, -1.2),
                (0.28, -0.39),
                (1.14, -0.37),
                (0.46, 0.15),
                (0.7, 0.97),
                (0.0, 0.48),
                (-0.7, 0.97),
                (-0.46, 0.15),
                (-1.14, -0.37),
                (-0.28, -0.39),
            ],
            Marker::Square => &[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)],
            Marker::Diamond => &[(0.0, -1.25), (1.25, 0.0), (0.0, 1.25), (-1.25, 0.0)],
            Marker::Triangle => &[(0.0, -1.15), (1.05, 0.8), (-1.05, 0.8)],
        };
        self.put(format_args!(
            r#"<polygon points="{}" fill="{fill}" stroke-linejoin="round" {pen}/>"#,
            shape(polygon)
        ));
    }

    pub fn words(&mut self, at: Point, font: Font, text: &str) {
        let (x, y) = (Number(at.0), Number(at.1));
        let anchor = match font.anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let weight = if font.bold {
            r#" font-weight="bold""#
        } else {
            ""
        };
        let turn = if font.upright {
            format!(r#" transform="rotate(-90 {x} {y})""#)
        } else {
            String::new()
        };
        self.put(format_args!(
            r#"<text x="{x}" y="{y}" font-size="{}" text-anchor="{anchor}" fill="{}"{weight}{turn}>{}</text>"#,
            Number(font.size),
            font.colour,
            escaped(text)
        ));
    }
}

fn places(points: &[Point]) -> String {
    let places: Vec<String> = points
        .iter()
        .map(|(x, y)| format!("{},{}", Number(*x), Number(*y)))
        .collect();
    places.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_words_are_escaped() {
        let mut svg = Svg::new(100.0, 50.0, "a < b & c", "");
        svg.words((1.0 / 3.0, -0.001), Font::new(10.0, Anchor::Middle), "<&>");
        let text = svg.finish();
        assert!(text.contains("<title>a &lt; b &amp; c</title>"), "{text}");
        assert!(
            text.contains(r#"<text x="0.33" y="0" font-size="10""#),
            "{text}"
        );
        assert!(text.contains(">&lt;&amp;&gt;</text>"), "{text}");
    }
}
