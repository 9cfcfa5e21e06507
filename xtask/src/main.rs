//! Installs what is missing, runs the demo and the tests.
fn main() {}
