//! Frusta of a batch under light: gradients along them. Their rays shade them, one by one.

use super::rows::{Rows, no_interpolants};
use super::{Batch, LaneStatus, PASSES};
use crate::lit::FrustumInterpolant;
use crate::single_volume::SingleVolumeTracer;
use crate::walk::packet::{LANES, Lanes};
use icoray_grid::real::Real;

/// Gradients of the frusta of a batch.
#[derive(Debug)]
pub(super) struct Lights<T> {
    /// The gradient along each frustum that is usual and not clear.
    interpolants: [FrustumInterpolant<Lanes<T>, 3>; PASSES],
}

/// A gradient of each frustum.
type Vectors<T> = [Lanes<T>; 3];

impl<T: Real, const N: usize> Batch<T, N> {
    /// Value, and gradient with lighting, along frustum `i` of a pass, which is usual and not clear.
    #[inline]
    pub fn complete_interpolant(&self, pass: usize, i: usize) -> FrustumInterpolant<T, N> {
        let piece = self.segments[pass].at(i);
        let interpolants = self.lights.as_ref().map(|lights| &lights.interpolants[pass]);
        let of = |value: T, gradient: Option<&Vectors<T>>| {
            let mut values = [value; N];
            if let Some(gradient) = gradient {
                for (k, value) in values.iter_mut().enumerate().skip(1) {
                    *value = gradient[(k - 1) % 3][i];
                }
            }
            values
        };
        FrustumInterpolant {
            from: of(piece.f0, interpolants.map(|interpolants| &interpolants.from)),
            to: of(piece.f1, interpolants.map(|interpolants| &interpolants.to)),
            kappa: of(piece.kappa, interpolants.map(|interpolants| &interpolants.kappa)),
            eps: piece.eps,
        }
    }

    /// Stores the gradients of a pass, whose light is left to its rays.
    #[inline(always)]
    pub(super) fn shade(&mut self, pass: usize, tracer: &SingleVolumeTracer<'_, T>) {
        let interpolants = self.interpolants(pass, &self.gradients(pass, tracer));
        let none = || Box::new(Lights { interpolants: [no_interpolants(); PASSES] });
        self.lights.get_or_insert_with(none).interpolants[pass] = interpolants;
        for known in &mut self.known[pass] {
            *known = if *known == LaneStatus::Light { LaneStatus::Scalar } else { *known };
        }
    }

    /// The gradients at the six vertices, of the frusta that are usual and not clear.
    #[inline(always)]
    fn gradients(&self, pass: usize, tracer: &SingleVolumeTracer<'_, T>) -> [Vectors<T>; 6] {
        let layers = tracer.shell.layers();
        let mut gradients = [[[T::zero(); LANES]; 3]; 6];
        for i in 0..LANES {
            let is_read = self.is_usual[pass][i] & (self.known[pass][i] != LaneStatus::Clear);
            if !is_read | (pass * LANES + i >= self.count) {
                continue;
            }
            let (cells, [behind, ahead]) = (self.cells[pass][i], self.layers[pass][i]);
            for k in 0..6 {
                let layer = if k < 3 { behind } else { ahead };
                let gradient = tracer.gradients.at(cells[k % 3] as usize * layers + layer as usize);
                for (rows, x) in gradients[k].iter_mut().zip(gradient) {
                    rows[i] = T::of(f64::from(x));
                }
            }
        }
        gradients
    }

    /// The gradient along each frustum of a pass.
    #[inline(always)]
    fn interpolants(&self, pass: usize, gradients: &[Vectors<T>; 6]) -> FrustumInterpolant<Lanes<T>, 3> {
        let crossings = self.crossing.map(|rows| &rows[pass]);
        let mut interpolants = no_interpolants();
        for k in 0..3 {
            for i in 0..LANES {
                let at = |vertex: usize| [gradients[vertex][k][i]];
                let interpolant = crossings.map(|row| row[i]).interpolant([at(0), at(1), at(2)], [at(3), at(4), at(5)]);
                interpolants.from[k][i] = interpolant.from[0];
                interpolants.to[k][i] = interpolant.to[0];
                interpolants.kappa[k][i] = interpolant.kappa[0];
            }
        }
        interpolants.eps = *crossings.eps;
        interpolants
    }
}
