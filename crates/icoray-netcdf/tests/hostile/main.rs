//! Damaged files, in a test program of their own: it starts others, which would inherit the files that tests beside it
//! have open, and HDF5's locks on them.

mod hostile;
#[expect(dead_code, reason = "the tests of whole files use the rest")]
#[path = "../../../icoray-dataset/tests/dataset/made.rs"]
mod made;
#[expect(dead_code, reason = "the tests of whole files use the rest")]
#[path = "../../../icoray-dataset/tests/dataset/made_icon.rs"]
mod made_icon;
#[expect(dead_code, reason = "the tests of whole files use the rest")]
#[path = "../../../icoray-dataset/tests/dataset/made_ocean.rs"]
mod made_ocean;
#[path = "../files/written.rs"]
mod written;
