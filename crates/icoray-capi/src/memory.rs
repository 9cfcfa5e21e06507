//! The system's allocator with two counters of icoray's memory.
//!
//! It serves this library only, which has its own copy of Rust's standard library, not the host. An allocation costs
//! two relaxed atomic additions; rays do not allocate.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Currently allocated bytes.
static ALLOCATED: AtomicUsize = AtomicUsize::new(0);
/// Peak of the allocated bytes.
static PEAK: AtomicUsize = AtomicUsize::new(0);

/// Peak of the memory that icoray has allocated, bytes.
pub(crate) fn peak() -> u64 {
    PEAK.load(Relaxed) as u64
}

struct Counted;

impl Counted {
    fn grew(by: usize) {
        let allocated = ALLOCATED.fetch_add(by, Relaxed) + by;
        // Usually only a read, as new peaks are rare.
        if allocated > PEAK.load(Relaxed) {
            PEAK.fetch_max(allocated, Relaxed);
        }
    }

    fn shrank(by: usize) {
        ALLOCATED.fetch_sub(by, Relaxed);
    }
}

// SAFETY: every call is passed on to the system's allocator as it came; the counters change nothing.
unsafe impl GlobalAlloc for Counted {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: passed on.
        let pointer = unsafe { System.alloc(layout) };
        if !pointer.is_null() {
            Self::grew(layout.size());
        }
        pointer
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: passed on.
        let pointer = unsafe { System.alloc_zeroed(layout) };
        if !pointer.is_null() {
            Self::grew(layout.size());
        }
        pointer
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: passed on.
        unsafe { System.dealloc(pointer, layout) };
        Self::shrank(layout.size());
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: passed on.
        let moved = unsafe { System.realloc(pointer, layout, size) };
        if !moved.is_null() {
            Self::grew(size);
            Self::shrank(layout.size());
        }
        moved
    }
}

#[global_allocator]
static ALLOCATOR: Counted = Counted;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_peak_counts_bytes_that_are_allocated_at_once() {
        let size = 16 << 20;
        let before = ALLOCATED.load(Relaxed);
        drop(vec![1u8; size]);
        assert!(peak() >= (before + size) as u64 / 2 && peak() >= size as u64);
        for _ in 0..20 {
            drop(vec![1u8; size]);
        }
        assert!(peak() < 15 * size as u64, "freed memory does not add up: {}", peak());
        let mut grown: Vec<u8> = Vec::with_capacity(size);
        grown.resize(4 * size, 1);
        assert!(peak() >= 4 * size as u64);
    }
}
