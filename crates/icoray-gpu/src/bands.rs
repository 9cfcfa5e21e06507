//! Bands of tiles. A band is one dispatch, short enough that no watchdog mistakes it for a hung device.

use crate::context::Context;
use crate::device_field::DeviceField;
use crate::layout::{Fragment, Params, Passed, Piece, Pixel};
use crate::picture::Picture;
use crate::pieces::pieces;
use crate::pipelines::dispatch;
use crate::pool::PooledBuffer;
use crate::readback::Readback;
use crate::scenery::contents;
use crate::timestamps::Timestamps;
use icoray::device::{FallbackReason, Rect};
use std::ops::Range;
use wgpu::BufferUsages;

/// Approximate number of pixels of a band: enough to fill a device, few enough for a slow one.
const BAND_PIXELS: usize = 1 << 18;

/// A tile with its index in the job.
pub(crate) type Tile = (usize, Rect);

/// A band: ranges of the tiles and of the pieces of all tiles.
pub(crate) struct Band {
    pub tiles: Range<usize>,
    pieces: Range<u32>,
}

/// Tiles of a picture, ready to be traced band by band.
pub(crate) struct Bands<'b> {
    pub ctx: &'b Context,
    pub tiles: &'b [Tile],
    pub list: Vec<Band>,
    /// Largest number of rays of a band.
    pub max_rays: usize,
    /// Bytes that were uploaded.
    pub bytes: u64,
    pipeline: wgpu::ComputePipeline,
    /// Groups 0, 1 and 3.
    groups: [wgpu::BindGroup; 3],
    params: Params,
    uniform: PooledBuffer,
    /// Bound in `groups`: not to return to the pool before all bands are submitted.
    _pieces: PooledBuffer,
    /// A result per ray of a band.
    output: PooledBuffer,
    ray_bytes: usize,
    timestamps: Timestamps,
    /// Layout of group 2.
    pub scene_layout: &'b wgpu::BindGroupLayout,
}

impl<'b> Bands<'b> {
    /// Prepares tiles of a picture of `field`; `in_parts` to trace fragments through a part of the grid.
    pub fn new(
        picture: &Picture<'b>,
        field: &DeviceField,
        tiles: &'b [Tile],
        in_parts: bool,
    ) -> Result<Self, FallbackReason> {
        let (ctx, pipelines) = (picture.ctx, picture.pipelines);
        let contents = contents(picture.job, in_parts);
        // A band whose fragments exceed their buffer is traced twice.
        let (name, layouts, label, ray_bytes, runs) = match in_parts {
            true => ("parts", &pipelines.parts, "rays through a part", size_of::<Passed>(), 2),
            false => ("picture", &pipelines.picture, "pixels", size_of::<Pixel>(), 1),
        };
        let scene_layout = &layouts[usize::from(contents.scenery)];
        let shader = (name, contents, scene_layout);
        let constants = [picture.constants(in_parts), field.constants()].concat();
        let pipeline = pipelines.get(ctx, shader, field.layout.pages, constants)?;
        let params = field.params(picture);
        let (list, pieces) = split(picture, tiles);
        let uniform = ctx.pooled_data("params", &[params], BufferUsages::UNIFORM)?;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let max_rays = list.iter().map(|band| rays(&tiles[band.tiles.clone()])).max().unwrap_or(0);
        let output = ctx.pooled(label, max_rays * ray_bytes, usage)?;
        let bytes = size_of_val(pieces.as_slice()) as u64;
        let pieces = ctx.pooled_data("pieces", &pieces, BufferUsages::STORAGE)?;
        let group = picture.group(&field.cells, [&uniform, &pieces, &output])?;
        let [values, gradients] = field.groups(ctx)?;
        let timestamps = Timestamps::new(ctx, runs * list.len())?;
        Ok(Bands {
            ctx,
            tiles,
            list,
            max_rays,
            bytes,
            pipeline,
            groups: [group, values, gradients],
            params,
            uniform,
            _pieces: pieces,
            output,
            ray_bytes,
            timestamps,
            scene_layout,
        })
    }

    /// Submits a band with bind group 2 and the readback of its results. `before` encodes commands that precede it.
    pub fn submit(
        &self,
        band: &Band,
        group: &wgpu::BindGroup,
        before: impl FnOnce(&mut wgpu::CommandEncoder),
    ) -> Result<Readback, FallbackReason> {
        let (ctx, pieces) = (self.ctx, &band.pieces);
        let params = Params { first_piece: pieces.start, ..self.params };
        let [tables, values, gradients] = &self.groups;
        let commands = ctx.scoped(|| {
            ctx.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&params));
            let mut commands = ctx.device.create_command_encoder(&Default::default());
            before(&mut commands);
            let groups = [tables, values, group, gradients];
            let workgroups = [pieces.end - pieces.start, 1];
            dispatch(&mut commands, &self.timestamps.pass(), &self.pipeline, groups, workgroups);
            self.timestamps.resolve(&mut commands);
            commands
        })?;
        let bytes = rays(&self.tiles[band.tiles.clone()]) * self.ray_bytes;
        Readback::submit(ctx, commands, &self.output, bytes)
    }

    /// Seconds in rays by the device's clock, if it has one.
    pub fn seconds(&self) -> Result<Option<f64>, FallbackReason> {
        self.timestamps.seconds(self.ctx)
    }
}

fn rays(tiles: &[Tile]) -> usize {
    tiles.iter().map(|(_, tile)| tile.pixels()).sum()
}

/// Groups tiles into bands, and cuts them into pieces.
fn split(picture: &Picture, tiles: &[Tile]) -> (Vec<Band>, Vec<Piece>) {
    let max_buffer = picture.ctx.max_buffer_size(BufferUsages::STORAGE) as usize;
    // Room for a fragment of each ray, with their count.
    let max = (max_buffer / size_of::<Fragment>() - 1).min(BAND_PIXELS);
    let rects: Vec<Rect> = tiles.iter().map(|(_, tile)| *tile).collect();
    let (mut bands, mut all) = (Vec::<Band>::new(), Vec::new());
    let mut pixels = 0;
    for (i, mut pieces) in pieces(picture.job, &picture.entries, &rects).into_iter().enumerate() {
        if bands.is_empty() || pixels + rects[i].pixels() > max {
            let before = all.len() as u32;
            bands.push(Band { tiles: i..i, pieces: before..before });
            pixels = 0;
        }
        pieces.iter_mut().for_each(|piece| piece.first += pixels as u32);
        pixels += rects[i].pixels();
        all.append(&mut pieces);
        if let Some(Band { tiles, pieces }) = bands.last_mut() {
            (tiles.end, pieces.end) = (i + 1, all.len() as u32);
        }
    }
    (bands, all)
}
