//! The C ABI of icoray.
