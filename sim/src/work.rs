//! The directory that a check works in: empty at first, and nobody else's meanwhile.

use std::fs::{File, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Marks a work directory, so that nothing else is ever emptied; a check holds a lock on it.
const MARK: &str = ".hwgen-work";

/// Why a directory can't be worked in.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WorkError {
    /// There are files in it, and no earlier check has left them.
    #[error(
        "{}: a new or empty directory, or one of an earlier check, expected, another one found",
        path.display()
    )]
    Foreign {
        /// The directory.
        path: PathBuf,
    },
    /// Another check is at work in it.
    #[error("{}: a directory that nobody works in expected, another check is running", path.display())]
    Busy {
        /// The directory.
        path: PathBuf,
    },
    /// The system refused it.
    #[error("{}: {source}", path.display())]
    Io {
        /// The directory, or a file in it.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
}

/// A work directory, locked for as long as this lives.
#[derive(Debug)]
pub(crate) struct WorkDir {
    _locked: File,
}

impl WorkDir {
    /// Makes the directory or empties the one of an earlier check.
    ///
    /// # Errors
    /// [`WorkError`] if it is not to be had; then nothing in it was touched.
    pub(crate) fn claim(path: &Path) -> Result<Self, WorkError> {
        std::fs::create_dir_all(path).map_err(io_error(path))?;
        let entries = || -> Result<Vec<PathBuf>, WorkError> {
            let read = std::fs::read_dir(path).map_err(io_error(path))?;
            read.map(|entry| Ok(entry.map_err(io_error(path))?.path()))
                .collect()
        };
        let mark = path.join(MARK);
        if !entries()?.is_empty() && !mark.is_file() {
            return Err(WorkError::Foreign {
                path: path.to_owned(),
            });
        }
        let mut options = File::options();
        options.create(true).write(true).truncate(false);
        let mut file = options.open(&mark).map_err(io_error(&mark))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(WorkError::Busy {
                    path: path.to_owned(),
                });
            }
            Err(TryLockError::Error(source)) => return Err(io_error(&mark)(source)),
        }
        file.write_all(b"hwgen empties this directory before each check.\n")
            .map_err(io_error(&mark))?;
        // All but the mark: who deletes it deletes the lock.
        for entry in entries()?.iter().filter(|entry| **entry != mark) {
            let kind = entry.symlink_metadata().map_err(io_error(entry))?;
            if kind.is_dir() {
                std::fs::remove_dir_all(entry).map_err(io_error(entry))?;
            } else {
                std::fs::remove_file(entry).map_err(io_error(entry))?;
            }
        }
        Ok(Self { _locked: file })
    }
}

fn io_error(path: &Path) -> impl FnOnce(io::Error) -> WorkError {
    let path = path.to_owned();
    move |source| WorkError::Io { path, source }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(files: &[&str]) -> tempfile::TempDir {
        let place = tempfile::tempdir().expect("a directory");
        for file in files {
            std::fs::write(place.path().join(file), "precious").expect("written");
        }
        place
    }

    #[test]
    fn a_directory_of_others_is_not_touched() {
        let place = place(&["notes.txt"]);
        let error = WorkDir::claim(place.path()).unwrap_err();
        assert!(matches!(error, WorkError::Foreign { .. }), "{error}");
        let notes = std::fs::read_to_string(place.path().join("notes.txt"));
        assert_eq!(notes.expect("still there"), "precious");
        assert!(!place.path().join(MARK).exists());
    }

    #[test]
    fn the_directory_of_an_earlier_check_is_emptied_once_it_has_ended() {
        let place = place(&[]);
        let work = WorkDir::claim(place.path()).expect("an empty one");
        let old = place.path().join("old/deep");
        std::fs::create_dir_all(&old).expect("created");
        let error = WorkDir::claim(place.path()).unwrap_err();
        assert!(matches!(error, WorkError::Busy { .. }), "{error}");
        assert!(old.is_dir());
        drop(work);
        let _work = WorkDir::claim(place.path()).expect("free again");
        assert!(!place.path().join("old").exists());
        assert!(place.path().join(MARK).is_file());
    }
}
