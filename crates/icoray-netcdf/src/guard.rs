//! Guards calls of the NetCDF binding: a damaged file must not make them print, unwind or loop.
//!
//! A call that waits for a disk, even for hours, uses no processor time; one that unpacks a whole file uses a time that
//! its length bounds. An endless loop of HDF5 over a damaged structure uses more.

use hdf5_metno_sys::{LOCK, h5e};
use icoray::{Error, ErrorKind, Result};
use std::cell::Cell;
use std::collections::BTreeMap;
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};
use std::time::Duration;

/// Bytes of a file for which a call may take a second of processor time: a tenth of what decompression takes.
const BYTES_PER_SECOND: u64 = 10_000_000;
/// Ticks of processor time in a second, in Linux's files of processes.
const TICKS: u64 = 100;

thread_local! {
    static IS_GUARDED: Cell<bool> = const { Cell::new(false) };
    /// Whether HDF5 prints no errors in this thread.
    static IS_SILENT: Cell<bool> = const { Cell::new(false) };
}

/// A call that has not returned.
struct Call {
    /// What Linux shows of the thread.
    thread: PathBuf,
    path: PathBuf,
    what: String,
    /// The thread's processor time when the call was seen first.
    begin: Option<Duration>,
}

static CALLS: Mutex<BTreeMap<u64, Call>> = Mutex::new(BTreeMap::new());

fn calls() -> MutexGuard<'static, BTreeMap<u64, Call>> {
    CALLS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Runs a call of the binding. It unwraps what the library reports in places where it cannot return an error; a damaged
/// file must not end the process, so such a panic becomes an error too, and is not printed.
pub(crate) fn guarded<T>(path: &Path, what: impl fmt::Display, call: impl FnOnce() -> netcdf::Result<T>) -> Result<T> {
    static NUMBERS: AtomicU64 = AtomicU64::new(0);
    static QUIET: Once = Once::new();
    QUIET.call_once(|| {
        let print = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if !IS_GUARDED.get() {
                print(panic);
            }
        }));
    });
    silence_hdf5();
    let number = NUMBERS.fetch_add(1, Ordering::Relaxed);
    let thread = Path::new("/proc").join(std::fs::read_link("/proc/thread-self").unwrap_or_default());
    calls().insert(number, Call { thread, path: path.to_owned(), what: what.to_string(), begin: None });
    IS_GUARDED.set(true);
    let outcome = catch_unwind(AssertUnwindSafe(call));
    IS_GUARDED.set(false);
    calls().remove(&number);
    let cause = match outcome {
        Ok(Ok(value)) => return Ok(value),
        Ok(Err(error)) => error.to_string(),
        Err(_) => "the file is damaged".to_owned(),
    };
    Err(Error::new(ErrorKind::Io, format!("{}: {what}: {cause}", path.display())))
}

/// Disables HDF5's error reports in this thread.
///
/// The NetCDF library queries optional attributes, which fail in HDF5, and returns real failures itself. It disables
/// the reports only in the thread that initialises it; HDF5 keeps the setting per thread.
fn silence_hdf5() {
    if IS_SILENT.replace(true) {
        return;
    }
    let _lock = LOCK.lock();
    // SAFETY: the lock is the one that the NetCDF binding takes; no callback is set, so no data are used.
    unsafe {
        h5e::H5Eset_auto2(h5e::H5E_DEFAULT, None, std::ptr::null_mut());
    }
}

/// Watches all calls of the process from a thread of its own, on Linux. `on_hang` gets the error of a call that has
/// used the processor time `min_time` and what the length of its file allows. It never returns, so that the process
/// should end ([`end_process`]).
pub fn watch_calls(min_time: Duration, on_hang: impl Fn(Error) + Send + 'static) {
    std::thread::spawn(move || {
        loop {
            std::thread::sleep(min_time / 64);
            for call in calls().values_mut() {
                let Some(now) = processor_time(&call.thread) else { continue };
                let length = std::fs::metadata(&call.path).map_or(0, |metadata| metadata.len());
                let used = now.saturating_sub(*call.begin.get_or_insert(now));
                if used > min_time + Duration::from_secs(length / BYTES_PER_SECOND) {
                    let (path, what, used) = (call.path.display(), &call.what, used.as_secs());
                    let context =
                        format!("{path}: {what}: no end after {used} s of processor time: incomplete or damaged");
                    on_hang(Error::new(ErrorKind::Io, context));
                }
            }
        }
    });
}

/// Processor time of the thread that Linux shows at `thread`; `None` on other systems.
fn processor_time(thread: &Path) -> Option<Duration> {
    let stat = std::fs::read_to_string(thread.join("stat")).ok()?;
    // The name, in parentheses, may have blanks; user and system time are the fields 14 and 15.
    let times = stat.rsplit_once(") ")?.1.split(' ').skip(11).take(2).map(str::parse::<u64>);
    let ticks = times.sum::<std::result::Result<u64, _>>().ok()?;
    Some(Duration::from_millis(ticks * 1000 / TICKS))
}

/// Ends this process at once. What libraries do at the end of a process would wait for a call that never returns.
pub fn end_process(code: i32) -> ! {
    // SAFETY: ends the process and returns to no code.
    unsafe { libc::_exit(code) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::Command;
    use std::sync::mpsc::channel;
    use std::thread;

    /// One call goes in a circle until it is found, and another, which began before it, waits meanwhile.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_call_in_a_circle_is_found_and_a_slow_disk_is_waited_for() {
        let (report, reports) = channel();
        watch_calls(Duration::from_millis(200), move |error| drop(report.send(error)));
        let ((begin, begun), (release, disk)) = (channel(), channel::<()>());
        let waiting = thread::spawn(move || {
            guarded(Path::new("slow.nc"), "variable q", || {
                begin.send(()).unwrap();
                disk.recv().unwrap();
                Ok(())
            })
        });
        begun.recv().unwrap();
        let circle = || loop {
            if let Ok(error) = reports.try_recv() {
                return Ok(error);
            }
        };
        let found = guarded(Path::new("circle.nc"), "the list of variables", circle).unwrap();
        assert!(found.context().starts_with("circle.nc: the list of variables: no end after"), "{found}");
        release.send(()).unwrap();
        waiting.join().unwrap().unwrap();
        assert!(reports.try_iter().all(|error| !error.context().contains("slow.nc")));
    }

    /// Set in the process whose stderr is checked.
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
        let output = command.args(["--exact", name, "--nocapture"]).env(CHILD, "1").output().unwrap();
        let printed = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
        assert!(output.status.success() && printed[0].contains("running 1 test"), "{printed:?}");
        assert_eq!(printed[1], "");
    }
}
