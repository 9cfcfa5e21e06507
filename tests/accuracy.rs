//! Pictures against references, their errors, and the instructions that they take.

mod errors;
mod instructions;
mod pictures;
