//! Training: samples of a scene to the networks that answer it.

mod cholesky;
pub mod data;
mod integer;
pub mod learner;
mod levenberg;
mod normal;
mod perceptron;
pub mod recipe;
mod rprop;
mod tanh;
mod training;

pub use integer::IntegerFront;
pub use levenberg::Levenberg;
pub use perceptron::{Batch, Perceptron, Shape, Slope};
pub use rprop::Rprop;
pub use training::{BadCheckpoint, Checkpoint, NETWORKS, RESOLUTION_PX, Training};
