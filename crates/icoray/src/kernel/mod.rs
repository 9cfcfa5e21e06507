//! The ray caster's inner loop, one file per idea, in the order in which a ray meets them:
//!
//! [`plane`] the ray's own plane → [`walk`] from triangle to triangle along the great circle below the ray → [`column`]
//! from layer to layer inside one triangle → [`segment`] the scalar along one frustum, its extremum and its knots →
//! [`piece`] the integral of one monotone piece → [`ray`] all of it for one pixel.
//!
//! Geometry is in f64 up to a column's ends (positions on a real Earth need it); everything from the column's ends on is
//! generic over [`Real`], so that f32 meets only numbers of order one: fractions, normalised values, lengths.

pub(crate) mod column;
mod doubt;
pub(crate) mod general;
pub(crate) mod leap;
pub(crate) mod lit;
pub(crate) mod piece;
pub(crate) mod plane;
pub(crate) mod ray;
pub(crate) mod real;
pub(crate) mod sample;
pub(crate) mod segment;
pub(crate) mod shade;
pub(crate) mod signature;
pub(crate) mod transfer;
pub(crate) mod walk;

pub(crate) use real::Real;
