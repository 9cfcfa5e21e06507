//! A GPU as a device of icoray's renderer.

use crate::adapters::find;
use crate::bands::Tile;
use crate::context::Context;
use crate::culling::CellSet;
use crate::field_store::FieldStore;
use crate::mesh::MeshCache;
use crate::peaks::Peaks;
use crate::picture::Picture;
use crate::pieces::RayEntryCache;
use crate::pipelines::Pipelines;
use crate::trace_fragments::FragmentTrace;
use crate::trace_pixels::Passes;
use icoray::Adapter;
use icoray::device::{Band, Device, DeviceCost, DeviceRequest, Devices, FallbackReason, Fragments, Job, OwnedColumns};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// The GPUs of this machine, for a renderer.
#[derive(Debug, Clone, Copy, Default)]
pub struct Gpus;

impl Devices for Gpus {
    fn open(&self, wanted: &DeviceRequest) -> Result<Arc<dyn Device>, FallbackReason> {
        Ok(Arc::new(Gpu::open(wanted, MemoryLimits::default())?))
    }
}

/// Limits below those of a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MemoryLimits {
    /// Largest size in bytes of a buffer that a shader reads.
    pub binding: Option<u64>,
    /// Largest size in bytes of a field, gradients included. Pictures of larger fields are traced in passes, each with
    /// the columns that its rays read.
    pub field: Option<u64>,
}

/// An open GPU.
#[derive(Debug)]
pub struct Gpu {
    pipelines: Pipelines,
    entries: RayEntryCache,
    meshes: MeshCache,
    fields: FieldStore,
    /// Dropped last: it frees the memory of the others.
    ctx: Context,
}

impl Gpu {
    /// Opens an adapter, by default one of the fastest kind, which may be a CPU driver such as lavapipe.
    ///
    /// # Errors
    /// A [`FallbackReason`] if there is no such adapter, or it lacks features that the shaders need.
    pub fn new(adapter: Option<Adapter>) -> Result<Self, FallbackReason> {
        Self::with_limits(adapter, MemoryLimits::default())
    }

    /// [`Self::new`] with less memory than the device has.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_limits(adapter: Option<Adapter>, limits: MemoryLimits) -> Result<Self, FallbackReason> {
        Self::open(&DeviceRequest { adapter, or_processor: true, node_rank: 0 }, limits)
    }

    fn open(wanted: &DeviceRequest, limits: MemoryLimits) -> Result<Self, FallbackReason> {
        let ctx = Context::open(&find(wanted, Path::new("/dev"))?, limits.binding)?;
        Ok(Gpu {
            pipelines: Pipelines::new(&ctx),
            entries: RayEntryCache::default(),
            meshes: MeshCache::default(),
            fields: FieldStore::new(limits.field.unwrap_or(u64::MAX)),
            ctx,
        })
    }

    /// Number of buffers created so far.
    pub fn buffers_created(&self) -> u64 {
        self.ctx.buffers_created()
    }

    /// Measures the device. Takes about a second, and several hundred megabytes on the host and on the device.
    ///
    /// # Errors
    /// A [`FallbackReason`] if the device fails.
    pub fn peaks(&self) -> Result<Peaks, FallbackReason> {
        Peaks::measure(&self.ctx)
    }

    /// Uploads all but the field: returns the picture, the cells whose columns its rays read, and the cost.
    fn prepare<'j>(&'j self, job: &'j Job) -> Result<(Picture<'j>, Arc<CellSet>, DeviceCost), FallbackReason> {
        let (mesh, mesh_bytes) = self.meshes.get(&self.ctx, job.grid())?;
        let picture = Picture::new(&self.ctx, &self.pipelines, job, mesh, self.entries.get(job))?;
        let fits_a_page = self.fields.fits_a_page(&self.ctx, job);
        let (cells, cells_bytes) = picture.mesh.culling.of_picture(&self.ctx, job, fits_a_page)?;
        let (columns, layers, _) = job.order();
        let spent = DeviceCost {
            bytes_uploaded: mesh_bytes + cells_bytes + picture.bytes(),
            field_bytes: (columns * layers * size_of::<f32>()) as u64,
            ..DeviceCost::default()
        };
        Ok((picture, cells, spent))
    }

    /// Ends a frame; fails if tiles have lost rays.
    fn finish(&self, lost_tiles: usize) -> Result<(), FallbackReason> {
        self.ctx.pool.end_frame();
        if lost_tiles == 0 {
            return Ok(());
        }
        let name = self.ctx.name();
        Err(FallbackReason::new(format!("the walk of rays failed on {name}, or its driver ended loops early")))
    }
}

impl Device for Gpu {
    fn name(&self) -> String {
        self.ctx.name()
    }

    fn trace(&self, job: &Job, sink: &(dyn Fn(Band) + Sync)) -> Result<DeviceCost, FallbackReason> {
        let since = Instant::now();
        let (picture, cells, spent) = self.prepare(job)?;
        let tiles: Vec<Tile> = job.tiles().enumerate().collect();
        let mut passes = Passes { fields: &self.fields, picture, sink, since, spent, lost: 0 };
        match self.fields.get(&passes.picture, &cells)? {
            Ok(field) => passes.trace(field, &tiles)?,
            // Fragments are traced in one pass only, so a part that would need several belongs to the CPU.
            Err(reason) if job.is_part() => return Err(reason),
            Err(_) => passes.trace_bisected(tiles)?,
        }
        self.finish(passes.lost)?;
        Ok(passes.spent)
    }

    fn fragments(
        &self,
        job: &Job,
        own: &OwnedColumns,
        sink: &(dyn Fn(Fragments) + Sync),
    ) -> Result<DeviceCost, FallbackReason> {
        let start = Instant::now();
        let (picture, cells, mut spent) = self.prepare(job)?;
        let tiles: Vec<Tile> = job.tiles().enumerate().collect();
        // In one pass only: a second one would walk all rays again.
        let (field, bytes) = self.fields.get(&picture, &cells)??;
        let trace = FragmentTrace::new(&picture, &field, own, &tiles)?;
        spent.bytes_uploaded += bytes + trace.bands.bytes;
        spent.unread_bytes = spent.field_bytes.saturating_sub(field.bytes());
        spent.passes = 1;
        spent.upload_s = start.elapsed().as_secs_f64();
        let (lost, device_s) = trace.run(sink)?;
        spent.device_s = device_s;
        self.finish(lost)?;
        Ok(spent)
    }
}

#[cfg(test)]
mod tests {
    use crate::Gpu;
    use icoray::{Field, Grid, IcosahedralMesh, Layers, Location, Renderer, Scene};
    use icoray_test_support::{Need, skip_because};
    use std::sync::Arc;

    /// The CPU draws the pictures of a lost device, at once and later.
    #[test]
    fn a_lost_device_is_a_reason() {
        let gpu = match Gpu::new(None) {
            Ok(gpu) => Arc::new(gpu),
            Err(reason) => return skip_because(Need::Gpu, reason),
        };
        let tables = IcosahedralMesh::new(2).unwrap();
        let grid = Grid::new(tables.tables()).unwrap();
        let layers = Layers::new(vec![1.0, 1.1, 1.2], 1.0).unwrap();
        let values: Vec<f32> = (0..3 * grid.cells()).map(|i| (i % 7) as f32 / 7.0).collect();
        let field = Field::level_fastest(&values, 3, Location::Center).unwrap();
        let scene = Scene::parse(
            "field = \"f\"\n[image]\nwidth = 24\nheight = 24\n[camera]\nlon = 30\nlat = 25\ndistance = 3\nfov = 50\n\
             [transfer]\nmap = \"viridis\"\nrange = [0, 1]\nopacity = [[0, 0.2], [1, 0.8]]\n",
        )
        .unwrap();
        let cpu = Renderer::new(1).unwrap().render(&scene, &grid, &layers, &field).unwrap();
        let renderer = Renderer::new(1).unwrap().with_device(Arc::clone(&gpu) as _);
        let draw = || renderer.render(&scene, &grid, &layers, &field).unwrap();
        assert!(draw().report.device.name.is_some());
        gpu.ctx.device.destroy();
        for _ in 0..2 {
            let frame = draw();
            assert!(
                frame.report.device.name.is_none() && frame.report.device.left_to_cpu.is_some(),
                "{:?}",
                frame.report
            );
            assert!(frame.pixels == cpu.pixels && frame.error == cpu.error);
        }
    }
}
