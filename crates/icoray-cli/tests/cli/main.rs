//! Runs the built binary on small files that the tests write, and on real ones if the test data are present.

#[expect(dead_code, reason = "the tests of datasets in memory use the rest")]
#[path = "../../../icoray-dataset/tests/dataset/made.rs"]
mod made;
#[path = "../../../icoray-dataset/tests/dataset/made_icon.rs"]
mod made_icon;

mod files;
mod gpu;
mod heights;
mod icon;
#[cfg(target_os = "linux")]
mod isolated;
mod ocean;
mod printed;
mod progress;
#[cfg(feature = "mpi")]
mod ranks;
mod real;
mod refused;
mod run;
mod sample;
mod series;
mod shell;
mod suggested;
mod surfaces;
mod times;
mod view;
mod viewer;
mod views;
mod watch;
#[expect(dead_code, reason = "the tests of files use the rest")]
#[path = "../../../icoray-netcdf/tests/files/written.rs"]
mod written;
