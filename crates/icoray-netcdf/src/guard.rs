//! Calls of the NetCDF binding, which a damaged file must not make print, unwind or run for ever.
//!
//! A call that waits for a disk uses no processor time, and one that works through a large file keeps reading. A damaged
//! structure that leads HDF5 in a circle does neither: it uses processor time and reads nothing, or the same bytes again.

use crate::hdf5_errors;
use icoray::{Error, ErrorKind, Result};
use std::cell::Cell;
use std::collections::BTreeMap;
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};
use std::thread;
use std::time::Duration;

/// Processor time that a call may take without reading: more than unpacking a chunk of 4 GB takes.
pub const CALL_LIMIT: Duration = Duration::from_secs(60);
/// Bytes that a call may read per byte of its file. It reads each chunk once, and some of the structure again.
const READS_PER_BYTE: u64 = 4;
/// Bytes that it may read of the shortest file.
const MIN_READS: u64 = 1 << 24;
/// Time between two looks at the calls.
const LOOK: Duration = Duration::from_secs(1);
/// Ticks of processor time in a second, in Linux's files of processes.
const TICKS: u64 = 100;

thread_local! {
    static IS_GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// A call that has not returned.
struct Call {
    /// What Linux shows of the thread.
    thread: PathBuf,
    path: PathBuf,
    what: String,
}

static CALLS: Mutex<BTreeMap<u64, Call>> = Mutex::new(BTreeMap::new());

fn calls() -> MutexGuard<'static, BTreeMap<u64, Call>> {
    CALLS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The entry of a call, until it is dropped.
struct Entry(u64);

impl Entry {
    fn new(path: &Path, what: &impl fmt::Display) -> Self {
        let thread = std::fs::read_link("/proc/thread-self").unwrap_or_default();
        let call = Call { thread: Path::new("/proc").join(thread), path: path.to_owned(), what: what.to_string() };
        static NUMBERS: AtomicU64 = AtomicU64::new(0);
        let number = NUMBERS.fetch_add(1, Ordering::Relaxed);
        calls().insert(number, call);
        Entry(number)
    }
}

impl Drop for Entry {
    fn drop(&mut self) {
        calls().remove(&self.0);
    }
}

/// Runs a call of the binding. It unwraps what the library reports in places where it cannot return an error; a damaged
/// file must not end the process, so such a panic becomes an error too, and is not printed.
pub(crate) fn guarded<T>(path: &Path, what: impl fmt::Display, call: impl FnOnce() -> netcdf::Result<T>) -> Result<T> {
    static QUIET: Once = Once::new();
    QUIET.call_once(|| {
        let print = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if !IS_GUARDED.get() {
                print(panic);
            }
        }));
    });
    hdf5_errors::silence();
    let _entry = Entry::new(path, &what);
    IS_GUARDED.set(true);
    let outcome = catch_unwind(AssertUnwindSafe(call));
    IS_GUARDED.set(false);
    let cause = match outcome {
        Ok(Ok(value)) => return Ok(value),
        Ok(Err(error)) => error.to_string(),
        Err(_) => "the file is damaged".to_owned(),
    };
    Err(Error::new(ErrorKind::Io, format!("{}: {what}: {cause}", path.display())))
}

/// Processor time of a thread, and bytes that it has read.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Usage {
    ticks: u64,
    read: u64,
}

impl Usage {
    /// That of the thread which Linux shows at `thread`; `None` on other systems.
    fn of(thread: &Path) -> Option<Self> {
        let stat = std::fs::read_to_string(thread.join("stat")).ok()?;
        // The name, in parentheses, may have blanks; user and system time are the fields 14 and 15.
        let times = stat.rsplit_once(") ")?.1.split(' ').skip(11).take(2).map(str::parse::<u64>);
        let ticks = times.sum::<std::result::Result<u64, _>>().ok()?;
        let io = std::fs::read_to_string(thread.join("io")).ok()?;
        let read = io.lines().find_map(|line| line.strip_prefix("rchar: "))?.parse().ok()?;
        Some(Usage { ticks, read })
    }
}

/// How far a call has come.
struct Advance {
    /// When it has read something new last.
    last: Usage,
    /// Bytes beyond which nothing that is read is new.
    limit: u64,
}

impl Advance {
    fn new(first: Usage, file_bytes: u64) -> Self {
        let allowed = file_bytes.saturating_mul(READS_PER_BYTE).max(MIN_READS);
        Advance { last: first, limit: first.read.saturating_add(allowed) }
    }

    /// Processor time since the call has read anything new.
    fn idle(&mut self, now: Usage) -> Duration {
        if now.read > self.last.read && self.last.read < self.limit {
            self.last = now;
        }
        Duration::from_millis(now.ticks.saturating_sub(self.last.ticks) * 1000 / TICKS)
    }
}

/// Watches all calls of this process from a thread of its own, on Linux: `on_hang` gets the error of a call that uses
/// `limit` of processor time without reading anything new, mostly [`CALL_LIMIT`]. Such a call never returns, so that the
/// process should end ([`end_process`]). A call that waits for a disk is waited for.
pub fn watch_calls(limit: Duration, on_hang: impl Fn(Error) + Send + 'static) {
    thread::spawn(move || {
        let mut known: BTreeMap<u64, Advance> = BTreeMap::new();
        loop {
            thread::sleep(LOOK.min(limit));
            let running = calls();
            known.retain(|number, _| running.contains_key(number));
            for (number, call) in &*running {
                let Some(usage) = Usage::of(&call.thread) else { continue };
                let length = || std::fs::metadata(&call.path).map_or(0, |metadata| metadata.len());
                let advance = known.entry(*number).or_insert_with(|| Advance::new(usage, length()));
                if advance.idle(usage) >= limit {
                    let context = format!(
                        "{}: {}: {} s of processor time have passed and nothing new was read: not whole, or damaged",
                        call.path.display(),
                        call.what,
                        limit.as_secs()
                    );
                    on_hang(Error::new(ErrorKind::Io, context));
                }
            }
        }
    });
}

/// Ends this process at once. What libraries do at the end of a process would wait for a call that never returns.
pub fn end_process(code: i32) -> ! {
    // SAFETY: ends the process and returns to no code.
    unsafe { libc::_exit(code) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use icoray_test_support::PATIENCE;
    use std::process::Command;
    use std::sync::mpsc::channel;
    use std::time::Instant;

    #[test]
    fn reading_on_is_an_advance_and_reading_again_is_none() {
        let usage = |ticks, read| Usage { ticks, read };
        let limit = 10 + MIN_READS;
        let mut advance = Advance::new(usage(5, 10), 1000);
        for (now, idle_ms) in [
            (usage(5, 10), 0),
            // An hour in a call of a disk is none of the processor's.
            (usage(5, 10), 0),
            (usage(305, 10), 3000),
            (usage(400, 11), 0),
            (usage(450, 11), 500),
            (usage(500, limit), 0),
            (usage(600, limit + 1), 1000),
            (usage(6500, u64::MAX), 60_000),
        ] {
            assert_eq!(advance.idle(now), Duration::from_millis(idle_ms), "{now:?}");
        }
        // A large file is read for as long as it has bytes.
        let mut advance = Advance::new(usage(0, 0), MIN_READS);
        assert!((1..=4).all(|part| advance.idle(usage(part * 10_000, part * MIN_READS)) == Duration::ZERO));
        assert_eq!(advance.idle(usage(50_000, 5 * MIN_READS)), Duration::from_secs(100));
    }

    /// One call goes in a circle and another, which began before it, waits.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_call_in_a_circle_is_found_and_a_slow_disk_is_waited_for() {
        let (report, reports) = channel();
        watch_calls(Duration::from_millis(100), move |error| drop(report.send(error)));
        let ((begin, begun), (release, disk)) = (channel(), channel::<()>());
        let waiting = thread::spawn(move || {
            guarded(Path::new("slow.nc"), "variable q", || {
                begin.send(()).unwrap();
                Ok(disk.recv().unwrap())
            })
        });
        begun.recv().unwrap();
        let start = Instant::now();
        let found = guarded(Path::new("circle.nc"), "the list of variables", || {
            while start.elapsed() < PATIENCE {
                if let Ok(error) = reports.try_recv() {
                    return Ok(error);
                }
            }
            Err("the call was not found".into())
        });
        let found = found.unwrap();
        assert!(found.context().starts_with("circle.nc: the list of variables: 0 s of processor time"), "{found}");
        release.send(()).unwrap();
        waiting.join().unwrap().unwrap();
        assert!(reports.try_iter().all(|error| !error.context().contains("slow.nc")));
    }

    /// Set in the process whose stderr is looked at.
    const CHILD: &str = "ICORAY_TEST_GUARDED_PANIC";

    #[test]
    fn a_panic_of_the_binding_is_an_error_and_prints_nothing() {
        if std::env::var_os(CHILD).is_some() {
            let error = guarded(Path::new("a.nc"), "dimension x", || -> netcdf::Result<()> { panic!("unwrapped") });
            assert_eq!(error.unwrap_err().context(), "a.nc: dimension x: the file is damaged");
            return;
        }
        let name = "guard::tests::a_panic_of_the_binding_is_an_error_and_prints_nothing";
        let mut command = Command::new(std::env::current_exe().unwrap());
        let output = command.args(["--exact", name, "--nocapture", "--test-threads=1"]).env(CHILD, "1").output().unwrap();
        let printed = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
        assert!(output.status.success() && printed[0].contains("running 1 test"), "{printed:?}");
        assert_eq!(printed[1], "");
    }
}
