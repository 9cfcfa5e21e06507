//! What lit scenes have beside the others and their gradients: group 2 of the shaders' bindings.

use crate::gpu::Gpu;
use crate::layout::{Shading, halves3};
use crate::store::Lent;
use icoray::Lights;
use icoray::device::{Job, Reason};

/// How often a piece of a ray may be cut in two for its light's sake: `MOST_CUTS` of `shaders/kernel/lit.wgsl`.
const MOST_CUTS: u32 = 20;

/// The light of a job's rays, or what stands for it. It is to be kept until rays are submitted: a buffer that is given back is
/// the next one's, of another thread too.
pub(crate) fn uniform(gpu: &Gpu, job: &Job) -> Result<Lent, Reason> {
    gpu.lend_uniform("the light", &shading(job).unwrap_or_default())
}

/// The light's numbers, where there is any.
fn shading(job: &Job) -> Option<Shading> {
    let shading = job.shading()?;
    let [light_hi, light_lo] = halves3(shading.towards_light.unwrap_or_default());
    Some(Shading {
        light_hi,
        ambient: shading.ambient,
        light_lo,
        diffuse: shading.diffuse,
        specular: shading.specular,
        shininess: shading.shininess,
        sharpness: shading.sharpness,
        blind: shading.blind,
        dull: shading.dull,
        is_headlight: u32::from(shading.towards_light.is_none()),
        most_cuts: if job.quality().lights == Lights::Coarse { 0 } else { MOST_CUTS },
        padding: 0,
    })
}
