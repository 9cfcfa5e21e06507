//! The rays of a packet, a lane each, and their step from column to column.

use super::MOST;
use super::integral::Light;
use super::layers::Layers;
use super::medium::number;
use super::part::{Part, all};
use crate::light::Radiance;
use crate::plane::Plane;
use crate::walk::Side;
use fearless_simd::prelude::*;
use glam::DVec3;
use icoray_grid::Grid;
use icoray_grid::grid::half_edges::HalfEdges;
use icoray_simd::{Floats, Machine, Mask, Numbers, Table, Wide, WideMask, wide_mask};

/// The numbers of the lanes whose bits are set.
#[inline(always)]
pub(super) fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = (bits != 0).then_some(bits.trailing_zeros() as usize);
        bits &= bits.wrapping_sub(1);
        lane
    })
}

/// The tables over which a packet walks.
#[derive(Clone, Copy)]
pub(super) struct Mesh<'t> {
    half_edges: &'t [HalfEdges],
    /// Their words.
    words: Table<'t, u32>,
    directions: Table<'t, [f64; 3]>,
}

impl<'t> Mesh<'t> {
    /// The tables of a grid; `None` if it has more cells than a gather reaches.
    #[inline]
    pub fn new(grid: &'t Grid) -> Option<Self> {
        let (words, directions) = (Table::new(grid.half_edge_words())?, Table::new(grid.directions())?);
        Some(Mesh { half_edges: grid.half_edges(), words, directions })
    }
}

impl Mesh<'_> {
    /// The half-edges of a triangle.
    #[inline(always)]
    pub fn half_edges(&self, triangle: u32) -> &HalfEdges {
        &self.half_edges[triangle as usize]
    }

    /// Starts to fetch the direction of a cell.
    #[inline(always)]
    pub fn prefetch_direction(&self, cell: u32) {
        self.directions.prefetch(cell);
    }

    /// The direction of a cell.
    #[inline(always)]
    pub fn direction(&self, cell: u32) -> DVec3 {
        DVec3::from_array(self.directions.elements()[cell as usize])
    }
}

/// The rays that were put into lanes, in f64: axes, distance from the centre, end and start, the ends of the side, the
/// point of entry, its height and weights.
pub(super) struct Entries([[[f64; 3]; 8]; MOST]);

impl Entries {
    /// No rays.
    #[inline(always)]
    pub fn new() -> Self {
        Entries([[[0.0; 3]; 8]; MOST])
    }
}

/// Rays, one per lane: the ray, its column, its gap, the rest of its frustum, and its light.
///
/// [`Self::put`] enters a ray into a lane. The members correspond to those of `walk.rs`, `column.rs` and `segment.rs`.
pub(super) struct Lanes<V: Machine> {
    /// The axes x, y and q of the ray's plane; its distance from the centre, and its end.
    axes: [[Wide<V>; 3]; 3],
    b: Wide<V>,
    end: Wide<V>,
    /// x, y and q of the vertices between which it leaves its column.
    left: [Wide<V>; 3],
    right: [Wide<V>; 3],
    /// The half-edge of the next column.
    half_edge: Numbers<V>,
    /// Whether the apex is on the left.
    on_left: Mask<V>,
    /// The cells of the column: left, right and apex; offsets of their values.
    pub cells: [Numbers<V>; 3],
    pub bases: [Numbers<V>; 3],
    /// Offsets of their heights, if each cell has its own.
    pub heights: [Numbers<V>; 3],
    /// The column's triangle.
    pub triangles: Numbers<V>,
    /// The point on the unit facets at which it leaves.
    point: [Wide<V>; 2],
    /// Distance and height at the column's entry and exit, and 1 / the difference of heights.
    pub t: [Wide<V>; 2],
    pub rho: [Wide<V>; 2],
    pub scale: Wide<V>,
    pub rising: Mask<V>,
    /// Weights of the second and third vertex at the column's entry and exit, and at the entry of the next one.
    pub weights: [[Floats<V>; 2]; 2],
    next_weights: [Floats<V>; 2],
    /// The same in double precision, if rays may meet more than one volume.
    pub wide_weights: [[Wide<V>; 2]; 2],
    next_wide_weights: [Wide<V>; 2],
    /// Whether the ray ends in the column.
    pub last: Mask<V>,
    /// The distance before which it does not leap.
    pub next_leap: Wide<V>,
    /// Its gap, and the point at which it entered the gap: the fraction of the column's length, the fraction of the way
    /// between the edge points, height, the fraction of the way from the layer below to that above.
    pub gap: Numbers<V>,
    pub u: Wide<V>,
    pub tau: Floats<V>,
    pub height: Wide<V>,
    pub place: Floats<V>,
    /// The rest of its frustum, and whether the scalar is monotone there.
    pub rest: Part<V>,
    pub is_monotone: Mask<V>,
    /// The largest magnitude of values at its frustum's vertices, as for scalar rays.
    pub size: Floats<V>,
    /// The span of its last piece.
    pub span: Numbers<V>,
    /// Its light so far.
    pub light: Light<V>,
    /// The most by which the colour in its frustum differs from that on a finer grid, and what the ray had absorbed
    /// before that frustum.
    pub color_change: Floats<V>,
    pub absorbed_before: Floats<V>,
}

impl<V: Machine> Lanes<V> {
    /// Number of lanes.
    pub const COUNT: usize = <Floats<V> as SimdBase<V>>::LEN;

    /// Lanes without rays.
    #[inline(always)]
    pub fn new(simd: V) -> Self {
        let (none, zero, nothing) = (Wide::splat(simd, 0.0), all(simd, 0.0), number(simd, 0));
        let no = <Mask<V> as SimdMask<V>>::splat(simd, false);
        Lanes {
            axes: [[none; 3]; 3],
            b: none,
            end: none,
            left: [none; 3],
            right: [none; 3],
            half_edge: nothing,
            on_left: no,
            cells: [nothing; 3],
            bases: [nothing; 3],
            heights: [nothing; 3],
            triangles: nothing,
            point: [none; 2],
            t: [none; 2],
            rho: [none; 2],
            scale: none,
            rising: no,
            weights: [[zero; 2]; 2],
            next_weights: [zero; 2],
            wide_weights: [[none; 2]; 2],
            next_wide_weights: [none; 2],
            last: no,
            next_leap: none,
            gap: nothing,
            u: none,
            tau: zero,
            height: none,
            place: zero,
            rest: Part::none(simd),
            is_monotone: no,
            size: all(simd, 1.0),
            span: nothing,
            light: Radiance { color: [zero; 3], alpha: zero, error: zero, variance: zero, shade_variance: zero },
            color_change: zero,
            absorbed_before: zero,
        }
    }

    /// Puts a ray into a lane, before its first column, with the bases of the values and heights of the side's two
    /// cells. [`Self::load`] transfers numbers in f64 to the lanes.
    #[inline]
    pub fn put(&mut self, lane: usize, side: &Side, bases: [[u32; 2]; 2], entries: &mut Entries) {
        let Side { line, left, right, point, weight, height, .. } = side;
        let Plane { x, y, q } = line.plane;
        entries.0[lane % MOST] = [
            x.to_array(),
            y.to_array(),
            q.to_array(),
            [line.b, line.end, side.t],
            [left.x, left.y, left.q],
            [right.x, right.y, right.q],
            [point.x, point.y, *height],
            [weight[0], weight[1], 0.0],
        ];
        self.put_side(lane, side, bases);
    }

    /// Puts the ray of a lane before a later column, which it enters through `side`.
    #[inline]
    pub fn put_amid<L: Layers>(&mut self, lane: usize, side: &Side, bases: [[u32; 2]; 2]) {
        let Side { left, right, point, weight, .. } = side;
        for (row, number) in self.left.iter_mut().zip([left.x, left.y, left.q]) {
            row.set(lane, number);
        }
        for (row, number) in self.right.iter_mut().zip([right.x, right.y, right.q]) {
            row.set(lane, number);
        }
        self.point[0].set(lane, point.x);
        self.point[1].set(lane, point.y);
        self.t[1].set(lane, side.t);
        self.rho[1].set(lane, side.height);
        for (row, weight) in self.next_weights.iter_mut().zip(weight) {
            row[lane] = *weight as f32;
        }
        if L::HAS_SCENE {
            for (row, weight) in self.next_wide_weights.iter_mut().zip(weight) {
                row.set(lane, *weight);
            }
        }
        self.put_side(lane, side, bases);
    }

    /// Sets the side through which the next column is entered.
    #[inline]
    fn put_side(&mut self, lane: usize, side: &Side, [bases, heights]: [[u32; 2]; 2]) {
        self.half_edge[lane] = side.half_edge;
        // The step into the column keeps both ends of the side: the left one replaces itself.
        self.on_left.set(lane, true);
        (self.cells[1][lane], self.cells[2][lane]) = (side.right.cell, side.left.cell);
        (self.bases[1][lane], self.bases[2][lane]) = (bases[1], bases[0]);
        (self.heights[1][lane], self.heights[2][lane]) = (heights[1], heights[0]);
    }

    /// Loads the entries of the lanes of `new`, and clears their light.
    #[inline(always)]
    pub fn load<L: Layers>(&mut self, simd: V, entries: &Entries, new: Mask<V>) {
        let Some(table) = Table::new(entries.0.as_flattened()) else { return };
        let wide = wide_mask::<V>(new);
        let first = <Numbers<V> as SimdBase<V>>::from_fn(simd, |lane| 8 * lane as u32);
        for (k, row) in self.axes.iter_mut().enumerate() {
            put(row, wide, simd.gather_vector(table, first + k as u32));
        }
        let [b, end, start] = simd.gather_vector(table, first + 3);
        put(&mut self.left, wide, simd.gather_vector(table, first + 4));
        put(&mut self.right, wide, simd.gather_vector(table, first + 5));
        let [x, y, height] = simd.gather_vector(table, first + 6);
        let [first, second, _] = simd.gather_vector(table, first + 7);
        (self.b, self.end) = (b.over(wide, self.b), end.over(wide, self.end));
        (self.t[1], self.rho[1]) = (start.over(wide, self.t[1]), height.over(wide, self.rho[1]));
        put(&mut self.point, wide, [x, y]);
        for (row, weight) in self.next_weights.iter_mut().zip([first, second]) {
            *row = new.select(weight.narrow(), *row);
        }
        if L::HAS_SCENE {
            put(&mut self.next_wide_weights, wide, [first, second]);
        }
        let zero = all(simd, 0.0);
        let Radiance { color, alpha, error, variance, shade_variance } = &mut self.light;
        let numbers = [alpha, error, variance, shade_variance, &mut self.color_change, &mut self.absorbed_before];
        for row in numbers.into_iter().chain(color) {
            *row = new.select(zero, *row);
        }
    }

    /// Moves the lanes of `step` into their next columns: [`Walk::next_column`]. Returns the apexes of these columns.
    #[inline(always)]
    pub fn step<L: Layers>(&mut self, simd: V, mesh: &Mesh, step: Mask<V>) -> Numbers<V> {
        let wide = wide_mask::<V>(step);
        let apex = self.next_apexes(simd, mesh);
        let triangles = self.half_edge >> 2;
        let direction = simd.gather_vector(mesh.directions, apex);
        let seen = [dot(&direction, &self.axes[0]), dot(&direction, &self.axes[1]), dot(&direction, &self.axes[2])];
        let (zero, one) = (Wide::splat(simd, 0.0), Wide::splat(simd, 1.0));
        let on_left = seen[2].ge(zero);
        let [mut left, mut right] = [self.left, self.right];
        for k in 0..3 {
            left[k] = seen[k].over(on_left, left[k]);
            right[k] = right[k].over(on_left, seen[k]);
        }
        let w = left[2] / (left[2] - right[2]);
        let (x, y) = (left[0] + w * (right[0] - left[0]), left[1] + w * (right[1] - left[1]));
        let (b, end, entry) = (self.b, self.end, self.t[1]);
        let last = (b * y - end * x).ge(zero);
        // A NaN of 0/0 (a ray through the centre) becomes the distance of the entry.
        let t = (b * y / x).max(entry).min(end);
        let rho = (b * x + t * y) / (x * x + y * y);
        let weight = [w.over(on_left, zero), (one - w).over(on_left, w)];
        let mut exit = Exit { t, rho, weight: [weight[0].narrow(), weight[1].narrow()], wide_weight: weight };
        let is_last = last.narrow();
        if (is_last & step).any_true() {
            let place = [x, y];
            exit = exit.clipped::<L>(simd, self, place, last);
        }
        self.enter::<L>(step, wide, on_left.narrow(), apex, triangles);
        put(&mut self.left, wide, left);
        put(&mut self.right, wide, right);
        put(&mut self.point, wide, [x, y]);
        let [t, rho] = [exit.t, exit.rho];
        self.scale = (one / (rho - self.rho[0])).over(wide, self.scale);
        self.rising = step.select(self.rho[0].le(rho).narrow(), self.rising);
        self.t[1] = t.over(wide, self.t[1]);
        self.rho[1] = rho.over(wide, self.rho[1]);
        self.u = zero.over(wide, self.u);
        self.height = self.rho[0].over(wide, self.height);
        self.tau = step.select(all(simd, 0.0), self.tau);
        self.last = step.select(is_last, self.last);
        for k in 0..2 {
            self.weights[1][k] = step.select(exit.weight[k], self.weights[1][k]);
        }
        if L::HAS_SCENE {
            put(&mut self.wide_weights[1], wide, exit.wide_weight);
            put(&mut self.next_wide_weights, wide, [w, zero]);
        }
        self.next_weights[0] = step.select(w.narrow(), self.next_weights[0]);
        self.next_weights[1] = step.select(all(simd, 0.0), self.next_weights[1]);
        // Beyond the side opposite the vertex at which the half-edge begins, or else the one after it.
        let first = words_before::<V>(self.half_edge);
        let after = (self.half_edge & 2).simd_eq(number(simd, 0)).select(first + 1, first - 2);
        let next = simd.gather_u32(mesh.words, on_left.narrow().select(first, after));
        self.half_edge = step.select(next, self.half_edge);
        apex
    }

    /// The apexes of the columns behind those of the lanes.
    #[inline(always)]
    pub fn next_apexes(&self, simd: V, mesh: &Mesh) -> Numbers<V> {
        simd.gather_u32(mesh.words, words_before::<V>(self.half_edge) + 3)
    }

    /// Starts to fetch the half-edge through which a lane leaves its column.
    #[inline(always)]
    pub fn prefetch_half_edge(&self, mesh: &Mesh, lane: usize) {
        let half_edge = self.half_edge[lane];
        mesh.words.prefetch(half_edge + (half_edge >> 2 << 1));
    }

    /// The exit of the last column becomes the entry of the next, over the triangle with this apex.
    #[inline(always)]
    fn enter<L: Layers>(
        &mut self,
        step: Mask<V>,
        wide: WideMask<V>,
        on_left: Mask<V>,
        apex: Numbers<V>,
        triangles: Numbers<V>,
    ) {
        let replaced = [step & self.on_left, step & !self.on_left];
        for row in [&mut self.cells, &mut self.bases] {
            replace::<V>(replaced, row);
        }
        if L::HAS_HEIGHTS {
            replace::<V>(replaced, &mut self.heights);
        }
        self.cells[2] = step.select(apex, self.cells[2]);
        self.on_left = step.select(on_left, self.on_left);
        self.triangles = step.select(triangles, self.triangles);
        self.t[0] = self.t[1].over(wide, self.t[0]);
        self.rho[0] = self.rho[1].over(wide, self.rho[0]);
        for k in 0..2 {
            self.weights[0][k] = step.select(self.next_weights[k], self.weights[0][k]);
        }
        if L::HAS_SCENE {
            put(&mut self.wide_weights[0], wide, self.next_wide_weights);
        }
    }

    /// Puts the bases of the values and heights of new apexes into the lanes of `step`.
    #[inline(always)]
    pub fn put_bases<L: Layers>(&mut self, step: Mask<V>, bases: Numbers<V>, heights: Numbers<V>) {
        self.bases[2] = step.select(bases, self.bases[2]);
        if L::HAS_HEIGHTS {
            self.heights[2] = step.select(heights, self.heights[2]);
        }
    }
}

/// The number of words before that of half-edges in the records of [`HalfEdges`].
#[inline(always)]
fn words_before<V: Machine>(half_edges: Numbers<V>) -> Numbers<V> {
    half_edges + ((half_edges >> 2) << 1)
}

/// The points at which rays leave their columns.
struct Exit<V: Machine> {
    t: Wide<V>,
    rho: Wide<V>,
    weight: [Floats<V>; 2],
    wide_weight: [Wide<V>; 2],
}

impl<V: Machine> Exit<V> {
    /// The end of the ray in the lanes of `last`, whose columns end at `place` on the unit facets.
    #[inline(always)]
    fn clipped<L: Layers>(self, simd: V, lanes: &Lanes<V>, place: [Wide<V>; 2], last: WideMask<V>) -> Self {
        let (b, end) = (lanes.b, lanes.end);
        let across = |[x, y]: [Wide<V>; 2]| b * y - end * x;
        let [before, after] = [across(lanes.point), across(place)];
        let whole = before - after;
        let zero = Wide::splat(simd, 0.0);
        let w = (before / whole).fraction(simd).over(whole.lt(zero), zero);
        let [entry, exit] = [lanes.point, place];
        let [x, y] = [entry[0] + w * (exit[0] - entry[0]), entry[1] + w * (exit[1] - entry[1])];
        let rho = (b * x + end * y) / (x * x + y * y);
        let (is_last, part) = (last.narrow(), w.narrow());
        let mut weight = self.weight;
        for (weight, entry) in weight.iter_mut().zip(lanes.next_weights) {
            *weight = is_last.select(part.mul_add(*weight - entry, entry), *weight);
        }
        let mut wide_weight = self.wide_weight;
        if L::HAS_SCENE {
            for (weight, entry) in wide_weight.iter_mut().zip(lanes.next_wide_weights) {
                *weight = (entry + w * (*weight - entry)).over(last, *weight);
            }
        }
        Exit { t: end.over(last, self.t), rho: rho.over(last, self.rho), weight, wide_weight }
    }
}

#[inline(always)]
fn put<V: Machine, const N: usize>(rows: &mut [Wide<V>; N], mask: WideMask<V>, numbers: [Wide<V>; N]) {
    for k in 0..N {
        rows[k] = numbers[k].over(mask, rows[k]);
    }
}

/// Replaces the first item of a row by the third where `left` is set, and the second where `right` is.
#[inline(always)]
fn replace<V: Machine>([left, right]: [Mask<V>; 2], row: &mut [Numbers<V>; 3]) {
    row[0] = left.select(row[2], row[0]);
    row[1] = right.select(row[2], row[1]);
}

/// The scalar product, rounded as that of `glam`: all computations of a vertex's side agree.
#[inline(always)]
fn dot<V: Machine>(a: &[Wide<V>; 3], b: &[Wide<V>; 3]) -> Wide<V> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
