//! What hwgen computes, in which format, in which cycle.

pub mod format;
pub mod json;
pub mod network;
