//! The layers of a field between which anything is visible.

use icoray::device::{ColorByField, Isosurface, IsosurfacePaint, Job, Scenery, Span, SurfaceLayer, SurfacePlace};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Number of columns that are read at a time.
const CHUNK: usize = 1024;

/// The layers without the lowest and the highest ones that lie, together with their neighbour, within one clear span of
/// the transfer function over all of `columns`. Values that shaders read instead of the missing ones lie in the same
/// span, so that the picture is the same.
pub(crate) fn visible_layers(job: &Job, columns: &[u32]) -> Range<usize> {
    let layers = job.radius().len();
    if needs_all_layers(job) {
        return 0..layers;
    }
    let below = clear_layers(job, columns, |k| k);
    if below == layers {
        // All are clear, and a field has at least one layer.
        return 0..1;
    }
    let above = clear_layers(job, columns, |k| layers - 1 - k);
    // Gradients read one layer more.
    let kept = if job.shading().is_some() { 2 } else { 1 };
    below.max(kept) - kept..layers - above.max(kept) + kept
}

/// Whether values that the transfer function shows as clear are needed: for an isosurface, or for the colour of a volume
/// with the opacity of another field.
pub(crate) fn needs_all_layers(job: &Job) -> bool {
    let is_of_own = |surface: &Isosurface| {
        let is_painted = matches!(&surface.paint, IsosurfacePaint::Field(ColorByField { field: None, .. }));
        surface.field.is_none() || is_painted
    };
    let is_between = |surface: &SurfaceLayer| matches!(surface.place, SurfacePlace::Radius(_));
    let needs = |scenery: &Scenery| {
        !scenery.volumes.is_empty()
            || scenery.isosurfaces.iter().any(is_of_own)
            || scenery.surface_layers.iter().any(is_between)
    };
    job.scenery().is_some_and(needs)
}

/// Counts the layers, in the order of `layer`, whose values all lie in the clear span of the first value.
fn clear_layers(job: &Job, columns: &[u32], layer: impl Fn(usize) -> usize + Sync) -> usize {
    let value = |column: u32, k: usize| {
        let mut value = [0.0];
        job.values(&[column], layer(k)..layer(k) + 1, 0, &mut value);
        value[0]
    };
    let Some(first) = columns.first().map(|column| value(*column, 0)) else { return 0 };
    let spans = job.spans();
    let Some(span) = spans.iter().find(|span| span.is_clear && is_inside(span, first)) else { return 0 };
    let clear = AtomicUsize::new(job.radius().len());
    let check = |columns: &[u32]| {
        let mut values = [0.0; CHUNK];
        let values = &mut values[..columns.len()];
        for k in 0..clear.load(Ordering::Relaxed) {
            job.values(columns, layer(k)..layer(k) + 1, 0, values);
            if !values.iter().all(|value| is_inside(span, *value)) {
                clear.fetch_min(k, Ordering::Relaxed);
            }
            if clear.load(Ordering::Relaxed) <= k {
                break;
            }
        }
    };
    // A sample of the whole globe first: it shows quickly that most fields have no clear layer.
    let sample: Vec<u32> = columns.iter().step_by((columns.len() / CHUNK).max(1)).copied().take(CHUNK).collect();
    check(&sample);
    columns.par_chunks(CHUNK).for_each(check);
    clear.into_inner()
}

/// Whether a value lies inside a span by more than the rounding error of any mean of such values.
fn is_inside(span: &Span, value: f32) -> bool {
    const FARTHEST: f32 = 100.0;
    const MARGIN: f32 = 1e-3;
    value.abs() <= FARTHEST && value - MARGIN >= span.low && value + MARGIN <= span.high
}
