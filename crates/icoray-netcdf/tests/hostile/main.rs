//! Damaged files, in a test program of their own: it starts others, which would inherit the files that tests beside it
//! have open, and HDF5's locks on them.

#[allow(dead_code, reason = "the tests of whole files use the rest")]
#[path = "../files/changed.rs"]
mod changed;
mod hostile;
#[allow(dead_code, reason = "the tests of whole files use the rest")]
#[path = "../files/made.rs"]
mod made;
#[allow(dead_code, reason = "the tests of whole files use the rest")]
#[path = "../files/made_icon.rs"]
mod made_icon;
#[allow(dead_code, reason = "the tests of whole files use the rest")]
#[path = "../files/made_ocean.rs"]
mod made_ocean;
