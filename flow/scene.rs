//! Scene files and the camera files beside them.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use hwgen_pose::error::FileError;
use hwgen_pose::sample::{NoiseShape, Sampler};
use hwgen_pose::scene::Scene;
use hwgen_pose::scene_file::{self, MAX_BYTES};

use crate::failure::Failure;

/// A scene file that was read.
#[derive(Clone, Debug)]
pub struct SceneFile {
    path: PathBuf,
    file: scene_file::SceneFile,
}

impl SceneFile {
    /// Reads a scene file, and the camera file that it names relative to itself.
    ///
    /// # Errors
    /// If either can't be read or is refused.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let text = bytes(path).map_err(|e| Failure::io(path, &e))?;
        let camera = |name: &str| {
            let camera = beside(path, name);
            bytes(&camera).map_err(|e| format!("{}: {e}", camera.display()))
        };
        match scene_file::read(&text, camera) {
            Ok(file) => Ok(Self {
                path: path.to_owned(),
                file,
            }),
            Err(error) => Err(failure(path, &error)),
        }
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        self.file.scene()
    }

    /// Where it was read from.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A sampler of the scene.
    ///
    /// # Errors
    /// If the landmarks are almost never in view.
    pub fn sampler(&self, shape: NoiseShape, seed: u64) -> Result<Sampler<'_>, Failure> {
        Sampler::new(self.scene(), shape, seed)
            .map_err(|error| failure(&self.path, &self.file.never_in_view(&error)))
    }
}

/// One byte more than is allowed is enough to refuse a file.
fn bytes(path: &Path) -> io::Result<Vec<u8>> {
    let most = u64::try_from(MAX_BYTES).map_or(u64::MAX, |most| most + 1);
    let mut text = Vec::new();
    File::open(path)?.take(most).read_to_end(&mut text)?;
    Ok(text)
}

fn beside(scene: &Path, name: &str) -> PathBuf {
    scene.parent().unwrap_or(Path::new("")).join(name)
}

fn failure(scene: &Path, error: &FileError) -> Failure {
    let fault = error.fault();
    let file = match error.file() {
        Some(name) => beside(scene, name),
        None => scene.to_owned(),
    };
    let mut failure =
        Failure::input(fault.code, fault.message.as_str()).file(file.display().to_string());
    failure.path = Some(fault.path.clone());
    failure.line = Some(fault.line);
    failure.column = Some(fault.column);
    failure.help.clone_from(&fault.help);
    failure
}
