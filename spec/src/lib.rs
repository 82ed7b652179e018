//! What hwgen computes, in which format, in which cycle: the contract that generator and model meet in.
//!
//! [`weights`] reads a file into a float [`network`]; [`quantize`] turns it into integers whose
//! words have a [`mod@format`]; [`eval`] computes with them, untimed; [`folding`] and [`schedule`]
//! lay them out in hardware and time, within what a [`device`] holds; a [`design::Design`] is all of that, checked.
//! A [`deviation`] says how far its outputs are from those of the float network.
//!
//! The worked example stands at [`design::Design`].

pub mod activation;
pub mod adders;
pub mod design;
pub mod deviation;
pub mod device;
pub mod eval;
pub mod folding;
pub mod format;
pub mod json;
pub mod keywords;
pub mod network;
pub mod options;
pub mod quantize;
pub mod schedule;
pub mod weights;
