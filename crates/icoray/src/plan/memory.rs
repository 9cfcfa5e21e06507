//! The memory that a frame takes, computed before it is allocated.

use super::blocks::MAX_CLEAR;
use super::{Plan, Savings};
use icoray_grid::{Grid, Result, memory};
use icoray_kernel::empty_space_skipping::{clear_knots, clear_ranges};
use icoray_kernel::transfer::{KernelKnot, Spans};
use icoray_scene::{Heights, Scene, Volume};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::fmt;

/// Bytes of a pixel while tiles are assembled, with its colour and error in the frame.
const PIXEL: u64 = 80;

/// Bytes that a frame takes beside the model's arrays.
///
/// Gradients are an upper bound, as they are computed in visible blocks only. For visible blocks each column has a word
/// per range of clear values; a frequent single clear value may take another word.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FrameMemory {
    /// Directions and half-edges: taken by [`Grid::new`] and kept as long as the grid.
    pub grid: u64,
    /// Averages of a field at corners.
    pub averages: u64,
    /// Derived fields, and the fields of first frames of which they are made.
    pub derived: u64,
    /// Bits of the visible blocks.
    pub occupancy: u64,
    /// Gradients at the vertices that rays can pass.
    pub gradients: u64,
    /// The picture.
    pub picture: u64,
}

impl FrameMemory {
    fn parts(&self) -> [(&'static str, u64); 6] {
        [
            ("tables of the grid", self.grid),
            ("averages of corners", self.averages),
            ("derived fields", self.derived),
            ("visible blocks", self.occupancy),
            ("gradients", self.gradients),
            ("picture", self.picture),
        ]
    }

    /// The sum of all.
    pub fn total(&self) -> u64 {
        self.parts().iter().map(|(_, bytes)| bytes).sum()
    }

    /// Checks that they fit into `limit` or, without one, in each of a number of processes into the system's free memory.
    pub(crate) fn require(&self, limit: Option<u64>, processes: usize) -> Result<()> {
        memory::require_each(&format!("a frame ({self})"), self.total(), limit, processes)
    }
}

/// The bytes in readable units.
impl fmt::Display for FrameMemory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts = self.parts().into_iter().filter(|(_, bytes)| *bytes > 0);
        let texts: Vec<String> = parts.map(|(name, bytes)| format!("{name} {}", memory::readable(bytes))).collect();
        f.write_str(&texts.join(", "))
    }
}

impl Plan {
    /// Bytes that a frame of the scene takes on the CPU, over a rank's part of the grid if `is_part`; with
    /// `counts_cells`, gradients count only for cells that rays can pass.
    pub(crate) fn memory_with(
        &self,
        scene: &Scene,
        grid: &Grid,
        is_part: bool,
        savings: Savings,
        counts_cells: bool,
    ) -> FrameMemory {
        let is_own = !is_part && scene.scenery.heights != Heights::Native;
        let is_packed = is_own && savings.packing && self.allows_single_gradients(scene);
        let is_partial = counts_cells && is_own && savings.gradients;
        FrameMemory {
            grid: grid.derived_bytes() as u64,
            averages: self.average_bytes,
            derived: self.derived_bytes,
            occupancy: if savings.empty_space { self.occupancy_bytes(scene, grid) } else { 0 },
            gradients: scene.lighting.map_or(0, |_| self.gradient_bytes(scene, grid, is_packed, is_partial)),
            picture: PIXEL * u64::from(scene.width) * u64::from(scene.height),
        }
    }

    fn occupancy_bytes(&self, scene: &Scene, grid: &Grid) -> u64 {
        let clear = |volume: &Volume| {
            let transfer = volume.opacity.as_ref().map_or(&volume.transfer, |opacity| &opacity.transfer);
            let (spans, all) = (Spans::<f64>::new(&KernelKnot::of(transfer, self.thickness())), [0.0, 1.0]);
            let has_knots = !clear_knots(&spans, all, 1).is_empty();
            clear_ranges(&spans, all, MAX_CLEAR).len().max(has_knots.into())
        };
        // Values below and above that of an isosurface are clear.
        let clear = scene.volumes.iter().map(clear).chain(scene.scenery.isosurfaces.iter().map(|_| 2));
        let clear: usize = clear.sum();
        // Blocks of each field's columns and of each triangle, and the macrocells of each triangle.
        let words = clear * grid.cells() + if clear > 0 { 2 * grid.triangles() } else { 0 };
        (words * size_of::<u32>()) as u64
    }

    fn gradient_bytes(&self, scene: &Scene, grid: &Grid, is_packed: bool, is_partial: bool) -> u64 {
        let cells = match is_partial {
            true => {
                let seen = self.visible_cells(scene, grid);
                let is_seen = |cell: &u32| seen.contains(grid.direction(*cell));
                (0..grid.cells() as u32).into_par_iter().filter(is_seen).count()
            }
            false => grid.cells(),
        };
        let each = if is_packed { size_of::<u64>() } else { size_of::<[f32; 3]>() };
        (lit_fields(scene).len() * (cells * self.radius.len() * each + grid.cells())) as u64
    }
}

/// The fields whose gradients a lit scene needs.
pub(crate) fn lit_fields(scene: &Scene) -> BTreeSet<&String> {
    let of_volumes = scene.volumes.iter().map(|volume| volume.opacity.as_ref().map_or(&volume.field, |by| &by.field));
    of_volumes.chain(scene.scenery.isosurfaces.iter().map(|surface| &surface.field)).collect()
}
