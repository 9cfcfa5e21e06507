//! References, errors and timings of icoray.
