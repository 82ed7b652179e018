//! Ctrl-C and its like: nothing that a command has started may outlive it.

use std::sync::atomic::{AtomicU8, Ordering};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

/// From here on an interrupt, a termination or a hang-up ends the process with 128 + signal, after
/// the external tools that run were killed and what they had half built was deleted.
pub fn heed() {
    let mut wanted = vec![SIGINT, SIGTERM];
    // Ignored from the start, as `nohup` asks for, it stays so.
    if !ignored(SIGHUP) {
        wanted.push(SIGHUP);
    }
    // Where it can't be had, a signal ends this process as it ends any other.
    let Ok(mut signals) = Signals::new(wanted) else {
        return;
    };
    std::thread::spawn(move || {
        for signal in signals.forever() {
            if STATE
                .compare_exchange(SOFT, ASKED, Ordering::SeqCst, Ordering::SeqCst)
                .is_ok()
            {
                continue;
            }
            hwgen_sim::tool::abandon();
            // Without a word: standard error may be gone, or be what the command hangs at.
            std::process::exit(128 + signal);
        }
    });
}

/// A signal ends the process.
const HARD: u8 = 0;
/// The first signal only asks.
const SOFT: u8 = 1;
/// It has asked; the next one ends the process.
const ASKED: u8 = 2;

static STATE: AtomicU8 = AtomicU8::new(HARD);

/// While this lives, the first signal asks for an end instead of making one.
#[derive(Debug)]
pub struct Softened(());

/// Lets a command bring what it has to an end by itself.
pub fn soften() -> Softened {
    STATE.store(SOFT, Ordering::SeqCst);
    Softened(())
}

impl Softened {
    /// Whether a signal has come.
    pub fn asked(&self) -> bool {
        STATE.load(Ordering::SeqCst) == ASKED
    }
}

impl Drop for Softened {
    fn drop(&mut self) {
        STATE.store(HARD, Ordering::SeqCst);
    }
}

/// Whether the process was started with this signal ignored, where the system tells.
fn ignored(signal: i32) -> bool {
    std::fs::read_to_string("/proc/self/status")
        .ok()
        .and_then(|status| {
            let mask = status.lines().find_map(|l| l.strip_prefix("SigIgn:"))?;
            let mask = u64::from_str_radix(mask.trim(), 16).ok()?;
            Some(mask >> (signal - 1) & 1 == 1)
        })
        .unwrap_or(false)
}
