//! A thread pool whose threads have ended when it is dropped.
//!
//! Rayon signals the threads of a dropped pool to end and does not wait for them. A model that closes icoray and then
//! unloads the library, forks or counts its threads would find threads still running, so the pool joins its threads.

use crate::error::{Error, ErrorKind, Result};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::num::NonZero;
use std::thread::{Builder, JoinHandle, available_parallelism, current};

/// Threads of a renderer.
#[derive(Debug)]
pub struct Threads {
    /// Dropped first, which ends the threads.
    pool: ThreadPool,
    handles: Handles,
}

/// Joins the threads when dropped.
#[derive(Debug)]
struct Handles(Vec<JoinHandle<()>>);

impl Drop for Handles {
    fn drop(&mut self) {
        // Work that drops its own threads cannot wait for them: they stay until it is done.
        if self.0.iter().any(|handle| handle.thread().id() == current().id()) {
            return;
        }
        for handle in self.0.drain(..) {
            // Rayon has reported panics to the caller of the work already.
            let _ = handle.join();
        }
    }
}

impl Threads {
    /// Starts `count` threads, or as many as the affinity mask allows for 0. Rayon's own default would obey an
    /// environment variable that is meant for other programs.
    ///
    /// # Errors
    /// [`ErrorKind::Io`] if the system starts no thread.
    pub fn new(count: usize) -> Result<Self> {
        let count = if count == 0 { available_parallelism().map_or(1, NonZero::get) } else { count };
        let mut handles = Handles(Vec::with_capacity(count));
        let spawn = |thread: rayon::ThreadBuilder| {
            let named = Builder::new().name(format!("icoray-{}", thread.index()));
            handles.0.push(named.spawn(|| thread.run())?);
            Ok(())
        };
        let pool = ThreadPoolBuilder::new().num_threads(count).spawn_handler(spawn).build();
        let pool = pool.map_err(|e| Error::new(ErrorKind::Io, format!("cannot make {count} threads: {e}")))?;
        Ok(Threads { pool, handles })
    }

    /// Number of threads.
    pub fn count(&self) -> usize {
        self.handles.0.len()
    }

    /// Runs `work` on the threads.
    pub fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        let (mut work, mut result) = (Some(work), None);
        install(&self.pool, &mut || result = work.take().map(|work| work()));
        match result {
            Some(result) => result,
            None => unreachable!("the pool returns when the work is done"),
        }
    }

    /// Runs `work` on the threads and meanwhile `beside` on this one, which must not wait for anything that `work` may
    /// not deliver. Returns when both are done.
    pub fn run_with<R>(&self, work: impl FnOnce() + Send, beside: impl FnOnce() -> R) -> R {
        self.pool.in_place_scope(|scope| {
            scope.spawn(|_| work());
            beside()
        })
    }
}

/// Runs `work` on a thread of the pool: compiled once, not for each type of work.
fn install(pool: &ThreadPool, work: &mut (dyn FnMut() + Send)) {
    pool.install(work);
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;
    use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
    use std::sync::mpsc::channel;
    use std::time::Duration;

    static ENDED: AtomicUsize = AtomicUsize::new(0);

    /// Counts when its thread ends, and takes its time over it.
    struct Last(Cell<bool>);

    impl Drop for Last {
        fn drop(&mut self) {
            std::thread::sleep(Duration::from_millis(50));
            ENDED.fetch_add(1, SeqCst);
        }
    }

    thread_local! {
        static LAST: Last = const { Last(Cell::new(false)) };
    }

    #[test]
    fn threads_have_ended_when_the_pool_is_dropped() {
        let threads = Threads::new(3).unwrap();
        threads.run(|| rayon::broadcast(|_| LAST.with(|last| last.0.set(true))));
        assert_eq!((threads.count(), ENDED.load(SeqCst)), (3, 0));
        drop(threads);
        assert_eq!(ENDED.load(SeqCst), 3);
    }

    #[test]
    fn work_may_drop_its_own_threads() {
        let threads = std::sync::Arc::new(Threads::new(2).unwrap());
        let theirs = threads.clone();
        let (sent, received) = channel::<()>();
        let (done, is_done) = channel();
        threads.pool.spawn(move || {
            let _ = received.recv();
            // The last one, on one of its own threads.
            drop(theirs);
            let _ = done.send(());
        });
        drop(threads);
        sent.send(()).unwrap();
        is_done.recv().unwrap();
    }
}
