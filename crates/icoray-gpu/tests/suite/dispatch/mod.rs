//! Runs a piece of WGSL once per row of a table of inputs.

use icoray_gpu::layout::Params;
use icoray_gpu::shader::expand;
use icoray_test_support::{Need, skip_because};
use wgpu::BufferUsages as Usage;

/// Last digits of f32 between two numbers, counted at the size of `size` or of the numbers, whichever is larger.
pub fn ulps(a: f32, b: f32, size: f32) -> f64 {
    let unit = f64::from(a.abs().max(b.abs()).max(size)) * f64::from(f32::EPSILON);
    if a == b { 0.0 } else { (f64::from(a) - f64::from(b)).abs() / unit.max(1e-38) }
}

pub struct Device {
    device: wgpu::Device,
    queue: wgpu::Queue,
}

impl Device {
    /// The first adapter's. Where there is none, skips the test.
    pub fn open() -> Option<Self> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends: wgpu::Backends::VULKAN,
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let adapter = pollster::block_on(instance.request_adapter(&Default::default()));
        let adapter = adapter.inspect_err(|e| skip_because(Need::Gpu, e)).ok()?;
        let (device, queue) = pollster::block_on(adapter.request_device(&Default::default())).unwrap();
        Some(Device { device, queue })
    }

    /// `body` for each row `i` of `width` numbers in `inputs`; gives `results` numbers of `outputs` per row.
    pub fn run(&self, text: &str, body: &str, inputs: &[f32], width: usize, results: usize) -> Vec<f32> {
        self.run_with(text, body, inputs, width, results, &[])
    }

    pub fn run_with(
        &self,
        text: &str,
        body: &str,
        inputs: &[f32],
        width: usize,
        results: usize,
        constants: &[(&str, f64)],
    ) -> Vec<f32> {
        self.run_beside(text, body, inputs, [width, results], constants, (Params::default(), &[]))
    }

    /// Beside what all rays share, and other bindings with their bytes.
    pub fn run_beside(
        &self,
        text: &str,
        body: &str,
        inputs: &[f32],
        [width, results]: [usize; 2],
        constants: &[(&str, f64)],
        (params, others): (Params, &[(u32, &[u8])]),
    ) -> Vec<f32> {
        let rows = inputs.len() / width;
        let source = expand(&format!(
            "#import params\n{text}
            @group(1) @binding(0) var<storage, read> inputs: array<f32>;
            @group(1) @binding(1) var<storage, read_write> outputs: array<f32>;
            @compute @workgroup_size(64) fn table(@builtin(global_invocation_id) id: vec3u) {{
            let i = id.x;
            if i >= {rows}u || params.zero != 0u {{ return; }}
            {body}
            }}"
        ));
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
        let buffer = |bytes: usize, usage| {
            self.device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: bytes as u64,
                usage,
                mapped_at_creation: false,
            })
        };
        let uniform = buffer(size_of::<Params>(), Usage::UNIFORM | Usage::COPY_DST);
        self.queue.write_buffer(&uniform, 0, bytemuck::bytes_of(&params));
        let held = |(binding, bytes): &(u32, &[u8])| {
            let held = buffer(bytes.len(), Usage::STORAGE | Usage::COPY_DST);
            self.queue.write_buffer(&held, 0, bytes);
            (*binding, held)
        };
        let mut shared = vec![(0, uniform)];
        shared.extend(others.iter().map(held));
        let read = buffer(size_of_val(inputs), Usage::STORAGE | Usage::COPY_DST);
        self.queue.write_buffer(&read, 0, bytemuck::cast_slice(inputs));
        let written = buffer(4 * results * rows, Usage::STORAGE | Usage::COPY_SRC);
        let back = buffer(4 * results * rows, Usage::MAP_READ | Usage::COPY_DST);
        let group = |index, buffers: &[(u32, wgpu::Buffer)]| {
            let entries: Vec<_> = buffers
                .iter()
                .map(|(binding, b)| wgpu::BindGroupEntry {
                    binding: *binding,
                    resource: b.as_entire_binding(),
                })
                .collect();
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
        encoder.copy_buffer_to_buffer(&written, 0, &back, 0, (4 * results * rows) as u64);
        self.queue.submit([encoder.finish()]);
        back.map_async(wgpu::MapMode::Read, .., |mapped| mapped.unwrap());
        self.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        bytemuck::cast_slice(&back.get_mapped_range(..).unwrap()).to_vec()
    }
}
