//! A bundle of files, written whole or not at all.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use hwgen_spec::design::DesignError;
use hwgen_spec::weights::WeightsError;
use serde_json::Value;

use crate::manifest::BUNDLE_FORMAT;

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
    /// `--force` was given, but there are files that no emission wrote.
    #[error(
        "{path}: files of the bundle alone expected, others found: {}",
        named(files)
    )]
    Foreign {
        /// The bundle.
        path: PathBuf,
        /// The files below it that its manifest does not list.
        files: Vec<String>,
    },
    /// The path does not end in a name for the bundle's directory.
    #[error("{path}: a path that ends in a directory's name expected")]
    NoName {
        /// The path.
        path: PathBuf,
    },
    /// The new bundle could not be put in place, nor the old one put back.
    #[error("{source}; the old bundle is in {path}")]
    Parked {
        /// Where the old bundle is.
        path: PathBuf,
        /// Why the new one could not be put in place.
        source: io::Error,
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
    /// A file around the Verilog has another text than the design leads to.
    #[error("{path}:{line}: expected the text that hwgen generates, found another")]
    Differs {
        /// The file.
        path: PathBuf,
        /// The first line that differs, from 1.
        line: usize,
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
    /// The manifest says what its weights and options don't lead to.
    #[error("{path}: {field}: {expected} expected from its weights and options, {found} found")]
    Altered {
        /// The manifest.
        path: PathBuf,
        /// The first field that differs.
        field: String,
        /// What weights and options lead to.
        expected: String,
        /// What the manifest says.
        found: String,
    },
    /// There is a source file that the manifest does not list.
    #[error(
        "{path}: only files that the manifest lists expected in `rtl`, `sim` and `tb`, another found"
    )]
    Unlisted {
        /// The file.
        path: PathBuf,
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
            Self::Foreign { .. } => "--force would delete them: move them elsewhere first".into(),
            Self::NoName { .. } => "name the directory that is to be made".into(),
            Self::Parked { path, .. } => format!("move {} back", path.display()),
            Self::Unlisted { .. } => "move the file elsewhere: tools read all of rtl/*.v".into(),
            Self::Altered { .. } | Self::Differs { .. } => "emit the bundle again".into(),
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
    /// [`BundleError::Exists`], [`BundleError::NoName`] or [`BundleError::Io`]; nothing is left
    /// behind then.
    pub fn write(&self, out: &Path) -> Result<(), BundleError> {
        check_name(out)?;
        if out.symlink_metadata().is_ok() {
            return Err(BundleError::Exists {
                path: out.to_owned(),
            });
        }
        let aside = self.write_aside(out)?;
        rename(aside.path(), out)?;
        // It is no longer where it would be deleted.
        let _ = aside.keep();
        Ok(())
    }

    /// Writes the bundle, in place of one that may be there.
    ///
    /// # Errors
    /// [`BundleError::NotABundle`] if something else is there, [`BundleError::Foreign`] if
    /// something else is in it, or as [`write`](Self::write).
    pub fn replace(&self, out: &Path) -> Result<(), BundleError> {
        check_name(out)?;
        if out.symlink_metadata().is_err() {
            return self.write(out);
        }
        let there = files_below(out, "")?;
        if !there.is_empty() && !is_bundle(out) {
            return Err(BundleError::NotABundle {
                path: out.to_owned(),
            });
        }
        let ours = listed(out);
        let foreign = |file: &String| file != "manifest.json" && !ours.contains(file);
        let files: Vec<String> = there.into_iter().filter(foreign).collect();
        if !files.is_empty() {
            return Err(BundleError::Foreign {
                path: out.to_owned(),
                files,
            });
        }
        let aside = self.write_aside(out)?;
        let old = tempfile::Builder::new()
            .prefix(".hwgen-old-")
            .tempdir_in(parent(out))
            .map_err(io_error(out))?;
        let parked = old.path().join("bundle");
        rename(out, &parked)?;
        if let Err(source) = fs::rename(aside.path(), out) {
            return Err(match fs::rename(&parked, out) {
                Ok(()) => io_error(out)(source),
                Err(_) => {
                    let _ = old.keep();
                    BundleError::Parked {
                        path: parked,
                        source,
                    }
                }
            });
        }
        let _ = aside.keep();
        Ok(())
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

/// The files that a manifest lists, of whatever version.
fn listed(directory: &Path) -> Vec<String> {
    let text = fs::read_to_string(directory.join("manifest.json")).unwrap_or_default();
    let manifest: Value = serde_json::from_str(&text).unwrap_or_default();
    let files = manifest["files"].as_array().cloned().unwrap_or_default();
    let path = |file: &Value| Some(file["path"].as_str()?.to_owned());
    files.iter().filter_map(path).collect()
}

/// Paths of all that is no directory below one, with `/`, behind a prefix.
pub(crate) fn files_below(directory: &Path, prefix: &str) -> Result<Vec<String>, BundleError> {
    let mut files = Vec::new();
    for entry in fs::read_dir(directory).map_err(io_error(directory))? {
        let entry = entry.map_err(io_error(directory))?;
        let path = format!("{prefix}{}", entry.file_name().to_string_lossy());
        let kind = entry.file_type().map_err(io_error(directory))?;
        if kind.is_dir() {
            files.extend(files_below(&entry.path(), &format!("{path}/"))?);
        } else {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

fn named(files: &[String]) -> String {
    const MOST: usize = 5;
    let mut text = files[..files.len().min(MOST)].join(", ");
    if files.len() > MOST {
        text.push_str(&format!(" and {} more", files.len() - MOST));
    }
    text
}

fn check_name(out: &Path) -> Result<(), BundleError> {
    match out.file_name() {
        Some(_) => Ok(()),
        None => Err(BundleError::NoName {
            path: out.to_owned(),
        }),
    }
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

pub(crate) fn io_error(path: &Path) -> impl FnOnce(io::Error) -> BundleError {
    let path = path.to_owned();
    move |source| BundleError::Io { path, source }
}
