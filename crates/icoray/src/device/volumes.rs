//! Several volumes, or one whose opacity is that of another field, for a device.

use super::fields::FieldTable;
use super::{FieldId, Span, Step};
use icoray_kernel::general::{KernelScene, Medium, TransferMap};
use icoray_kernel::transfer::{KernelKnot, Spans};

/// Maximum number of volumes that a device takes.
pub const MAX_VOLUMES: usize = 4;

/// A volume: colour by one field, opacity by the same or another one.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneVolume {
    /// The transfer function of the extinctions, and of the colours if [`Self::color`] is `None`.
    pub extinction: VolumeMap,
    /// The transfer function of the colours.
    pub color: Option<VolumeMap>,
}

/// A transfer function with its field.
#[derive(Debug, Clone, PartialEq)]
pub struct VolumeMap {
    /// The field, normalised to the range of the spans.
    pub field: FieldId,
    /// The transfer function, in rising order.
    pub spans: Vec<Span>,
    /// Its discontinuities, as [`Job::steps`](super::Job::steps).
    pub steps: Vec<Step>,
}

impl VolumeMap {
    fn new(map: &TransferMap, fields: &mut FieldTable) -> Self {
        let spans = Spans::<f32>::new(map.knots());
        VolumeMap { field: fields.of_map(map), spans: spans.all().to_vec(), steps: spans.steps().to_vec() }
    }
}

impl SceneVolume {
    /// The volumes of a scene; none if the only one is that of the job, with this transfer function.
    pub(super) fn all(scene: &KernelScene, knots: &[KernelKnot], fields: &mut FieldTable) -> Vec<Self> {
        let is_own = |medium: &Medium| medium.extinction.source == 0 && medium.extinction.knots() == knots;
        if scene.has_one_field_of_volume() && scene.media.iter().all(is_own) {
            return Vec::new();
        }
        let volume = |medium: &Medium| SceneVolume {
            extinction: VolumeMap::new(&medium.extinction, fields),
            color: (!medium.has_own_color()).then(|| VolumeMap::new(&medium.color, fields)),
        };
        scene.media.iter().map(volume).collect()
    }
}
