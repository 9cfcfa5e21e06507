//! Rays through a rank's part of the cells, in bands: fragments come back in no order, and are put in order here.

use crate::band::{Stretch, cut, pixels};
use crate::gpu::Gpu;
use crate::groups::READ;
use crate::held::Held;
use crate::layout::{self, Params, halves};
use crate::light;
use crate::scene::{Picture, Variant};
use crate::store::Lent;
use crate::times::Times;
use icoray::device::{ENDLESS, Fragment, Fragments, Own, Passed, Reason, Rect, Signature};
use rayon::prelude::*;
use std::cell::RefCell;
use wgpu::BufferBindingType::{self, Storage, Uniform};
use wgpu::BufferUsages;

/// Kinds of the bindings of group 2.
pub(crate) const BINDINGS: [BufferBindingType; 4] = [Uniform, Uniform, READ, Storage { read_only: false }];

/// Bytes of the count before fragments.
const COUNT: usize = size_of::<u32>();

/// Tiles on their way through the device, each with its place in the job.
pub(crate) struct Course<'c> {
    gpu: &'c Gpu,
    picture: &'c Picture<'c>,
    tiles: &'c [(usize, Rect)],
    bands: Vec<Stretch>,
    pipeline: wgpu::ComputePipeline,
    /// 0, 1 and 3.
    groups: [wgpu::BindGroup; 3],
    params: Params,
    uniform: Lent,
    passed: Lent,
    part: layout::Part,
    owned: Lent,
    /// Bound in `groups`, with nobody else to write to it meanwhile.
    _pieces: Lent,
    found: RefCell<Found>,
    times: Times,
    bytes: u64,
}

/// Room for fragments.
struct Found {
    most: usize,
    buffer: Lent,
    /// Group 2.
    group: wgpu::BindGroup,
    _bound: [Lent; 2],
}

impl<'c> Course<'c> {
    /// Tiles of a picture, of a field that is there.
    pub fn new(
        gpu: &'c Gpu,
        picture: &'c Picture,
        held: &Held,
        own: &Own,
        tiles: &'c [(usize, Rect)],
    ) -> Result<Self, Reason> {
        let job = picture.job;
        let pipeline = Variant::in_parts(job, held).pipeline(gpu)?;
        let params = held.params(picture);
        let (bands, pieces) = cut(gpu, job, tiles);
        let largest = bands.iter().map(|band| pixels(&tiles[band.tiles.clone()])).max().unwrap_or(0);
        let uniform = gpu.lend_uniform("params", &params)?;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let passed = gpu.lend("rays through a part", largest * size_of::<layout::Passed>(), usage)?;
        let owned = bits(own.triangles);
        let bytes = (size_of_val(pieces.as_slice()) + size_of_val(owned.as_slice())) as u64;
        let pieces = gpu.lend_with("pieces", &pieces)?;
        let owned = gpu.lend_with("own triangles", &owned)?;
        let group = picture.group(gpu, held, &uniform, &pieces, &passed)?;
        let [values, gradients] = held.groups(gpu)?;
        let part = part(own, job.radius()[0]);
        // A band whose fragments have no room is traced once more.
        let times = Times::new(gpu, 2 * bands.len())?;
        let found = RefCell::new(Found::new(gpu, picture, part, &owned, largest)?);
        let groups = [group, values, gradients];
        Ok(Course {
            gpu,
            picture,
            tiles,
            bands,
            pipeline,
            groups,
            params,
            uniform,
            passed,
            part,
            owned,
            _pieces: pieces,
            found,
            times,
            bytes,
        })
    }

    /// Bytes that were uploaded for it.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Traces the tiles and gives those away of which no ray was lost. How many have lost one.
    pub fn run(&self, give: &(dyn Fn(Fragments) + Sync)) -> Result<usize, Reason> {
        let mut lost = 0;
        for band in &self.bands {
            let mut passed = self.trace(band)?;
            let needed = count(&passed);
            if needed > self.found.borrow().most {
                let room = Found::new(self.gpu, self.picture, self.part, &self.owned, needed)?;
                self.found.replace(room);
                passed = self.trace(band)?;
            }
            let fragments = self.fetch(count(&passed))?;
            lost += give_tiles(&self.tiles[band.tiles.clone()], &passed, &fragments, give);
        }
        Ok(lost)
    }

    /// Seconds in the rays by the device's clock, if it has one.
    pub fn seconds(self) -> Result<Option<f64>, Reason> {
        self.times.seconds(self.gpu)
    }

    /// What the rays of a band meet; their fragments are left on the device.
    fn trace(&self, Stretch { tiles, pieces }: &Stretch) -> Result<Vec<layout::Passed>, Reason> {
        let (gpu, found) = (self.gpu, self.found.borrow());
        let params = Params { first_piece: pieces.start, ..self.params };
        let commands = gpu.watched(|| {
            gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&params));
            let mut commands = gpu.device.create_command_encoder(&Default::default());
            commands.clear_buffer(&found.buffer, 0, Some(COUNT as u64));
            let mut pass = commands.begin_compute_pass(&self.times.pass());
            pass.set_pipeline(&self.pipeline);
            let [tables, values, gradients] = &self.groups;
            (0..).zip([tables, values, &found.group, gradients]).for_each(|(i, group)| {
                pass.set_bind_group(i, group, &[]);
            });
            pass.dispatch_workgroups(pieces.end - pieces.start, 1, 1);
            drop(pass);
            self.times.resolve(&mut commands);
            commands
        })?;
        let bytes = pixels(&self.tiles[tiles.clone()]) * size_of::<layout::Passed>();
        let flight = gpu.submit(commands, &self.passed, bytes)?;
        gpu.land(flight, |bytes| bytemuck::cast_slice(bytes).to_vec())
    }

    /// The first fragments of those that were found.
    fn fetch(&self, count: usize) -> Result<Vec<layout::Fragment>, Reason> {
        let found = self.found.borrow();
        let commands = self.gpu.device.create_command_encoder(&Default::default());
        let bytes = COUNT + count * size_of::<layout::Fragment>();
        let flight = self.gpu.submit(commands, &found.buffer, bytes)?;
        self.gpu.land(flight, |bytes| bytemuck::cast_slice(&bytes[COUNT..]).to_vec())
    }
}

impl Found {
    fn new(
        gpu: &Gpu,
        picture: &Picture,
        part: layout::Part,
        owned: &wgpu::Buffer,
        most: usize,
    ) -> Result<Self, Reason> {
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let buffer = gpu.lend("fragments", COUNT + most * size_of::<layout::Fragment>(), usage)?;
        let uniform = gpu.lend_uniform("part", &layout::Part { most: most as u32, ..part })?;
        let light = light::uniform(gpu, picture.job)?;
        let group = gpu.group(&gpu.of_parts, [&*light, &*uniform, owned, &*buffer])?;
        Ok(Found { most, buffer, group, _bound: [light, uniform] })
    }
}

/// How many fragments rays have.
fn count(passed: &[layout::Passed]) -> usize {
    passed.iter().map(|ray| (ray.fragments & !layout::Passed::LOST) as usize).sum()
}

/// A bit per triangle.
fn bits(triangles: &[bool]) -> Vec<u32> {
    let word = |triangles: &[bool]| (0..).zip(triangles).fold(0, |word, (k, is)| word | u32::from(*is) << k);
    triangles.chunks(32).map(word).collect()
}

fn part(own: &Own, inner: f64) -> layout::Part {
    // Rays that just miss the ball in f64 do no harm: they have no fragments.
    let reach = (own.reach * (1.0 + 1e-5) + 1e-6).min(1e30) as f32;
    let [lowest_hi, lowest_lo] = halves(inner * own.lowest_facet);
    let middle = own.middle.map(|x| x as f32);
    let reach = if own.reach < 0.0 { -1.0 } else { reach };
    layout::Part { middle, reach, lowest_hi, lowest_lo, most: 0, padding: 0 }
}

/// Gives the tiles away that have lost no ray; how many have.
fn give_tiles(
    tiles: &[(usize, Rect)],
    mut passed: &[layout::Passed],
    found: &[layout::Fragment],
    give: &(dyn Fn(Fragments) + Sync),
) -> usize {
    let mut found = found.to_vec();
    found.par_sort_unstable_by(|a, b| a.ray.cmp(&b.ray).then(entry(a).total_cmp(&entry(b))));
    let mut found = found.as_slice();
    let of_tile = |(place, tile): &(usize, Rect)| {
        let (rays, others) = passed.split_at(tile.pixels());
        let (fragments, behind) = found.split_at(count(rays));
        (passed, found) = (others, behind);
        (*place, rays, fragments)
    };
    let all: Vec<_> = tiles.iter().map(of_tile).collect();
    let give = |(first, rays, fragments): (usize, &[layout::Passed], &[layout::Fragment])| {
        if rays.iter().any(|ray| ray.fragments & layout::Passed::LOST != 0) {
            return 1;
        }
        let rays: Vec<Passed> = rays.iter().map(told).collect();
        let all: Vec<Fragment> = fragments.iter().map(wide).collect();
        give(Fragments { first, rays: &rays, all: &all });
        0
    };
    all.into_par_iter().map(give).sum()
}

fn told(ray: &layout::Passed) -> Passed {
    let layout::Passed { columns, frusta, void_frusta, fragments } = *ray;
    Passed { counts: [columns, frusta, void_frusta], fragments }
}

fn entry(fragment: &layout::Fragment) -> f64 {
    f64::from(fragment.entry_hi) + f64::from(fragment.entry_lo)
}

fn wide(fragment: &layout::Fragment) -> Fragment {
    let layout::Fragment { exit_hi, exit_lo, red, green, blue, absorbed, error, variance, .. } = *fragment;
    let exit = if exit_hi == ENDLESS { f64::INFINITY } else { f64::from(exit_hi) + f64::from(exit_lo) };
    Fragment {
        t: [entry(fragment), exit],
        color: [red, green, blue],
        absorbed,
        error,
        variance,
        surfaces: Signature::default(),
    }
}
