//! Sort-last compositing: the fragments of a ray from all ranks are blended in order along the ray.
//!
//! Fragments of one ray do not overlap, and adjacent fragments share their boundary to the bit. An interval without a
//! fragment is a hole of the whole mesh, where the core is a sphere.
//!
//! A tile is encoded as its number of fragments and, if there are any, the number of fragments of each ray (2 bytes)
//! and the fragments themselves, ray by ray; if any fragment has met a surface, the surfaces of each fragment follow (8
//! bytes).

use glam::DVec3;
use icoray_grid::{Error, ErrorKind, Result};
use icoray_kernel::ground::Core;
use icoray_kernel::piece::Radiance;
use icoray_kernel::plane::RayLine;
use icoray_kernel::shade::Shading;
use icoray_kernel::signature::{Boundary, BoundarySignature, EyeDistance};
use icoray_kernel::{Budget, Counts, Fragment};
use std::iter;

/// Bytes of a fragment.
const BYTES: usize = 40;
/// Bytes of a fragment's surfaces.
const SURFACES: usize = 8;
/// The bit of the number of fragments that marks that their surfaces follow.
const HAS_SURFACES: u64 = 1 << 63;
/// Gaps between fragments shorter than this, in planet radii, are due to rounding.
const HAIR: f64 = 1e-12;

/// Parameters of compositing, shared by all rays of a frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Composer<'g> {
    /// Radii of the innermost and outermost layer.
    pub radius: [f64; 2],
    pub core: Option<Core<'g>>,
    pub shading: Option<Shading>,
    pub budget: Budget,
}

impl Composer<'_> {
    /// The light along the ray from `eye` towards `dir`, and the surfaces that it meets; `None` if it misses the shell.
    /// Sorts `fragments`.
    pub fn ray(
        &self,
        eye: DVec3,
        dir: DVec3,
        fragments: &mut [Fragment],
        counts: &mut Counts,
    ) -> Option<(Radiance<f64>, BoundarySignature)> {
        let line = RayLine::new(eye, dir, self.radius[1])?;
        counts.rays += 1;
        counts.fragments += fragments.len() as u64;
        fragments.sort_by(|a, b| a.t[0].total_cmp(&b.t[0]));
        let (mut light, mut surfaces) = (Radiance::none(), BoundarySignature::default());
        let mut reached = line.start;
        for fragment in fragments.iter().map(Some).chain([None]) {
            let gap = [reached, fragment.map_or(line.end, |fragment| fragment.t[0])];
            let core = self.core.as_ref().and_then(|core| Some((core, first_inside_gap(&line, self.radius[0], gap)?)));
            if let Some((core, t)) = core {
                if Budget::sees_behind(light.alpha) {
                    surfaces.push(Boundary::Core, EyeDistance::new(eye, dir).distance(t));
                }
                let shading = self.shading.map(|shading| shading.along(dir));
                light.over(&core.round_light(line.position(t), None, shading.as_ref()));
                break;
            }
            let Some(fragment) = fragment else { break };
            if Budget::sees_behind(light.alpha) {
                surfaces.then(&fragment.surfaces);
            }
            light.over(&fragment.light());
            let Budget { min_transmittance, brightest, .. } = self.budget;
            if fragment.t[1] == f64::INFINITY || light.ends(min_transmittance, brightest) {
                break;
            }
            reached = reached.max(fragment.t[1]);
        }
        Some((light, surfaces))
    }
}

/// The distance at which a ray is first inside a sphere, within an interval without data.
pub(crate) fn first_inside_gap(line: &RayLine, radius: f64, part: [f64; 2]) -> Option<f64> {
    if part[1] - part[0] > HAIR { line.first_inside(radius, part) } else { None }
}

/// The fragments of a tile's rays, which are added in any order.
#[derive(Debug, Default)]
pub(crate) struct TileFragments {
    /// Index in `all` of the first fragment of each ray, and the ray's number of fragments.
    rays: Vec<(usize, u16)>,
    all: Vec<Fragment>,
}

impl TileFragments {
    /// An empty list for this number of rays.
    pub fn of_rays(rays: usize) -> Self {
        TileFragments { rays: vec![(0, 0); rays], all: Vec::new() }
    }

    /// Adds the fragments of a ray, ordered along it; once for each ray.
    ///
    /// # Panics
    /// If their number exceeds 16 bits.
    pub fn add(&mut self, ray: usize, fragments: &[Fragment]) {
        let count = u16::try_from(fragments.len()).expect("a ray has fewer than 65536 fragments");
        self.rays[ray] = (self.all.len(), count);
        self.all.extend_from_slice(fragments);
    }

    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// The fragments, ray by ray.
    fn in_order(&self) -> impl Iterator<Item = &Fragment> {
        self.rays.iter().flat_map(|(first, count)| &self.all[*first..first + usize::from(*count)])
    }

    /// Appends the encoded tile.
    pub fn put(&self, bytes: &mut Vec<u8>) {
        let has_surfaces = self.all.iter().any(|fragment| fragment.surfaces != BoundarySignature::default());
        let head = self.all.len() as u64 | if has_surfaces { HAS_SURFACES } else { 0 };
        bytes.extend_from_slice(&head.to_le_bytes());
        if self.all.is_empty() {
            return;
        }
        self.rays.iter().for_each(|(_, count)| bytes.extend_from_slice(&count.to_le_bytes()));
        for fragment in self.in_order() {
            fragment.t.iter().for_each(|t| bytes.extend_from_slice(&t.to_le_bytes()));
            let [r, g, b] = fragment.color;
            for value in [r, g, b, fragment.alpha, fragment.error, fragment.variance] {
                bytes.extend_from_slice(&value.to_le_bytes());
            }
        }
        let surfaces = self.in_order().filter(|_| has_surfaces).flat_map(|f| f.surfaces.values());
        surfaces.for_each(|value| bytes.extend_from_slice(&value.to_le_bytes()));
    }
}

/// A tile of one rank, as received.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ReceivedTile<'b> {
    counts: &'b [[u8; 2]],
    fragments: &'b [[u8; BYTES]],
    /// One entry per fragment; empty if no fragment has met a surface.
    surfaces: &'b [[u8; SURFACES]],
}

impl<'b> ReceivedTile<'b> {
    /// Decodes a tile of `rays` rays from the front of `bytes`.
    pub fn take(bytes: &mut &'b [u8], rays: usize) -> Result<Self> {
        let cut = || Error::new(ErrorKind::Mpi, "a tile's fragments are cut short");
        let mut next = |count: usize| -> Result<&'b [u8]> {
            let (taken, rest) = bytes.split_at_checked(count).ok_or_else(cut)?;
            *bytes = rest;
            Ok(taken)
        };
        let head = next(8)?.first_chunk::<8>().map_or(0, |head| u64::from_le_bytes(*head));
        let (count, has_surfaces) = (head & !HAS_SURFACES, head & HAS_SURFACES != 0);
        if count == 0 {
            return Ok(ReceivedTile::default());
        }
        let counts = next(2 * rays)?.as_chunks().0;
        let length = usize::try_from(count).ok().and_then(|count| count.checked_mul(BYTES)).ok_or_else(cut)?;
        let fragments = next(length)?.as_chunks().0;
        let expected: usize = counts.iter().map(|count| usize::from(u16::from_le_bytes(*count))).sum();
        if expected != fragments.len() {
            return Err(cut());
        }
        let surfaces = if has_surfaces { next(SURFACES * expected)?.as_chunks().0 } else { &[] };
        Ok(ReceivedTile { counts, fragments, surfaces })
    }

    /// Moves the fragments of ray number `ray` to `found`; rays are read in their order.
    pub fn ray(&mut self, ray: usize, found: &mut Vec<Fragment>) {
        let count = self.counts.get(ray).map_or(0, |count| usize::from(u16::from_le_bytes(*count)));
        let (mine, rest) = self.fragments.split_at(count);
        let (surfaces, others) = self.surfaces.split_at(count.min(self.surfaces.len()));
        (self.fragments, self.surfaces) = (rest, others);
        let surfaces = surfaces.iter().map(Some).chain(iter::repeat(None));
        found.extend(mine.iter().zip(surfaces).map(|(fragment, surfaces)| read(fragment, surfaces)));
    }
}

fn read(bytes: &[u8; BYTES], surfaces: Option<&[u8; SURFACES]>) -> Fragment {
    let (t, values) = bytes.split_at(16);
    let t = [0, 1].map(|i| f64::from_le_bytes(t.as_chunks().0[i]));
    let [r, g, b, absorbed, error, variance] = [0, 1, 2, 3, 4, 5].map(|i| f32::from_le_bytes(values.as_chunks().0[i]));
    let values = |bytes: &[u8; SURFACES]| [0, 1].map(|i| f32::from_le_bytes(bytes.as_chunks().0[i]));
    let surfaces = surfaces.map_or(BoundarySignature::default(), |bytes| BoundarySignature::of_values(values(bytes)));
    Fragment { t, color: [r, g, b], alpha: absorbed, error, variance, surfaces }
}

#[cfg(test)]
mod tests {
    use super::*;
    use icoray_kernel::ground::Ground;

    fn fragment(t: [f64; 2], color: [f32; 3], absorbed: f32) -> Fragment {
        Fragment { t, color, alpha: absorbed, error: 1e-5, variance: 0.0, surfaces: BoundarySignature::default() }
    }

    const COMPOSER: Composer<'static> = Composer {
        radius: [1.0, 1.5],
        core: None,
        shading: None,
        budget: Budget { color_tolerance: 5e-4, min_transmittance: 5e-4, brightest: 1.0 },
    };

    #[test]
    fn the_nearer_fragment_is_in_front_for_any_order_of_ranks() {
        let (red, green) = (fragment([-1.0, -0.9], [0.5, 0.0, 0.0], 0.5), fragment([0.2, 0.3], [0.0, 1.0, 0.0], 1.0));
        for mut order in [[red, green], [green, red]] {
            let mut counts = Counts::default();
            let (light, _) = COMPOSER.ray(DVec3::X * 3.0, DVec3::NEG_X, &mut order, &mut counts).unwrap();
            assert_eq!((light.color, light.alpha), ([0.5, 0.5, 0.0], 1.0));
            assert!((light.error - 1.5e-5).abs() < 1e-10, "{}", light.error);
            assert_eq!((counts.rays, counts.fragments), (1, 2));
        }
    }

    #[test]
    fn a_gap_shows_the_core_and_data_hide_it() {
        let composer = Composer { core: Core::new(Some([0.0, 0.0, 1.0]), None), ..COMPOSER };
        let trace = |fragments: &mut [Fragment]| {
            composer.ray(DVec3::X * 3.0, DVec3::NEG_X, fragments, &mut Counts::default()).unwrap().0.color
        };
        assert_eq!(trace(&mut []), [0.0, 0.0, 1.0]);
        // Data from the top to a little below the core's sphere, where their facets are, and a fragment from there on.
        let clear = |from, to| Fragment { error: 0.0, ..fragment([from, to], [0.0; 3], 0.0) };
        let facet = Fragment { error: 0.0, ..fragment([-0.99, -0.98], [1.0, 0.0, 0.0], 1.0) };
        assert_eq!(trace(&mut [clear(-1.5, -0.99), facet]), [1.0, 0.0, 0.0]);
        assert_eq!(trace(&mut [clear(-1.5, -1.2), facet]), [0.0, 0.0, 1.0], "the gap begins above the core");
        assert_eq!(trace(&mut [clear(-1.5, -0.995), facet]), [0.0, 0.0, 1.0], "and inside it");
        assert!(composer.ray(DVec3::X * 3.0, DVec3::Y, &mut [], &mut Counts::default()).is_none());
    }

    #[test]
    fn a_gap_shows_land_and_sea() {
        let text =
            "field = 'q'\ncamera = { lon = 20, lat = 10, distance = 3 }\nground = { land = 'lime', ocean = 'blue' }";
        let scene = icoray_scene::Scene::parse(text).unwrap();
        let ground = Ground::new(&scene).unwrap();
        let composer = Composer { core: Core::new(scene.core, Some(&ground)), ..COMPOSER };
        let eye = DVec3::from_array(scene.camera.eye());
        let at = |lon: f64, lat: f64| {
            let dir = (icoray_grid::grid::unit_vector(lon.to_radians(), lat.to_radians()) - eye).normalize();
            composer.ray(eye, dir, &mut [], &mut Counts::default()).unwrap().0.color
        };
        assert_eq!([at(20.0, 10.0), at(-15.0, 0.0)], [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    }

    #[test]
    fn the_error_of_early_termination_is_reported_once() {
        // Half of what comes is hidden by a fragment in front; the ray ended in the one behind with 2e-4 left.
        let front = Fragment { error: 0.0, ..fragment([-1.4, -1.3], [0.5, 0.0, 0.0], 0.5) };
        let last = Fragment { error: 2e-4, ..fragment([-1.3, f64::INFINITY], [0.0, 0.9998, 0.0], 1.0 - 2e-4) };
        let behind = fragment([-1.2, -1.0], [1.0, 0.0, 0.0], 1.0);
        let (light, _) =
            COMPOSER.ray(DVec3::X * 3.0, DVec3::NEG_X, &mut [behind, last, front], &mut Counts::default()).unwrap();
        assert!((light.error - 1e-4).abs() < 1e-9, "{}", light.error);
        assert!(light.color[0] == 0.5 && light.alpha < 1.0, "{light:?}");
    }

    #[test]
    fn fragments_come_ray_by_ray_and_cut_ones_are_errors() {
        let found = [3usize, 0, 1].map(|count| {
            let at = |i: usize| (count * 10 + i) as f64;
            (0..count).map(|i| fragment([at(i), at(i) + 0.5], [0.1, 0.2, 0.3], 0.4)).collect::<Vec<_>>()
        });
        let mut bytes = Vec::new();
        let mut tile = TileFragments::of_rays(3);
        [2, 0, 1].into_iter().for_each(|ray| tile.add(ray, &found[ray]));
        tile.put(&mut bytes);
        TileFragments::of_rays(3).put(&mut bytes);
        assert_eq!(bytes.len(), 8 + 3 * 2 + 4 * BYTES + 8);
        let mut rest = bytes.as_slice();
        for expected in [&found, &[const { Vec::new() }; 3]] {
            let mut received = ReceivedTile::take(&mut rest, 3).unwrap();
            for (pixel, expected) in expected.iter().enumerate() {
                let mut found = Vec::new();
                received.ray(pixel, &mut found);
                assert_eq!(found, *expected);
            }
        }
        assert!(rest.is_empty());
        for length in 0..bytes.len() - 8 {
            assert!(ReceivedTile::take(&mut &bytes[..length], 3).is_err(), "{length} bytes");
        }
    }
}
