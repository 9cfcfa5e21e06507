//! Pictures against references, and their errors.

mod errors;
mod holes;
mod pictures;
mod random;
