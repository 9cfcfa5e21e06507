//! A picture on the device, without its field: parameters, transfer function, shell and light.

use crate::context::Context;
use crate::culling::CellSet;
use crate::layout::{Params, Shading, ShellLayer, Span, Step, halves, halves3, lit};
use crate::mesh::DeviceMesh;
use crate::pieces::RayEntries;
use crate::pipelines::{Constants, Pipelines, bind_group};
use crate::pool::PooledBuffer;
use crate::scenery::{SceneTables, scenery_spans, volume_spans, volume_steps};
use glam::DVec3;
use icoray::device::{self, BudgetTable, ENDLESS, FallbackReason, Job};
use icoray::{Lights, Method};
use std::sync::Arc;
use wgpu::BufferUsages;

/// A picture and the data besides the field that its rays read on the device.
pub(crate) struct Picture<'p> {
    pub ctx: &'p Context,
    pub pipelines: &'p Pipelines,
    pub job: &'p Job<'p>,
    pub mesh: Arc<DeviceMesh>,
    pub entries: Arc<RayEntries>,
    /// Bindings 4, 5 and 7: spans and steps of the transfer function, and layers of the shell.
    tables: [PooledBuffer; 3],
}

impl<'p> Picture<'p> {
    pub fn new(
        ctx: &'p Context,
        pipelines: &'p Pipelines,
        job: &'p Job,
        mesh: Arc<DeviceMesh>,
        entries: Arc<RayEntries>,
    ) -> Result<Self, FallbackReason> {
        // The spans of surfaces and of several volumes follow those of the field.
        let spans: Vec<Span> = job.spans().iter().chain(scenery_spans(job)).map(Span::from).collect();
        let steps: Vec<Step> = job.steps().iter().chain(volume_steps(job)).map(Step::from).collect();
        let radius = job.radius();
        let layer = |k: usize| {
            let [radius_hi, radius_lo] = halves(radius[k]);
            let inverse = radius.get(k + 1).map_or(0.0, |above| 1.0 / (above - radius[k]));
            ShellLayer { radius_hi, radius_lo, curvature: (1.0 / radius[k]) as f32, inverse: inverse as f32 }
        };
        let shell: Vec<ShellLayer> = (0..radius.len()).map(layer).collect();
        let tables = [
            ctx.pooled_data("spans", &spans, BufferUsages::STORAGE)?,
            ctx.pooled_data("steps", &steps, BufferUsages::STORAGE)?,
            ctx.pooled_data("layers", &shell, BufferUsages::STORAGE)?,
        ];
        Ok(Picture { ctx, pipelines, job, mesh, entries, tables })
    }

    /// Binds group 0: parameters, tables, the columns of `cells`, the pieces of workgroups and the output buffer.
    pub fn group(
        &self,
        cells: &CellSet,
        [params, pieces, output]: [&wgpu::Buffer; 3],
    ) -> Result<wgpu::BindGroup, FallbackReason> {
        let [spans, steps, shell] = &self.tables;
        // Shaders read `places` only if the set has some; any storage buffer can be bound otherwise.
        let places = cells.places.as_ref().unwrap_or(spans);
        let others: [&wgpu::Buffer; 6] = [spans, steps, places, shell, pieces, output];
        let layout = &self.pipelines.tables;
        bind_group(self.ctx, layout, std::iter::once(params).chain(&self.mesh.buffers).chain(others))
    }

    /// Uploads light and scenery: the first buffers of group 2. They must not return to the pool before all bands are
    /// submitted.
    pub fn scene_buffers(&self) -> Result<Vec<PooledBuffer>, FallbackReason> {
        let ctx = self.ctx;
        // All zero if the scene is unlit.
        let light = shading(self.job).unwrap_or_default();
        let mut buffers = vec![ctx.pooled_data("the light", &[light], BufferUsages::UNIFORM)?];
        if let Some(scenery) = self.job.scenery() {
            let tables = SceneTables::new(self.job, scenery);
            buffers.push(ctx.pooled_data("scenery", &[tables.scenery], BufferUsages::UNIFORM)?);
            buffers.push(ctx.pooled_data("values of surfaces", &tables.values, BufferUsages::STORAGE)?);
        }
        Ok(buffers)
    }

    pub fn bytes(&self) -> u64 {
        self.tables.iter().map(|table| table.size()).sum()
    }

    /// The override constants of the picture's shader; `in_parts` if it traces fragments through a part of the grid.
    pub fn constants(&self, in_parts: bool) -> Constants {
        let (job, scene) = (self.job, self.job.scene());
        let has_several = job.scenery().is_some_and(|scenery| !scenery.volumes.is_empty());
        let flags = [
            // Several volumes are integrated to the tolerance with either method, and have other transfer functions.
            ("IS_EXACT", has_several || scene.method == Method::Exact),
            // Parts have holes, and beside the code of other scenes that of holes costs little.
            ("HAS_VOID", in_parts || job.scenery().is_some() || job.grid().void_triangles() > 0),
            ("HAS_STEPS", job.spans().iter().chain(volume_spans(job)).any(device::Span::is_narrow)),
            ("FEW_KNOTS", !has_several && few_knots(job).is_some()),
            ("IS_LIT", job.quality().lights != Lights::Off),
            ("IN_PARTS", in_parts),
        ];
        flags.map(|(name, is)| (name, u32::from(is))).to_vec()
    }

    /// The parameters of all rays, without those of a dispatch and of the field's layout.
    pub fn params(&self) -> Params {
        let (job, scene, grid) = (self.job, self.job.scene(), self.job.grid());
        let ([forward, right, up], half_height) = scene.camera.frame();
        let [[eye_hi, eye_lo], [forward_hi, forward_lo], [right_hi, right_lo], [up_hi, up_lo]] =
            [scene.camera.eye(), forward, right, up].map(halves3);
        let [half_pixel_hi, half_pixel_lo] = halves(half_height / f64::from(scene.height));
        let triangles = grid.triangles() + grid.void_triangles();
        let BudgetTable { color_tolerance: share, min_transmittance: rest, brightest } = job.allowed();
        Params {
            eye_hi,
            width: scene.width,
            eye_lo,
            height: scene.height,
            forward_hi,
            forward_lo,
            right_hi,
            half_pixel_hi,
            right_lo,
            half_pixel_lo,
            up_hi,
            up_lo,
            pixel_step: job.quality().pixel_step,
            // A great circle crosses about 3 sqrt(triangles) of them, and more on refined meshes and over slivers.
            max_steps: 1000 + 40 * triangles.isqrt() as u32,
            knots: few_knots(job).unwrap_or_default(),
            core: scene.core.unwrap_or_default().map(|c| c as f32),
            has_core: u32::from(scene.core.is_some()),
            paints_core: u32::from(job.has_ground()),
            layers: job.radius().len() as u32,
            triangles: grid.triangles() as u32,
            spans: job.spans().len() as u32,
            steps: job.steps().len() as u32,
            color_tolerance: share,
            min_transmittance: rest,
            brightest,
            start: self.mesh.start,
            ..Params::default()
        }
    }
}

/// Lower ends of all spans but the first, padded with [`ENDLESS`]; `None` if there are more than four.
fn few_knots(job: &Job) -> Option<[f32; 4]> {
    let spans = job.spans();
    let mut knots = [ENDLESS; 4];
    let is_few = spans.len() <= knots.len() + 1;
    is_few.then(|| {
        knots.iter_mut().zip(&spans[1..]).for_each(|(knot, span)| *knot = span.low);
        knots
    })
}

fn shading(job: &Job) -> Option<Shading> {
    let shading = job.shading()?;
    let [light_hi, light_lo] = halves3(shading.towards_light.unwrap_or_default().to_array());
    // All but the directions is equal along all rays.
    let ray = shading.along::<f32>(DVec3::Z);
    Some(Shading {
        light_hi,
        ambient: ray.ambient,
        light_lo,
        diffuse: ray.diffuse,
        specular: ray.specular,
        shininess: ray.shininess,
        sharpness: ray.sharpness,
        is_headlight: u32::from(shading.towards_light.is_none()),
        max_cuts: if job.quality().lights == Lights::Coarse { 0 } else { lit::MAX_CUTS },
        padding: [0; 3],
    })
}
