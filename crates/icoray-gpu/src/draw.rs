//! A picture's tiles: dispatched in bands, so that no watchdog takes a long one for a hung device, and read back.

use crate::gpu::{Gpu, because};
use crate::layout::{Params, Piece, Pixel};
use crate::light;
use crate::scene::{self, Picture, Variant};
use crate::times::Times;
use icoray::device::{Band, Device, Job, Reason, Rect, Spent};
use std::ops::Range;
use std::sync::mpsc::{Receiver, channel};
use std::time::Instant;
use wgpu::BufferUsages;

/// About how many pixels a dispatch has: enough to fill a device, few enough for a slow one.
const BAND: usize = 1 << 18;

impl Device for Gpu {
    fn name(&self) -> String {
        self.described()
    }

    fn trace(&self, job: &Job, give: &(dyn Fn(Band) + Sync)) -> Result<Spent, Reason> {
        let start = Instant::now();
        let (picture, mut bytes_uploaded) = self.picture(job)?;
        let pipeline = Variant::of(job).pipeline(self)?;
        let tiles: Vec<Rect> = job.tiles().collect();
        let most = (self.limits.max_storage_buffer_binding_size / size_of::<Pixel>() as u64).min(BAND as u64);
        let bands = bands(&tiles, most as usize);
        let mut pieces = scene::pieces(self, job, &tiles);
        let mut groups = Vec::with_capacity(bands.len());
        for band in &bands {
            let mut first = 0;
            let before = groups.last().map_or(0, |groups: &Range<u32>| groups.end);
            for (tile, pieces) in tiles[band.clone()].iter().zip(&mut pieces[band.clone()]) {
                pieces.iter_mut().for_each(|piece| piece.first += first);
                first += tile.pixels() as u32;
            }
            let count: usize = pieces[band.clone()].iter().map(Vec::len).sum();
            groups.push(before..before + count as u32);
        }
        let pieces: Vec<Piece> = pieces.concat();
        bytes_uploaded += size_of_val(pieces.as_slice()) as u64;
        let largest = bands.iter().map(|band| pixels(&tiles[band.clone()])).max().unwrap_or(0);
        let times = Times::new(self, bands.len())?;
        let run = Run::new(self, job, &picture, pipeline, &pieces, largest)?;
        let mut spent = Spent { upload_s: start.elapsed().as_secs_f64(), device_s: None, bytes_uploaded };
        let (mut lost, mut last, mut before) = (0, Instant::now(), None);
        let mut finish = |(band, flight): (Range<usize>, Flight)| {
            let seconds = || std::mem::replace(&mut last, Instant::now()).elapsed().as_secs_f64();
            lost += run.finish(flight, &tiles[band.clone()], band.start, seconds, give)?;
            Ok(())
        };
        // One band is traced while the one before is read.
        for (band, groups) in bands.into_iter().zip(groups) {
            let flight = run.begin(groups, pixels(&tiles[band.clone()]), &times)?;
            before.replace((band, flight)).map_or(Ok(()), &mut finish)?;
        }
        before.map_or(Ok(()), &mut finish)?;
        spent.device_s = times.seconds(self)?;
        if lost > 0 {
            return because(format!(
                "rays have lost their way on {}, or their loops were cut short",
                self.name()
            ));
        }
        Ok(spent)
    }
}

fn pixels(tiles: &[Rect]) -> usize {
    tiles.iter().map(Rect::pixels).sum()
}

/// Tiles put together to no more than `most` pixels.
fn bands(tiles: &[Rect], most: usize) -> Vec<Range<usize>> {
    let (mut bands, mut start, mut sum) = (Vec::new(), 0, 0);
    for (i, tile) in tiles.iter().enumerate() {
        if i > start && sum + tile.pixels() > most {
            bands.push(start..i);
            (start, sum) = (i, 0);
        }
        sum += tile.pixels();
    }
    bands.extend((start < tiles.len()).then_some(start..tiles.len()));
    bands
}

/// What the dispatches of a job have in common.
struct Run<'g> {
    gpu: &'g Gpu,
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    light: wgpu::BindGroup,
    uniform: wgpu::Buffer,
    pixels: wgpu::Buffer,
    params: Params,
}

/// A band that is being traced.
struct Flight {
    back: wgpu::Buffer,
    submission: wgpu::SubmissionIndex,
    mapped: Receiver<Result<(), wgpu::BufferAsyncError>>,
}

impl<'g> Run<'g> {
    fn new(
        gpu: &'g Gpu,
        job: &Job,
        picture: &Picture,
        pipeline: wgpu::ComputePipeline,
        pieces: &[Piece],
        most: usize,
    ) -> Result<Self, Reason> {
        let params = scene::params(job, &picture.mesh);
        let uniform =
            gpu.buffer("params", size_of_val(&params), BufferUsages::UNIFORM | BufferUsages::COPY_DST)?;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let pixels = gpu.buffer("pixels", most * size_of::<Pixel>(), usage)?;
        let pieces = gpu.upload("pieces", pieces)?;
        let [directions, corner_cell, corner_edge, edge_corner, seats, voids, rim] = &picture.mesh.buffers;
        let [spans, steps, shell] = &picture.tables;
        let buffers = [
            &uniform,
            directions,
            corner_cell,
            corner_edge,
            edge_corner,
            seats,
            voids,
            rim,
            spans,
            steps,
            &picture.field,
            shell,
            &pieces,
            &pixels,
        ];
        let entries: Vec<_> = (0u32..)
            .zip(buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
            .collect();
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("picture"),
            layout: &gpu.bindings,
            entries: &entries,
        });
        let light = light::bind(gpu, job, picture.gradients.as_ref())?;
        gpu.untroubled()?;
        Ok(Run { gpu, pipeline, group, light, uniform, pixels, params })
    }

    /// Dispatches some pieces, which trace so many pixels.
    fn begin(&self, pieces: Range<u32>, pixels: usize, times: &Times) -> Result<Flight, Reason> {
        let gpu = self.gpu;
        let bytes = pixels * size_of::<Pixel>();
        let back = gpu.buffer("picture", bytes, BufferUsages::MAP_READ | BufferUsages::COPY_DST)?;
        let params = Params { first_piece: pieces.start, ..self.params };
        gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&params));
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&times.pass());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.set_bind_group(1, &self.light, &[]);
        pass.dispatch_workgroups(pieces.end - pieces.start, 1, 1);
        drop(pass);
        times.resolve(&mut encoder);
        encoder.copy_buffer_to_buffer(&self.pixels, 0, &back, 0, bytes as u64);
        let submission = gpu.queue.submit([encoder.finish()]);
        let (told, mapped) = channel();
        back.map_async(wgpu::MapMode::Read, .., move |is| drop(told.send(is)));
        gpu.untroubled()?;
        Ok(Flight { back, submission, mapped })
    }

    /// Waits for a band of `tiles`, the first of which has the number `number`, and gives those away of which no ray was lost.
    /// How many have lost one.
    fn finish(
        &self,
        flight: Flight,
        tiles: &[Rect],
        number: usize,
        seconds: impl FnOnce() -> f64,
        give: &(dyn Fn(Band) + Sync),
    ) -> Result<usize, Reason> {
        let (gpu, name) = (self.gpu, || self.gpu.name());
        let Flight { back, submission, mapped } = flight;
        let waited =
            gpu.device.poll(wgpu::PollType::Wait { submission_index: Some(submission), timeout: None });
        gpu.untroubled()?;
        waited.map_err(|e| Reason::new(format!("waiting for {}: {e}", name())))?;
        let mapped = mapped.recv().map_err(|_| Reason::new(format!("{} gives no picture back", name())))?;
        mapped.map_err(|e| Reason::new(format!("reading from {}: {e}", name())))?;
        let view = back.get_mapped_range(..).map_err(|e| Reason::new(format!("{}: {e}", name())))?;
        let bytes = pixels(tiles) * size_of::<Pixel>();
        let rays: &[icoray::device::Traced] = bytemuck::cast_slice(&view[..bytes]);
        let seconds = seconds() / tiles.len() as f64;
        // Runs of tiles without a lost ray.
        let (mut lost, mut run, mut start, mut end) = (0, 0..0, 0, 0);
        for (i, tile) in tiles.iter().enumerate() {
            let next = end + tile.pixels();
            if rays[end..next].iter().any(|ray| ray.error == Pixel::LOST) {
                lost += 1;
                self::give(give, number, run, &rays[start..end], seconds);
                (run, start) = (i + 1..i + 1, next);
            } else {
                run.end = i + 1;
            }
            end = next;
        }
        self::give(give, number, run, &rays[start..end], seconds);
        Ok(lost)
    }
}

/// Gives a run of tiles, if there are any, each of which took so many seconds.
fn give(
    give: &(dyn Fn(Band) + Sync),
    number: usize,
    run: Range<usize>,
    rays: &[icoray::device::Traced],
    seconds: f64,
) {
    if !run.is_empty() {
        give(Band { first: number + run.start, rays, seconds: seconds * run.len() as f64 });
    }
}
