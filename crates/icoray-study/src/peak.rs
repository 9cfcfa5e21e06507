//! How much memory this process takes, as the kernel tells.

use crate::io_error;
use icoray::Result;
use std::path::Path;

/// The most memory that this process has had since a moment, beyond what it had then.
pub(crate) struct Peak(u64);

impl Peak {
    pub fn start() -> Result<Self> {
        let path = Path::new("/proc/self/clear_refs");
        std::fs::write(path, "5").map_err(|e| io_error(path, e))?;
        status("VmRSS:").map(Peak)
    }

    pub fn bytes(&self) -> Result<u64> {
        Ok(status("VmHWM:")?.saturating_sub(self.0))
    }
}

fn status(name: &str) -> Result<u64> {
    let path = Path::new("/proc/self/status");
    let text = std::fs::read_to_string(path).map_err(|e| io_error(path, e))?;
    let of_line = |line: &str| line.strip_prefix(name)?.trim().strip_suffix(" kB")?.trim().parse().ok();
    let kilobytes: u64 =
        text.lines().find_map(of_line).ok_or_else(|| io_error(path, format!("has no {name}")))?;
    Ok(1024 * kilobytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_seen_to_rise() {
        let peak = Peak::start().unwrap();
        let block = std::hint::black_box(vec![1u8; 64 << 20]);
        let bytes = peak.bytes().unwrap();
        assert!(bytes >= 60 << 20, "{bytes} of {}", block.len());
    }
}
