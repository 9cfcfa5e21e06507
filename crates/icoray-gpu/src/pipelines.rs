//! Compute pipelines: bind groups of buffers, numbered from 0, and their layouts, compilation and dispatch.

use crate::context::Context;
use crate::pool::PooledBuffer;
use crate::shader::{self, Contents};
use icoray::device::FallbackReason;
use std::sync::{Mutex, PoisonError};
use wgpu::BufferBindingType::{self, Storage, Uniform};

/// Bindings of group 0, in order.
const TABLES: [BufferBindingType; 10] = {
    let mut kinds = [READ; 10];
    kinds[0] = Uniform;
    kinds[9] = READ_WRITE;
    kinds
};

pub(crate) type Constants = Vec<(&'static str, u32)>;

/// The shader of a pipeline, its contents and its constants.
type Key = (&'static str, Contents, Constants);

/// Largest number of compiled pipelines that are kept: viewers of a running model can ask for hundreds of kinds of
/// scenes, and a pipeline takes tens of megabytes with lavapipe.
const MAX_PIPELINES: usize = 16;

/// The pipelines of a device, compiled on first use, the last used of which are kept, and the layouts of their bind
/// groups. Groups 1 and 3 are pages of the field and of the data that accompany it.
#[derive(Debug)]
pub(crate) struct Pipelines {
    /// Group 0.
    pub tables: wgpu::BindGroupLayout,
    /// Group 2 of `shaders/picture.wgsl`, and for scenes of more than one volume and a core.
    pub picture: [wgpu::BindGroupLayout; 2],
    /// Group 2 of `shaders/parts.wgsl`, and for such scenes.
    pub parts: [wgpu::BindGroupLayout; 2],
    /// Group 2 of `shaders/gradient.wgsl`.
    pub gradient: wgpu::BindGroupLayout,
    /// The last used comes last.
    compiled: Mutex<Vec<(Key, wgpu::ComputePipeline)>>,
}

impl Pipelines {
    pub fn new(ctx: &Context) -> Self {
        // As `Picture::scene_buffers` has them.
        let scenes: [&[_]; 2] = [&[Uniform], &[Uniform, Uniform, READ]];
        let part = [READ, READ, READ_WRITE];
        Pipelines {
            tables: bind_group_layout(ctx, &TABLES),
            picture: scenes.map(|scene| bind_group_layout(ctx, scene)),
            parts: scenes.map(|scene| bind_group_layout(ctx, &[scene, &part].concat())),
            gradient: bind_group_layout(ctx, &[Uniform, READ, READ, READ_WRITE]),
            compiled: Mutex::default(),
        }
    }

    /// The pipeline of a shader whose entry point has its name, with code for `contents` and the layout of its group 2,
    /// for a field of `pages` pages.
    pub fn get(
        &self,
        ctx: &Context,
        (name, contents, own): (&'static str, Contents, &wgpu::BindGroupLayout),
        pages: usize,
        constants: Constants,
    ) -> Result<wgpu::ComputePipeline, FallbackReason> {
        let mut compiled = self.compiled.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (name, contents, constants);
        let pipeline = if let Some(at) = compiled.iter().position(|(kept, _)| *kept == key) {
            compiled.remove(at).1
        } else {
            let page_layout = page_layout(ctx, pages);
            let layouts = [&self.tables, &page_layout, own, &page_layout];
            compile(ctx, name, shader::compose(name, contents, pages), Some(layouts), &key.2)?
        };
        if compiled.len() == MAX_PIPELINES {
            compiled.remove(0);
        }
        compiled.push((key, pipeline.clone()));
        Ok(pipeline)
    }
}

/// Compiles the entry point `entry` of a shader. Without `layouts` they follow from the shader.
pub(crate) fn compile(
    ctx: &Context,
    entry: &str,
    text: String,
    layouts: Option<[&wgpu::BindGroupLayout; 4]>,
    constants: &[(&str, u32)],
) -> Result<wgpu::ComputePipeline, FallbackReason> {
    let constants: Vec<_> = constants.iter().map(|(name, value)| (*name, f64::from(*value))).collect();
    ctx.scoped(|| {
        let module = ctx.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(entry),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        let layout = layouts.map(|layouts| {
            ctx.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(entry),
                bind_group_layouts: &layouts.map(Some),
                immediate_size: 0,
            })
        });
        let constants = wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() };
        ctx.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry),
            layout: layout.as_ref(),
            module: &module,
            entry_point: Some(entry),
            compilation_options: constants,
            cache: None,
        })
    })
}

pub(crate) fn dispatch<'g>(
    commands: &mut wgpu::CommandEncoder,
    pass: &wgpu::ComputePassDescriptor,
    pipeline: &wgpu::ComputePipeline,
    groups: impl IntoIterator<Item = &'g wgpu::BindGroup>,
    [x, y]: [u32; 2],
) {
    let mut pass = commands.begin_compute_pass(pass);
    pass.set_pipeline(pipeline);
    (0..).zip(groups).for_each(|(i, group)| pass.set_bind_group(i, group, &[]));
    pass.dispatch_workgroups(x, y, 1);
}

/// A storage buffer that shaders read.
const READ: BufferBindingType = Storage { read_only: true };
/// A storage buffer that shaders write.
const READ_WRITE: BufferBindingType = Storage { read_only: false };

/// The layout of a group of buffers of these kinds.
fn bind_group_layout(ctx: &Context, kinds: &[BufferBindingType]) -> wgpu::BindGroupLayout {
    let entry = |(binding, ty): (u32, &BufferBindingType)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty: *ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    };
    let entries: Vec<_> = (0..).zip(kinds).map(entry).collect();
    let descriptor = wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries };
    ctx.device.create_bind_group_layout(&descriptor)
}

/// The layout of a group of `pages` pages of a field or of its gradients.
fn page_layout(ctx: &Context, pages: usize) -> wgpu::BindGroupLayout {
    bind_group_layout(ctx, &vec![READ; pages])
}

pub(crate) fn bind_group<'b>(
    ctx: &Context,
    layout: &wgpu::BindGroupLayout,
    buffers: impl IntoIterator<Item = &'b wgpu::Buffer>,
) -> Result<wgpu::BindGroup, FallbackReason> {
    let entry = |(binding, buffer): (u32, &'b wgpu::Buffer)| wgpu::BindGroupEntry {
        binding,
        resource: buffer.as_entire_binding(),
    };
    let entries: Vec<_> = (0..).zip(buffers).map(entry).collect();
    let descriptor = wgpu::BindGroupDescriptor { label: None, layout, entries: &entries };
    ctx.scoped(|| ctx.device.create_bind_group(&descriptor))
}

pub(crate) fn page_group(ctx: &Context, pages: &[PooledBuffer]) -> Result<wgpu::BindGroup, FallbackReason> {
    let layout = page_layout(ctx, pages.len());
    bind_group(ctx, &layout, pages.iter().map(|page| &**page))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adapters::find;
    use icoray::device::DeviceRequest;
    use icoray_test_support::{Need, skip_because};
    use std::path::Path;

    #[test]
    fn a_pipeline_too_many_drops_the_least_recently_used() {
        let wanted = DeviceRequest { adapter: None, or_processor: true, node_rank: 0 };
        let opened = find(&wanted, Path::new("/dev")).and_then(|adapter| Context::open(&adapter, None));
        let ctx = match opened {
            Ok(ctx) => ctx,
            Err(reason) => return skip_because(Need::Gpu, reason),
        };
        let pipelines = Pipelines::new(&ctx);
        // Kinds of a small shader.
        let get = |kind: usize| {
            let shader = ("gradient", Contents::default(), &pipelines.gradient);
            pipelines.get(&ctx, shader, 1, vec![("PAGES", kind as u32 + 1)]).unwrap()
        };
        let first: Vec<_> = (0..MAX_PIPELINES).map(get).collect();
        assert!(get(0) == first[0]);
        get(MAX_PIPELINES);
        assert!((2..MAX_PIPELINES).all(|kind| get(kind) == first[kind]) && get(0) == first[0]);
        assert!(get(1) != first[1]);
    }
}
