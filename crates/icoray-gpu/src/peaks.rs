//! What a device can do at most, measured: what frames are held against.

use crate::gpu::Gpu;
use crate::shader;
use crate::times::Times;
use icoray::device::Reason;
use std::time::Instant;
use wgpu::BufferUsages;

/// Rates of a device, each the best of several runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peaks {
    /// Bytes per second from host memory that the device reads to its own.
    pub host_to_device: f64,
    /// The same from any memory of the host's, which is first copied to such memory by one thread.
    pub staged: f64,
    /// Bytes per second from the device's memory to any of the host's.
    pub readback: f64,
    /// Bytes per second that a shader reads of the device's memory.
    pub memory: f64,
    /// Floating-point operations per second of a shader, in f32: two in a multiplication with a sum.
    pub flops: f64,
}

/// Bytes that are sent and read back: much more than caches hold.
const SENT: u64 = 256 << 20;
/// Bytes that a shader reads, where a binding takes as many.
const STREAMED: u64 = 1 << 30;
/// Runs of each; the first one warms up.
const RUNS: usize = 6;
/// Invocations in a workgroup of the shaders.
const GROUP: u64 = 256;
/// Workgroups that fill any device.
const GROUPS: u64 = 4096;
/// See `shaders/measure/multiply.wgsl`.
const FLOPS: f64 = (2 * 12 * 16 * 64) as f64;

impl Gpu {
    /// Measures the device: takes a second, and some hundred megabytes on both sides.
    ///
    /// # Errors
    /// A [`Reason`] where the device fails.
    pub fn peaks(&self) -> Result<Peaks, Reason> {
        let (host_to_device, staged) = self.sent()?;
        let readback = self.read_back()?;
        // Frames need no such buffers.
        self.store.clear();
        Ok(Peaks { host_to_device, staged, readback, memory: self.streamed()?, flops: self.multiplied()? })
    }

    fn sent(&self) -> Result<(f64, f64), Reason> {
        let bytes = self.limits.max_buffer_size.min(SENT);
        let there = self.buffer("sent", bytes as usize, BufferUsages::COPY_DST)?;
        let usage = BufferUsages::MAP_WRITE | BufferUsages::COPY_SRC;
        let here = self.buffer("to be sent", bytes as usize, usage)?;
        here.unmap();
        let host = vec![1u8; bytes as usize];
        let direct = best(|| {
            let mut encoder = self.device.create_command_encoder(&Default::default());
            encoder.copy_buffer_to_buffer(&here, 0, &there, 0, bytes);
            self.wait(encoder)
        })?;
        let staged = best(|| {
            self.queue.write_buffer(&there, 0, &host);
            self.wait(self.device.create_command_encoder(&Default::default()))
        })?;
        Ok((bytes as f64 / direct, bytes as f64 / staged))
    }

    fn read_back(&self) -> Result<f64, Reason> {
        let bytes = self.limits.max_buffer_size.min(SENT);
        let there = self.buffer("read", bytes as usize, BufferUsages::COPY_SRC | BufferUsages::COPY_DST)?;
        let mut host = vec![0u8; bytes as usize];
        let seconds = best(|| {
            let commands = self.device.create_command_encoder(&Default::default());
            let flight = self.submit(commands, &there, bytes as usize)?;
            self.land(flight, |read| host.copy_from_slice(read))
        })?;
        Ok(bytes as f64 / seconds)
    }

    fn streamed(&self) -> Result<f64, Reason> {
        let limits = &self.limits;
        let bytes = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size).min(STREAMED);
        let bytes = bytes / 16 * 16;
        let streamed = self.buffer("streamed", bytes as usize, BufferUsages::STORAGE)?;
        let sums = self.buffer("sums", (4 * GROUP * GROUPS) as usize, BufferUsages::STORAGE)?;
        let seconds = self.passes("measure/stream", "stream", &[&streamed, &sums], GROUPS)?;
        Ok(bytes as f64 / seconds)
    }

    /// With as many workgroups as take some milliseconds.
    fn multiplied(&self) -> Result<f64, Reason> {
        let mut groups = 64;
        loop {
            let products = self.buffer("products", (4 * GROUP * groups) as usize, BufferUsages::STORAGE)?;
            let seconds = self.passes("measure/multiply", "multiply", &[&products], groups)?;
            if seconds > 5e-3 || groups == 1 << 15 {
                return Ok((groups * GROUP) as f64 * FLOPS / seconds);
            }
            groups *= 4;
        }
    }

    /// Seconds of a pass of `groups` workgroups, by the device's clock if it has one.
    fn passes(&self, name: &str, entry: &str, buffers: &[&wgpu::Buffer], groups: u64) -> Result<f64, Reason> {
        let pipeline = self.watched(|| {
            let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(name),
                source: wgpu::ShaderSource::Wgsl(shader::compose(name).into()),
            });
            self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(name),
                layout: None,
                module: &module,
                entry_point: Some(entry),
                compilation_options: Default::default(),
                cache: None,
            })
        })?;
        let entries: Vec<_> = (0u32..)
            .zip(buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
            .collect();
        let group = self.watched(|| {
            self.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(name),
                layout: &pipeline.get_bind_group_layout(0),
                entries: &entries,
            })
        })?;
        let mut least = f64::INFINITY;
        for run in 0..RUNS {
            let times = Times::new(self, 1)?;
            let mut encoder = self.device.create_command_encoder(&Default::default());
            let mut pass = encoder.begin_compute_pass(&times.pass());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(groups as u32, 1, 1);
            drop(pass);
            times.resolve(&mut encoder);
            let start = Instant::now();
            self.wait(encoder)?;
            let waited = start.elapsed().as_secs_f64();
            let seconds = times.seconds(self)?.unwrap_or(waited);
            if run > 0 {
                least = least.min(seconds);
            }
        }
        Ok(least)
    }

    /// Submits, and waits until all is done.
    fn wait(&self, encoder: wgpu::CommandEncoder) -> Result<(), Reason> {
        self.queue.submit([encoder.finish()]);
        let waited = self.device.poll(wgpu::PollType::wait_indefinitely());
        self.untroubled()?;
        waited.map(drop).map_err(|e| Reason::new(format!("waiting for {}: {e}", self.described())))
    }
}

/// The least seconds that `run` took, but for the first time.
fn best(mut run: impl FnMut() -> Result<(), Reason>) -> Result<f64, Reason> {
    let mut least = f64::INFINITY;
    for i in 0..RUNS {
        let start = Instant::now();
        run()?;
        if i > 0 {
            least = least.min(start.elapsed().as_secs_f64());
        }
    }
    Ok(least)
}
