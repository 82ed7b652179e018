//! Ctrl-C and its like: nothing that a command has started may outlive it.

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
        if let Some(signal) = signals.forever().next() {
            hwgen_sim::tool::abandon();
            // Without a word: standard error may be gone, or be what the command hangs at.
            std::process::exit(128 + signal);
        }
    });
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
