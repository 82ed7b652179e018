//! What must not outlive the process: tools that run, and directories that are not whole yet.

use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use std::os::unix::process::CommandExt;

use rustix::process::{Pid, Signal, kill_process_group};

static LIVE: Mutex<Live> = Mutex::new(Live {
    groups: Vec::new(),
    directories: Vec::new(),
});

struct Live {
    groups: Vec<Pid>,
    directories: Vec<PathBuf>,
}

fn live() -> MutexGuard<'static, Live> {
    LIVE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Kills every tool that runs, with all that it started, and deletes what is half built.
///
/// For a process that was told to stop, and ends right after it: from here on no tool can be
/// started, and whoever tries to waits for ever.
pub fn abandon() {
    let mut live = live();
    for group in live.groups.drain(..) {
        let _ = kill_process_group(group, Signal::KILL);
    }
    for directory in live.directories.drain(..) {
        // The killed may write for a moment more.
        for _ in 0..50 {
            match std::fs::remove_dir_all(&directory) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => {
                    std::thread::sleep(Duration::from_millis(20));
                }
                _ => break,
            }
        }
    }
    std::mem::forget(live);
}

/// A child that leads a process group of its own, so that make's compilers end with make.
pub(super) struct Running {
    child: Child,
    /// Until the child has been waited for; then its number may pass to another process.
    group: Option<Pid>,
}

impl Running {
    pub(super) fn start(command: &mut Command) -> io::Result<Self> {
        // Held over the start, or a child could come to life behind `abandon`'s back.
        let mut live = live();
        let child = command.process_group(0).spawn()?;
        let group = Pid::from_child(&child);
        live.groups.push(group);
        Ok(Self {
            child,
            group: Some(group),
        })
    }

    /// Its status, if it has ended.
    pub(super) fn poll(&mut self) -> io::Result<Option<ExitStatus>> {
        let mut live = live();
        let status = self.child.try_wait()?;
        if status.is_some() {
            self.forget(&mut live);
        }
        Ok(status)
    }

    /// Ends it with all the processes that it started.
    pub(super) fn kill(mut self) -> io::Result<()> {
        let mut live = live();
        if let Some(group) = self.group {
            let _ = kill_process_group(group, Signal::KILL);
        }
        self.child.kill()?;
        self.child.wait()?;
        self.forget(&mut live);
        Ok(())
    }

    fn forget(&mut self, live: &mut Live) {
        if let Some(group) = self.group.take() {
            live.groups.retain(|g| *g != group);
        }
    }
}

/// A directory of a random name that is deleted when it goes out of use.
pub(crate) struct Scratch {
    path: PathBuf,
}

impl Scratch {
    pub(crate) fn new(prefix: &str, parent: &Path) -> io::Result<Self> {
        let mut live = live();
        let directory = tempfile::Builder::new().prefix(prefix).tempdir_in(parent)?;
        let path = directory.keep();
        live.directories.push(path.clone());
        Ok(Self { path })
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // Not there any more if it was renamed.
        let _ = std::fs::remove_dir_all(&self.path);
        live().directories.retain(|d| *d != self.path);
    }
}

/// Copies a program, and starts no child meanwhile: what a child was born holding open for
/// writing can't be run.
pub(crate) fn copy_program(from: &Path, to: &Path) -> io::Result<()> {
    let _live = live();
    std::fs::copy(from, to).map(drop)
}
