//! What can be wrong with a scene, a sample request or a training.

use hwgen_spec::json::Fault;

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

impl Field {
    /// What belongs there, for those who have to mend it.
    pub fn help(self) -> &'static str {
        match self {
            Self::Name => "the trained design and its modules get this name",
            Self::Landmarks => {
                "give four or more landmarks that lie on no line, each as [x, y, z] in metres"
            }
            Self::Landmark(_) => "each landmark is a place of its own, [x, y, z] in metres",
            Self::Camera(_) => "lengths are in pixels, and image and focal length above zero",
            Self::Poses(0) => "write [nearest, farthest] in metres",
            Self::Poses(_) => "write [least, greatest] in degrees",
            Self::Margin => "landmarks have to be this many pixels inside the image",
        }
    }

    /// Short stable name of the kind of error there.
    pub fn code(self) -> &'static str {
        match self {
            Self::Name => "bad-name",
            Self::Landmarks | Self::Landmark(_) => "bad-landmarks",
            Self::Camera(_) => "bad-camera",
            Self::Poses(_) => "bad-poses",
            Self::Margin => "bad-margin",
        }
    }
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

/// A refused file: the scene's, or the calibration's that it names.
///
/// Displayed as `<path>: <what was expected>, <what was found>`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{fault}")]
pub struct FileError {
    file: Option<String>,
    fault: Box<Fault>,
}

impl From<Fault> for FileError {
    fn from(fault: Fault) -> Self {
        Self {
            file: None,
            fault: Box::new(fault),
        }
    }
}

impl FileError {
    /// The same error in a file that the one at hand names.
    #[must_use]
    pub fn in_file(mut self, name: &str) -> Self {
        self.file = Some(name.to_owned());
        self
    }

    /// The file at fault as the one at hand names it, if it is another.
    pub fn file(&self) -> Option<&str> {
        self.file.as_deref()
    }

    /// What is wrong, and where: code, message, path, line, column, help.
    pub fn fault(&self) -> &Fault {
        &self.fault
    }
}
