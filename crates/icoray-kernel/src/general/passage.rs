//! The places that a single ray passes, in order, for callers that explain a pixel.

use super::wedge::{Facet, Wedge};
use super::{KernelScene, Medium};

/// Number of equal parts of a frustum that are recorded at least.
pub(super) const PARTS: usize = 4;

/// A place of a ray that is recorded: a part of a frustum, a surface, or the core.
#[derive(Debug, Clone, PartialEq)]
pub struct Passage {
    /// The kind of the place.
    pub kind: PassageKind,
    /// The cells of the triangle over it; `None` over a hole of the mesh.
    pub cells: Option<[u32; 3]>,
    /// Distances from the ray's closest point to the centre at which it begins and ends, planet radii; equal for
    /// surfaces and the core.
    pub t: [f64; 2],
    /// Height ρ of its middle: the radius of a layer on the layer's facets, planet radii.
    pub rho: f64,
    /// The fraction of the light from behind that it absorbs.
    pub alpha: f64,
    /// The value of each field at its middle; NaN where it is missing.
    pub values: Vec<f64>,
}

/// A kind of [`Passage`].
#[derive(Debug, Clone, PartialEq)]
pub enum PassageKind {
    /// A part of a frustum, with each volume's share of the absorbed light; the shares of a clear part are 0.
    Frustum(Vec<f64>),
    /// The isosurface of this number.
    Isosurface(usize),
    /// The surface layer of this number, with a bit for each of its materials that is painted there.
    SurfaceLayer(usize, u32),
    /// The core.
    Core,
}

/// The shares of these volumes in the extinction at a place with these values.
pub(super) fn shares(media: &[Medium], values: &[f64]) -> Vec<f64> {
    let extinction = |medium: &Medium| {
        let map = &medium.extinction;
        let (value, is_colored) = (values[map.source], values[medium.color.source].is_finite());
        let found = if value.is_finite() && is_colored { map.span(value).extinction(map.normal(value)) } else { 0.0 };
        found.max(0.0)
    };
    let all: Vec<f64> = media.iter().map(extinction).collect();
    let sum: f64 = all.iter().sum();
    all.into_iter().map(|one| if sum > 0.0 { one / sum } else { 0.0 }).collect()
}

impl KernelScene<'_> {
    /// The value of each field on the facet of a layer at `u`.
    pub(super) fn values_on_layer(&self, wedge: &Wedge, facet: &Facet, u: f64) -> Vec<f64> {
        self.sources.iter().map(|source| source.on_layer(wedge, facet, u)).collect()
    }
}
