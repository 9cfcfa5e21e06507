//! Checks that directories can be written, and that their disk has space.

use std::fs;
use std::io;
use std::path::Path;
use std::process;

use crate::error::Error;
use crate::system::output;

/// Fails if files cannot be written to a directory, or the directory cannot be made; leaves nothing behind. `advice` is
/// the end of the message.
pub fn writable(directory: &Path, advice: &str) -> Result<(), Error> {
    probe(directory)
        .map_err(|cause| Error::Failed(format!("cannot write to {}: {cause}; {advice}", directory.display())))
}

/// Writes a file to the directory, or to its nearest ancestor that exists, and removes it.
fn probe(directory: &Path) -> io::Result<()> {
    let existing = directory.ancestors().find(|path| path.exists()).unwrap_or(directory);
    let probe = existing.join(format!(".icoray-{}", process::id()));
    let written = fs::write(&probe, "x");
    // A full disk leaves an empty file.
    let removed = fs::remove_file(&probe);
    written.and(removed)
}

/// Fails if less than `megabytes` are free on the disk of a directory for builds, or of its nearest ancestor that
/// exists.
pub fn has_space(directory: &Path, megabytes: u64) -> Result<(), Error> {
    let existing = directory.ancestors().find(|path| path.is_dir()).unwrap_or(directory);
    let printed = output("df", ["-P", "-k", &existing.to_string_lossy()]).unwrap_or_default();
    match free_megabytes(&printed) {
        Some(free) if free < megabytes => Err(Error::Failed(format!(
            "{free} MB are free on the disk of {}, and about {megabytes} MB are needed; free some, or let \
             CARGO_TARGET_DIR name a directory on another disk",
            existing.display()
        ))),
        // Without an answer of df, the build itself reports a full disk.
        _ => Ok(()),
    }
}

/// The free megabytes that `df -P -k` prints.
fn free_megabytes(printed: &str) -> Option<u64> {
    let line = printed.lines().nth(1)?;
    // The first and the last column may have blanks.
    let percent = line.split_whitespace().position(|word| word.ends_with('%'))?;
    let free = line.split_whitespace().nth(percent.checked_sub(1)?)?;
    Some(free.parse::<u64>().ok()? / 1024)
}

#[cfg(test)]
mod tests {
    use super::*;
    use xshell::Shell;

    #[test]
    fn free_space_is_read_from_df() {
        let printed = "Filesystem     1024-blocks     Used Available Capacity Mounted on\n\
                       /dev/sd a1       263174212 15938860  80658688      17% /a place\n";
        assert_eq!(free_megabytes(printed), Some(78768));
        assert_eq!(free_megabytes("df: no such file"), None);
        let directory = std::env::temp_dir().join("nonexistent/below");
        assert_eq!(has_space(&directory, 0), Ok(()));
        let error = has_space(&directory, u64::MAX).unwrap_err().to_string();
        assert!(
            error.contains(" MB are free on ") && error.contains("18446744073709551615 MB are needed; "),
            "{error}"
        );
    }

    #[test]
    fn writable_leaves_nothing_and_advises() {
        let scratch = Shell::new().unwrap().create_temp_dir().unwrap();
        let directory = scratch.path();
        assert_eq!(writable(&directory.join("a/b"), ""), Ok(()));
        assert!(!directory.join("a").exists());
        fs::write(directory.join("file"), "").unwrap();
        assert_eq!(writable(directory, ""), Ok(()));
        assert!(writable(&directory.join("file/below"), "").is_err());
        assert_eq!(fs::read_dir(directory).unwrap().count(), 1);
        let message = writable(Path::new("/proc/nothing"), "advice").unwrap_err().to_string();
        assert!(message.starts_with("cannot write to /proc/nothing: ") && message.ends_with("; advice"), "{message}");
    }
}
