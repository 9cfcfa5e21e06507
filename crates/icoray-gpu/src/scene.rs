//! A scene on the device: its numbers, its variant of the shader, and the field.

use crate::gpu::Gpu;
use crate::held::Held;
use crate::layout::{Params, Piece, ShellLayer, Span, Step, halves, halves3};
use crate::mesh::Mesh;
use crate::shader;
use crate::starts::Starts;
use crate::store::Lent;
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
    in_parts: bool,
    places: Places,
}

/// How the field lies on the device, as far as shaders differ in that.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Places {
    pub pages: usize,
    pub has_places: bool,
    pub has_all_layers: bool,
}

impl Places {
    pub fn constants(self) -> [(&'static str, f64); 3] {
        let number = |is: bool| f64::from(u8::from(is));
        [
            ("PAGES", self.pages as f64),
            ("HAS_PLACES", number(self.has_places)),
            ("HAS_ALL_LAYERS", number(self.has_all_layers)),
        ]
    }
}

/// What the rays of a picture read on the device beside the field.
pub(crate) struct Picture<'j> {
    pub job: &'j Job<'j>,
    pub mesh: Arc<Mesh>,
    /// Bindings 8, 9 and 11.
    pub tables: [Lent; 3],
}

impl Gpu {
    /// A shader's entry point of its own name.
    pub(crate) fn pipeline(
        &self,
        name: &str,
        text: String,
        layouts: [&wgpu::BindGroupLayout; 4],
        constants: &[(&str, f64)],
    ) -> Result<wgpu::ComputePipeline, Reason> {
        self.watched(|| {
            let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(name),
                source: wgpu::ShaderSource::Wgsl(text.into()),
            });
            let layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(name),
                bind_group_layouts: &layouts.map(Some),
                immediate_size: 0,
            });
            self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(name),
                layout: Some(&layout),
                module: &module,
                entry_point: Some(name),
                compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
                cache: None,
            })
        })
    }
}

impl Picture<'_> {
    /// Group 0, with what workgroups trace and where they write.
    pub fn group(
        &self,
        gpu: &Gpu,
        held: &Held,
        uniform: &wgpu::Buffer,
        pieces: &wgpu::Buffer,
        pixels: &wgpu::Buffer,
    ) -> Result<wgpu::BindGroup, Reason> {
        let [spans, steps, shell] = &self.tables;
        let places = held.cells.places.as_ref().unwrap_or(spans);
        let others: [&wgpu::Buffer; 6] = [spans, steps, places, shell, pieces, pixels];
        gpu.group(&gpu.bindings, std::iter::once(uniform).chain(&self.mesh.buffers).chain(others))
    }

    /// Bytes of the tables.
    pub fn bytes(&self) -> u64 {
        self.tables.iter().map(|table| table.size()).sum()
    }
}

impl Variant {
    /// Of pictures of a whole grid.
    pub fn of(job: &Job, held: &Held) -> Self {
        let scene = job.scene();
        Variant {
            is_exact: scene.method == Method::Exact,
            has_core: scene.core.is_some(),
            has_void: job.grid().void_triangles() > 0,
            has_steps: !job.steps().is_empty(),
            few_knots: few_knots(job).is_some(),
            is_lit: job.quality().lights != Lights::Off,
            in_parts: false,
            places: held.places(),
        }
    }

    /// Of rays through a part of a grid.
    pub fn in_parts(job: &Job, held: &Held) -> Self {
        Variant { in_parts: true, ..Variant::of(job, held) }
    }

    /// The pipeline of this variant, made once.
    pub fn pipeline(self, gpu: &Gpu) -> Result<wgpu::ComputePipeline, Reason> {
        let mut known = gpu.pipelines.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(pipeline) = known.get(&self) {
            return Ok(pipeline.clone());
        }
        let number = |is: bool| f64::from(u8::from(is));
        let constants = [
            ("IS_EXACT", number(self.is_exact)),
            ("HAS_CORE", number(self.has_core)),
            ("HAS_VOID", number(self.has_void)),
            ("HAS_STEPS", number(self.has_steps)),
            ("FEW_KNOTS", number(self.few_knots)),
            ("IS_LIT", number(self.is_lit)),
            ("IN_PARTS", number(self.in_parts)),
        ];
        let constants = [&constants[..], &self.places.constants()].concat();
        let pages = gpu.page_layout(self.places.pages);
        let (name, own) = if self.in_parts { ("parts", &gpu.of_parts) } else { ("picture", &gpu.of_light) };
        let layouts = [&gpu.bindings, &pages, own, &pages];
        let text = shader::compose_for(name, self.places.pages);
        let pipeline = gpu.pipeline(name, text, layouts, &constants)?;
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

/// The numbers that all rays share, but for the pieces of a dispatch and where the field lies.
pub(crate) fn params(job: &Job, mesh: &Mesh) -> Params {
    let (scene, grid) = (job.scene(), job.grid());
    let ([forward, right, up], half_height) = scene.camera.frame();
    let [[eye_hi, eye_lo], [forward_hi, forward_lo], [right_hi, right_lo], [up_hi, up_lo]] =
        [scene.camera.eye(), forward, right, up].map(halves3);
    let [half_pixel_hi, half_pixel_lo] = halves(half_height / f64::from(scene.height));
    let triangles = grid.triangles() + grid.void_triangles();
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
        layers: job.radius().len() as u32,
        index_base: grid.tables().index_base,
        triangles: grid.triangles() as u32,
        rim_sides: mesh.rim_sides,
        spans: job.spans().len() as u32,
        steps: job.steps().len() as u32,
        share,
        rest,
        brightest,
        start: mesh.start,
        ..Params::default()
    }
}

/// The transfer function, its steps and the shell.
pub(crate) fn tables(gpu: &Gpu, job: &Job) -> Result<[Lent; 3], Reason> {
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
    Ok([gpu.lend_with("spans", &spans)?, gpu.lend_with("steps", &steps)?, gpu.lend_with("layers", &shell)?])
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
