//! What a scene shows beside its volume, for a device.

use icoray_grid::array::MapInline;
use icoray_grid::grid::unit_vector;
use icoray_scene::{Clip, Heights, Level, LonLatBox, Scene, Volume};

/// Largest number of cuts that a device is given.
pub const MAX_CLIPS: usize = 8;

/// What is shown beside the volume and the core; nothing in a plain scene.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scenery {
    /// The cuts.
    pub clips: Vec<ClipRegion>,
}

/// A cut: where all of its conditions hold.
#[derive(Debug, Clone, PartialEq)]
pub struct ClipRegion {
    /// Whether the inside is cut away; else the outside.
    pub cuts_inside: bool,
    /// A box in longitude and latitude.
    pub region: Option<LonLatBox>,
    /// From layer to layer, counted from the innermost; both included.
    pub layers: Option<[usize; 2]>,
    /// From radius to radius, planet radii.
    pub shell: Option<[f64; 2]>,
    /// Beyond a plane: the direction in which it lies, a unit vector, and how far out, planet radii.
    pub half_space: Option<([f64; 3], f64)>,
}

impl ClipRegion {
    /// A cut of a scene. `radius_of` converts heights in metres to radii in planet radii, exaggeration included.
    pub(crate) fn new(clip: &Clip, radius_of: impl Fn(f64) -> f64) -> Self {
        ClipRegion {
            cuts_inside: clip.cuts_inside,
            region: clip.region,
            layers: clip.layers,
            shell: clip.height_m.map(|ends| ends.map_inline(&radius_of)),
            half_space: clip.half_space.map(|half| {
                let [lon, lat] = half.towards_deg.map_inline(f64::to_radians);
                (unit_vector(lon, lat).to_array(), half.distance)
            }),
        }
    }
}

/// What devices do not draw of a scene, if there is something.
pub(crate) fn unsupported(scene: &Scene) -> Option<String> {
    let scenery = &scene.scenery;
    if scene.is_plain() {
        return None;
    }
    let reason = if scenery.heights == Heights::Native {
        "the scene's layers lie at other heights in each column"
    } else if scene.volumes.len() > 1 {
        "the scene shows several volumes"
    } else if matches!(scene.volumes.as_slice(), [Volume { opacity: Some(_), .. }]) {
        "the opacity of the scene's volume is that of another field"
    } else if !scenery.surfaces.is_empty() {
        "the scene shows surfaces on layers"
    } else if !scenery.isosurfaces.is_empty() {
        "the scene shows isosurfaces"
    } else if scenery.lines.iter().any(|lines| lines.on != Level::Ground) {
        "the scene has lines on a layer"
    } else if scenery.clips.len() > MAX_CLIPS {
        return Some(format!("the scene has {} cuts, expected at most {MAX_CLIPS}", scenery.clips.len()));
    } else {
        return None;
    };
    Some(reason.into())
}
