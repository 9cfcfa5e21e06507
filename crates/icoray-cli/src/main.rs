//! icoray on the command line.
fn main() {}
