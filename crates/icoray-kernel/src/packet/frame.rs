//! The part of a frame that all packets share.

use super::packet_scene::PacketScene;
use crate::general::{KernelScene, RaySettings};
use crate::shade::Shading;
use icoray_grid::gradient::Gradients;

/// The first volume of a scene and its surroundings, as all packets of a frame read them.
///
/// Rays interpolate `N` values: the field's value (`N = 1`), or value and gradient (`N = 4`) where there is lighting.
pub(crate) struct PacketFrame<'f> {
    /// The scene.
    pub scene: &'f KernelScene<'f>,
    /// The scene as packets read it.
    pub packets: &'f PacketScene<'f>,
    /// The settings of the rays.
    pub rays: &'f RaySettings<'f, 'f>,
    /// Lighting of the volume; `None` shows the transfer function's own colours, or no volume.
    pub shading: Option<Shading>,
    /// Gradients at the vertices, level-fastest; not read without lighting.
    pub gradients: &'f Gradients<'f>,
    /// [`Spans::needs_sizes`](crate::transfer::Spans::needs_sizes) of the field.
    pub needs_sizes: bool,
    /// Whether frusta are integrated; false where the walk and the interpolation alone are measured.
    pub integrates: bool,
}

impl<'f> PacketFrame<'f> {
    /// The frame of a tracer.
    pub fn new(rays: &'f RaySettings<'f, 'f>, packets: &'f PacketScene<'f>, integrates: bool) -> Self {
        let scene = rays.scene;
        let field = &scene.sources[scene.media.first().map_or(0, |medium| medium.extinction.source)];
        PacketFrame {
            scene,
            packets,
            rays,
            shading: rays.shading.filter(|_| !scene.media.is_empty()),
            gradients: field.gradients.values(),
            needs_sizes: packets.spans.needs_sizes(field.value_range),
            integrates,
        }
    }
}
