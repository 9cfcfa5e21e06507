//! What packets of rays read of a scene: its volume in single precision, and where rays must be followed one by one.
//!
//! In a frustum in which a ray meets no isosurface, no surface and no bound of a cut, only the volume is seen: packets
//! integrate it by their own rules ([`packet`](crate::packet)). What is rare, a few frusta of each ray, is left to the
//! rays of this kernel, in double precision.

use super::{KernelScene, MultiVolumeTracer, SurfaceHeight, TransferMap};
use crate::column::Shell;
use crate::counts::Counts;
use crate::packet;
use crate::single_volume::SingleVolumeTracer;
use crate::trace::{PrimaryRay, Target};
use crate::transfer::{KernelKnot, Spans};
use fearless_simd::Level;
use icoray_grid::gradient::Gradients;
use icoray_grid::occupancy::OccupancyMask;
use icoray_grid::sample::AnySamples;
use icoray_scene::Method;

/// A scene as packets of rays read it, the same for all rays of a frame.
pub struct PacketScene<'f> {
    level: Level,
    shell: Shell<f32>,
    spans: Spans<f32>,
    samples: AnySamples<'f>,
    volumes: Option<PacketVolumes<'f>>,
    visible: OccupancyMask,
    /// For each gap, the bits of the cuts that hold it.
    pub(crate) clips_of_gaps: Vec<u32>,
    /// Whether frusta are integrated; false where the walk and the interpolation alone are measured.
    integrates: bool,
}

/// Several volumes, or one whose opacity is that of another field, in single precision.
pub(crate) struct PacketVolumes<'f> {
    /// Transfer functions with their fields.
    pub maps: Vec<PacketMap<'f>>,
    /// The numbers of each volume's maps: that of its extinction and that of its colour.
    pub maps_of: Vec<[usize; 2]>,
}

/// A transfer function with its field.
pub(crate) struct PacketMap<'f> {
    pub samples: AnySamples<'f>,
    pub spans: Spans<f32>,
}

impl<'f> PacketVolumes<'f> {
    fn new(scene: &KernelScene<'f>) -> Option<Self> {
        let (mut maps, mut maps_of) = (Vec::new(), Vec::new());
        let mut add = |map: &TransferMap| {
            let spans = Spans::new(map.knots());
            let samples = scene.sources.get(map.source)?.samples_in(spans.range());
            maps.push(PacketMap { samples, spans });
            Some(maps.len() - 1)
        };
        for medium in &scene.media {
            let extinction = add(&medium.extinction)?;
            let is_one = medium.color.is_of(&medium.extinction);
            maps_of.push([extinction, if is_one { extinction } else { add(&medium.color)? }]);
        }
        Some(PacketVolumes { maps, maps_of })
    }
}

/// Largest number of cuts: a bit each.
const MAX_CLIPS: usize = 32;

impl<'f> PacketScene<'f> {
    /// A scene between layers of these radii, planet radii (mean ones under native heights), for packets at `level`;
    /// `None` where there are more cuts than packets know, and rays are traced one after the other.
    pub fn new(scene: &KernelScene<'f>, radius: &[f64], level: Level, integrates: bool) -> Option<Self> {
        const CLEAR: [KernelKnot; 1] = [KernelKnot { value: 0.0, color: [0.0; 3], extinction: 0.0 }];
        let (source, knots) = match scene.media.as_slice() {
            [] => (0, CLEAR.as_slice()),
            [medium, ..] => (medium.extinction.source, medium.extinction.knots()),
        };
        let volumes = if scene.has_one_field_of_volume() { None } else { Some(PacketVolumes::new(scene)?) };
        if scene.clips.len() > MAX_CLIPS {
            return None;
        }
        let spans = Spans::new(knots);
        let samples = scene.sources.get(source)?.samples_in(spans.range());
        let gaps = 0..=radius.len();
        let clips_of_gaps = gaps.map(|gap| scene.clips.around([gap.saturating_sub(1), gap])).collect();
        let (shell, visible) = (Shell::new(radius), scene.joined_blocks(radius.len()));
        Some(PacketScene { level, shell, spans, samples, volumes, visible, clips_of_gaps, integrates })
    }
}

impl KernelScene<'_> {
    /// Whether there is no more than one volume, whose opacity is that of its own field.
    fn has_one_field_of_volume(&self) -> bool {
        match self.media.as_slice() {
            [] => true,
            [medium] => medium.color.is_of(&medium.extinction),
            _ => false,
        }
    }

    /// The blocks of gaps in which a volume or an isosurface can be seen, or that a surface lies beside.
    fn joined_blocks(&self, layers: usize) -> OccupancyMask {
        let Some(first) = self.visible.first().filter(|_| self.visible.iter().all(|mask| !mask.is_full())) else {
            return OccupancyMask::default().full(layers);
        };
        let mut beside = 0;
        for surface in &self.surface_layers {
            let SurfaceHeight::Layer(layer) = surface.place else { return OccupancyMask::default().full(layers) };
            beside |= first.between([layer, layer + 1], layers);
        }
        let mut blocks: Vec<u32> = first.blocks.iter().map(|blocks| blocks | beside).collect();
        for mask in &self.visible[1..] {
            blocks.iter_mut().zip(&mask.blocks).for_each(|(all, blocks)| *all |= blocks);
        }
        OccupancyMask { blocks, shift: first.shift, top: layers - 1, ..OccupancyMask::default() }
    }
}

impl MultiVolumeTracer<'_, '_> {
    /// Traces all rays in packets and returns true, or traces none.
    pub(super) fn in_packets(
        &self,
        rays: &mut dyn Iterator<Item = PrimaryRay>,
        counts: &mut Counts,
        target: &mut Target,
    ) -> bool {
        let Some(packets) = self.packets else { return false };
        let MultiVolumeTracer { scene, shading, budget, is_coarse, .. } = *self;
        let source = scene.media.first().map_or(0, |medium| medium.extinction.source);
        let volume = SingleVolumeTracer {
            grid: scene.grid,
            shell: &packets.shell,
            spans: &packets.spans,
            samples: packets.samples,
            visible: &packets.visible,
            outer: scene.outer,
            gradients: scene.sources[source].gradients().values(),
            method: Method::Exact,
            budget,
            shading: shading.filter(|_| !scene.media.is_empty()),
            is_coarse,
            level: Some(packets.level),
            integrates: packets.integrates,
            core: scene.core,
        };
        match volume.shading {
            Some(_) => packet::trace_scene::<4>(packets.level, &volume, self, rays, counts, target),
            None => packet::trace_scene::<1>(packets.level, &volume, self, rays, counts, target),
        }
    }

    /// Several volumes, and the gradients of each where there is light.
    #[inline]
    pub(crate) fn packet_volumes(&self) -> Option<(&PacketVolumes<'_>, Vec<&Gradients>)> {
        let volumes = self.packets?.volumes.as_ref()?;
        let sources = self.scene.media.iter().map(|medium| medium.extinction.source);
        let gradients = sources.filter(|_| self.shading.is_some());
        Some((volumes, gradients.map(|source| self.scene.sources[source].gradients().values()).collect()))
    }

    /// What packets of rays read of the scene.
    #[inline]
    pub(crate) fn packet_scene(&self) -> Option<&PacketScene<'_>> {
        self.packets
    }
}
