//! What a scene shows beside its volume, as shaders read it.

use crate::bindings;
use crate::layout::{Clip, Scenery, halves, halves3};
use crate::picture::Picture;
use crate::pool::PooledBuffer;
use icoray::device::{ClipRegion, FallbackReason, Job};

/// Group 2 of the shader of a picture, and the buffers that are bound there: not to return to the pool before all bands
/// are submitted.
pub(crate) struct SceneGroup {
    pub group: wgpu::BindGroup,
    _buffers: Vec<PooledBuffer>,
}

impl SceneGroup {
    /// Uploads light and scenery of a picture.
    pub fn new(picture: &Picture) -> Result<Self, FallbackReason> {
        let (ctx, pipelines) = (picture.ctx, picture.pipelines);
        let mut buffers = vec![picture.light()?];
        let mut layout = &pipelines.picture;
        if let Some(scenery) = scenery(picture.job) {
            buffers.push(ctx.pooled_uniform("scenery", &scenery)?);
            layout = &pipelines.scene;
        }
        let group = bindings::group(ctx, layout, buffers.iter().map(|buffer| &**buffer))?;
        Ok(SceneGroup { group, _buffers: buffers })
    }
}

/// The scenery of a job; `None` if its scene is plain.
fn scenery(job: &Job) -> Option<Scenery> {
    let shown = job.scenery()?;
    let mut scenery =
        Scenery { clip_count: shown.clips.len() as u32, seen_above: job.sees_above(), ..Scenery::default() };
    scenery.clips.iter_mut().zip(&shown.clips).for_each(|(clip, region)| *clip = clip_of(region));
    Some(scenery)
}

fn clip_of(region: &ClipRegion) -> Clip {
    let [first, last] = region.layers.map_or([0, u32::MAX], |layers| layers.map(|layer| layer as u32));
    let cuts_inside = u32::from(region.cuts_inside);
    let mut clip = Clip { first_layer: first, last_layer: last, cuts_inside, ..Clip::default() };
    if let Some((towards, distance)) = region.half_space {
        clip.kind |= Clip::HAS_HALF_SPACE;
        [clip.towards_hi, clip.towards_lo] = halves3(towards);
        [clip.distance_hi, clip.distance_lo] = halves(distance);
    }
    if let Some(shell) = region.shell {
        clip.kind |= Clip::HAS_SHELL;
        [clip.inner, clip.outer] = shell.map(halves);
    }
    let Some(region) = region.region else { return clip };
    clip.kind |= Clip::HAS_LATITUDES;
    // Beyond the poles, where rounding is not asked.
    let sine = |lat: f64| if lat.abs() < 90.0 { lat.to_radians().sin() } else { 2.0 * lat.signum() };
    [clip.south, clip.north] = region.lat_deg.map(|lat| halves(sine(lat)));
    let [west, east] = region.lon_deg;
    if east - west < 360.0 {
        clip.kind |= Clip::HAS_LONGITUDES | if east - west > 180.0 { Clip::IS_WIDE } else { 0 };
        [clip.west, clip.east] = region.lon_deg.map(|lon| {
            let [[x, x_lo], [y, y_lo]] = [-lon.to_radians().sin(), lon.to_radians().cos()].map(halves);
            [x, y, x_lo, y_lo]
        });
    }
    clip
}
