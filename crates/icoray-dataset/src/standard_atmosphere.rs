//! Heights of pressures in the International Standard Atmosphere (ISO 2533:1975; U.S. Standard Atmosphere 1976, which
//! is identical up to 86 km).

/// Earth's radius for geopotential heights, metres.
const RADIUS_M: f64 = 6_356_766.0;
/// `g0 M / R`, kelvin per metre of geopotential height.
const GMR: f64 = 0.034_163_194_7;
/// Layers: geopotential height of the base in metres, temperature there in kelvin, its slope in kelvin per metre.
const LAYERS: [(f64, f64, f64); 7] = [
    (0.0, 288.15, -0.0065),
    (11e3, 216.65, 0.0),
    (20e3, 216.65, 0.001),
    (32e3, 228.65, 0.0028),
    (47e3, 270.65, 0.0),
    (51e3, 270.65, -0.0028),
    (71e3, 214.65, -0.002),
];

/// Height above the sea in metres at which the standard atmosphere has a pressure of `pressure_pa` pascals; the lowest
/// and the uppermost layer extend beyond their ends.
pub(crate) fn height_m(pressure_pa: f64) -> f64 {
    let mut base_pa = 101_325.0;
    let mut geopotential_m = 0.0;
    for (i, &(base_m, base_k, slope)) in LAYERS.iter().enumerate() {
        geopotential_m = base_m
            + if slope == 0.0 {
                base_k / GMR * (base_pa / pressure_pa).ln()
            } else {
                base_k / slope * ((base_pa / pressure_pa).powf(slope / GMR) - 1.0)
            };
        let Some(&(top_m, top_k, _)) = LAYERS.get(i + 1) else { break };
        if geopotential_m <= top_m {
            break;
        }
        base_pa *=
            if slope == 0.0 { (-GMR * (top_m - base_m) / base_k).exp() } else { (base_k / top_k).powf(GMR / slope) };
    }
    RADIUS_M * geopotential_m / (RADIUS_M - geopotential_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table IV of U.S. Standard Atmosphere 1976: geometric heights and pressures, which it gives to five digits.
    #[test]
    fn heights_are_those_of_the_table() {
        for (height, pressure) in [
            (-500.0, 107_477.0),
            (0.0, 101_325.0),
            (5_000.0, 54_048.0),
            (11_000.0, 22_700.0),
            (20_000.0, 5_529.3),
            (30_000.0, 1_197.0),
            (50_000.0, 79.779),
            (70_000.0, 5.220_9),
        ] {
            assert!((height_m(pressure) - height).abs() < 1.0, "{pressure} Pa: {} m", height_m(pressure));
        }
    }

    #[test]
    fn heights_fall_as_pressures_rise() {
        let heights: Vec<f64> = (0..4000).map(|i| height_m(1e-2 * 1.005f64.powi(i))).collect();
        assert!(heights.windows(2).all(|pair| pair[1] < pair[0]));
    }
}
