//! Where compiled programs are kept: in the user's own cache. What lies beside a bundle came with
//! it, maybe from a stranger, and is never run.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// A directory that can be written to: `$XDG_CACHE_HOME/hwgen/<part>`, else
/// `$HOME/.cache/hwgen/<part>`, else `<otherwise>/<part>`.
pub fn directory(part: &str, otherwise: &Path) -> PathBuf {
    let usable = own(std::env::var_os("XDG_CACHE_HOME"), std::env::var_os("HOME"))
        .map(|cache| cache.join(part))
        .filter(|cache| {
            // Tried, for permissions say little on a file system that is mounted read-only.
            std::fs::create_dir_all(cache).is_ok() && tempfile::tempfile_in(cache).is_ok()
        });
    usable.unwrap_or_else(|| otherwise.join(part))
}

/// As the XDG Base Directory Specification (0.8) has it: a path that is not absolute counts as
/// not set.
fn own(cache: Option<OsString>, home: Option<OsString>) -> Option<PathBuf> {
    let absolute = |path: OsString| Some(PathBuf::from(path)).filter(|path| path.is_absolute());
    let cache = cache.and_then(absolute);
    let cache = cache.or_else(|| Some(home.and_then(absolute)?.join(".cache")))?;
    Some(cache.join("hwgen"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cache_is_where_the_specification_says() {
        let some = |text: &str| Some(OsString::from(text));
        let path = |text: &str| Some(PathBuf::from(text));
        assert_eq!(own(some("/c"), some("/h")), path("/c/hwgen"));
        assert_eq!(own(some("c"), some("/h")), path("/h/.cache/hwgen"));
        assert_eq!(own(some(""), some("/h")), path("/h/.cache/hwgen"));
        assert_eq!(own(None, some("h")), None);
        assert_eq!(own(None, None), None);
    }
}
