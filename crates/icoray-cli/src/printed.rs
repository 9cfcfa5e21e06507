//! stdout, without the control characters of files, paths and scenes.

use icoray::printable;
use std::io::{self, StdoutLock, Write};

/// Writes lines. Each text that is written, as each piece of `writeln!`, has whole characters.
pub struct Printed(pub StdoutLock<'static>);

impl Write for Printed {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let text = String::from_utf8_lossy(bytes);
        let lines: Vec<_> = text.split('\n').map(printable).collect();
        self.0.write_all(lines.join("\n").as_bytes())?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}
