//! The tables for the packets of a tile.

use super::frame::PacketFrame;
use super::lanes::Mesh;
use super::light::Slopes;
use super::medium::SpanTables;
use super::scene::SceneTables;
use super::several::VolumeTables;
use crate::deviation::Deviations;
use crate::leap::{HollowCore, Leaps};
use crate::owned_region::OwnedRegion;
use icoray_simd::Table;

/// The tables that all packets of a tile read.
pub(super) struct Tables<'t> {
    pub mesh: Mesh<'t>,
    pub spans: SpanTables<'t>,
    pub slopes: Slopes<'t>,
    /// The macrocells; `None` where rays do not leap.
    pub leaps: Option<Leaps<'t>>,
    /// The hollow core; `None` where rays do not leap over it.
    pub hollow: Option<HollowCore<'t>>,
    /// Visible parts beside the volume; `None` if there is only the core.
    pub scene: Option<SceneTables<'t>>,
    /// Several volumes, which replace the first one.
    pub volumes: Option<VolumeTables<'t>>,
    /// The deviations from a finer grid: the number of gaps over a triangle, and [`Deviations::words`].
    pub deviations: Option<(u32, Table<'t, u32>)>,
    /// The region of the requested fragments, and the words of its marks.
    pub own: Option<(&'t OwnedRegion<'t>, Table<'t, u32>)>,
}

impl<'t> Tables<'t> {
    /// The tables of a frame; `None` where they are too long for gathers. Rays do not leap.
    pub fn new(frame: &'t PacketFrame<'_>, region: Option<&'t OwnedRegion<'t>>) -> Option<Self> {
        let slopes = match frame.shading {
            Some(_) => Slopes::new(frame.gradients, frame.packets.shell.layers())?,
            None => Slopes::None,
        };
        let own = match region {
            Some(region) => Some((region, Table::new(region.triangles().words())?)),
            None => None,
        };
        let deviations = match frame.packets.deviations {
            Some(Deviations { gaps, words, .. }) => Some((*gaps as u32, Table::new(words)?)),
            None => None,
        };
        Some(Tables {
            slopes,
            mesh: Mesh::new(frame.scene.grid)?,
            spans: SpanTables::new(&frame.packets.spans)?,
            leaps: None,
            hollow: None,
            scene: None,
            volumes: None,
            deviations,
            own,
        })
    }
}
