//! Every pixel of random scenes of all kinds within its error of an oracle that shares no code with the kernels.

use icoray::Renderer;
use icoray_reference::random::{Checked, RandomScene, check, check_levels};

/// Checks every pixel of the scenes of these seeds.
fn no_pixel_is_beyond_its_error(seeds: impl Iterator<Item = u64>) {
    let [renderer, all] = [1, 0].map(|threads| Renderer::new(threads).unwrap());
    let mut checked = Checked::default();
    for seed in seeds {
        checked.add(check(&RandomScene::new(seed).unwrap(), &renderer, &all).unwrap());
    }
    println!("{} pixels, {} undecided", checked.pixels, checked.undecided);
    assert!(checked.failures.is_empty(), "{}", checked.failures.join("\n"));
}

#[test]
fn no_pixel_of_random_scenes_is_beyond_its_error() {
    no_pixel_is_beyond_its_error(1..=300);
}

/// Scenes on coarser grids, whatever the error of these. One has so many holes that no grid is coarser than that of
/// their rims; in the last the eye is between the innermost layers' facets of two grids.
#[test]
fn no_pixel_of_random_scenes_on_levels_is_beyond_its_error() {
    let finest = Renderer::new(2).unwrap();
    let levels = [1, 2].map(|level| Renderer::new(2).unwrap().on_level(level));
    let (mut checked, mut on_coarsest) = (Checked::default(), 0);
    for seed in (800_001..800_101).chain([801_573]) {
        let drawn = RandomScene::with_levels(seed).unwrap();
        let of_levels = check_levels(&drawn, &finest, &levels).unwrap();
        on_coarsest += usize::from(of_levels.len() == levels.len());
        of_levels.into_iter().for_each(|level| checked.add(level));
    }
    println!("{} pixels on levels, {} errors known", checked.pixels, checked.ratios.len());
    assert!(checked.failures.is_empty(), "{}", checked.failures.join("\n"));
    assert!(on_coarsest > 40 && checked.ratios.len() > 3_000, "{on_coarsest}, {}", checked.ratios.len());
}

/// Scenes that were wrong once: frames that did not end; a surface on the outermost layer along the axis; a smaller
/// tolerance that made a picture worse; a core with two shades; fields that reach far beyond their transfer functions,
/// unlit and lit; values over decades; last digits of lit isosurfaces; dense volumes that begin clear; highlights
/// beside a fast turn; dense pieces where normals cancel; a frustum that was integrated twice; a missing value beside
/// an opaque volume; gradients whose rounding many parts share; light that passes an opaque piece; a ray through a
/// vertex; a step where the field is flatter than in the mean; rounding of values at the ends of frusta; last digits of
/// a lit core; gradients of values that differ in last digits; a ray from above a vertex through the centre; an opaque
/// volume that begins where the gradients cancel.
#[test]
fn random_scenes_that_were_wrong_are_right() {
    let seeds = [
        274, 631, 1012, 807, 727, 1328, 3797, 4604, 1087, 5047, 357, 221, 2566, 1447, 79, 6778, 8643, 7814, 7090, 8112,
        6431, 2547, 7018, 4644, 7803, 8557, 33063, 43779, 34622, 31239, 30618, 30412, 46341, 53723, 60146, 72717,
        93773, 110797, 111262, 140878, 142845, 310615,
    ];
    no_pixel_is_beyond_its_error(seeds.into_iter());
}
