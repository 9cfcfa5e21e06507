//! Runs WGSL code once per row of a table of inputs, and inputs that several tests share.

use icoray::device::Span;
use icoray_gpu::instance;
use icoray_gpu::layout::Params;
use icoray_gpu::shader::{Contents, expand};
use icoray_kernel::piece::Radiance;
use icoray_kernel::segment::Segment;
use icoray_test_support::{Need, skip_because};
use wgpu::BufferUsages as Usage;
use wgpu::util::DeviceExt as _;

/// The difference of two numbers in ulps of f32 at the largest magnitude of `a`, `b` and `size`.
pub fn ulps(a: f32, b: f32, size: f32) -> f64 {
    let unit = f64::from(a.abs().max(b.abs()).max(size)) * f64::from(f32::EPSILON);
    if a == b { 0.0 } else { (f64::from(a) - f64::from(b)).abs() / unit.max(1e-38) }
}

/// A segment of f0, f1, kappa, eps, length.
pub fn segment([f0, f1, kappa, eps, length]: [f32; 5]) -> Segment<f32> {
    Segment { f0, f1, kappa, eps, length }
}

/// Red, green, blue, absorbed, error, both variances.
pub fn numbers_of(light: Radiance<f32>) -> [f32; 7] {
    let Radiance { color: [r, g, b], alpha, error, variance, shade_variance } = light;
    [r, g, b, alpha, error, variance, shade_variance]
}

/// The numbers that [`SPAN_AT`] reads.
pub fn numbers_of_span(span: &Span) -> [f32; 3] {
    [span.extinction, span.extinction_slope, span.color_slope[0]]
}

/// WGSL that reads a segment from `inputs`: f0, f1, kappa, eps, length.
pub const SEGMENT_AT: &str = "
fn segment_at(at: u32) -> Segment {
    return Segment(inputs[at], inputs[at + 1u], inputs[at + 2u], inputs[at + 3u], inputs[at + 4u], 1.0);
}";

/// WGSL that reads a [`span`] from `inputs`.
pub const SPAN_AT: &str = "
fn span_at(at: u32) -> Span {
    let slope = inputs[at + 2u];
    return Span(-3e38, 3e38, -8.0, inputs[at], vec3f(0.1, 0.5, 0.9), inputs[at + 1u],
        vec3f(slope, -0.2 * slope, 0.0), abs(slope), 0u, 0.9);
}";

/// An unbounded span whose colour and extinction vary linearly.
pub fn span(extinction: f32, extinction_slope: f32, slope: f32) -> Span {
    Span {
        low: f32::NEG_INFINITY,
        high: f32::INFINITY,
        anchor: -8.0,
        extinction,
        extinction_slope,
        color: [0.1, 0.5, 0.9],
        color_slope: [slope, -0.2 * slope, 0.0],
        steepest: slope.abs(),
        brightest: 0.9,
        is_clear: false,
    }
}

/// Spans whose extinction is positive wherever a segment of the tests can be: pieces stay in their span.
pub fn absorbing_spans() -> [Span; 5] {
    [span(0.0, 0.5, 0.1), span(6.0, -0.4, 0.1), span(0.0, 40.0, 0.2), span(1e4, 1e3, -0.1), span(2.0, 0.0, 0.0)]
}

pub struct Device {
    device: wgpu::Device,
    queue: wgpu::Queue,
}

impl Device {
    /// Opens the first adapter. If there is none, skips the test.
    pub fn open() -> Option<Self> {
        let instance = instance().inspect_err(|reason| skip_because(Need::Gpu, reason)).ok()?;
        let adapter = pollster::block_on(instance.request_adapter(&Default::default()));
        let adapter = adapter.inspect_err(|e| skip_because(Need::Gpu, e)).ok()?;
        let (device, queue) = pollster::block_on(adapter.request_device(&Default::default())).unwrap();
        // Not to be closed while other tests compile shaders: NVIDIA's driver would wait for ever.
        std::mem::forget(device.clone());
        Some(Device { device, queue })
    }

    /// Runs `body` for each case, whose row `i` of `inputs` has these numbers. It ends with
    /// `let all = array<f32, N>(…);`, and these results are returned with the case.
    pub fn run<C, const N: usize>(
        &self,
        text: &str,
        body: &str,
        cases: Vec<C>,
        numbers: impl Fn(&C) -> Vec<f32>,
    ) -> Vec<(C, [f32; N])> {
        self.run_beside(text, body, cases, numbers, &[], (Params::default(), &[]))
    }

    /// [`Self::run`], with override constants, parameters and the contents of other bindings of group 0.
    pub fn run_beside<C, const N: usize>(
        &self,
        text: &str,
        body: &str,
        cases: Vec<C>,
        numbers: impl Fn(&C) -> Vec<f32>,
        constants: &[(&str, f64)],
        (params, others): (Params, &[(u32, &[u8])]),
    ) -> Vec<(C, [f32; N])> {
        let inputs: Vec<f32> = cases.iter().flat_map(numbers).collect();
        let rows = cases.len();
        let text = format!(
            "#import params\n{text}
            @group(1) @binding(0) var<storage, read> inputs: array<f32>;
            @group(1) @binding(1) var<storage, read_write> outputs: array<f32>;
            @compute @workgroup_size(64) fn table(@builtin(global_invocation_id) id: vec3u) {{
            let i = id.x;
            if i >= ({rows}u ^ params.zero) {{ return; }}
            {body}
            var row = all;
            for (var k = 0u; k < {N}u; k++) {{ outputs[{N}u * i + k] = row[k]; }}
            }}"
        );
        let source = expand(&text, Contents::default(), 1);
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let pipeline = self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &module,
            entry_point: Some("table"),
            compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
            cache: None,
        });
        let filled = |contents: &[u8], usage| {
            self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
        };
        let mut shared = vec![(0, filled(bytemuck::bytes_of(&params), Usage::UNIFORM))];
        shared.extend(others.iter().map(|(binding, bytes)| (*binding, filled(bytes, Usage::STORAGE))));
        let read = filled(bytemuck::cast_slice(&inputs), Usage::STORAGE);
        let size = (4 * N * rows) as u64;
        let empty = |usage| {
            let descriptor = wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
            self.device.create_buffer(&descriptor)
        };
        let written = empty(Usage::STORAGE | Usage::COPY_SRC);
        let back = empty(Usage::MAP_READ | Usage::COPY_DST);
        let group = |index, buffers: &[(u32, wgpu::Buffer)]| {
            let entries = buffers.iter().map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding: *binding,
                resource: buffer.as_entire_binding(),
            });
            let entries: Vec<_> = entries.collect();
            self.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: &pipeline.get_bind_group_layout(index),
                entries: &entries,
            })
        };
        let groups = [group(0, &shared), group(1, &[(0, read), (1, written.clone())])];
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        for (index, group) in (0..).zip(&groups) {
            pass.set_bind_group(index, group, &[]);
        }
        pass.dispatch_workgroups(rows.div_ceil(64) as u32, 1, 1);
        drop(pass);
        encoder.copy_buffer_to_buffer(&written, 0, &back, 0, size);
        self.queue.submit([encoder.finish()]);
        back.map_async(wgpu::MapMode::Read, .., |mapped| mapped.unwrap());
        self.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        let view = back.get_mapped_range(..).unwrap();
        let results = bytemuck::cast_slice::<u8, f32>(&view).chunks_exact(N).map(|row| row.try_into().unwrap());
        cases.into_iter().zip(results).collect()
    }
}
