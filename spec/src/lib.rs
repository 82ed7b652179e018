//! What hwgen computes, in which format, in which cycle.

pub mod activation;
pub mod design;
pub mod eval;
pub mod folding;
pub mod format;
pub mod network;
pub mod options;
pub mod quantize;
pub mod schedule;
