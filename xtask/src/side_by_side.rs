//! Runs tasks in parallel, as many at a time as there are processors.

use std::sync::{Mutex, PoisonError};
use std::thread;

/// Does `work` with each of the items, begun in their order; `take` has the outcomes as they come.
pub fn side_by_side<T: Send, R>(items: Vec<T>, work: impl Fn(T) -> R + Sync, take: impl FnMut(R) + Send) {
    let (queue, take) = (Mutex::new(items.into_iter()), Mutex::new(take));
    let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
    let worker = || {
        while let Some(item) = next() {
            let outcome = work(item);
            take.lock().unwrap_or_else(PoisonError::into_inner)(outcome);
        }
    };
    thread::scope(|scope| {
        (0..thread::available_parallelism().map_or(1, usize::from)).for_each(|_| drop(scope.spawn(worker)));
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_items_have_an_outcome() {
        let mut squares = Vec::new();
        side_by_side((0..100).collect(), |number: u32| number * number, |square| squares.push(square));
        squares.sort_unstable();
        assert_eq!(squares, (0..100).map(|number| number * number).collect::<Vec<_>>());
    }
}
