//! Damaged files, in a separate test program: the processes that it starts would inherit open files of other tests, and
//! HDF5's locks on them.

mod hostile;
#[expect(dead_code, reason = "the tests of whole files use the rest")]
#[path = "../../../icoray-dataset/tests/dataset/made.rs"]
mod made;
#[expect(dead_code, reason = "the tests of whole files use the rest")]
#[path = "../../../icoray-dataset/tests/dataset/made_icon.rs"]
mod made_icon;
#[path = "../files/written.rs"]
mod written;
