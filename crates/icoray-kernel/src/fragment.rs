//! Fragments of a ray, if each rank has a part of the cells: one for each run of columns that belong to the rank.
//!
//! The rank's mesh is closed by hole filling, so the ray walks over it from end to end and skips columns of other ranks
//! and void columns. A column and the distances at its sides have the same bits in each rank's mesh: the run of the
//! next rank begins at the distance at which the run of one rank ends.
//!
//! A ray may end inside a rank's columns by the transmittance of these columns alone: that of the whole ray is no
//! larger. An opaque core is met under the rank's own columns only. The walk ends behind the distance at which the ray
//! must have met the core for any depth of the facets.

use crate::column::Flow;
use crate::general::RayState;
use crate::owned_region::OwnedRegion;
use crate::piece::Radiance;
use crate::plane::RayLine;
use crate::signature::BoundarySignature;
use crate::walk::{Column, Walk};
use icoray_grid::array::MapInline;
use icoray_grid::real::Real;

/// Light of a part of a ray, in single precision, as it is sent to the rank that composes the ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fragment {
    /// Distances along the ray at which it begins and ends, in planet radii from the ray's closest point to the centre.
    /// The end is infinite if the ray ends in it: the core hides all light from behind, or the error includes it.
    pub t: [f64; 2],
    /// Premultiplied linear RGB.
    pub color: [f32; 3],
    /// The part of the light from behind that is absorbed, 0 to 1.
    pub alpha: f32,
    /// Largest error of a channel; includes rounding to single precision, but no other rounding.
    pub error: f32,
    /// Variance of colour and absorption due to rounding.
    pub variance: f32,
    /// The surfaces that the ray meets in it; empty for rays through one field.
    pub surfaces: BoundarySignature,
}

impl Fragment {
    /// A fragment with this light; `brightest` is the largest value of a channel behind.
    #[inline]
    pub fn new<T: Real>(t: [f64; 2], light: &Radiance<T>, surfaces: BoundarySignature, brightest: f64) -> Self {
        let color = light.color.map_inline(|c| c.wide() as f32);
        let absorbed = light.alpha.wide();
        // The rounded absorption dims all light from behind.
        let most = color.iter().fold(absorbed * brightest, |most, c| most.max(f64::from(*c)));
        let stored = if size_of::<T>() > size_of::<f32>() { 0.5 * f64::from(f32::EPSILON) * most } else { 0.0 };
        Fragment {
            t,
            color,
            alpha: absorbed as f32,
            error: (light.error.wide() + stored) as f32,
            variance: light.total_variance().wide() as f32,
            surfaces,
        }
    }

    /// The light in double precision.
    #[inline]
    pub fn light(&self) -> Radiance<f64> {
        Radiance {
            color: self.color.map_inline(f64::from),
            alpha: self.alpha.into(),
            error: self.error.into(),
            variance: self.variance.into(),
            shade_variance: 0.0,
        }
    }

    /// Whether it contributes nothing to a picture.
    #[inline]
    fn is_clear(&self) -> bool {
        self.alpha == 0.0
            && self.error == 0.0
            && self.variance == 0.0
            && self.color == [0.0; 3]
            && self.surfaces == BoundarySignature::default()
    }
}

/// The data on which the fragments of a ray depend beside their light.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct FragmentRules {
    brightest: f64,
    /// Smallest and largest distance at which the ray can meet the core.
    core: [f64; 2],
}

impl FragmentRules {
    /// The rules of a ray that meets an opaque core, if `is_solid`, below a layer whose radius lies between `radius`.
    #[inline]
    pub fn new(own: &OwnedRegion, line: &RayLine, radius: [f64; 2], is_solid: bool, brightest: f64) -> Self {
        let core = |radius: f64| line.first_inside(radius, [line.start, line.end]).filter(|_| is_solid);
        let core = [radius[1], radius[0] * own.lowest_facet()].map_inline(|r| core(r).unwrap_or(f64::INFINITY));
        FragmentRules { brightest, core }
    }

    /// Distance behind which the ray has met the core, for any depth of the facets.
    #[inline]
    pub fn core_by(&self) -> f64 {
        self.core[1]
    }

    /// The fragment of a run that the ray has left; `None` if it shows nothing and cannot meet the core.
    #[inline]
    pub fn left<T: Real>(&self, t: [f64; 2], (light, surfaces): (&Radiance<T>, BoundarySignature)) -> Option<Fragment> {
        let fragment = Fragment::new(t, light, surfaces, self.brightest);
        (!fragment.is_clear() || self.core[0] <= t[1]).then_some(fragment)
    }

    /// The fragment of a run from `start` on in which the ray has ended.
    #[inline]
    pub fn ended<T: Real>(&self, start: f64, (light, surfaces): (&Radiance<T>, BoundarySignature)) -> Fragment {
        Fragment::new([start, f64::INFINITY], light, surfaces, self.brightest)
    }
}

/// The fragments of a single ray while it is traced: runs of a rank's own columns.
pub(crate) struct FragmentBuilder<'r> {
    found: &'r mut Vec<Fragment>,
    rules: FragmentRules,
    /// Start and end of the current run.
    run: Option<[f64; 2]>,
}

impl<'r> FragmentBuilder<'r> {
    /// Appends fragments to `found`.
    #[inline]
    pub fn new(rules: FragmentRules, found: &'r mut Vec<Fragment>) -> Self {
        FragmentBuilder { found, rules, run: None }
    }

    /// Traces `ray` over the columns of `walk` that are `own`, until it ends.
    #[inline]
    pub fn trace(mut self, ray: &mut RayState, own: &OwnedRegion, mut walk: Walk) {
        loop {
            let triangle = walk.triangle();
            let is_own = own.has(triangle);
            let blocks = ray.blocks(triangle);
            let column = walk.next_column();
            if column.filter(|_| is_own).is_none() && self.close(ray.met()) {
                ray.restart();
            }
            let Some(column) = column else { return };
            if !is_own {
                ray.counts().columns += 1;
                if column.exit.t > self.rules.core_by() {
                    return;
                }
                continue;
            }
            let flow = ray.column(&column, triangle, blocks);
            self.extend(&column);
            if flow == Flow::Stop {
                self.end(ray.met());
                return;
            }
        }
    }

    /// Adds an own column to the run.
    #[inline]
    fn extend(&mut self, column: &Column) {
        self.run = Some([self.run.map_or(column.entry.t, |[from, _]| from), column.exit.t]);
    }

    /// Ends the run, if there is one, and appends its fragment.
    #[inline]
    fn close<T: Real>(&mut self, met: (&Radiance<T>, BoundarySignature)) -> bool {
        let Some(t) = self.run.take() else { return false };
        self.found.extend(self.rules.left(t, met));
        true
    }

    /// Appends the fragment of a run in which the ray has ended.
    #[inline]
    fn end<T: Real>(&mut self, met: (&Radiance<T>, BoundarySignature)) {
        self.found.extend(self.run.take().map(|[start, _]| self.rules.ended(start, met)));
    }
}
