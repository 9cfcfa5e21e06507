//! The tolerances of rays, from the tolerance of a scene.

use icoray_kernel::Budget;
use icoray_scene::{Lights, Paint, Quality, Scene};

/// The error budget of rays that end as early as the tolerance permits, and find the edges of surfaces, where the scene
/// may have such edges.
pub(crate) fn allowed(scene: &Scene, quality: &Quality) -> Budget {
    let lit = scene.lighting.filter(|_| quality.lights != Lights::Off).map(|light| light.ambient + light.diffuse);
    let budget = Budget::new(quality.tolerance, brightest(scene), lit);
    if scene.antialias && scene.has_boundaries() { budget.with_surfaces() } else { budget }
}

/// The largest channel value behind a ray's end: the brightest colour in the scene.
pub(crate) fn brightest(scene: &Scene) -> f64 {
    let most = |colors: &mut dyn Iterator<Item = [f64; 3]>| colors.flatten().fold(0.0, f64::max);
    let paints = scene.scenery.paints().filter_map(|paint| match paint {
        Paint::Plain(color) => Some(*color),
        Paint::Field { .. } => None,
    });
    let paintings = scene.paintings();
    let knots = paintings.iter().flat_map(|painting| &painting.transfer.knots);
    let field = most(&mut knots.map(|knot| knot.color).chain(paints));
    let lit = scene.lighting.map_or(field, |l| (l.ambient + l.diffuse) * field + l.specular);
    let ground = scene.scenery.ground;
    let lines = scene.scenery.lines.iter().map(|lines| lines.color);
    let solid = scene.core.into_iter().chain(ground.land).chain(ground.ocean).chain(lines);
    let solid = most(&mut { solid }) * scene.lighting.map_or(1.0, |l| l.ambient + l.diffuse);
    // A transparent picture has an opacity of up to 1.
    let back = scene.background.map_or(1.0, |back| most(&mut [back].into_iter()));
    lit.max(solid).max(back).max(0.01)
}
