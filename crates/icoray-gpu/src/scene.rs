//! A scene on the device: its numbers, its variant of the shader, and the field.

use crate::gpu::{Gpu, Reason, because};
use crate::layout::{Params, ShellLayer, Span, Step, halves, halves3};
use crate::mesh::Mesh;
use crate::shader;
use icoray::device::{Allowed, Job, locate};
use icoray::{Grid, Lights, Method, Precision, Scene};
use rayon::prelude::*;
use std::sync::PoisonError;

/// Pixels along a workgroup's sides.
pub(crate) const GROUP: u32 = 8;

/// What of the shader a scene needs: its override constants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Variant {
    is_exact: bool,
    has_core: bool,
    has_void: bool,
    has_steps: bool,
    is_lit: bool,
}

/// Why `scene` is none for this crate, if it is not.
pub(crate) fn suits(scene: &Scene) -> Result<(), Reason> {
    if scene.precision == Precision::F64 {
        return because("the scene asks for precision = \"f64\", which the GPU's kernel has not");
    }
    if scene.time_budget_ms.is_some() {
        return because("the scene has a time budget, which is kept by measuring the CPU");
    }
    Ok(())
}

impl Variant {
    pub fn of(scene: &Scene, mesh: &Mesh, job: &Job, lights: Lights) -> Self {
        Variant {
            is_exact: scene.method == Method::Exact,
            has_core: scene.core.is_some(),
            has_void: mesh.grid.void_triangles() > 0,
            has_steps: !job.steps().is_empty(),
            is_lit: lights != Lights::Off,
        }
    }

    /// The pipeline of this variant, made once.
    pub fn pipeline(self, gpu: &Gpu) -> Result<wgpu::ComputePipeline, Reason> {
        let mut known = gpu.pipelines.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(pipeline) = known.get(&self) {
            return Ok(pipeline.clone());
        }
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("picture"),
            source: wgpu::ShaderSource::Wgsl(shader::compose("picture").into()),
        });
        let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("picture"),
            bind_group_layouts: &[Some(&gpu.bindings), Some(&gpu.light.layout)],
            immediate_size: 0,
        });
        let number = |is: bool| f64::from(u8::from(is));
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("picture"),
            layout: Some(&layout),
            module: &module,
            entry_point: Some("picture"),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: &[
                    ("IS_EXACT", number(self.is_exact)),
                    ("HAS_CORE", number(self.has_core)),
                    ("HAS_VOID", number(self.has_void)),
                    ("HAS_STEPS", number(self.has_steps)),
                    ("IS_LIT", number(self.is_lit)),
                ],
                ..Default::default()
            },
            cache: None,
        });
        gpu.untroubled()?;
        known.insert(self, pipeline.clone());
        Ok(pipeline)
    }
}

/// The numbers that all rays share, but for the rows of a dispatch.
pub(crate) fn params(scene: &Scene, mesh: &Mesh, job: &Job) -> Params {
    let ([forward, right, up], half_height) = scene.camera.frame();
    let [[eye_hi, eye_lo], [forward_hi, forward_lo], [right_hi, right_lo], [up_hi, up_lo]] =
        [scene.camera.eye(), forward, right, up].map(halves3);
    let [half_pixel_hi, half_pixel_lo] = halves(half_height / f64::from(scene.height));
    let triangles = mesh.grid.triangles() + mesh.grid.void_triangles();
    let (columns, layers, is_level_fastest) = job.order();
    let (column_stride, layer_stride) = if is_level_fastest { (layers, 1) } else { (1, columns) };
    let Allowed { share, rest, brightest } = job.allowed();
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
        // A great circle passes some 3 times the root of them, on refined meshes and over slivers more.
        most_steps: 1000 + 40 * triangles.isqrt() as u32,
        core: scene.core.unwrap_or_default().map(|c| c as f32),
        layers: layers as u32,
        index_base: mesh.grid.tables().index_base,
        triangles: mesh.grid.triangles() as u32,
        rim_sides: mesh.rim_sides,
        spans: job.spans().len() as u32,
        steps: job.steps().len() as u32,
        column_stride: column_stride as u32,
        layer_stride: layer_stride as u32,
        share,
        rest,
        brightest,
        groups_across: scene.width.div_ceil(GROUP),
        start: mesh.start,
        ..Params::default()
    }
}

/// The transfer function, its steps and the shell: bindings 8, 9 and 11.
pub(crate) fn tables(gpu: &Gpu, job: &Job) -> Result<[wgpu::Buffer; 3], Reason> {
    let spans: Vec<Span> = job.spans().iter().map(Span::from).collect();
    let step = |[value, extinction]: [f32; 2]| Step { value, extinction: extinction.min(1e37) };
    let steps: Vec<Step> = job.steps().into_iter().map(step).collect();
    let radius = job.radius();
    let layer = |k: usize| {
        let [radius_hi, radius_lo] = halves(radius[k]);
        let inverse = radius.get(k + 1).map_or(0.0, |above| 1.0 / (above - radius[k]));
        ShellLayer { radius_hi, radius_lo, curvature: (1.0 / radius[k]) as f32, inverse: inverse as f32 }
    };
    let shell: Vec<ShellLayer> = (0..radius.len()).map(layer).collect();
    Ok([gpu.upload("spans", &spans)?, gpu.upload("steps", &steps)?, gpu.upload("layers", &shell)?])
}

/// Values that are normalised at a time: a piece that a processor's cache holds.
const PIECE: usize = 1 << 18;

/// The field, normalised on the way: binding 10. Each value is read from the model's array and written where the device takes
/// it from, so that the host never has a second field.
///
/// Normalised here, in f64, and not in the shader: it is done once per value instead of once per read, and gives the bits
/// that the CPU's kernel has.
pub(crate) fn field(gpu: &Gpu, job: &Job) -> Result<wgpu::Buffer, Reason> {
    let (columns, layers, _) = job.order();
    let count = columns * layers;
    if u32::try_from(count).is_err() {
        return because(format!(
            "the field: {count} values, expected fewer than the shader's numbers have, 2^32"
        ));
    }
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
    let buffer = gpu.buffer("the field", count * size_of::<f32>(), usage)?;
    let bytes = wgpu::BufferSize::new((count * size_of::<f32>()) as u64);
    let Some(mut staged) = bytes.and_then(|bytes| gpu.queue.write_buffer_with(&buffer, 0, bytes)) else {
        gpu.untroubled()?;
        return because("the device has no room to take the field in");
    };
    let mut piece = vec![0.0f32; PIECE.min(count)];
    for first in (0..count).step_by(PIECE) {
        let values = &mut piece[..PIECE.min(count - first)];
        job.values(first, values);
        let start = first * size_of::<f32>();
        staged.slice(start..start + size_of_val(values)).copy_from_slice(bytemuck::cast_slice(values));
    }
    drop(staged);
    gpu.untroubled()?;
    Ok(buffer)
}

/// For each workgroup the triangle that the ray through its middle first lies over: binding 12.
pub(crate) fn hints(scene: &Scene, grid: &Grid, outer: f64) -> Vec<u32> {
    let [across, down] = [scene.width, scene.height].map(|side| side.div_ceil(GROUP));
    let eye = glam::DVec3::from_array(scene.camera.eye());
    let row = |y: u32| {
        let mut hint = 0;
        (0..across).map(move |x| {
            let middle = |group: u32, side: u32| (group * GROUP + GROUP / 2).min(side - 1);
            let (x, y) = (middle(x, scene.width), middle(y, scene.height));
            let dir = glam::DVec3::from_array(scene.camera.direction(x, y, scene.width, scene.height));
            // Where it enters the shell, or comes closest: there neighbours may enter.
            let closest = -eye.dot(dir);
            let b = (eye + closest * dir).length();
            let half = ((outer - b) * (outer + b)).max(0.0).sqrt();
            let place = eye + (closest - half).max(0.0) * dir;
            hint = locate(grid, hint, place.try_normalize().unwrap_or(dir).to_array());
            hint
        })
    };
    (0..down).into_par_iter().flat_map_iter(row).collect()
}
