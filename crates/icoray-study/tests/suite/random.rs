//! Every pixel of random scenes of all kinds within its error of an oracle that shares no code with the kernels.

use crate::study;
use icoray_test_support::count;

#[test]
fn no_pixel_of_random_scenes_is_beyond_its_error() {
    let scenes = count(300, 10_000);
    let printed = study(["error", "--random", &scenes.to_string(), "--seed", "1"].into_iter());
    // The scenes are printed to the output, which an error does not carry.
    printed.unwrap_or_else(|e| panic!("{e}; icoray-study error --random {scenes} --seed 1 prints the scenes"));
}
