//! The landing problem: where is the camera, given the pixels of a few known landmarks?
//!
//! This crate knows cameras and poses, and no bits: it makes the samples, trains the networks
//! that `hwgen-spec` describes, and says how good any answer can be.
//!
//! ```
//! use hwgen_pose::sample::{NoiseShape, Sampler};
//! use hwgen_pose::scene_file;
//! use hwgen_pose::solve::Estimator;
//! use hwgen_pose::solve::ml::Ml;
//!
//! let text = include_bytes!("../../designs/landing/scene.toml");
//! let scene = scene_file::read(text, |name| Err(format!("no file {name}")))?.into_scene();
//! let sample = Sampler::new(&scene, NoiseShape::Gaussian, 1)?.draw(0);
//!
//! // Without noise the maximum of the likelihood is the pose itself.
//! let pose = Ml::new(&scene).estimate(&sample.clean_px).expect("an answer");
//! assert!((pose.position_m - sample.pose.position_m).norm() < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

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
