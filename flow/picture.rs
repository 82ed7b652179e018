//! Pictures: SVG of a page, the same bytes for the same numbers.
//!
//! They have a white ground of their own, so that they are read on dark pages too, and the colours
//! of M. Okabe and K. Ito (2008), which colour-blind readers tell apart. Drawing crates round to
//! whole pixels and know no axis that is broken at zero, hence this one.

pub mod errors;
pub mod floorplan;
pub mod training;
pub mod view;

mod axis;
mod svg;

const BLACK: &str = "#000000";
const GREY: &str = "#6b6b6b";
const RULE: &str = "#e2e2e2";
const BLUE: &str = "#0072b2";
const SKY: &str = "#56b4e9";
const GREEN: &str = "#009e73";
const ORANGE: &str = "#e69f00";
const VERMILLION: &str = "#d55e00";
const PURPLE: &str = "#cc79a7";
