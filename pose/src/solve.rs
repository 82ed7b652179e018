//! Classical answers to the landing problem, and how good any answer can be.
//!
//! They are what a network is compared with: closed forms ([`epnp`], [`sqpnp`]), iteration to the
//! best fit ([`ml`]), the best that the pose box and the noise allow ([`bayes`]), consensus among
//! mismatched landmarks ([`ransac`]), and the bound of unbiased answers ([`crb`]).

pub mod bayes;
pub mod crb;
pub mod epnp;
pub mod ml;
pub mod p3p;
pub mod ransac;
pub mod sqpnp;

pub mod fit;
mod placement;
mod prior;

use crate::frames::Pose;

/// Something that tells the pose from the pixels of all landmarks of its scene.
pub trait Estimator: Sync {
    /// The name that tables show.
    fn name(&self) -> &'static str;

    /// The pose that `[u0, v0, u1, v1, ...]` were seen from; `None` where there is no answer.
    ///
    /// # Shape
    /// `[2n]` for the scene's `n` landmarks
    ///
    /// # Units
    /// px
    fn estimate(&self, pixels: &[f64]) -> Option<Pose>;
}
