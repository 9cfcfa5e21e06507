//! How a colour map runs along values: evenly, by powers of ten, or by powers of ten to both sides of 0.

/// Along what colours are even.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Scale {
    /// The value.
    #[default]
    Linear,
    /// The logarithm of the value, which is positive.
    Log,
    /// The value up to `threshold` on either side of 0, its logarithm beyond; what lies within the threshold takes as
    /// much room on each side as a power of ten.
    SymLog {
        /// Where the logarithm begins, above 0.
        threshold: f64,
    },
}

impl Scale {
    /// Whether a value has a place on the scale.
    pub fn admits(&self, value: f64) -> bool {
        value.is_finite() && (*self != Scale::Log || value > 0.0)
    }

    /// Where a value stands: even steps of this are even steps of colour.
    pub fn forward(&self, value: f64) -> f64 {
        match *self {
            Scale::Linear => value,
            Scale::Log => value.log10(),
            Scale::SymLog { threshold } => {
                let times = value / threshold;
                if times.abs() <= 1.0 { times } else { (1.0 + times.abs().log10()).copysign(times) }
            }
        }
    }

    /// The value that stands at a place.
    pub fn backward(&self, place: f64) -> f64 {
        match *self {
            Scale::Linear => place,
            Scale::Log => 10f64.powf(place),
            Scale::SymLog { threshold } => {
                if place.abs() <= 1.0 {
                    place * threshold
                } else {
                    10f64.powf(place.abs() - 1.0).copysign(place) * threshold
                }
            }
        }
    }

    /// In a word, and the threshold.
    pub(crate) fn describe(&self) -> String {
        match self {
            Scale::Linear => "linear".into(),
            Scale::Log => "log".into(),
            Scale::SymLog { threshold } => format!("symlog beyond {threshold}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_lead_back_to_values_and_rise_with_them() {
        let values = [-2e5, -1.0, -1e-3, -2e-4, 0.0, 3e-9, 5e-4, 1e-3, 0.7, 1.0, 4e7];
        for scale in [Scale::Linear, Scale::Log, Scale::SymLog { threshold: 1e-3 }] {
            let admitted: Vec<f64> = values.into_iter().filter(|v| scale.admits(*v)).collect();
            let places: Vec<f64> = admitted.iter().map(|v| scale.forward(*v)).collect();
            assert!(places.is_sorted_by(|a, b| a < b), "{scale:?}: {places:?}");
            for (value, place) in admitted.iter().zip(places) {
                assert!((scale.backward(place) - value).abs() <= 1e-13 * value.abs(), "{scale:?}: {value}");
            }
        }
        assert_eq!(Scale::SymLog { threshold: 0.1 }.forward(-10.0), -3.0);
        assert!(!Scale::Log.admits(0.0) && !Scale::Linear.admits(f64::NAN));
    }
}
