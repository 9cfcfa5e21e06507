//! A scene in the form for packets: its volumes in single precision, and the cuts of each gap.

use super::read::Source;
use crate::column::Shell;
use crate::deviation::Deviations;
use crate::general::{KernelScene, TransferMap};
use crate::transfer::{KernelKnot, Spans};

/// A scene for packets of rays, equal for all rays of a frame.
#[derive(Debug)]
pub struct PacketScene<'f> {
    pub(crate) shell: Shell,
    pub(crate) spans: Spans<f32>,
    /// The field of the first volume.
    pub(super) source: Source<'f>,
    pub(super) volumes: Option<PacketVolumes<'f>>,
    /// For each gap, the bits of the cuts that contain it.
    pub(crate) clips_of_gaps: Vec<u32>,
    /// Whether rays leap over the hollow core.
    pub(crate) leaps_core: bool,
    /// The deviations of the only volume from a finer grid, which are added to the errors of rays.
    pub(super) deviations: Option<&'f Deviations>,
}

/// Several volumes, or one whose opacity is that of another field, in single precision.
#[derive(Debug)]
pub(super) struct PacketVolumes<'f> {
    /// Transfer functions with their fields.
    pub maps: Vec<PacketMap<'f>>,
    /// The numbers of each volume's maps: that of its extinction and that of its colour.
    pub maps_of: Vec<[usize; 2]>,
}

/// A transfer function with its field.
#[derive(Debug)]
pub(super) struct PacketMap<'f> {
    pub source: Source<'f>,
    pub spans: Spans<f32>,
}

impl<'f> PacketVolumes<'f> {
    fn new(scene: &KernelScene<'f>) -> Option<Self> {
        let (mut maps, mut maps_of) = (Vec::new(), Vec::new());
        let mut add = |map: &TransferMap| {
            let spans = Spans::new(map.knots());
            let source = Source::new(&scene.sources.get(map.source)?.field, spans.range());
            maps.push(PacketMap { source, spans });
            Some(maps.len() - 1)
        };
        for medium in &scene.media {
            let extinction = add(&medium.extinction)?;
            let is_one = medium.has_own_color();
            maps_of.push([extinction, if is_one { extinction } else { add(&medium.color)? }]);
        }
        Some(PacketVolumes { maps, maps_of })
    }
}

/// Largest number of cuts: a bit each.
const MAX_CLIPS: usize = 32;

impl<'f> PacketScene<'f> {
    /// A scene between layers of these radii, planet radii (mean ones under native heights); `None` if there are more
    /// cuts than packets support: then rays are traced one at a time.
    ///
    /// Rays leap over a hollow core if `leaps` is set.
    pub fn new(scene: &KernelScene<'f>, radius: &[f64], leaps: bool) -> Option<Self> {
        const CLEAR: [KernelKnot; 1] = [KernelKnot { value: 0.0, color: [0.0; 3], extinction: 0.0 }];
        let (number, knots) = match scene.media.as_slice() {
            [] => (0, CLEAR.as_slice()),
            [medium, ..] => (medium.extinction.source, medium.extinction.knots()),
        };
        let volumes = if scene.has_one_field_of_volume() { None } else { Some(PacketVolumes::new(scene)?) };
        if scene.clips.regions().len() > MAX_CLIPS {
            return None;
        }
        let spans = Spans::new(knots);
        let source = Source::new(&scene.sources.get(number)?.field, spans.range());
        let gaps = 0..=radius.len();
        let clips_of_gaps = gaps.map(|gap| scene.clips.around([gap.saturating_sub(1), gap])).collect();
        let leaps_core = leaps && scene.core.is_none();
        let (shell, deviations) = (Shell::new(radius), None);
        Some(PacketScene { shell, spans, source, volumes, clips_of_gaps, leaps_core, deviations })
    }

    /// The scene of a volume alone on a grid that is coarser than the model's, with these deviations.
    #[must_use]
    pub fn with_deviations(self, deviations: &'f Deviations) -> Self {
        PacketScene { deviations: Some(deviations), ..self }
    }
}
