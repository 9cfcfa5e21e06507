//! Tiles that are dispatched in bands, so that no watchdog takes a long one for a hung device; one is traced while the one before
//! is read back.

use crate::gpu::Gpu;
use crate::held::Held;
use crate::layout::{Params, Piece, Pixel};
use crate::light;
use crate::readback::Flight;
use crate::scene::{self, Picture, Variant};
use crate::store::Lent;
use crate::times::Times;
use icoray::device::{Band, Job, Reason, Rect, Traced};
use std::ops::Range;
use std::time::Instant;
use wgpu::BufferUsages;

/// About how many pixels a dispatch has: enough to fill a device, few enough for a slow one.
const BAND: usize = 1 << 18;

/// Tiles on their way through the device, each with its place in the job.
pub(crate) struct Course<'c> {
    gpu: &'c Gpu,
    tiles: &'c [(usize, Rect)],
    bands: Vec<Stretch>,
    pipeline: wgpu::ComputePipeline,
    groups: [wgpu::BindGroup; 4],
    params: Params,
    uniform: Lent,
    /// Bound in `groups`, with nobody else to write to it meanwhile.
    _bound: [Lent; 2],
    pixels: Lent,
    times: Times,
    bytes: u64,
}

/// A band.
pub(crate) struct Stretch {
    pub tiles: Range<usize>,
    /// What they have of all pieces.
    pub pieces: Range<u32>,
}

impl<'c> Course<'c> {
    /// Tiles of a picture, of a field that is there.
    pub fn new(
        gpu: &'c Gpu,
        picture: &Picture,
        held: &Held,
        tiles: &'c [(usize, Rect)],
    ) -> Result<Self, Reason> {
        let job = picture.job;
        let pipeline = Variant::of(job, held).pipeline(gpu)?;
        let params = held.params(picture);
        let (bands, pieces) = cut(gpu, job, tiles);
        let largest = bands.iter().map(|band| pixels(&tiles[band.tiles.clone()])).max().unwrap_or(0);
        let uniform = gpu.lend_uniform("params", &params)?;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let pixels = gpu.lend("pixels", largest * size_of::<Pixel>(), usage)?;
        let bytes = size_of_val(pieces.as_slice()) as u64;
        let pieces = gpu.lend_with("pieces", &pieces)?;
        let group = picture.group(gpu, held, &uniform, &pieces, &pixels)?;
        let [values, gradients] = held.groups(gpu)?;
        let light = light::uniform(gpu, job)?;
        let groups = [group, values, gpu.group(&gpu.of_light, [&*light])?, gradients];
        let times = Times::new(gpu, bands.len())?;
        Ok(Course {
            gpu,
            tiles,
            bands,
            pipeline,
            groups,
            params,
            uniform,
            _bound: [light, pieces],
            pixels,
            times,
            bytes,
        })
    }

    /// Bytes that were uploaded for it.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Traces the tiles and gives those away of which no ray was lost. How many have lost one.
    pub fn run(&self, give: &(dyn Fn(Band) + Sync)) -> Result<usize, Reason> {
        let (mut lost, mut last, mut before) = (0, Instant::now(), None);
        let mut finish = |(band, flight): (Range<usize>, Flight)| {
            let tiles = &self.tiles[band];
            lost += self.gpu.land(flight, |bytes| {
                let seconds = std::mem::replace(&mut last, Instant::now()).elapsed().as_secs_f64();
                give_runs(tiles, bytemuck::cast_slice(bytes), seconds, give)
            })?;
            Ok(())
        };
        for band in &self.bands {
            let flight = self.begin(band)?;
            before.replace((band.tiles.clone(), flight)).map_or(Ok(()), &mut finish)?;
        }
        before.map_or(Ok(()), &mut finish)?;
        Ok(lost)
    }

    /// Seconds in the rays by the device's clock, if it has one.
    pub fn seconds(self) -> Result<Option<f64>, Reason> {
        self.times.seconds(self.gpu)
    }

    fn begin(&self, Stretch { tiles, pieces }: &Stretch) -> Result<Flight, Reason> {
        let gpu = self.gpu;
        let params = Params { first_piece: pieces.start, ..self.params };
        let commands = gpu.watched(|| {
            gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&params));
            let mut commands = gpu.device.create_command_encoder(&Default::default());
            let mut pass = commands.begin_compute_pass(&self.times.pass());
            pass.set_pipeline(&self.pipeline);
            (0..).zip(&self.groups).for_each(|(i, group)| pass.set_bind_group(i, group, &[]));
            pass.dispatch_workgroups(pieces.end - pieces.start, 1, 1);
            drop(pass);
            self.times.resolve(&mut commands);
            commands
        })?;
        gpu.submit(commands, &self.pixels, pixels(&self.tiles[tiles.clone()]) * size_of::<Pixel>())
    }
}

pub(crate) fn pixels(tiles: &[(usize, Rect)]) -> usize {
    tiles.iter().map(|(_, tile)| tile.pixels()).sum()
}

/// Tiles put together to bands, and the pieces of all of them.
pub(crate) fn cut(gpu: &Gpu, job: &Job, tiles: &[(usize, Rect)]) -> (Vec<Stretch>, Vec<Piece>) {
    let most = (gpu.most(BufferUsages::STORAGE) as usize / size_of::<Pixel>()).min(BAND);
    let rects: Vec<Rect> = tiles.iter().map(|(_, tile)| *tile).collect();
    let (mut bands, mut all) = (Vec::<Stretch>::new(), Vec::new());
    let mut taken = 0;
    for (i, mut pieces) in scene::pieces(gpu, job, &rects).into_iter().enumerate() {
        if bands.is_empty() || taken + rects[i].pixels() > most {
            let before = all.len() as u32;
            bands.push(Stretch { tiles: i..i, pieces: before..before });
            taken = 0;
        }
        pieces.iter_mut().for_each(|piece| piece.first += taken as u32);
        taken += rects[i].pixels();
        all.append(&mut pieces);
        if let Some(Stretch { tiles, pieces }) = bands.last_mut() {
            (tiles.end, pieces.end) = (i + 1, all.len() as u32);
        }
    }
    (bands, all)
}

/// Gives runs of tiles whose places follow each other, without those that have lost a ray; how many have. Each took its part of
/// the seconds.
fn give_runs(tiles: &[(usize, Rect)], rays: &[Traced], seconds: f64, give: &(dyn Fn(Band) + Sync)) -> usize {
    let seconds = seconds / tiles.len() as f64;
    let give = |run: &[(usize, Rect)], rays: &[Traced]| {
        if let Some((first, _)) = run.first() {
            give(Band { first: *first, rays, seconds: seconds * run.len() as f64 });
        }
    };
    let (mut lost, mut run, mut start, mut end) = (0, 0..0, 0, 0);
    for (i, (place, tile)) in tiles.iter().enumerate() {
        let next = end + tile.pixels();
        let is_lost = rays[end..next].iter().any(|ray| ray.error == Pixel::LOST);
        let follows = i > run.start && tiles[i - 1].0 + 1 == *place;
        if is_lost || !follows {
            give(&tiles[run.clone()], &rays[start..end]);
            (run.start, start) = if is_lost { (i + 1, next) } else { (i, end) };
        }
        run.end = i + 1;
        lost += usize::from(is_lost);
        end = next;
    }
    give(&tiles[run], &rays[start..end]);
    lost
}
