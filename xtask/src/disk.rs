//! Directories that can be written, and the space on their disk.

use std::fs;
use std::io;
use std::path::Path;
use std::process;

use crate::error::Error;
use crate::system::output;

/// Fails where files cannot be written to a directory, or the directory not be made; leaves nothing behind. `advice` tells what
/// to do.
pub fn writable(directory: &Path, advice: &str) -> Result<(), Error> {
    probe(directory)
        .map_err(|cause| Error::Failed(format!("cannot write to {}: {cause}; {advice}", directory.display())))
}

/// Writes a file to the directory, or to the nearest above it that is there, and removes it.
fn probe(directory: &Path) -> io::Result<()> {
    let there = directory.ancestors().find(|path| path.exists()).unwrap_or(directory);
    let probe = there.join(format!(".icoray-{}", process::id()));
    let written = fs::write(&probe, "x");
    // An empty file is left where the disk is full.
    let removed = fs::remove_file(&probe);
    written.and(removed)
}

/// Fails where less than `megabytes` are free on the disk of `directory`, or of what is there of the path to it.
pub fn has_space(directory: &Path, megabytes: u64, advice: &str) -> Result<(), Error> {
    let there = directory.ancestors().find(|path| path.is_dir()).unwrap_or(directory);
    let printed = output("df", ["-P", "-k", &there.to_string_lossy()]).unwrap_or_default();
    match free_megabytes(&printed) {
        Some(free) if free < megabytes => Err(Error::Failed(format!(
            "{free} MB are free on the disk of {}, and about {megabytes} MB are needed; {advice}",
            there.display()
        ))),
        // Where df tells nothing, a full disk is told when it is full.
        _ => Ok(()),
    }
}

/// The column of free kilobytes of `df -P -k`.
fn free_megabytes(printed: &str) -> Option<u64> {
    let line = printed.lines().nth(1)?;
    // The first column may have blanks; the mount point, too, but it is the last.
    let percent = line.split_whitespace().position(|word| word.ends_with('%'))?;
    let free = line.split_whitespace().nth(percent.checked_sub(1)?)?;
    Some(free.parse::<u64>().ok()? / 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_space_is_read_from_df() {
        let printed = "Filesystem     1024-blocks     Used Available Capacity Mounted on\n\
                       /dev/sd a1       263174212 15938860  80658688      17% /a place\n";
        assert_eq!(free_megabytes(printed), Some(78768));
        assert_eq!(free_megabytes("df: no such file"), None);
    }

    #[test]
    fn a_lack_of_space_names_both_numbers() {
        let directory = std::env::temp_dir().join("nonexistent/below");
        assert_eq!(has_space(&directory, 0, ""), Ok(()));
        let error = has_space(&directory, u64::MAX, "use another").unwrap_err().to_string();
        assert!(error.contains("18446744073709551615 MB are needed; use another"), "{error}");
    }

    #[test]
    fn what_can_be_written_stays_as_it_is() {
        let directory = std::env::temp_dir().join(format!("icoray-disk-{}", process::id()));
        assert_eq!(writable(&directory.join("a/b"), ""), Ok(()));
        assert!(!directory.exists());
        fs::create_dir_all(&directory).unwrap();
        fs::write(directory.join("file"), "").unwrap();
        assert_eq!(writable(&directory, ""), Ok(()));
        assert!(writable(&directory.join("file/below"), "").is_err());
        assert_eq!(fs::read_dir(&directory).unwrap().count(), 1);
        fs::remove_dir_all(directory).unwrap();
    }

    #[test]
    fn a_directory_that_cannot_be_made_is_told_with_advice() {
        let error = writable(Path::new("/proc/nothing"), "--out DIR takes another directory").unwrap_err();
        let message = error.to_string();
        assert!(message.starts_with("cannot write to /proc/nothing: "), "{message}");
        assert!(message.ends_with("; --out DIR takes another directory"), "{message}");
    }
}
