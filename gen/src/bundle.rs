//! A bundle of files, written whole or not at all.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use hwgen_spec::design::{Design, DesignError};
use hwgen_spec::network::FloatNet;
use hwgen_spec::weights::{self, WeightsError};

use crate::manifest::{BUNDLE_FORMAT, Manifest};
use crate::{design_digest, sha256};

/// One text file of a bundle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct File {
    /// Path below the bundle's directory, with `/`.
    pub path: String,
    /// Its contents, ending in a newline.
    pub text: String,
}

/// The files of one design.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bundle {
    design: String,
    digest: String,
    files: Vec<File>,
}

/// Why a bundle could not be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BundleError {
    /// There is something at the place where the bundle should go.
    #[error("{path}: a new directory expected, an existing one found")]
    Exists {
        /// Where.
        path: PathBuf,
    },
    /// `--force` was given, but what is there is no bundle.
    #[error(
        "{path}: a bundle to replace expected, a directory without a bundle's manifest.json found"
    )]
    NotABundle {
        /// Where.
        path: PathBuf,
    },
    /// The file system refused.
    #[error("{path}: {source}")]
    Io {
        /// What was being written or read.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// There is no manifest, or one that can't be read.
    #[error("{path}: a manifest of the format {BUNDLE_FORMAT} expected, {found} found")]
    Manifest {
        /// The manifest.
        path: PathBuf,
        /// What it is instead.
        found: String,
    },
    /// A file is not what the manifest says.
    #[error("{path}: a file of digest {expected} expected, {found} found")]
    Changed {
        /// The file.
        path: PathBuf,
        /// The manifest's digest.
        expected: String,
        /// The file's, or why there is none.
        found: String,
    },
    /// The weights in the bundle can't be read.
    #[error("{path}: {source}")]
    Weights {
        /// The weights file.
        path: PathBuf,
        /// Why not.
        source: Box<WeightsError>,
    },
    /// The weights in the bundle don't make a design.
    #[error(transparent)]
    Design(Box<DesignError>),
    /// The bundle was made by another version of the tool, or its options were changed.
    #[error(
        "{path}: design digest {expected} expected from its weights and options, {found} found"
    )]
    Stale {
        /// The manifest.
        path: PathBuf,
        /// What weights and options lead to.
        expected: String,
        /// What the manifest says.
        found: String,
    },
}

impl BundleError {
    /// One line that says how to mend it.
    pub fn help(&self) -> String {
        match self {
            Self::Exists { .. } => "choose another --out, or replace it with --force".into(),
            Self::NotABundle { .. } => {
                "--force replaces bundles only: remove the directory yourself".into()
            }
            Self::Io { .. } => "check that the path exists and that you may use it".into(),
            Self::Manifest { .. } => "give the directory that `hwgen emit` wrote".into(),
            Self::Changed { .. } | Self::Stale { .. } => {
                "emit the bundle again, or renew the digest in manifest.json if you mean it".into()
            }
            Self::Weights { source, .. } => source.help().unwrap_or("emit again").to_owned(),
            Self::Design(e) => e.help(),
        }
    }
}

impl Bundle {
    pub(crate) fn new(design: &str, digest: String, files: Vec<File>) -> Self {
        Self {
            design: design.to_owned(),
            digest,
            files,
        }
    }

    /// Name of the design.
    pub fn design(&self) -> &str {
        &self.design
    }

    /// Digest of what the design was made from.
    pub fn digest(&self) -> &str {
        &self.digest
    }

    /// All files, the manifest last.
    pub fn files(&self) -> &[File] {
        &self.files
    }

    /// Writes the bundle to a directory that does not exist yet.
    ///
    /// The files are written beside it and the directory is renamed when it is whole.
    ///
    /// # Errors
    /// [`BundleError::Exists`] or [`BundleError::Io`]; nothing is left behind then.
    pub fn write(&self, out: &Path) -> Result<(), BundleError> {
        if out.symlink_metadata().is_ok() {
            return Err(BundleError::Exists {
                path: out.to_owned(),
            });
        }
        let aside = self.write_aside(out)?;
        rename(&aside.keep(), out)
    }

    /// Writes the bundle, in place of one that may be there.
    ///
    /// # Errors
    /// [`BundleError::NotABundle`] if something else is there, or [`BundleError::Io`].
    pub fn replace(&self, out: &Path) -> Result<(), BundleError> {
        if out.symlink_metadata().is_err() {
            return self.write(out);
        }
        let empty = fs::read_dir(out).map_err(io_error(out))?.next().is_none();
        if !empty && !is_bundle(out) {
            return Err(BundleError::NotABundle {
                path: out.to_owned(),
            });
        }
        let aside = self.write_aside(out)?;
        let old = tempfile::Builder::new()
            .prefix(".hwgen-old-")
            .tempdir_in(parent(out))
            .map_err(io_error(out))?;
        let parked = old.path().join("bundle");
        rename(out, &parked)?;
        let aside = aside.keep();
        rename(&aside, out).inspect_err(|_| {
            // Put the old one back; the error tells of the new one.
            let _ = fs::rename(&parked, out);
            let _ = fs::remove_dir_all(&aside);
        })
    }

    fn write_aside(&self, out: &Path) -> Result<tempfile::TempDir, BundleError> {
        let parent = parent(out);
        fs::create_dir_all(&parent).map_err(io_error(&parent))?;
        let aside = tempfile::Builder::new()
            .prefix(".hwgen-new-")
            .tempdir_in(&parent)
            .map_err(io_error(&parent))?;
        for file in &self.files {
            let path = aside.path().join(&file.path);
            let directory = path.parent().expect("a file stands in a directory");
            fs::create_dir_all(directory).map_err(io_error(directory))?;
            fs::write(&path, &file.text).map_err(io_error(&path))?;
        }
        // A temporary directory is private; a bundle is as public as its parent makes it.
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = fs::metadata(aside.path().join("rtl"))
                .map_err(io_error(out))?
                .permissions();
            let mode = fs::Permissions::from_mode(mode.mode());
            fs::set_permissions(aside.path(), mode).map_err(io_error(out))?;
        }
        Ok(aside)
    }
}

/// A bundle read back: what it was made from, and a manifest that its files agree with.
#[derive(Clone, Debug)]
pub struct Source {
    /// The manifest.
    pub manifest: Manifest,
    /// The float network.
    pub net: FloatNet,
    /// The design that weights and options lead to.
    pub design: Design,
}

impl Source {
    /// Reads a bundle and checks every file against the manifest.
    ///
    /// # Errors
    /// [`BundleError`] if a file is missing or changed, or the bundle is another version's.
    pub fn read(directory: &Path) -> Result<Self, BundleError> {
        let path = directory.join("manifest.json");
        let manifest = |found: String| BundleError::Manifest {
            path: path.clone(),
            found,
        };
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Err(manifest("none".into())),
            Err(e) => return Err(manifest(e.to_string())),
        };
        let read: Manifest = serde_json::from_str(&text).map_err(|e| manifest(e.to_string()))?;
        if read.format != BUNDLE_FORMAT {
            return Err(manifest(format!("`{}`", read.format)));
        }
        for file in &read.files {
            let path = directory.join(&file.path);
            let found = match fs::read_to_string(&path) {
                Ok(text) => sha256(&text),
                Err(e) => e.to_string(),
            };
            if found != file.sha256 {
                return Err(BundleError::Changed {
                    path,
                    expected: file.sha256.clone(),
                    found,
                });
            }
        }
        let weights_path = directory.join("weights.json");
        let weights = fs::read_to_string(&weights_path).map_err(io_error(&weights_path))?;
        let net = weights::read(weights.as_bytes()).map_err(|source| BundleError::Weights {
            path: weights_path,
            source: Box::new(source),
        })?;
        let design =
            Design::new(&net, &read.options).map_err(|e| BundleError::Design(Box::new(e)))?;
        let expected = design_digest(&design, &weights);
        if expected != read.digest {
            return Err(BundleError::Stale {
                path,
                expected,
                found: read.digest,
            });
        }
        Ok(Self {
            manifest: read,
            net,
            design,
        })
    }
}

/// Whether there is a manifest of ours, of whatever version: other programs have a
/// `manifest.json` too.
fn is_bundle(directory: &Path) -> bool {
    let family = BUNDLE_FORMAT.split('/').next();
    fs::read_to_string(directory.join("manifest.json"))
        .ok()
        .and_then(|text| serde_json::from_str::<serde_json::Value>(&text).ok())
        .and_then(|manifest| Some(manifest.get("format")?.as_str()?.split('/').next() == family))
        .unwrap_or(false)
}

fn parent(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

fn rename(from: &Path, to: &Path) -> Result<(), BundleError> {
    fs::rename(from, to).map_err(io_error(to))
}

fn io_error(path: &Path) -> impl FnOnce(io::Error) -> BundleError {
    let path = path.to_owned();
    move |source| BundleError::Io { path, source }
}
