//! Checks that directories can be written, and that their disk has space.

use std::fs;
use std::path::Path;
use std::process;

use crate::error::Error;
use crate::system::output;

/// The directory, or its nearest ancestor that exists.
fn existing(directory: &Path) -> &Path {
    directory.ancestors().find(|path| path.exists()).unwrap_or(directory)
}

/// Fails if files cannot be written to a directory, or the directory cannot be made; leaves nothing behind. `advice` is
/// the end of the message.
pub fn writable(directory: &Path, advice: &str) -> Result<(), Error> {
    let probe = existing(directory).join(format!(".icoray-{}", process::id()));
    let written = fs::write(&probe, "x");
    // A full disk leaves an empty file.
    let removed = fs::remove_file(&probe);
    let what = format!("cannot write to {}", directory.display());
    written.and(removed).map_err(|cause| Error::Failed(format!("{what}: {cause}; {advice}")))
}

/// Fails if less than `megabytes` are free on the disk of a directory for builds. Without an answer of df, the build
/// itself reports a full disk.
pub fn has_space(directory: &Path, megabytes: u64) -> Result<(), Error> {
    let existing = existing(directory);
    let printed = output("df", ["--output=avail", "-BM", &existing.to_string_lossy()]).unwrap_or_default();
    let free = printed.lines().nth(1).and_then(|line| line.trim().trim_end_matches('M').parse::<u64>().ok());
    match free.filter(|free| *free < megabytes) {
        None => Ok(()),
        Some(free) => Err(Error::Failed(format!(
            "{free} MB are free on the disk of {}, and about {megabytes} MB are needed; free some, or let \
             CARGO_TARGET_DIR name a directory on another disk",
            existing.display()
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lack_of_space_is_found() {
        let directory = std::env::temp_dir().join("nonexistent/below");
        assert_eq!(has_space(&directory, 0), Ok(()));
        let error = has_space(&directory, u64::MAX).unwrap_err().to_string();
        assert!(error.contains(" MB are free on ") && error.contains("18446744073709551615 MB are needed"), "{error}");
    }

    #[test]
    fn writable_leaves_nothing_and_advises() {
        let scratch = xshell::Shell::new().unwrap().create_temp_dir().unwrap();
        let directory = scratch.path();
        assert_eq!(writable(&directory.join("a/b"), ""), Ok(()));
        assert_eq!(fs::read_dir(directory).unwrap().count(), 0);
        fs::write(directory.join("file"), "").unwrap();
        assert!(writable(&directory.join("file/below"), "").is_err());
        let message = writable(Path::new("/proc/nothing"), "advice").unwrap_err().to_string();
        assert!(message.starts_with("cannot write to /proc/nothing: ") && message.ends_with("; advice"), "{message}");
    }
}
