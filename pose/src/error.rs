//! What can be wrong with a scene, a sample request or a training.

/// The field of a scene that an error is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Field {
    /// `name`
    Name,
    /// `landmarks` as a whole.
    Landmarks,
    /// One landmark, by index.
    Landmark(usize),
    /// A field of `[camera]`.
    Camera(&'static str),
    /// A range of `[poses]`, by parameter index.
    Poses(usize),
    /// `margin_px` of `[poses]`.
    Margin,
}

impl std::fmt::Display for Field {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Name => write!(f, "name"),
            Self::Landmarks => write!(f, "landmarks"),
            Self::Landmark(i) => write!(f, "landmarks[{i}]"),
            Self::Camera(key) => write!(f, "camera.{key}"),
            Self::Poses(0) => write!(f, "poses.distance_m"),
            Self::Poses(i) => write!(f, "poses.{}_deg", crate::scene::PARAMETER_NAMES[*i]),
            Self::Margin => write!(f, "poses.margin_px"),
        }
    }
}

/// A scene that cannot be: which field, and what was expected and found there.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{field}: {reason}")]
pub struct SceneError {
    /// The field at fault.
    pub field: Field,
    /// What was expected and what was found.
    pub reason: String,
}

impl SceneError {
    /// An error at a field.
    pub fn new(field: Field, reason: String) -> Self {
        Self { field, reason }
    }
}
