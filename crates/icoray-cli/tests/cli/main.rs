//! Runs the built binary on small files that the tests write, and on real ones where the test data are there.

#[path = "../../../icoray-netcdf/tests/files/made.rs"]
mod made;

mod files;
mod gpu;
mod real;
mod refused;
mod run;
