//! One volume along a single ray, by the rules of [`VolumeRay`], whose error is bounded.

use super::TransferMap;
use crate::column::Flow;
use crate::lit::FrustumInterpolant;
use crate::segment::Segment;
use crate::volume_ray::VolumeRay;

impl VolumeRay<'_, f64> {
    /// Adds the light of a part of a frustum. Value, and gradient where `N` is 4, run along the whole frustum; `map` is
    /// that of the volume.
    #[inline]
    pub(super) fn part<const N: usize>(
        &mut self,
        map: &TransferMap,
        along: [&Segment<f64>; N],
        [from, to]: [f64; 2],
    ) -> Flow {
        let value = along[0];
        let whole =
            Segment { f0: map.normal(value.f0), f1: map.normal(value.f1), kappa: value.kappa * map.scale(), ..*value };
        let [mut from_all, mut to_all, mut kappa] = [[whole.f0; N], [whole.f1; N], [whole.kappa; N]];
        for k in 1..N {
            (from_all[k], to_all[k], kappa[k]) = (along[k].f0, along[k].f1, along[k].kappa);
        }
        let interpolant = FrustumInterpolant { from: from_all, to: to_all, kappa, eps: whole.eps };
        let end = |u: f64, f: f64| if u == 0.0 || u == 1.0 { (u, f) } else { (u, whole.value(u)) };
        let part = match [from, to] {
            [0.0, 1.0] => whole,
            _ => whole.part(end(from, whole.f0), end(to, whole.f1)),
        };
        self.segment(&part, &interpolant, [from, to])
    }
}
