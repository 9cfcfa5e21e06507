//! A picture: dispatched in bands of rows, so that no watchdog takes a long one for a hung device, and read back.

use crate::Outcome;
use crate::gpu::{Gpu, Reason, because};
use crate::layout::Pixel;
use crate::mesh::Mesh;
use crate::scene::{self, GROUP, Variant};
use icoray::device::{Job, Traced};
use icoray::{Field, Layers, Renderer, Result, Scene};
use wgpu::BufferUsages;

/// About how many pixels a dispatch has: enough to fill a device, few enough for a slow one.
const BAND: u32 = 1 << 18;

impl Gpu {
    /// Draws `scene`; what the CPU has to prepare is done on the threads of `renderer`.
    ///
    /// # Errors
    /// As [`Plan::new`](icoray::Plan::new). What the GPU cannot do is no error but [`Outcome::Left`].
    pub fn render(
        &self,
        renderer: &Renderer,
        scene: &Scene,
        mesh: &Mesh,
        layers: &Layers,
        field: &Field,
    ) -> Result<Outcome> {
        if let Err(reason) = scene::suits(scene) {
            return Ok(Outcome::Left(reason));
        }
        let job = Job::new(renderer, scene, mesh.grid, layers, field)?;
        Ok(match renderer.run(|| self.trace(scene, mesh, &job)) {
            Ok((traced, prepare_s)) => Outcome::Drawn(Box::new(job.frame(&traced, prepare_s))),
            Err(reason) => Outcome::Left(reason),
        })
    }

    /// What each ray met, and the seconds from the job's start until rays began.
    fn trace(
        &self,
        scene: &Scene,
        mesh: &Mesh,
        job: &Job,
    ) -> std::result::Result<(Vec<Option<Traced>>, f64), Reason> {
        let pipeline = Variant::of(scene, mesh, job).pipeline(self)?;
        let mut params = scene::params(scene, mesh, job);
        let [spans, steps, shell] = scene::tables(self, job)?;
        let field = scene::field(self, job)?;
        let outer = job.radius()[job.radius().len() - 1];
        let hints = self.upload("hints", &scene::hints(scene, mesh.grid, outer))?;
        let prepare_s = job.seconds();

        let row_bytes = scene.width as usize * size_of::<Pixel>();
        let most = self.limits.max_storage_buffer_binding_size / row_bytes as u64;
        let most = u32::try_from(most).unwrap_or(u32::MAX);
        let rows = (BAND / scene.width).max(GROUP).min(most).min(scene.height.next_multiple_of(GROUP));
        // Workgroups of all bands begin at a row of hints.
        let rows = rows / GROUP * GROUP;
        if rows == 0 {
            return because(format!("{} pixels in a row are more than a buffer holds", scene.width));
        }
        let uniform =
            self.buffer("params", size_of_val(&params), BufferUsages::UNIFORM | BufferUsages::COPY_DST)?;
        let band =
            self.buffer("pixels", rows as usize * row_bytes, BufferUsages::STORAGE | BufferUsages::COPY_SRC)?;
        let whole = scene.height as usize * row_bytes;
        let picture = self.buffer("picture", whole, BufferUsages::MAP_READ | BufferUsages::COPY_DST)?;
        let [directions, corner_cell, corner_edge, edge_corner, seats, voids, rim] = &mesh.buffers;
        let buffers = [
            &uniform,
            directions,
            corner_cell,
            corner_edge,
            edge_corner,
            seats,
            voids,
            rim,
            &spans,
            &steps,
            &field,
            &shell,
            &hints,
            &band,
        ];
        let entries: Vec<_> = (0u32..)
            .zip(buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
            .collect();
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("picture"),
            layout: &self.bindings,
            entries: &entries,
        });
        for first in (0..scene.height).step_by(rows as usize) {
            (params.first_row, params.end_row) = (first, (first + rows).min(scene.height));
            let band_rows = params.end_row - first;
            self.queue.write_buffer(&uniform, 0, bytemuck::bytes_of(&params));
            let mut encoder = self.device.create_command_encoder(&Default::default());
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(params.groups_across, band_rows.div_ceil(GROUP), 1);
            drop(pass);
            let (to, bytes) = ((first as usize * row_bytes) as u64, (band_rows as usize * row_bytes) as u64);
            encoder.copy_buffer_to_buffer(&band, 0, &picture, to, bytes);
            self.queue.submit([encoder.finish()]);
            self.untroubled()?;
        }
        let met: Vec<Option<Traced>> =
            self.read(&picture, |bytes| bytemuck::cast_slice(&bytes[..whole]).iter().map(traced).collect())?;
        if met.iter().any(|pixel| matches!(pixel, Some(met) if met.error == Pixel::LOST)) {
            return because(format!("a ray has lost its way on {}", self.name()));
        }
        Ok((met, prepare_s))
    }

    /// Waits for the device and takes what it wrote to a buffer.
    pub(crate) fn read<R>(
        &self,
        buffer: &wgpu::Buffer,
        take: impl FnOnce(&[u8]) -> R,
    ) -> std::result::Result<R, Reason> {
        let (told, hear) = std::sync::mpsc::channel();
        buffer.map_async(wgpu::MapMode::Read, .., move |mapped| drop(told.send(mapped)));
        let waited = self.device.poll(wgpu::PollType::wait_indefinitely());
        self.untroubled()?;
        waited.map_err(|e| Reason(format!("waiting for {}: {e}", self.name())))?;
        let mapped = hear.recv().map_err(|_| Reason(format!("{} gives nothing back", self.name())))?;
        mapped.map_err(|e| Reason(format!("reading from {}: {e}", self.name())))?;
        let view = buffer.get_mapped_range(..).map_err(|e| Reason(format!("{}: {e}", self.name())))?;
        let taken = take(&view);
        drop(view);
        buffer.unmap();
        Ok(taken)
    }
}

fn traced(pixel: &Pixel) -> Option<Traced> {
    (pixel.error != Pixel::MISSED).then_some(Traced {
        color: [pixel.red, pixel.green, pixel.blue],
        absorbed: pixel.absorbed,
        error: pixel.error,
        variance: pixel.variance,
        counts: [pixel.columns, pixel.frusta, pixel.void_frusta],
    })
}
