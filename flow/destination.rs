//! Where results go: files that nobody misses.

use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

use crate::aside::Aside;
use crate::failure::Failure;

/// What a result may not be written to.
#[derive(Clone, Copy, Debug)]
pub struct Precious<'a> {
    /// The bundle that is read, if any: nothing inside of it is ever written.
    pub bundle: Option<&'a Path>,
    /// The file that is read.
    pub inputs: &'a Path,
    /// Whether another file may be replaced.
    pub force: bool,
}

/// A file to be written, or a pipe or a device.
#[derive(Clone, Debug)]
pub struct Destination {
    named: PathBuf,
    real: PathBuf,
    force: bool,
}

impl Destination {
    /// A place that may be written to.
    ///
    /// # Errors
    /// If it is the file that is read, inside of the bundle, or an existing file without `force`.
    pub fn new(path: &Path, precious: &Precious<'_>) -> Result<Self, Failure> {
        let refuse = |code, message: &str, help: &str| {
            let failure = Failure::input(code, message).file(path.display().to_string());
            Err(failure.help(help))
        };
        let real_path = |path: &Path| real_path(path).map_err(|e| Failure::io(path, &e));
        let real = real_path(path)?;
        let existing = fs::metadata(&real).ok();
        if existing.as_ref().is_none_or(fs::Metadata::is_file) {
            if real == real_path(precious.inputs)? {
                let message = "another file than that of the inputs expected";
                return refuse("overwrites-input", message, "write to another file");
            }
            let bundle = precious.bundle.map(real_path).transpose()?;
            if bundle.is_some_and(|bundle| real.starts_with(bundle)) {
                let message = "a file outside of the bundle expected";
                let help = "write to another directory: a bundle is never written to";
                return refuse("inside-bundle", message, help);
            }
        }
        if existing.as_ref().is_some_and(fs::Metadata::is_dir) {
            let help = "name a file, in that directory for example";
            return refuse("is-directory", "a file expected, a directory found", help);
        }
        if existing.is_some_and(|e| e.is_file()) && !precious.force {
            let help = "write to another file, or replace this one with --force";
            return refuse("exists", "a new file expected, an existing one found", help);
        }
        Ok(Self {
            named: path.to_owned(),
            real,
            force: precious.force,
        })
    }

    /// As the user named it.
    pub fn path(&self) -> &Path {
        &self.named
    }

    /// Whether both are the same place.
    pub fn is(&self, other: &Self) -> bool {
        self.real == other.real
    }

    /// Writes a file whole or not at all: beside its place, then renamed.
    ///
    /// # Errors
    /// If the system refuses it, or a file came into being meanwhile.
    pub fn write(&self, text: &[u8]) -> Result<(), Failure> {
        let mut aside = self.begin()?;
        aside.write(text)?;
        aside.keep()
    }

    /// Begins the file beside its place, to be written piece by piece.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub fn begin(&self) -> Result<Aside, Failure> {
        Aside::create(&self.real, self.force)
    }
}

/// The path without links and dots, as far as it exists; what does not exist yet is no link.
pub(crate) fn real_path(path: &Path) -> io::Result<PathBuf> {
    let mut real = PathBuf::new();
    for component in std::path::absolute(path)?.components() {
        match component {
            Component::ParentDir => {
                real.pop();
            }
            other => real.push(other),
        }
        match real.canonicalize() {
            Ok(existing) => real = existing,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(error),
        }
    }
    Ok(real)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dots_and_links_lead_to_one_place() {
        let place = tempfile::tempdir().expect("a directory");
        let root = place.path().canonicalize().expect("real");
        fs::create_dir(root.join("a")).expect("created");
        std::os::unix::fs::symlink("a", root.join("link")).expect("linked");
        for path in [
            "a/f",
            "link/f",
            "./link/../a/f",
            "new/../a/f",
            "new/deep/../../a/f",
        ] {
            let real = real_path(&root.join(path)).expect(path);
            assert_eq!(real, root.join("a/f"), "{path}");
        }
    }
}
