//! Peak rates of a device, measured; frame times are compared with them.

use crate::context::Context;
use crate::pipelines::{bind_group, compile, dispatch};
use crate::readback::Readback;
use crate::shader::{self, Contents};
use crate::timestamps::Timestamps;
use icoray::device::FallbackReason;
use std::time::Instant;
use wgpu::BufferUsages;

/// Rates of a device, each the best of several runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peaks {
    /// Bytes per second from mapped host memory to the device's memory.
    pub host_to_device: f64,
    /// Bytes per second from any host memory to the device's memory: one thread first copies them to mapped memory.
    pub staged: f64,
    /// Bytes per second from the device's memory to any host memory.
    pub readback: f64,
    /// Bytes per second that a shader reads from the device's memory.
    pub memory: f64,
    /// Floating-point operations per second of a shader in f32; a fused multiply-add counts as two.
    pub flops: f64,
}

/// Bytes of a transfer: much more than caches hold.
const TRANSFER_BYTES: u64 = 256 << 20;
/// Bytes that a shader reads, if a binding can have as many.
const STREAM_BYTES: u64 = 1 << 30;
/// Runs of each measurement. The first one is a warm-up.
const RUNS: usize = 6;
/// Invocations in a workgroup of the shaders.
const WORKGROUP: u64 = 256;
/// Number of workgroups that saturates any device.
const WORKGROUPS: u64 = 4096;
/// Operations of an invocation of `shaders/measure/multiply.wgsl`.
const FLOPS: f64 = (2 * 12 * 16 * 64) as f64;

impl Peaks {
    pub(crate) fn measure(ctx: &Context) -> Result<Self, FallbackReason> {
        let (host_to_device, staged) = upload_rates(ctx)?;
        let readback = readback_rate(ctx)?;
        // Frames need no buffers of this size.
        ctx.pool.clear();
        Ok(Peaks { host_to_device, staged, readback, memory: memory_rate(ctx)?, flops: flops(ctx)? })
    }
}

fn upload_rates(ctx: &Context) -> Result<(f64, f64), FallbackReason> {
    let bytes = ctx.limits.max_buffer_size.min(TRANSFER_BYTES);
    let target = ctx.buffer("sent", bytes as usize, BufferUsages::COPY_DST)?;
    let usage = BufferUsages::MAP_WRITE | BufferUsages::COPY_SRC;
    let source = ctx.buffer("to be sent", bytes as usize, usage)?;
    source.unmap();
    let host = vec![1u8; bytes as usize];
    let copy = || {
        let mut encoder = ctx.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(&source, 0, &target, 0, bytes);
        execute(ctx, encoder)
    };
    let write = || {
        ctx.queue.write_buffer(&target, 0, &host);
        execute(ctx, ctx.device.create_command_encoder(&Default::default()))
    };
    let (direct, staged) = (fastest(|| seconds(copy))?, fastest(|| seconds(write))?);
    Ok((bytes as f64 / direct, bytes as f64 / staged))
}

fn readback_rate(ctx: &Context) -> Result<f64, FallbackReason> {
    let bytes = ctx.limits.max_buffer_size.min(TRANSFER_BYTES);
    let usage = BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
    let source = ctx.buffer("read", bytes as usize, usage)?;
    let mut host = vec![0u8; bytes as usize];
    let mut read = || {
        let commands = ctx.device.create_command_encoder(&Default::default());
        let readback = Readback::submit(ctx, commands, &source, bytes as usize)?;
        readback.wait(ctx, |read| host.copy_from_slice(read))
    };
    Ok(bytes as f64 / fastest(|| seconds(&mut read))?)
}

fn memory_rate(ctx: &Context) -> Result<f64, FallbackReason> {
    let limits = &ctx.limits;
    let bytes = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size).min(STREAM_BYTES);
    let bytes = bytes / 16 * 16;
    let streamed = ctx.buffer("streamed", bytes as usize, BufferUsages::STORAGE)?;
    let sums = ctx.buffer("sums", (4 * WORKGROUP * WORKGROUPS) as usize, BufferUsages::STORAGE)?;
    let seconds = pass_seconds(ctx, "stream", &[&streamed, &sums], WORKGROUPS)?;
    Ok(bytes as f64 / seconds)
}

/// Increases the number of workgroups until they take some milliseconds.
fn flops(ctx: &Context) -> Result<f64, FallbackReason> {
    let max = u64::from(ctx.limits.max_compute_workgroups_per_dimension);
    let mut workgroups = 64;
    loop {
        let bytes = (4 * WORKGROUP * workgroups) as usize;
        let products = ctx.buffer("products", bytes, BufferUsages::STORAGE)?;
        let seconds = pass_seconds(ctx, "multiply", &[&products], workgroups)?;
        if seconds > 5e-3 || 4 * workgroups > max {
            return Ok((workgroups * WORKGROUP) as f64 * FLOPS / seconds);
        }
        workgroups *= 4;
    }
}

/// Seconds of a pass of `shaders/measure/NAME.wgsl`, by the device's clock if it has one.
fn pass_seconds(ctx: &Context, name: &str, buffers: &[&wgpu::Buffer], count: u64) -> Result<f64, FallbackReason> {
    let text = shader::compose(&format!("measure/{name}"), Contents::default(), 1);
    let pipeline = compile(ctx, name, text, None, &[])?;
    let group = bind_group(ctx, &pipeline.get_bind_group_layout(0), buffers.iter().copied())?;
    let run = || {
        let timestamps = Timestamps::new(ctx, 1)?;
        let mut encoder = ctx.device.create_command_encoder(&Default::default());
        dispatch(&mut encoder, &timestamps.pass(), &pipeline, [&group], [count as u32, 1]);
        timestamps.resolve(&mut encoder);
        let elapsed = seconds(|| execute(ctx, encoder))?;
        Ok(timestamps.seconds(ctx)?.unwrap_or(elapsed))
    };
    fastest(run)
}

/// Submits commands and waits for their end.
fn execute(ctx: &Context, encoder: wgpu::CommandEncoder) -> Result<(), FallbackReason> {
    ctx.queue.submit([encoder.finish()]);
    let waited = ctx.device.poll(wgpu::PollType::wait_indefinitely());
    ctx.check()?;
    waited.map(drop).map_err(|e| FallbackReason::new(format!("waiting for {}: {e}", ctx.name())))
}

fn seconds(run: impl FnOnce() -> Result<(), FallbackReason>) -> Result<f64, FallbackReason> {
    let start = Instant::now();
    run()?;
    Ok(start.elapsed().as_secs_f64())
}

/// The shortest of several times, without the first one.
fn fastest(time: impl FnMut() -> Result<f64, FallbackReason>) -> Result<f64, FallbackReason> {
    let times: Vec<f64> = std::iter::repeat_with(time).take(RUNS).collect::<Result<_, _>>()?;
    Ok(times[1..].iter().copied().fold(f64::INFINITY, f64::min))
}
