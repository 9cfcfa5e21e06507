//! A picture's tiles: with the field on the device as a whole, or in passes, each with what its rays meet of it.

use crate::band::Course;
use crate::gpu::{Gpu, because};
use crate::held::Held;
use crate::part;
use crate::scene::{self, Picture};
use crate::select::Cells;
use icoray::device::{Band, Device, Fragments, Job, Own, Reason, Rect, Spent};
use std::sync::Arc;
use std::time::Instant;

impl Device for Gpu {
    fn name(&self) -> String {
        self.described()
    }

    fn trace(&self, job: &Job, give: &(dyn Fn(Band) + Sync)) -> Result<Spent, Reason> {
        let start = Instant::now();
        let (picture, cells, spent) = self.prepare(job)?;
        let tiles: Vec<(usize, Rect)> = job.tiles().enumerate().collect();
        let mut drawing = Drawing { gpu: self, picture, give, since: start, spent, lost: 0 };
        match self.hold(&drawing.picture, &cells)? {
            Ok(held) => drawing.draw(held, &tiles)?,
            // A part has no passes: its rays are traced here to see how long they take.
            Err(reason) if job.is_part() => return Err(reason),
            Err(_) => drawing.draw_in_passes(tiles)?,
        }
        self.store.sweep();
        self.unless_lost(drawing.lost)?;
        Ok(drawing.spent)
    }

    fn fragments(&self, job: &Job, own: &Own, give: &(dyn Fn(Fragments) + Sync)) -> Result<Spent, Reason> {
        let start = Instant::now();
        let (picture, cells, mut spent) = self.prepare(job)?;
        let tiles: Vec<(usize, Rect)> = job.tiles().enumerate().collect();
        // Another pass would mean another walk of all rays.
        let (held, bytes) = self.hold(&picture, &cells)??;
        let course = part::Course::new(self, &picture, &held, own, &tiles)?;
        spent.bytes_uploaded += bytes + course.bytes();
        spent.unread_bytes = spent.field_bytes.saturating_sub(held.bytes());
        spent.passes = 1;
        spent.upload_s = start.elapsed().as_secs_f64();
        let lost = course.run(give)?;
        spent.device_s = course.seconds()?;
        self.store.sweep();
        self.unless_lost(lost)?;
        Ok(spent)
    }
}

impl Gpu {
    /// What comes before the field: tables, the cells whose columns rays read, and what that has cost.
    fn prepare<'j>(&self, job: &'j Job) -> Result<(Picture<'j>, Arc<Cells>, Spent), Reason> {
        let (mesh, mesh_bytes) = self.mesh(job.grid())?;
        let picture = Picture { job, mesh, tables: scene::tables(self, job)? };
        let (cells, cells_bytes) = self.cells(&picture)?;
        let (columns, layers, _) = job.order();
        let spent = Spent {
            bytes_uploaded: mesh_bytes + cells_bytes + picture.bytes(),
            field_bytes: (columns * layers * size_of::<f32>()) as u64,
            ..Spent::default()
        };
        Ok((picture, cells, spent))
    }

    /// A reason where tiles have lost rays.
    fn unless_lost(&self, tiles: usize) -> Result<(), Reason> {
        if tiles == 0 {
            return Ok(());
        }
        because(format!("the walk of rays failed on {}, or its driver ended loops early", self.described()))
    }
}

/// A picture that is being drawn.
struct Drawing<'d> {
    gpu: &'d Gpu,
    picture: Picture<'d>,
    give: &'d (dyn Fn(Band) + Sync),
    /// When what comes before the next rays was begun.
    since: Instant,
    spent: Spent,
    /// Tiles that have lost rays.
    lost: usize,
}

impl Drawing<'_> {
    /// Draws tiles, each with its place in the job, of a field that is there.
    fn draw(&mut self, (held, bytes): (Arc<Held>, u64), tiles: &[(usize, Rect)]) -> Result<(), Reason> {
        let course = Course::new(self.gpu, &self.picture, &held, tiles)?;
        self.spent.bytes_uploaded += bytes + course.bytes();
        self.spent.unread_bytes = self.spent.field_bytes.saturating_sub(held.bytes());
        self.spent.passes += 1;
        self.spent.upload_s += self.since.elapsed().as_secs_f64();
        self.lost += course.run(self.give)?;
        self.spent += Spent { device_s: course.seconds()?, ..Spent::default() };
        self.since = Instant::now();
        Ok(())
    }

    /// Halves the tiles until the columns that their rays meet have room: a ray has all that it reads, so that the picture is
    /// the same. Halves are neighbours, whose rays meet much the same columns.
    fn draw_in_passes(&mut self, mut tiles: Vec<(usize, Rect)>) -> Result<(), Reason> {
        tiles.sort_by_key(|(_, tile)| interleaved(tile.left, tile.top));
        let mut rest = vec![&tiles[..]];
        while let Some(tiles) = rest.pop().filter(|tiles| !tiles.is_empty()) {
            let cells = Arc::new(self.gpu.cells_of(&self.picture, tiles)?);
            match self.gpu.hold(&self.picture, &cells)? {
                Ok((held, bytes)) => self.draw((held, bytes + cells.bytes()), tiles)?,
                Err(reason) if tiles.len() == 1 => return Err(reason),
                Err(_) => {
                    let (one, other) = tiles.split_at(tiles.len() / 2);
                    rest.extend([other, one]);
                }
            }
        }
        Ok(())
    }
}

/// The bits of two numbers in turn: near in both, near in this.
fn interleaved(x: u32, y: u32) -> u64 {
    let spread = |n: u32| (0..32).fold(0, |bits, i| bits | u64::from(n >> i & 1) << (2 * i));
    spread(x) | spread(y) << 1
}
