//! Fragments of rays through a rank's part of the grid. The device writes them unordered; the host sorts them.

use crate::bands::{Band, Bands, Tile};
use crate::device_field::DeviceField;
use crate::layout::{self, Passed, halves};
use crate::picture::Picture;
use crate::pipelines::bind_group;
use crate::pool::PooledBuffer;
use crate::readback::Readback;
use icoray::device::{
    BoundarySignature, ENDLESS, FallbackReason, Fragment, Fragments, OwnedColumns, PaintedPlace, TracedFragment,
};
use rayon::prelude::*;
use wgpu::BufferUsages;

const COUNT_BYTES: usize = size_of::<u32>();

/// Tiles of a picture, ready to be traced.
pub(crate) struct FragmentTrace<'t> {
    picture: &'t Picture<'t>,
    pub bands: Bands<'t>,
    part: layout::Part,
    /// The first buffers of group 2.
    scene: Vec<PooledBuffer>,
    /// A bit per triangle: whether it belongs to the rank.
    owned: PooledBuffer,
}

/// Memory for the fragments of a band.
struct FragmentBuffer {
    capacity: usize,
    buffer: PooledBuffer,
    /// Group 2.
    group: wgpu::BindGroup,
    /// Bound in `group` too: not to return to the pool before the band is submitted.
    _part: PooledBuffer,
}

impl<'t> FragmentTrace<'t> {
    pub fn new(
        picture: &'t Picture<'t>,
        field: &DeviceField,
        own: &OwnedColumns,
        tiles: &'t [Tile],
    ) -> Result<Self, FallbackReason> {
        let mut bands = Bands::new(picture, field, tiles, true)?;
        let owned = own.triangles.words();
        bands.bytes += size_of_val(owned) as u64;
        let owned = picture.ctx.pooled_data("own triangles", owned, BufferUsages::STORAGE)?;
        let part = part(own, picture.job.extent()[0]);
        Ok(FragmentTrace { picture, bands, part, scene: picture.scene_buffers()?, owned })
    }

    /// Traces the tiles and passes those without lost rays to `sink`. Returns the number of the other tiles, and the
    /// seconds in rays by the device's clock.
    pub fn run(self, sink: &(dyn Fn(Fragments) + Sync)) -> Result<(usize, Option<f64>), FallbackReason> {
        let (ctx, mut lost) = (self.picture.ctx, 0);
        let mut buffer = self.fragment_buffer(self.bands.max_rays)?;
        for band in &self.bands.list {
            let mut rays = self.trace(band, &buffer)?;
            let needed = count(&rays);
            if needed > buffer.capacity {
                buffer = self.fragment_buffer(needed)?;
                rays = self.trace(band, &buffer)?;
            }
            let commands = ctx.device.create_command_encoder(&Default::default());
            let bytes = COUNT_BYTES + count(&rays) * size_of::<layout::Fragment>();
            lost += Readback::submit(ctx, commands, &buffer.buffer, bytes)?.wait(ctx, |bytes| {
                let fragments = bytemuck::cast_slice(&bytes[COUNT_BYTES..]).to_vec();
                send_tiles(&self.bands.tiles[band.tiles.clone()], &rays, fragments, sink)
            })?;
        }
        Ok((lost, self.bands.seconds()?))
    }

    fn fragment_buffer(&self, capacity: usize) -> Result<FragmentBuffer, FallbackReason> {
        let ctx = self.picture.ctx;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let bytes = COUNT_BYTES + capacity * size_of::<layout::Fragment>();
        let buffer = ctx.pooled("fragments", bytes, usage)?;
        let part = layout::Part { max_fragments: capacity as u32, ..self.part };
        let part = ctx.pooled_data("part", &[part], BufferUsages::STORAGE)?;
        let buffers = self.scene.iter().chain([&part, &self.owned, &buffer]).map(|buffer| &**buffer);
        let group = bind_group(ctx, self.bands.scene_layout, buffers)?;
        Ok(FragmentBuffer { capacity, buffer, group, _part: part })
    }

    /// Traces a band and reads back its rays; the fragments stay on the device.
    fn trace(&self, band: &Band, fragments: &FragmentBuffer) -> Result<Vec<Passed>, FallbackReason> {
        let readback = self.bands.submit(band, &fragments.group, |commands| {
            commands.clear_buffer(&fragments.buffer, 0, Some(COUNT_BYTES as u64));
        })?;
        readback.wait(self.picture.ctx, |bytes| bytemuck::cast_slice(bytes).to_vec())
    }
}

/// Number of fragments of some rays.
fn count(rays: &[Passed]) -> usize {
    rays.iter().map(|ray| (ray.fragments & !layout::parts::LOST) as usize).sum()
}

/// The part's numbers in the shader, where `inner` is the least radius of the innermost layer.
fn part(own: &OwnedColumns, inner: f64) -> layout::Part {
    // Rounded up: a ray that just misses the ball in f64 has no fragments anyway.
    let reach = (own.reach * (1.0 + 1e-5) + 1e-6).min(1e30) as f32;
    let [lowest_hi, lowest_lo] = halves(inner * own.lowest_facet);
    let middle = own.middle.map(|x| x as f32);
    let reach = if own.reach < 0.0 { -1.0 } else { reach };
    layout::Part { middle, reach, lowest_hi, lowest_lo, max_fragments: 0, padding: [0; 1] }
}

/// Sorts the fragments of a band and passes the tiles without lost rays to `sink`. Returns the number of the other
/// tiles.
fn send_tiles(
    tiles: &[Tile],
    mut rays: &[Passed],
    mut fragments: Vec<layout::Fragment>,
    sink: &(dyn Fn(Fragments) + Sync),
) -> usize {
    fragments.par_sort_unstable_by_key(|fragment| (fragment.ray, fragment.number));
    let mut fragments = fragments.as_slice();
    let of_tile = |(index, tile): &Tile| {
        let (of_tile, others) = rays.split_at(tile.pixels());
        let (of_rays, behind) = fragments.split_at(count(of_tile));
        (rays, fragments) = (others, behind);
        (*index, of_tile, of_rays)
    };
    let all: Vec<_> = tiles.iter().map(of_tile).collect();
    let send = |(first, rays, fragments): (usize, &[Passed], &[layout::Fragment])| {
        if rays.iter().any(|ray| ray.fragments & layout::parts::LOST != 0) {
            return 1;
        }
        let all: Vec<TracedFragment> = fragments.iter().map(traced).collect();
        sink(Fragments { first, rays: bytemuck::cast_slice(rays), all: &all });
        0
    };
    all.into_par_iter().map(send).sum()
}

fn traced(fragment: &layout::Fragment) -> TracedFragment {
    let layout::Fragment { entry_hi, entry_lo, exit_hi, exit_lo, .. } = *fragment;
    let layout::Fragment { red, green, blue, alpha, error, variance, order, nearness, painted, triangle, .. } =
        *fragment;
    let [entry, exit] = [[entry_hi, entry_lo], [exit_hi, exit_lo]].map(|[hi, lo]| f64::from(hi) + f64::from(lo));
    let surface = (painted != layout::fragment::PAINTED_CORE).then_some(painted as usize);
    TracedFragment {
        fragment: Fragment {
            t: [entry, if exit_hi == ENDLESS { f64::INFINITY } else { exit }],
            color: [red, green, blue],
            alpha,
            error,
            variance,
            surfaces: BoundarySignature::of_values([f32::from_bits(order), nearness]),
        },
        painted: (painted != layout::fragment::NOT_PAINTED).then_some(PaintedPlace { t: exit, triangle, surface }),
    }
}
