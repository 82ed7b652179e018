//! Files that appear whole or not at all.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::failure::Failure;

/// A file that is written beside its place, and renamed when it is whole.
#[derive(Debug)]
pub struct Aside {
    path: PathBuf,
    target: PathBuf,
    file: Place,
    replace: bool,
}

#[derive(Debug)]
enum Place {
    Beside(NamedTempFile),
    /// A pipe or a device is written to, not replaced.
    Through(File),
}

impl Aside {
    /// Begins a file at a path, whose directories are made.
    ///
    /// # Errors
    /// If a file is there and is not to be replaced, or the system refuses it.
    pub fn create(path: &Path, replace: bool) -> Result<Self, Failure> {
        let error = |e: io::Error| Failure::io(path, &e);
        // A link's file is replaced, not the link.
        let target = match path.canonicalize() {
            Ok(real) if !real.is_file() => {
                return Ok(Self {
                    path: path.to_owned(),
                    file: Place::Through(File::options().write(true).open(path).map_err(error)?),
                    target: real,
                    replace,
                });
            }
            Ok(_) if !replace => return Err(exists(path)),
            Ok(real) => real,
            Err(_) => path.to_owned(),
        };
        let parent = match target.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        std::fs::create_dir_all(parent).map_err(|e| Failure::io(parent, &e))?;
        let mut builder = tempfile::Builder::new();
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // A temporary file is private; this one is as public as any new file.
            builder.permissions(std::fs::Permissions::from_mode(0o666));
        }
        let file = builder
            .prefix(".hwgen-new-")
            .tempfile_in(parent)
            .map_err(error)?;
        Ok(Self {
            path: path.to_owned(),
            file: Place::Beside(file),
            target,
            replace,
        })
    }

    /// Adds bytes.
    ///
    /// # Errors
    /// If the system refuses it.
    pub fn write(&mut self, text: &[u8]) -> Result<(), Failure> {
        let file = match &mut self.file {
            Place::Beside(file) => file.as_file_mut(),
            Place::Through(file) => file,
        };
        file.write_all(text)
            .map_err(|e| Failure::io(&self.path, &e))
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// If another has appeared there that is not to be replaced, or the system refuses it.
    pub fn keep(self) -> Result<(), Failure> {
        let Place::Beside(file) = self.file else {
            return Ok(());
        };
        let kept = if self.replace {
            file.persist(&self.target)
        } else {
            file.persist_noclobber(&self.target)
        };
        match kept {
            Ok(_) => Ok(()),
            Err(e) if e.error.kind() == io::ErrorKind::AlreadyExists => Err(exists(&self.path)),
            Err(e) => Err(Failure::io(&self.path, &e.error)),
        }
    }
}

fn exists(path: &Path) -> Failure {
    Failure::input("exists", "a new file expected, an existing one found")
        .file(path.display().to_string())
        .help("write to another file, or replace this one with --force")
}
