//! Light on the pieces of a packet: the rules of `lit.rs` and `shade.rs` in vectors.

use super::integral::Light;
use super::lanes::Lanes;
use super::layers::Way;
use super::medium::{Medium, number};
use super::part::{Part, all};
use super::read::{Course, FAR, Vertices};
use crate::light::{INDEPENDENT, LIT_DEVIATIONS};
use crate::lit::{ADVANCE, HALVINGS_ALONG, HALVINGS_AT_START, LightSpread};
use crate::number::Vector;
use crate::shade::{ColorChange, MeanShade, RayShading, Shade as ShadeOf};
use crate::turn::NormalTurn;
use fearless_simd::prelude::*;
use icoray_grid::array::MapInline;
use icoray_grid::gradient::Gradients;
use icoray_simd::{Floats, Machine, Mask, Numbers, Table};

/// A vector of space in each lane.
pub(super) type Vectors<V> = [Floats<V>; 3];

/// The gradients at the vertices.
#[derive(Clone, Copy)]
pub(super) enum Slopes<'t> {
    /// None: rays are not lit.
    None,
    /// Three floats each.
    Whole(Table<'t, f32>, u32),
    /// Packed ones.
    Packed(Table<'t, u64>, u32),
}

impl<'t> Slopes<'t> {
    /// The gradients over this number of layers; `None` if they are too many for gathers.
    #[inline]
    pub fn new(gradients: &'t Gradients, layers: usize) -> Option<Self> {
        let layers = layers as u32;
        match gradients.words() {
            Some(words) => Table::new(words).map(|table| Slopes::Packed(table, layers)),
            None => Table::new(gradients.whole().as_flattened()).map(|table| Slopes::Whole(table, layers)),
        }
    }

    /// The gradient along each lane's frustum.
    #[inline(always)]
    pub fn read<V: Machine>(&self, simd: V, lanes: &Lanes<V>, way: &impl Way<V>) -> GradientCourse<V> {
        let (Slopes::Whole(_, layers) | Slopes::Packed(_, layers)) = *self else {
            return GradientCourse::none(simd);
        };
        let upper = lanes.gap;
        let layers = number(simd, layers);
        let [a, b, c] = lanes.cells;
        let [a, b, c] = [a * layers + upper, b * layers + upper, c * layers + upper];
        let low = [self.at(simd, a - 1), self.at(simd, b - 1), self.at(simd, c - 1)];
        let high = [self.at(simd, a), self.at(simd, b), self.at(simd, c)];
        let components =
            [course_of(way, &low, &high, 0), course_of(way, &low, &high, 1), course_of(way, &low, &high, 2)];
        let mut most = all(simd, 0.0);
        for vertex in 0..3 {
            most = most.max(largest::<V>(&low[vertex]).max(largest::<V>(&high[vertex])));
        }
        GradientCourse { components, size: most }
    }

    /// Starts to fetch the gradient at `layer` over a cell.
    #[inline(always)]
    pub fn prefetch(&self, cell: u32, layer: u32) {
        let (Slopes::Whole(_, layers) | Slopes::Packed(_, layers)) = *self else { return };
        let number = cell.wrapping_mul(layers).wrapping_add(layer);
        match self {
            Slopes::None => {}
            Slopes::Whole(table, _) => table.prefetch(number.wrapping_mul(3)),
            Slopes::Packed(table, _) => table.prefetch(number),
        }
    }

    /// The gradients with these numbers.
    #[inline(always)]
    fn at<V: Machine>(&self, simd: V, index: Numbers<V>) -> Vectors<V> {
        match self {
            Slopes::None => [all(simd, 0.0); 3],
            Slopes::Whole(table, _) => {
                let first = index + (index << 1);
                [simd.gather_f32(*table, first), simd.gather_f32(*table, first + 1), simd.gather_f32(*table, first + 2)]
            }
            Slopes::Packed(table, _) => {
                let (low, high) = simd.gather_u64(*table, index);
                let unit = ((high >> 22) << 23).bitcast::<Floats<V>>();
                [
                    signed::<V>(low << 14) * unit,
                    signed::<V>((high << 28) | (low >> 4)) * unit,
                    signed::<V>(high << 10) * unit,
                ]
            }
        }
    }
}

/// The largest component of each lane's vector.
#[inline(always)]
pub(super) fn largest<V: Machine>([x, y, z]: &Vectors<V>) -> Floats<V> {
    x.abs().max(y.abs()).max(z.abs())
}

/// A component of gradients along each lane's frustum.
#[inline(always)]
fn course_of<V: Machine>(way: &impl Way<V>, low: &[Vectors<V>; 3], high: &[Vectors<V>; 3], k: usize) -> Course<V> {
    let vertices = Vertices { low: [low[0][k], low[1][k], low[2][k]], high: [high[0][k], high[1][k], high[2][k]] };
    let [from, to, kappa] = way.interpolate(&vertices);
    [from + low[0][k], to + low[0][k], kappa]
}

/// The number in the upper 18 bits.
#[inline(always)]
fn signed<V: Machine>(bits: Numbers<V>) -> Floats<V> {
    (bits.bitcast::<V::i32s>() >> 14).to_float::<Floats<V>>()
}

/// The gradient along each lane's frustum.
#[derive(Clone, Copy)]
pub(super) struct GradientCourse<V: Machine> {
    components: [Course<V>; 3],
    /// The largest component of the gradients at the vertices.
    pub size: Floats<V>,
}

impl<V: Machine> GradientCourse<V> {
    /// No gradients.
    #[inline(always)]
    pub fn none(simd: V) -> Self {
        GradientCourse { components: [[all(simd, 0.0); 3]; 3], size: all(simd, 0.0) }
    }

    /// Sets the gradients along the frusta of the lanes of `new`.
    #[inline(always)]
    pub fn put(&mut self, new: Mask<V>, course: &Self) {
        for (row, number) in self.components.as_flattened_mut().iter_mut().zip(course.components.as_flattened()) {
            *row = new.select(*number, *row);
        }
        self.size = new.select(course.size, self.size);
    }

    /// Lanes in which a gradient at an end of the frustum is so much smaller than one at a vertex that its direction
    /// requires double precision.
    #[inline(always)]
    pub fn is_cancelled(&self) -> Mask<V> {
        let [x, y, z] = &self.components;
        let least = largest::<V>(&[x[0], y[0], z[0]]).min(largest::<V>(&[x[1], y[1], z[1]]));
        self.size.simd_gt(least * FAR)
    }

    /// The gradients at the start, in the middle and at the end of a piece.
    #[inline(always)]
    fn of_piece(&self, simd: V, [from, to]: [Floats<V>; 2], eps: Floats<V>) -> [Vectors<V>; 3] {
        let middle = (from + to) * 0.5;
        [self.at(simd, from, eps), self.at(simd, middle, eps), self.at(simd, to, eps)]
    }

    /// The gradient at `u` of the frusta with this relative change of height.
    #[inline(always)]
    fn at(&self, simd: V, u: Floats<V>, eps: Floats<V>) -> Vectors<V> {
        let one = all(simd, 1.0);
        let bent = u * (one - u) / eps.mul_add(u, one);
        let [x, y, z] = &self.components;
        [along::<V>(x, u, bent), along::<V>(y, u, bent), along::<V>(z, u, bent)]
    }

    /// The gradient along a lane's frustum at its start, at its end, and its bend.
    pub fn interpolant(&self, lane: usize) -> [[f32; 3]; 3] {
        let [x, y, z] = &self.components;
        let at = |k: usize| [x[k][lane], y[k][lane], z[k][lane]];
        [at(0), at(1), at(2)]
    }
}

/// The lighting data of each lane: the gradient along its frustum, the rest of the frustum, the fraction of that to be
/// taken next, and the directions of its ray.
pub(super) struct Lit<V: Machine> {
    pub course: GradientCourse<V>,
    /// The frustum's relative change of height.
    pub eps: Floats<V>,
    /// Start of the rest in the frustum.
    pub from: Floats<V>,
    /// The fraction of a piece to be taken.
    pub fraction: Floats<V>,
    /// Number of halvings of pieces of the frustum.
    halvings: Floats<V>,
    pub light: Vectors<V>,
    pub halfway: Vectors<V>,
}

impl<V: Machine> Lit<V> {
    #[inline(always)]
    pub fn new(simd: V) -> Self {
        let zero = all(simd, 0.0);
        let none = [zero; 3];
        Lit {
            course: GradientCourse::none(simd),
            eps: zero,
            from: zero,
            fraction: zero,
            halvings: zero,
            light: none,
            halfway: none,
        }
    }

    /// Enters new frusta, with this relative change of height, in the lanes of `new`.
    #[inline(always)]
    pub fn enter(&mut self, simd: V, new: Mask<V>, eps: Floats<V>) {
        self.eps = new.select(eps, self.eps);
        self.from = new.select(all(simd, 0.0), self.from);
        self.fraction = new.select(all(simd, 1.0), self.fraction);
        self.halvings = new.select(all(simd, 0.0), self.halvings);
    }

    /// Lanes whose pieces, which end at `to` of the frustum, may be halved.
    #[inline(always)]
    pub fn may_halve(&self, to: Floats<V>) -> Mask<V> {
        let most = to * HALVINGS_ALONG as f32 + HALVINGS_AT_START as f32;
        self.fraction.simd_gt(LEAST_FRACTION) & self.halvings.simd_lt(most)
    }

    /// Continues behind the pieces of the lanes `taken`, which end at `to`; halves the pieces of those that are `left`.
    #[inline(always)]
    pub fn go_on(&mut self, simd: V, taken: Mask<V>, left: Mask<V>, to: Floats<V>) {
        self.from = taken.select(to, self.from);
        let next = taken.select((self.fraction + self.fraction).min(all(simd, 1.0)), self.fraction);
        self.fraction = left.select(self.fraction * 0.5, next);
        self.halvings = left.select(self.halvings + 1.0, self.halvings);
    }
}

/// A component at `u`, with the weight `bent` of the bend.
#[inline(always)]
fn along<V: Machine>([from, to, kappa]: &Course<V>, u: Floats<V>, bent: Floats<V>) -> Floats<V> {
    bent.mul_add(*kappa, u.mul_add(*to - *from, *from))
}

/// Length of a piece of a frustum up to which it is taken for any error of its shade.
const LEAST_FRACTION: f32 = 1e-4;

/// A piece with its medium.
pub(super) struct Piece<'p, V: Machine> {
    pub part: &'p Part<V>,
    pub medium: &'p Medium<V>,
    /// Extinction at its ends.
    pub ends: [Floats<V>; 2],
    /// Its start and end in its frustum, and the frustum's relative change of height.
    pub range: [Floats<V>; 2],
    pub eps: Floats<V>,
}

/// The change of colour along a piece of each lane, as `ColorChange::of`.
#[inline(always)]
fn change_of<V: Machine>(simd: V, part: &Part<V>, medium: &Medium<V>) -> ColorChange<Vector<V>> {
    let bend = medium.steepest * part.kappa.abs();
    let change = medium.steepest * (part.f1 - part.f0).abs() + bend;
    ColorChange { brightest: medium.brightest, change, bend, eps: part.eps }.map(|lanes| Vector::new(simd, lanes))
}

/// Shade of a piece: factors for its colour and for its change along the piece, the highlight, and their errors per
/// absorbed light ([`MeanShade`](crate::shade::MeanShade)).
pub(super) struct Shade<V: Machine> {
    pub body: Floats<V>,
    pub tilt: Floats<V>,
    pub highlight: Floats<V>,
    pub off: Floats<V>,
    pub rounding: Floats<V>,
    /// Standard deviation of the shade by rounding of the gradients.
    pub deviation: Floats<V>,
}

impl<V: Machine> Lit<V> {
    /// The mean shade of each lane's piece.
    #[inline(always)]
    pub fn shade(&self, simd: V, common: &RayShading<f32>, piece: &Piece<'_, V>) -> Shade<V> {
        let Piece { part, medium, ends, range, eps } = *piece;
        let vector = |lanes| Vector::new(simd, lanes);
        let spread = LightSpread::of(ends.map_inline(vector), vector(part.length), vector(medium.slope * part.kappa));
        self.shade_of(simd, common, (&self.course, range, eps), spread, &change_of(simd, part, medium))
    }

    /// The mean shade of each lane's piece with these gradients along its frustum, of which it is `range`.
    #[inline(always)]
    pub fn shade_of(
        &self,
        simd: V,
        common: &RayShading<f32>,
        (course, range, eps): (&GradientCourse<V>, [Floats<V>; 2], Floats<V>),
        spread: LightSpread<Vector<V>>,
        colors: &ColorChange<Vector<V>>,
    ) -> Shade<V> {
        let vector = |lanes| Vector::new(simd, lanes);
        let alike = |value: f32| vector(all(simd, value));
        let shading = RayShading {
            ambient: alike(common.ambient),
            diffuse: alike(common.diffuse),
            specular: alike(common.specular),
            shininess: alike(common.shininess),
            light: self.light.map_inline(vector),
            halfway: self.halfway.map_inline(vector),
            sharpness: alike(common.sharpness),
            deviations: common.deviations.map_inline(alike),
        };
        let gradients = course.of_piece(simd, range, eps).map_inline(|gradient| gradient.map_inline(vector));
        let mean = shading.mean(&NormalTurn::of(&gradients, colors.eps, spread), colors);
        let MeanShade { shade: ShadeOf { body, highlight }, tilt, off, rounding, size } = mean;
        let deviation = shading.deviation_of(vector(course.size), size);
        let [body, tilt, highlight, off, rounding, deviation] =
            [body, tilt, highlight, off, rounding, deviation].map_inline(|number: Vector<V>| number.lanes);
        Shade { body, tilt, highlight, off, rounding, deviation }
    }
}

impl<V: Machine> Shade<V> {
    /// `light` of a piece with this shade, as [`RayShading::apply`]; the piece is this fraction of one between knots.
    #[inline(always)]
    pub fn apply(&self, simd: V, piece: &Piece<'_, V>, fraction: Floats<V>, light: &mut Light<V>) {
        let rise = (piece.part.f1 - piece.part.f0) * self.tilt;
        for k in 0..3 {
            let added = rise.mul_add(piece.medium.color_slope[k], self.highlight);
            light.color[k] = light.color[k].mul_add(self.body, light.alpha * added);
        }
        light.error = light.error.mul_add(self.body, light.alpha * self.rounding);
        let off = self.off * light.alpha * INDEPENDENT as f32;
        light.shade_variance = off * off;
        let scale = self.body.max(all(simd, 1.0));
        // All parts of a piece, dense ones by their light, share the rounding of the gradients at the vertices.
        let turned = self.deviation * light.alpha;
        let turned = turned * turned / fraction.max(light.alpha * 0.5);
        light.variance = (light.variance * scale).mul_add(scale, turned);
    }

    /// Lanes whose rays cannot afford the error of their pieces.
    #[inline(always)]
    pub fn too_far(&self, simd: V, lanes: &Lanes<V>, piece: &Piece<'_, V>, color_tolerance: f32) -> Mask<V> {
        let depth = piece.part.length * piece.ends[0].max(piece.ends[1]);
        is_dear(simd, &lanes.light, depth.min(1.0), [self.rounding, self.off], color_tolerance)
    }
}

/// Lanes whose rays, which have the light `before` them, cannot afford pieces that absorb `absorbed` with these errors
/// per absorbed light: the opposite of [`is_affordable`](crate::lit::is_affordable).
#[inline(always)]
pub(super) fn is_dear<V: Machine>(
    simd: V,
    before: &Light<V>,
    absorbed: Floats<V>,
    [shared, own]: [Floats<V>; 2],
    color_tolerance: f32,
) -> Mask<V> {
    let share = absorbed * (all(simd, 1.0) - before.alpha);
    let earned = (before.alpha + share + ADVANCE as f32) * color_tolerance - before.error;
    let allowed = earned - share * shared;
    let own = own * (LIT_DEVIATIONS * INDEPENDENT) as f32;
    let own_share = share * own;
    let spread = before.shade_variance.mul_add((LIT_DEVIATIONS * LIT_DEVIATIONS) as f32, own_share * own_share);
    let is_beyond = allowed.simd_lt(0.0) | spread.simd_gt(allowed * allowed);
    (shared + own).simd_gt(color_tolerance) & is_beyond
}
