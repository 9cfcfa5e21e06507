//! One volume along a single ray, by the rules of [`VolumeRay`], whose error is bounded.

use super::{RaySettings, TransferMap};
use crate::column::Flow;
use crate::lit::FrustumInterpolant;
use crate::piece::Radiance;
use crate::segment::Segment;
use crate::volume_ray::{VolumeRay, VolumeRules, correlated};
use glam::DVec3;
use icoray_grid::array::MapInline;

/// The only volume of a scene, in the colours of its own field.
#[derive(Debug, Clone, Copy)]
pub(super) struct SingleVolume<'w> {
    map: &'w TransferMap,
    needs_sizes: bool,
    ray: VolumeRay<'w, f64>,
}

/// Bounds of a field at the vertices of a frustum.
#[derive(Debug, Clone, Copy)]
pub(super) struct VertexBounds {
    /// The least and the greatest value.
    pub values: [f64; 2],
    /// The largest component of the gradients; 0 without light.
    pub gradient_size: f64,
}

impl<'w> SingleVolume<'w> {
    /// The volume of a scene along `dir`; `None` where there are several, or its colours are those of another field or
    /// transfer function.
    #[inline]
    pub fn new(tracer: &RaySettings<'w, '_>, dir: DVec3) -> Option<Self> {
        let RaySettings { scene, shading, budget, method, is_coarse } = *tracer;
        let medium = scene.media.first().filter(|_| scene.has_one_field_of_volume())?;
        let map = &medium.extinction;
        let spans = map.spans();
        let needs_sizes = spans.needs_sizes(scene.sources[map.source].value_range);
        let rules = VolumeRules { spans, method, is_coarse, budget, shading };
        Some(SingleVolume { map, needs_sizes, ray: VolumeRay::new(&rules, dir) })
    }

    /// The number of its field.
    #[inline]
    pub fn source(&self) -> usize {
        self.map.source
    }

    /// The ray passes where the volume is not.
    #[inline]
    pub fn pass_void(&mut self) {
        self.ray.span = None;
    }

    /// Continues with this light, to the transmittance at which the ray ends.
    #[inline]
    pub fn go_on(&mut self, light: Radiance<f64>, min_transmittance: f64) {
        (self.ray.light, self.ray.min_transmittance) = (light, min_transmittance);
    }

    /// Adds the light of a part of a frustum. Value, and gradient where `N` is 4, run along the whole frustum, with the
    /// range of the values and the largest component of the gradients at its vertices.
    #[inline]
    pub fn light<const N: usize>(
        &mut self,
        along: [&Segment<f64>; N],
        vertices: VertexBounds,
        [from, to]: [f64; 2],
    ) -> (Radiance<f64>, Flow) {
        let (map, ray, value) = (self.map, &mut self.ray, along[0]);
        let whole =
            Segment { f0: map.normal(value.f0), f1: map.normal(value.f1), kappa: value.kappa * map.scale(), ..*value };
        let [mut from_all, mut to_all, mut kappa] = [[whole.f0; N], [whole.f1; N], [whole.kappa; N]];
        for k in 1..N {
            (from_all[k], to_all[k], kappa[k]) = (along[k].f0, along[k].f1, along[k].kappa);
        }
        let interpolant = FrustumInterpolant { from: from_all, to: to_all, kappa, eps: whole.eps };
        if self.needs_sizes {
            let [low, high] = vertices.values.map_inline(|value| map.normal(value).abs());
            ray.size = correlated(low.max(high));
        }
        let end = |u: f64, f: f64| if u == 0.0 || u == 1.0 { (u, f) } else { (u, whole.value(u)) };
        let part = match [from, to] {
            [0.0, 1.0] => whole,
            _ => whole.part(end(from, whole.f0), end(to, whole.f1)),
        };
        ray.gradient_size = vertices.gradient_size;
        let flow = ray.segment(&part, &interpolant, [from, to]);
        (ray.light, flow)
    }
}
