//! Reads NetCDF files: small ones that the tests write themselves, and real ones if the test data are present.

mod asked;
mod damaged;
mod filters;
mod formats;
mod groups;
#[expect(dead_code, reason = "the tests of datasets in memory use the rest")]
#[path = "../../../icoray-dataset/tests/dataset/made.rs"]
mod made;
#[path = "../../../icoray-dataset/tests/dataset/made_icon.rs"]
mod made_icon;
#[expect(dead_code, reason = "the tests of datasets in memory use the rest")]
#[path = "../../../icoray-dataset/tests/dataset/memory.rs"]
mod memory;
mod real;
mod written;
mod zarr;
