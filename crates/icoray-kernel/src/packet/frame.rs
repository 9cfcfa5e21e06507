//! The part of a frame that all packets share.

use super::packet_scene::PacketScene;
use super::read::Source;
use crate::budget::Budget;
use crate::column::{Shell, Values};
use crate::general::RaySettings;
use crate::ground::Core;
use crate::shade::Shading;
use crate::transfer::Spans;
use crate::volume_ray::VolumeRules;
use icoray_grid::Grid;
use icoray_grid::gradient::Gradients;
use icoray_grid::occupancy::OccupancyMask;
use icoray_scene::Method;

/// The first volume of a scene and its surroundings, as all packets of a frame read them.
///
/// Rays interpolate `N` values: the field's value (`N = 1`), or value and gradient (`N = 4`) where there is lighting.
pub(crate) struct PacketFrame<'f> {
    /// The scene and the settings of its rays.
    pub rays: &'f RaySettings<'f, 'f>,
    /// The scene as packets read it.
    pub packets: &'f PacketScene<'f>,
    /// Tables and directions of the grid.
    pub grid: &'f Grid<'f>,
    /// Radii of the layers, in planet radii.
    pub shell: &'f Shell,
    /// The transfer function.
    pub spans: &'f Spans<f32>,
    /// The field, normalised to the range of `spans`.
    pub(super) source: &'f Source<'f>,
    /// [`Spans::needs_sizes`] of the field.
    pub needs_sizes: bool,
    /// Visible blocks of gaps.
    pub visible: &'f OccupancyMask,
    /// Radius of the visible space, in planet radii.
    pub outer: f64,
    /// Gradients at the vertices, level-fastest; not read without lighting.
    pub gradients: &'f Gradients,
    /// Division of the tolerance along a ray.
    pub budget: Budget,
    /// Lighting; `None` shows the transfer function's own colours.
    pub shading: Option<Shading>,
    /// When set, pieces are not cut where the gradient turns.
    pub is_coarse: bool,
    /// Whether frusta are integrated; false where the walk and the interpolation alone are measured.
    pub integrates: bool,
    /// The opaque core; `None` lets rays through the hollow core.
    pub core: Option<Core<'f>>,
}

impl<'f> PacketFrame<'f> {
    /// The frame of a tracer.
    pub fn new(rays: &'f RaySettings<'f, 'f>, packets: &'f PacketScene<'f>, integrates: bool) -> Self {
        let RaySettings { scene, shading, budget, is_coarse, .. } = *rays;
        let field = &scene.sources[scene.media.first().map_or(0, |medium| medium.extinction.source)];
        PacketFrame {
            rays,
            packets,
            grid: scene.grid,
            shell: &packets.shell,
            spans: &packets.spans,
            source: &packets.source,
            needs_sizes: packets.spans.needs_sizes(field.value_range),
            visible: packets.visible(scene),
            outer: scene.outer,
            gradients: field.gradients.values(),
            budget,
            shading: shading.filter(|_| !scene.media.is_empty()),
            is_coarse,
            integrates,
            core: scene.core,
        }
    }

    /// Error of the colour that is allowed per absorbed light.
    #[inline]
    pub(crate) fn color_tolerance(&self) -> f64 {
        self.budget.color_tolerance_in::<f32>(self.shading.as_ref())
    }

    /// Inputs of the integral.
    #[inline]
    pub(crate) fn rules(&self) -> VolumeRules<'f, f32> {
        let PacketFrame { spans, is_coarse, budget, shading, .. } = *self;
        VolumeRules { spans, method: Method::Exact, is_coarse, budget, shading }
    }

    /// Value, and gradient where `N` is 4, at a vertex whose value is known.
    #[inline(always)]
    pub(crate) fn vertex<const N: usize>(&self, cell: u32, value: f32, layer: usize) -> Values<f32, N> {
        let mut values = [0.0; N];
        values[0] = value;
        if N == 4 {
            let gradient = self.gradients.at(cell as usize * self.shell.layers() + layer);
            values[1..].copy_from_slice(&gradient);
        }
        values
    }
}
