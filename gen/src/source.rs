//! A bundle read back, and checked against what it was made from.

use std::fs;
use std::io;
use std::path::Path;

use hwgen_spec::design::Design;
use hwgen_spec::network::FloatNet;
use hwgen_spec::weights;
use serde_json::Value;

use crate::bundle::{Bundle, BundleError, files_below, io_error};
use crate::manifest::{BUNDLE_FORMAT, Manifest};
use crate::{design_digest, generate, sha256};

/// A bundle read back: what it was made from, and a manifest that its files agree with.
#[derive(Clone, Debug)]
pub struct Source {
    /// The manifest.
    pub manifest: Manifest,
    /// The float network.
    pub net: FloatNet,
    /// The design that weights and options lead to.
    pub design: Design,
    /// The files that the design has, as this version of the tool generates them.
    generated: Bundle,
}

impl Source {
    /// Reads a bundle, checks every file against the manifest, and the manifest against the
    /// design that weights and options lead to.
    ///
    /// The digests of files are not part of the latter: whether a core that was edited is still
    /// equal to its model is for a verification to say.
    ///
    /// # Errors
    /// [`BundleError`] if a file is missing, changed or unlisted, the manifest says something
    /// else, or the bundle is another version's.
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
                Err(e) if e.kind() == io::ErrorKind::InvalidData => {
                    "bytes that are no UTF-8".into()
                }
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
        let generated = generate(&design, &net);
        check_manifest(&path, &text, &generated)?;
        check_surroundings(directory, &generated)?;
        for folder in ["rtl", "sim", "tb"] {
            let below = directory.join(folder);
            // Only some devices have models; a listed file that is not there was missed above.
            if !below.exists() {
                continue;
            }
            let listed = |file: &String| read.files.iter().any(|f| f.path == *file);
            let prefix = format!("{folder}/");
            if let Some(file) = files_below(&below, &prefix)?.iter().find(|f| !listed(f)) {
                return Err(BundleError::Unlisted {
                    path: directory.join(file),
                });
            }
        }
        Ok(Self {
            manifest: read,
            net,
            design,
            generated,
        })
    }

    /// The Verilog of the core, as it lies in the bundle.
    pub fn rtl(&self) -> Vec<String> {
        let files = self.manifest.files.iter().map(|file| &file.path);
        let verilog = files.filter(|path| path.starts_with("rtl/") && path.ends_with(".v"));
        verilog.cloned().collect()
    }

    /// Names and texts of the bench and of the models of blocks, generated: a check trusts none
    /// that lies in the bundle.
    ///
    /// `folder`: `tb` or `sim`.
    pub fn generated(&self, folder: &str) -> Vec<(String, String)> {
        let files = self.generated.files().iter().filter_map(|file| {
            let (above, name) = file.path.rsplit_once('/')?;
            (above == folder).then(|| (name.to_owned(), file.text.clone()))
        });
        files.collect()
    }
}

/// Compares what lies around the Verilog with what the design has: a script or a list of files that
/// says something else makes another core of it.
fn check_surroundings(directory: &Path, generated: &Bundle) -> Result<(), BundleError> {
    let read = ["manifest.json", "weights.json"];
    let files = generated.files().iter();
    for file in files.filter(|f| !f.path.starts_with("rtl/") && !read.contains(&&*f.path)) {
        let path = directory.join(&file.path);
        let text = fs::read_to_string(&path).map_err(io_error(&path))?;
        if text != file.text {
            let pairs = text.lines().zip(file.text.lines());
            let line = 1 + pairs
                .take_while(|(found, expected)| found == expected)
                .count();
            return Err(BundleError::Differs { path, line });
        }
    }
    Ok(())
}

/// Compares a manifest with the one that the design has, digests of files aside.
fn check_manifest(path: &Path, text: &str, generated: &Bundle) -> Result<(), BundleError> {
    let last = generated.files().last().map_or("", |f| f.text.as_str());
    let read = |text: &str| -> Value {
        let mut manifest: Value = serde_json::from_str(text).unwrap_or_default();
        // What the digest has to be was judged by the weights as they are written.
        manifest["digest"] = Value::Null;
        let files = manifest["files"].as_array_mut();
        for file in files.into_iter().flatten() {
            file["sha256"] = Value::Null;
        }
        manifest
    };
    match first_difference("", &read(last), &read(text)) {
        None => Ok(()),
        Some((field, expected, found)) => Err(BundleError::Altered {
            path: path.to_owned(),
            field,
            expected,
            found,
        }),
    }
}

/// Path of the first value that differs, and both values.
fn first_difference(at: &str, expected: &Value, found: &Value) -> Option<(String, String, String)> {
    let nothing = || "nothing".to_owned();
    match (expected, found) {
        (Value::Object(a), Value::Object(b)) => {
            let join = |key: &str| match at {
                "" => key.to_owned(),
                _ => format!("{at}.{key}"),
            };
            let missing = |key: &String| (join(key), a[key].to_string(), nothing());
            a.iter()
                .find_map(|(key, value)| match b.get(key) {
                    Some(other) => first_difference(&join(key), value, other),
                    None => Some(missing(key)),
                })
                .or_else(|| {
                    let (key, value) = b.iter().find(|(key, _)| !a.contains_key(*key))?;
                    Some((join(key), nothing(), value.to_string()))
                })
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            let mut pairs = a.iter().zip(b).enumerate();
            pairs.find_map(|(i, (a, b))| first_difference(&format!("{at}[{i}]"), a, b))
        }
        (Value::Array(a), Value::Array(b)) => Some((
            at.to_owned(),
            format!("a list of {}", a.len()),
            format!("one of {}", b.len()),
        )),
        _ if expected == found => None,
        _ => Some((at.to_owned(), expected.to_string(), found.to_string())),
    }
}
