//! Random scenes on levels of detail: every pixel against the model's grid.

use super::{Checked, ROUNDING, RandomScene};
use crate::comparison::Comparison;
use icoray::{Frame, Precision, Renderer, Result, Scene};

/// Renders a scene [with levels](RandomScene::with_levels) on each level from the finest, by the renderers that draw on
/// level 1, 2 and so on, and compares every pixel with that of `finest` on the model's grid. Stops at the first level
/// that the grid does not have. Ratios are of pixels with a known error, below 1.
///
/// # Errors
/// As [`Renderer::render`].
pub fn check_levels(drawn: &RandomScene, finest: &Renderer, levels: &[Renderer]) -> Result<Vec<Checked>> {
    let grid = drawn.grid();
    let draw = |renderer: &Renderer, scene: &Scene| renderer.render(scene, &grid, &drawn.layers, drawn.model_fields()?);
    let truth = Scene { precision: Precision::F64, tolerance: 1e-7, ..drawn.scene.clone() };
    let truth = draw(finest, &truth)?;
    let mut checked = Vec::new();
    for (level, renderer) in (1..).zip(levels) {
        let frame = draw(renderer, &drawn.scene)?;
        if frame.report.quality.level != level {
            break;
        }
        checked.push(compare(drawn, &frame, &truth));
    }
    Ok(checked)
}

fn compare(drawn: &RandomScene, frame: &Frame, truth: &Frame) -> Checked {
    let mut checked = Checked { scenes: 1, pixels: frame.pixels.len(), ..Checked::default() };
    let differences = Comparison::new(&frame.pixels, &truth.pixels).pixel_errors;
    for ((difference, reported), exact) in differences.into_iter().zip(&frame.error).zip(&truth.error) {
        let allowed = f64::from(*reported) + f64::from(*exact);
        checked.beyond += usize::from(difference.is_nan() || difference > allowed);
        checked.worst = checked.worst.max(if difference > 0.0 { difference / allowed } else { 0.0 });
        if *reported < 1.0 && difference > ROUNDING {
            checked.ratios.push(f64::from(*reported) / difference);
        }
    }
    if checked.beyond > 0 {
        let RandomScene { seed, recipe, text, .. } = drawn;
        let (beyond, level) = (checked.beyond, frame.report.quality.level);
        let found = format!("seed {seed}, level {level}: {beyond} pixels beyond their error\n# {recipe}\n{text}");
        checked.failures.push(found);
    }
    checked
}
