//! Peak memory of this process, from Linux's `/proc`.

use crate::results::{io_error, read_text, write_file};
use icoray::Result;
use icoray_shared_memory::trim_heap;
use std::path::Path;

/// Measures the peak memory of this process since `start`, beyond the memory at `start`.
pub(crate) struct PeakMemory(u64);

impl PeakMemory {
    pub fn start() -> Result<Self> {
        // Memory that is used again would not show as an increase.
        trim_heap();
        let path = Path::new("/proc/self/clear_refs");
        write_file(path, "5")?;
        status("VmRSS:").map(PeakMemory)
    }

    pub fn bytes(&self) -> Result<u64> {
        Ok(status("VmHWM:")?.saturating_sub(self.0))
    }
}

fn status(name: &str) -> Result<u64> {
    let path = Path::new("/proc/self/status");
    let text = read_text(path)?;
    let of_line = |line: &str| line.strip_prefix(name)?.trim().strip_suffix(" kB")?.trim().parse().ok();
    let kilobytes: u64 = text.lines().find_map(of_line).ok_or_else(|| io_error(path, format!("has no {name}")))?;
    Ok(1024 * kilobytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    // One test, as others in this process would disturb it; twice what they may free meanwhile.
    #[test]
    fn memory_is_seen_to_rise_also_where_it_was_freed_before() {
        let peak = PeakMemory::start().unwrap();
        let block = std::hint::black_box(vec![1u8; 128 << 20]);
        let bytes = peak.bytes().unwrap();
        assert!(bytes >= 64 << 20, "{bytes} of {}", block.len());
        drop(block);
        // Too small to be given back at once, and below one that stays.
        let blocks = || (0..2048).map(|i| std::hint::black_box(vec![i as u8; 60 << 10])).collect::<Vec<_>>();
        let mut freed = blocks();
        let last = freed.pop();
        drop(freed);
        let peak = PeakMemory::start().unwrap();
        let again = blocks();
        let bytes = peak.bytes().unwrap();
        assert!(bytes >= 60 << 20, "{bytes} of {} blocks", again.len());
        drop(last);
    }
}
