//! The landing problem: where is the camera, given the pixels of a few known landmarks?
//!
//! This crate knows cameras and poses, and no bits: it makes the samples, trains the networks
//! that `hwgen-spec` describes, and says how good any answer can be.

pub mod camera_file;
pub mod convert;
mod document;
pub mod error;
pub mod evaluate;
pub mod frames;
pub mod observe;
pub mod sample;
pub mod scene;
pub mod scene_file;
pub mod solve;
pub mod train;
