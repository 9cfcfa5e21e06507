//! Every pixel of random scenes of all kinds within its error of an oracle that shares no code with the kernels.

use crate::study;

#[test]
fn no_pixel_of_random_scenes_is_beyond_its_error() {
    let printed = study(["error", "--random", "300", "--seed", "1"].into_iter());
    // The scenes are printed to the output, which an error does not carry.
    printed.unwrap_or_else(|e| panic!("{e}; icoray-study error --random 300 --seed 1 prints the scenes"));
}
