//! What hwgen computes, in which format, in which cycle.

pub mod format;
pub mod json;
pub mod keywords;
pub mod network;
pub mod weights;
