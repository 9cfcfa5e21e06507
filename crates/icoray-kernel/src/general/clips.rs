//! Clipping: the stretches of a ray inside each cut, found from all places at which the ray may pass one of its bounds.
//! The middle of a stretch determines its side, never a rounded root.

use crate::plane::RayLine;
use glam::DVec3;
use icoray_grid::array::MapInline;
use icoray_scene::{Clip, LonLatBox};

/// The cuts of a scene.
#[derive(Debug, Clone, Default)]
pub struct Clips(Vec<ClipRegion>);

/// A cut: the region where all of its conditions hold.
#[derive(Debug, Clone, PartialEq)]
pub struct ClipRegion {
    /// Whether the inside is cut away; else the outside.
    pub cuts_inside: bool,
    /// A box in longitude and latitude.
    pub region: Option<LonLatBox>,
    /// From layer to layer, counted from the innermost; both included.
    pub layers: Option<[usize; 2]>,
    /// From radius to radius, planet radii, exaggerated.
    pub shell: Option<[f64; 2]>,
    /// Beyond a plane: its unit normal and its distance from the centre, planet radii.
    pub half_space: Option<(DVec3, f64)>,
}

/// The cuts along one ray: the stretches inside each, in rising order.
#[derive(Debug, Clone, Default)]
pub(super) struct RayClips<'c> {
    cuts: &'c [ClipRegion],
    inside: Vec<Vec<[f64; 2]>>,
}

impl Clips {
    /// The cuts of a scene. `radius_of` converts heights in metres to radii in planet radii, exaggeration included.
    #[inline]
    pub fn new(clips: &[Clip], radius_of: impl Fn(f64) -> f64) -> Self {
        let cut = |clip: &Clip| ClipRegion {
            cuts_inside: clip.cuts_inside,
            region: clip.region,
            layers: clip.layers,
            shell: clip.height_m.map(|ends| ends.map_inline(&radius_of)),
            half_space: clip.half_space.map(|half| {
                let [lon, lat] = half.towards_deg.map_inline(f64::to_radians);
                (icoray_grid::grid::unit_vector(lon, lat), half.distance)
            }),
        };
        Clips(clips.iter().map(cut).collect())
    }

    /// The regions of the cuts.
    #[inline]
    pub fn regions(&self) -> &[ClipRegion] {
        &self.0
    }

    /// The bits of the cuts that contain the space between or on `layers`, regardless of position.
    #[inline]
    pub(crate) fn around(&self, layers: [usize; 2]) -> u32 {
        self.bits(|cut| cut.has_layers(layers))
    }

    /// The bits of the cuts whose inside is cut away; for the others it is the outside.
    #[inline]
    pub(crate) fn inside_out(&self) -> u32 {
        self.bits(|cut| cut.cuts_inside)
    }

    #[inline]
    fn bits(&self, holds: impl Fn(&ClipRegion) -> bool) -> u32 {
        self.0.iter().enumerate().fold(0, |bits, (k, cut)| bits | u32::from(holds(cut)) << k)
    }

    /// The stretches of the ray inside each cut.
    #[inline]
    pub(super) fn along(&self, line: &RayLine) -> RayClips<'_> {
        RayClips { cuts: &self.0, inside: self.0.iter().map(|cut| cut.stretches(line)).collect() }
    }
}

impl ClipRegion {
    #[inline]
    fn stretches(&self, line: &RayLine) -> Vec<[f64; 2]> {
        let mut bounds = vec![line.start, line.end];
        self.bounds(line, &mut |t| {
            if t > line.start && t < line.end {
                bounds.push(t);
            }
        });
        bounds.sort_by(f64::total_cmp);
        let pairs = bounds.windows(2).map(|pair| [pair[0], pair[1]]);
        pairs.filter(|[a, b]| b > a && self.holds(line.position(0.5 * (a + b)))).collect()
    }

    /// Reports all places at which the ray may pass a bound.
    #[inline]
    fn bounds(&self, line: &RayLine, report: &mut impl FnMut(f64)) {
        let (x, y) = (line.b * line.plane.x, line.plane.y);
        if let Some((towards, distance)) = self.half_space {
            report((distance - towards.dot(x)) / towards.dot(y));
        }
        for radius in self.shell.into_iter().flatten() {
            let half = (radius - line.b) * (radius + line.b);
            if half > 0.0 {
                report(-half.sqrt());
                report(half.sqrt());
            }
        }
        let Some(region) = self.region else { return };
        for lon in region.lon_deg.map_inline(f64::to_radians) {
            let normal = DVec3::new(-lon.sin(), lon.cos(), 0.0);
            report(-normal.dot(x) / normal.dot(y));
        }
        for lat in region.lat_deg.map_inline(f64::to_radians) {
            // z² = sin²·(b² + t²), of which one root may lie on the other hemisphere.
            let s2 = lat.sin() * lat.sin();
            let (a, half_b, c) = (y.z * y.z - s2, x.z * y.z, x.z * x.z - s2 * line.b * line.b);
            let root = (half_b * half_b - a * c).max(0.0).sqrt();
            let q = -(half_b + root.copysign(half_b));
            report(q / a);
            report(c / q);
        }
    }

    /// Whether a point lies inside, regardless of layers.
    #[inline]
    fn holds(&self, at: DVec3) -> bool {
        let r = at.length();
        self.half_space.is_none_or(|(towards, distance)| towards.dot(at) > distance)
            && self.shell.is_none_or(|[low, high]| r >= low && r <= high)
            && self.region.is_none_or(|region| region.holds(at))
    }

    #[inline]
    fn has_layers(&self, [lowest, highest]: [usize; 2]) -> bool {
        self.layers.is_none_or(|[from, to]| lowest >= from && highest <= to)
    }
}

impl RayClips<'_> {
    /// Whether there is no cut.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.cuts.is_empty()
    }

    /// Whether the place at `t`, between or on `layers`, is shown.
    #[inline]
    pub fn shows(&self, layers: [usize; 2], t: f64) -> bool {
        self.cuts.iter().zip(&self.inside).all(|(cut, stretches)| {
            let is_inside = cut.has_layers(layers) && stretches.iter().any(|[a, b]| t >= *a && t <= *b);
            is_inside != cut.cuts_inside
        })
    }

    /// The bits of the cuts that contain the ray just behind `t`, regardless of layers, and the next bound.
    pub fn behind(&self, t: f64) -> (u32, f64) {
        let (mut bits, mut next) = (0, f64::INFINITY);
        for (k, stretches) in self.inside.iter().enumerate() {
            for [a, b] in stretches {
                bits |= u32::from(*a <= t && t < *b) << k;
                next = [*a, *b].into_iter().filter(|bound| *bound > t).fold(next, f64::min);
            }
        }
        (bits, next)
    }

    /// Calls `report` for the shown parts between `t[0]` and `t[1]`, in order, until it returns false.
    #[inline]
    pub fn parts(&self, layers: [usize; 2], [from, to]: [f64; 2], mut report: impl FnMut([f64; 2]) -> bool) {
        let mut bounds = vec![from, to];
        bounds.extend(self.inside.iter().flatten().flatten().filter(|t| **t > from && **t < to));
        bounds.sort_by(f64::total_cmp);
        for pair in bounds.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            if b > a && self.shows(layers, 0.5 * (a + b)) && !report([a, b]) {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use icoray_scene::HalfSpace;

    const NONE: Clip = Clip { cuts_inside: true, region: None, layers: None, height_m: None, half_space: None };

    /// Fine steps along many rays against the definition of each cut.
    #[test]
    fn stretches_are_those_that_fine_steps_find() {
        let boxes = [([10.0, 80.0], [-20.0, 35.0]), ([170.0, 200.0], [-90.0, 0.0]), ([-170.0, 150.0], [40.0, 90.0])];
        let mut clips: Vec<Clip> =
            boxes.map(|(lon_deg, lat_deg)| Clip { region: Some(LonLatBox { lon_deg, lat_deg }), ..NONE }).to_vec();
        clips.push(Clip { height_m: Some([0.1, 0.3]), ..NONE });
        clips.push(Clip { half_space: Some(HalfSpace { towards_deg: [33.0, -12.0], distance: 0.2 }), ..NONE });
        clips.push(Clip { height_m: Some([0.1, 0.3]), region: clips[0].region, ..NONE });
        let clips = Clips::new(&clips, |h| 1.0 + h);
        let mut wrong = 0;
        for i in 0..200 {
            let k = f64::from(i);
            let eye = DVec3::new((1.3 * k).sin(), (0.7 * k).cos(), (2.1 * k).sin()) * 3.0;
            let target = DVec3::new((0.3 * k).cos(), (1.9 * k).sin(), (0.9 * k).cos());
            let dir = (target - eye).normalize();
            let Some(line) = RayLine::new(eye, dir, 1.4) else { continue };
            let along = clips.along(&line);
            for (cut, stretches) in along.cuts.iter().zip(&along.inside) {
                for step in 0..500 {
                    let t = line.start + (line.end - line.start) * (f64::from(step) + 0.5) / 500.0;
                    let found = stretches.iter().any(|[a, b]| t >= *a && t <= *b);
                    wrong += u32::from(found != cut.holds(line.position(t)));
                }
            }
        }
        assert_eq!(wrong, 0);
    }

    #[test]
    fn stretches_leave_out_the_cut_parts_alone() {
        let line = RayLine::new(DVec3::X * 3.0, DVec3::NEG_X, 1.4).unwrap();
        let shell = |cuts_inside, layers| {
            Clips::new(&[Clip { cuts_inside, layers, height_m: Some([0.1, 0.2]), ..NONE }], |h| 1.0 + h)
        };
        let parts = |clips: &Clips, layers| {
            let mut found = Vec::new();
            clips.along(&line).parts(layers, [-1.3, -1.0], |part| {
                found.push(part.map(|t| (t * 1e6).round() / 1e6));
                true
            });
            found
        };
        assert_eq!(parts(&shell(true, None), [0, 1]), [[-1.3, -1.2], [-1.1, -1.0]]);
        assert_eq!(parts(&shell(false, None), [0, 1]), [[-1.2, -1.1]]);
        assert_eq!(parts(&shell(true, Some([1, 3])), [0, 1]), [[-1.3, -1.2], [-1.2, -1.1], [-1.1, -1.0]]);
        assert_eq!(parts(&shell(true, Some([1, 3])), [2, 3]).len(), 2);
    }
}
