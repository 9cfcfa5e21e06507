//! Known causes of failures, recognised in the output of cargo, compilers and apt-get.

use crate::error::last_lines;

/// Number of last lines that are searched: they have the error that ended the command.
const SEARCHED: usize = 60;

/// Known causes: texts of which one is in a line of the output, and a sentence with the cause and what to do. The first
/// that fits counts: a full disk also makes downloads fail.
static CAUSES: &[(&[&str], &str)] = &[
    (
        &["No space left on device", "(os error 28)", "You don't have enough free space in"],
        "no space is left on the disk: free some, or let CARGO_TARGET_DIR name a directory on another disk",
    ),
    (
        &["Read-only file system", "(os error 30)"],
        "a directory is read-only: let CARGO_TARGET_DIR name a directory that can be written, \
         and --out one for pictures",
    ),
    (
        &[
            "Could not get lock",
            "Unable to acquire the dpkg frontend lock",
            "Unable to lock directory",
            "is another process using it?",
        ],
        "another program uses apt: wait until it has ended (`ps -e | grep -E 'apt|dpkg'` shows it), \
         then run this command again",
    ),
    (
        &["dpkg was interrupted"],
        "an earlier installation was interrupted: run `dpkg --configure -a` as root, then this command again",
    ),
    (
        &[
            "Temporary failure resolving",
            "Could not connect to",
            "Unable to connect to",
            "Cannot initiate the connection",
        ],
        "apt-get cannot reach its archive: check the network and the proxy, then run this command again",
    ),
    (
        &["Unable to locate package", "has no installation candidate"],
        "the package lists of this system do not have a package: add Debian's main archive to \
         /etc/apt/sources.list, or install its counterpart by hand",
    ),
    (
        &[
            "failed to download",
            "download of config.json failed",
            "Could not resolve host",
            "Could not resolve hostname",
            "spurious network error",
            "attempting to make an HTTP request",
        ],
        "cargo cannot download crates: check the network and the proxy (HTTPS_PROXY), then run this command \
         again; `cargo fetch` downloads all, after which no network is needed",
    ),
    (
        &["is not supported by the following package", "requires rustc"],
        "this Rust is too old: run `rustup update`, then this command again",
    ),
    (
        &["signal: 9, SIGKILL", "Killed signal terminated program", "memory allocation of"],
        "the system ended a compiler, mostly for want of memory: close other programs, or set \
         CARGO_BUILD_JOBS=1, then run this command again",
    ),
    (
        &["Permission denied", "(os error 13)", "are you root?"],
        "a file or directory may not be written: let CARGO_TARGET_DIR name a directory of your own, \
         and --out one for pictures",
    ),
];

/// The cause of a failure with this output, and what to do, if it is known.
pub fn diagnose(output: &str) -> Option<&'static str> {
    let lines = last_lines(output, SEARCHED);
    let contains = |text: &&str| lines.iter().any(|line| line.contains(text));
    CAUSES.iter().find(|(texts, _)| texts.iter().any(contains)).map(|(_, sentence)| *sentence)
}

/// Whether apt-get failed because another program holds its lock.
pub fn is_locked(text: &str) -> bool {
    diagnose(text).is_some_and(|sentence| sentence.starts_with("another program uses apt"))
}

/// Whether apt-get failed because it cannot reach its archive.
pub fn is_offline(text: &str) -> bool {
    diagnose(text).is_some_and(|sentence| sentence.starts_with("apt-get cannot reach"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What cargo, apt-get and compilers really print.
    const SEEN: &[(&str, &str)] = &[
        ("error: failed to write `/t/x`\n\nCaused by:\n  No space left on device (os error 28)", "no space is left"),
        ("/usr/bin/ld: final link failed: No space left on device", "no space is left"),
        ("E: You don't have enough free space in /var/cache/apt/archives/.", "no space is left"),
        (
            "error: failed to create directory `/src/target`\n  Read-only file system (os error 30)",
            "a directory is read-only",
        ),
        (
            "E: Could not get lock /var/lib/dpkg/lock-frontend. It is held by process 7 (apt)\n\
             E: Unable to acquire the dpkg frontend lock (/var/lib/dpkg/lock-frontend), is another process using it?",
            "another program uses apt",
        ),
        ("E: Unable to lock directory /var/lib/apt/lists/", "another program uses apt"),
        ("E: dpkg was interrupted, you must manually run 'dpkg --configure -a' to correct the problem.", "an earlier"),
        (
            "W: Failed to fetch http://deb.debian.org/x  Temporary failure resolving 'deb.debian.org'",
            "apt-get cannot reach",
        ),
        ("E: Unable to locate package libnetcdf-dev", "the package lists"),
        (
            "error: failed to download from `https://index.crates.io/se/rd/serde`\n\nCaused by:\n  \
             [6] Could not resolve hostname (Could not resolve host: index.crates.io)",
            "cargo cannot download",
        ),
        (
            "error: failed to get `ab_glyph` as a dependency of package `icoray v0.1.0`\n\nCaused by:\n  \
             attempting to make an HTTP request, but --offline was specified",
            "cargo cannot download",
        ),
        (
            "error: rustc 1.90.0 is not supported by the following package:\n  icoray requires rustc 1.95",
            "this Rust is too old",
        ),
        ("error: could not compile `icoray`\n  (signal: 9, SIGKILL: kill)", "the system ended a compiler"),
        ("E: Could not open lock file - open (13: Permission denied)\n are you root?", "a file or directory"),
    ];

    #[test]
    fn what_tools_print_is_recognised() {
        for (output, start) in SEEN {
            let found = diagnose(output).unwrap_or_default();
            assert!(found.starts_with(start), "{output}\n{found}");
        }
        assert_eq!(diagnose("error[E0308]: mismatched types"), None);
        assert_eq!(diagnose(""), None);
    }

    #[test]
    fn only_the_end_of_the_output_counts() {
        let long = "warning: something\n".repeat(SEARCHED);
        assert_eq!(diagnose(&format!("No space left on device\n{long}")), None);
        assert!(diagnose(&format!("{long}No space left on device")).is_some());
    }

    #[test]
    fn locks_and_networks_are_told_apart() {
        assert!(is_locked(SEEN[4].0) && !is_offline(SEEN[4].0));
        assert!(is_offline(SEEN[7].0) && !is_locked(SEEN[7].0));
    }
}
