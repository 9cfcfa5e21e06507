//! A scene on the device: its numbers, its variant of the shader, and the field.

use crate::gpu::{Gpu, because};
use crate::layout::{Params, Piece, ShellLayer, Span, Step, halves, halves3};
use crate::light;
use crate::mesh::Mesh;
use crate::shader;
use crate::starts::Starts;
use icoray::device::{Allowed, ENDLESS, Job, Reason, Rect, locate};
use icoray::{Lights, Method};
use rayon::prelude::*;
use std::sync::{Arc, PoisonError};

/// Pixels along a workgroup's sides.
pub(crate) const GROUP: u32 = 8;

/// What of the shader a scene needs: its override constants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Variant {
    is_exact: bool,
    has_core: bool,
    has_void: bool,
    has_steps: bool,
    few_knots: bool,
    is_lit: bool,
}

/// What the rays of a picture read on the device, whatever their tiles.
#[derive(Debug)]
pub(crate) struct Picture {
    number: u64,
    pub mesh: Arc<Mesh>,
    /// Bindings 8, 9 and 11.
    pub tables: [wgpu::Buffer; 3],
    /// Binding 10.
    pub field: wgpu::Buffer,
    /// Of lit pictures.
    pub gradients: Option<wgpu::Buffer>,
}

impl Gpu {
    /// The picture of `job`, and how many bytes were uploaded for it: none where it is there. Nothing is locked while it is
    /// prepared: the pool's thread that waits for others may meet another picture.
    pub(crate) fn picture(&self, job: &Job) -> Result<(Arc<Picture>, u64), Reason> {
        let last = || self.picture.lock().unwrap_or_else(PoisonError::into_inner);
        // Another picture's memory goes before this one's comes.
        let before = last().take().filter(|picture| picture.number == job.number());
        if let Some(picture) = before {
            *last() = Some(Arc::clone(&picture));
            return Ok((picture, 0));
        }
        let (mesh, mesh_bytes) = self.mesh(job.grid())?;
        let (tables, field) = (tables(self, job)?, field(self, job)?);
        let (gradients, light_bytes) = light::gradients(self, job)?;
        let bytes =
            mesh_bytes + field.size() + light_bytes + tables.iter().map(wgpu::Buffer::size).sum::<u64>();
        let picture = Arc::new(Picture { number: job.number(), mesh, tables, field, gradients });
        *last() = Some(Arc::clone(&picture));
        Ok((picture, bytes))
    }
}

impl Variant {
    pub fn of(job: &Job) -> Self {
        let scene = job.scene();
        Variant {
            is_exact: scene.method == Method::Exact,
            has_core: scene.core.is_some(),
            has_void: job.grid().void_triangles() > 0,
            has_steps: !job.steps().is_empty(),
            few_knots: few_knots(job).is_some(),
            is_lit: job.quality().lights != Lights::Off,
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
                    ("FEW_KNOTS", number(self.few_knots)),
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

/// Where the spans behind the first begin, if they are few.
fn few_knots(job: &Job) -> Option<[f32; 4]> {
    let spans = job.spans();
    let mut knots = [ENDLESS; 4];
    let is_few = spans.len() <= knots.len() + 1;
    is_few.then(|| {
        knots.iter_mut().zip(&spans[1..]).for_each(|(knot, span)| *knot = span.low);
        knots
    })
}

/// The numbers that all rays share, but for the pieces of a dispatch.
pub(crate) fn params(job: &Job, mesh: &Mesh) -> Params {
    let (scene, grid) = (job.scene(), job.grid());
    let ([forward, right, up], half_height) = scene.camera.frame();
    let [[eye_hi, eye_lo], [forward_hi, forward_lo], [right_hi, right_lo], [up_hi, up_lo]] =
        [scene.camera.eye(), forward, right, up].map(halves3);
    let [half_pixel_hi, half_pixel_lo] = halves(half_height / f64::from(scene.height));
    let triangles = grid.triangles() + grid.void_triangles();
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
        pixel_step: job.quality().pixel_step,
        // A great circle passes some 3 times the root of them, on refined meshes and over slivers more.
        most_steps: 1000 + 40 * triangles.isqrt() as u32,
        knots: few_knots(job).unwrap_or_default(),
        core: scene.core.unwrap_or_default().map(|c| c as f32),
        layers: layers as u32,
        index_base: grid.tables().index_base,
        triangles: grid.triangles() as u32,
        rim_sides: mesh.rim_sides,
        spans: job.spans().len() as u32,
        steps: job.steps().len() as u32,
        column_stride: column_stride as u32,
        layer_stride: layer_stride as u32,
        share,
        rest,
        brightest,
        start: mesh.start,
        ..Params::default()
    }
}

/// The transfer function, its steps and the shell.
fn tables(gpu: &Gpu, job: &Job) -> Result<[wgpu::Buffer; 3], Reason> {
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

/// The field, normalised on the way. Each value is read from the model's array and written where the device takes
/// it from, so that the host never has a second field.
///
/// Normalised here, in f64, and not in the shader: it is done once per value instead of once per read, and gives the bits
/// that the CPU's kernel has.
fn field(gpu: &Gpu, job: &Job) -> Result<wgpu::Buffer, Reason> {
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

/// Tiles that a thread looks at in one go, each from where the one before was.
const RUN: usize = 16;

/// The pieces of each tile: what a workgroup traces, and the triangle that the ray through its middle first lies over. Places of
/// rays are counted from the tile's first.
pub(crate) fn pieces(gpu: &Gpu, job: &Job, tiles: &[Rect]) -> Vec<Vec<Piece>> {
    let starts = Starts::of(&gpu.starts, job);
    let run = |tiles: &[Rect]| {
        let mut hint = 0;
        tiles.iter().map(|tile| pieces_of(job, tile, &starts, &mut hint)).collect::<Vec<_>>()
    };
    tiles.par_chunks(RUN).flat_map_iter(run).collect()
}

fn pieces_of(job: &Job, tile: &Rect, starts: &Starts, hint: &mut u32) -> Vec<Piece> {
    let group = GROUP as usize;
    let places =
        (0..tile.height).step_by(group).flat_map(|y| (0..tile.width).step_by(group).map(move |x| (x, y)));
    let piece = |(x, y): (u32, u32)| {
        let (width, height) = ((tile.width - x).min(GROUP), (tile.height - y).min(GROUP));
        let (left, top) = (tile.left + x, tile.top + y);
        let node = [left + width / 2, top + height / 2];
        *hint = starts.find(node, *hint, |from| first_triangle(job, node, from));
        Piece { left, top, width, height, first: y * tile.width + x, stride: tile.width, hint: *hint }
    };
    places.map(piece).collect()
}

/// The triangle over which the ray through a traced pixel enters the shell, or comes closest: there neighbours may enter.
fn first_triangle(job: &Job, node: [u32; 2], from: u32) -> u32 {
    let (scene, radius) = (job.scene(), job.radius());
    let (outer, step) = (radius[radius.len() - 1], job.quality().pixel_step);
    let (x, y) = ((node[0] * step).min(scene.width - 1), (node[1] * step).min(scene.height - 1));
    let eye = glam::DVec3::from_array(scene.camera.eye());
    let dir = glam::DVec3::from_array(scene.camera.direction(x, y, scene.width, scene.height));
    let closest = -eye.dot(dir);
    let b = (eye + closest * dir).length();
    let half = ((outer - b) * (outer + b)).max(0.0).sqrt();
    let place = eye + (closest - half).max(0.0) * dir;
    locate(job.grid(), from, place.try_normalize().unwrap_or(dir).to_array())
}
