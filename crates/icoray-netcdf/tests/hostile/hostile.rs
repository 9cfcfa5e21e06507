//! Damaged and hostile files of every format: for any bytes, reading ends with a result.
//!
//! Each file is read in its own process, which a damaged NetCDF-4 file may end inside HDF5. The test counts such ends;
//! a panic, or a process that does not end, is a failure.

use crate::made::{Made, RECORDS};
use crate::made_icon::Angles;
use crate::written::formats;
use icoray_test_support::{Random, count};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// Set where a test is the process that reads: the folder of files, which are named by number.
const FOLDER: &str = "ICORAY_TEST_HOSTILE";
const FROM: &str = "ICORAY_TEST_HOSTILE_FROM";
/// Exit code of a process in which a call had no end.
const HUNG: i32 = 86;

/// Bytes of a classic file that hold its header.
const HEADER: usize = 2600;

/// A file with some bytes flipped, overwritten, moved or cut off, half of them near its begin, where headers are.
fn spoilt(whole: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = whole.to_vec();
    for _ in 0..=random.below(4) {
        let end = if random.below(2) == 0 { bytes.len() } else { bytes.len().min(HEADER) };
        let at = random.below(end);
        let end = (at + 1 + random.below(16)).min(bytes.len());
        match random.below(6) {
            0 => bytes[at] ^= 1 << random.below(8),
            1 => bytes[at] = [0, 1, 0x7f, 0x80, 0xff][random.below(5)],
            2 => bytes[at..end].fill([0, 0xff][random.below(2)]),
            3 => {
                let from = random.below(bytes.len() - (end - at) + 1);
                bytes.copy_within(from..from + end - at, at);
            }
            4 => bytes[at] = random.below(256) as u8,
            _ if random.below(4) == 0 => bytes.truncate(at.max(1)),
            _ => bytes[at] = bytes[at].wrapping_add(1),
        }
    }
    bytes
}

/// Everything that is read of a file.
fn read(path: &Path) -> icoray::Result<()> {
    let file = icoray_netcdf::open(path)?;
    let _ = file.mesh().grid();
    for info in file.fields() {
        let _ = file.layers(&info.name);
        for time in [0, RECORDS - 1] {
            file.read_field(&info.name, time)?.field()?.range();
        }
    }
    Ok(())
}

/// Reads the files of a folder from a number on, and says the number before each and what came of it after.
fn read_in_child(folder: &str) {
    let from: usize = std::env::var(FROM).unwrap().parse().unwrap();
    icoray_netcdf::watch_calls(Duration::from_secs(20), |_| icoray_netcdf::end_process(HUNG));
    let mut out = std::io::stdout();
    for number in from.. {
        let path = Path::new(folder).join(number.to_string());
        if !path.exists() {
            break;
        }
        writeln!(out, "begin {number}").unwrap();
        out.flush().unwrap();
        let outcome = std::panic::catch_unwind(|| read(&path));
        let word = match outcome {
            Ok(Ok(())) => "fine",
            Ok(Err(_)) => "error",
            Err(_) => "panic",
        };
        writeln!(out, "end {number} {word}").unwrap();
        out.flush().unwrap();
    }
}

/// What became of the files.
#[derive(Debug, Default, PartialEq)]
struct Outcomes {
    fine: usize,
    errors: usize,
    panics: usize,
    /// The process ended.
    ended: Vec<usize>,
    /// The process went on for ever.
    hung: Vec<usize>,
}

/// Has the files read by children: one after the other, each from where the one before ended.
fn outcomes(test: &str, folder: &Path, count: usize) -> Outcomes {
    let mut found = Outcomes::default();
    let mut from = 0;
    while from < count {
        let (said, has_hung) = child(test, folder, from);
        let last = said.last().unwrap_or_else(|| panic!("{test}: the child has not begun"));
        let of = |word: &str| said.iter().filter(|line| line.ends_with(word)).count();
        found.fine += of(" fine");
        found.errors += of(" error");
        found.panics += of(" panic");
        from = last.split(' ').nth(1).and_then(|number| number.parse().ok()).unwrap_or(count) + 1;
        if last.starts_with("begin ") {
            let lost = if has_hung { &mut found.hung } else { &mut found.ended };
            lost.push(from - 1);
        }
    }
    let all = found.fine + found.errors + found.panics + found.ended.len() + found.hung.len();
    assert_eq!(all, count, "{found:?}");
    found
}

/// What a child said of the files from a number on, and whether it has hung.
fn child(test: &str, folder: &Path, from: usize) -> (Vec<String>, bool) {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args([test, "--exact", "--nocapture", "--test-threads=1"]);
    let output = command.env(FOLDER, folder).env(FROM, from.to_string()).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    // The test's own name may stand before the first.
    let lines = text.lines().map(|line| line.rsplit_once("... ").map_or(line, |(_, line)| line));
    let lines = lines.filter(|line| line.starts_with("begin ") || line.starts_with("end "));
    (lines.map(str::to_owned).collect(), output.status.code() == Some(HUNG))
}

/// Classic files never end the process. In NetCDF-4's the HDF5 library itself may: how often is printed, and depends on
/// its version; a panic, or values of a wrong kind, would be ours.
#[test]
fn damaged_files_end_in_a_result() {
    if let Ok(folder) = std::env::var(FOLDER) {
        return read_in_child(&folder);
    }
    let count: usize = count(100, 400);
    for (made, seed) in [Made::history(), Made::ocean(), Made::icon_data(Angles::Radians)].iter().zip(1..) {
        for (format, options) in formats() {
            let (_folder, path): (_, PathBuf) = made.write(options);
            let whole = std::fs::read(path).unwrap();
            // Damaged copies, numbered.
            let (folder, mut random) = (tempfile::tempdir().unwrap(), Random::new(seed));
            for number in 0..count {
                std::fs::write(folder.path().join(number.to_string()), spoilt(&whole, &mut random)).unwrap();
            }
            let found = outcomes("hostile::damaged_files_end_in_a_result", folder.path(), count);
            println!("{format}: {found:?}");
            assert_eq!(found.panics, 0, "{format}: {found:?}");
            assert!(found.errors > count / 10 && found.fine > count / 10, "{format}: {found:?}");
            if format != "NetCDF-4" {
                assert!(found.ended.is_empty() && found.hung.is_empty(), "{format}: {found:?}");
            }
        }
    }
}
