//! The positions of layers, and how the rays of a packet cross them: at one radius each, or at separate heights over
//! each cell.

use super::frame::PacketFrame;
use super::lanes::Lanes;
use super::read::{Course, Vertices};
use crate::lit::FrustumInterpolant;
use icoray_simd::{Floats, Machine, Mask, Numbers, Wide};

/// The points at which the lanes' rays leave their gaps.
pub(super) struct Crossing<V: Machine, E> {
    /// Whether they leave through a layer; the others leave their columns.
    pub passes: Mask<V>,
    /// The fraction of the column's length.
    pub u: Wide<V>,
    /// Relative change of the value's denominator, and length.
    pub eps: Floats<V>,
    pub length: Floats<V>,
    /// Further data of these layers.
    pub end: E,
}

/// A place at which a ray meets the core.
pub(super) struct CoreHit {
    /// The distance.
    pub t: f64,
    /// The fraction of the column's length; `None` below a void triangle, where the core is round.
    pub u: Option<f64>,
}

/// Interpolation of values at the vertices along the lanes' frusta.
pub(super) trait Way<V: Machine>: Copy {
    /// A number along each frustum, as a difference from that of the first vertex below.
    fn interpolate(&self, vertices: &Vertices<V>) -> Course<V>;
}

/// The layers of a scene, for the lanes of a packet.
pub(super) trait Layers: Copy {
    /// Whether [`Lanes::heights`] are needed.
    const HAS_HEIGHTS: bool;
    /// Whether rays may meet more than one volume and the core ([`super::scene`]): then [`Lanes::wide_weights`] are
    /// needed.
    const HAS_SCENE: bool;
    /// Data of the points at which lanes leave their gaps.
    type End<V: Machine>: Copy;
    type Way<V: Machine>: Way<V>;

    /// Offsets of the heights of cells, for the lanes whose bits are set.
    fn bases<V: Machine>(&self, simd: V, cells: Numbers<V>, bits: u32) -> Numbers<V>;

    /// [`Self::bases`] of one cell.
    fn base(&self, cell: u32) -> u32;

    /// Sets the gap of a lane whose ray is at this height between two columns, before the column is entered.
    fn locate<V: Machine>(&self, lanes: &mut Lanes<V>, lane: usize, height: f64);

    /// Lets lanes enter their columns.
    fn enter<V: Machine>(&self, simd: V, lanes: &mut Lanes<V>, entered: u32);

    /// The crossings of the gaps: equal for each turn that a lane stays in its gap.
    fn cross<V: Machine>(&self, simd: V, lanes: &Lanes<V>) -> Crossing<V, Self::End<V>>;

    /// Lanes that leave their gaps upwards, of those that leave them through a layer.
    fn rising<V: Machine>(lanes: &Lanes<V>, crossing: &Crossing<V, Self::End<V>>) -> Mask<V>;

    /// The lanes' interpolation in their gaps.
    fn way<V: Machine>(lanes: &Lanes<V>, crossing: &Crossing<V, Self::End<V>>) -> Self::Way<V>;

    /// Moves the lanes of `passing` into the gaps ahead, and those of `leaving` to the exits of their columns.
    fn pass<V: Machine>(
        &self,
        simd: V,
        lanes: &mut Lanes<V>,
        crossing: &Crossing<V, Self::End<V>>,
        passing: Mask<V>,
        leaving: Mask<V>,
    );

    /// The gaps at the exits of the columns of `active` lanes, and the fractions of the way from the layers below to
    /// those above, if they are needed.
    fn exits<V: Machine>(&self, simd: V, lanes: &Lanes<V>, active: Mask<V>) -> (Numbers<V>, Option<Floats<V>>);

    /// Moves a lane from an invisible gap to the next visible one in its column, to the space below or above all
    /// layers, or to the column's exit: then it returns true. `blocks` are the visible ones, each of `1 << shift` gaps.
    fn skip<V: Machine>(&self, lanes: &mut Lanes<V>, lane: usize, blocks: u32, shift: u32) -> bool;

    /// Value, and gradient where `N` is 4, along the frustum of a lane, in scalar code; `None` if
    /// [`Self::HAS_SCENE`], where single rays pass such frusta.
    fn interpolant<V: Machine, const N: usize>(
        _: &Lanes<V>,
        _: usize,
        _: &PacketFrame<'_>,
        _: &Crossing<V, Self::End<V>>,
    ) -> Option<FrustumInterpolant<f32, N>> {
        None
    }
}

/// The next gap upwards or downwards from `gap` in which these `blocks` of 2^`shift` gaps are visible, or the space
/// beyond all layers, and the layer through which it is entered.
#[inline]
pub(super) fn next_shown(blocks: u32, shift: u32, gap: u32, is_rising: bool, layers: usize) -> (usize, usize) {
    let block = (gap - 1) >> shift;
    if is_rising {
        let above = blocks & u32::MAX.checked_shl(block + 1).unwrap_or(0);
        let gap = if above == 0 { layers } else { ((above.trailing_zeros() << shift) + 1) as usize };
        (gap.min(layers), gap.min(layers) - 1)
    } else {
        let below = blocks & ((1 << block) - 1);
        let gap = (u32::BITS - below.leading_zeros()) << shift;
        (gap as usize, gap as usize)
    }
}
