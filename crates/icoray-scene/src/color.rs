//! Colours: CSS names and codes, named colour maps, sRGB and linear light.

use colorgrad::{Gradient, preset};
use std::sync::LazyLock;

/// Steps of a map that is a formula, some of which are its stops.
const STEPS: usize = 256;
/// Largest difference, in linear light and in sRGB, between a map and the lines between its stops.
const NEAR: f64 = 2.0 / 255.0;

/// Maps that others made, as stops, which `data/maps.py` writes by the rule of [`stops`].
const TABLE: &str = include_str!("../data/maps.txt");

/// Linear RGB of a CSS colour, `None` when it is none or not opaque.
pub(super) fn css(text: &str) -> Option<[f64; 3]> {
    let color: colorgrad::Color = text.parse().ok()?;
    (color.a == 1.0).then(|| linear(&color))
}

fn linear(color: &colorgrad::Color) -> [f64; 3] {
    let [r, g, b, _] = color.to_linear_rgba();
    [r, g, b].map(|c| f64::from(c).clamp(0.0, 1.0))
}

/// A linear colour, 0 to 1, in 8-bit sRGB.
pub fn srgb8(linear: [f64; 3]) -> [u8; 3] {
    let [r, g, b] = linear.map(|c| c as f32);
    let [r, g, b, _] = colorgrad::Color::from_linear_rgba(r, g, b, 1.0).to_rgba8();
    [r, g, b]
}

/// A map that colorgrad has, by name.
type Formula = (&'static str, fn() -> Box<dyn Gradient>);

macro_rules! formulas {
    ($($name:literal $preset:ident,)*) => {
        [$(($name, || Box::new(preset::$preset())),)*]
    };
}

const FORMULAS: [Formula; 35] = formulas![
    "blues" blues, "brbg" br_bg, "bugn" bu_gn, "bupu" bu_pu, "cividis" cividis, "cubehelix_default" cubehelix_default,
    "gnbu" gn_bu, "greens" greens, "greys" greys, "inferno" inferno, "magma" magma, "oranges" oranges, "orrd" or_rd,
    "piyg" pi_yg, "plasma" plasma, "prgn" pr_gn, "pubu" pu_bu, "pubugn" pu_bu_gn, "puor" pu_or, "purd" pu_rd,
    "purples" purples, "rdbu" rd_bu, "rdgy" rd_gy, "rdpu" rd_pu, "rdylbu" rd_yl_bu, "rdylgn" rd_yl_gn, "reds" reds,
    "spectral" spectral, "turbo" turbo, "viridis" viridis, "warm" warm, "ylgn" yl_gn, "ylgnbu" yl_gn_bu,
    "ylorbr" yl_or_br, "ylorrd" yl_or_rd,
];

/// A colour map: linear RGB at stops from 0 to 1, linear in between.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ColorMap {
    /// Places and colours; rising, the first at 0, the last at 1.
    stops: Vec<(f64, [f64; 3])>,
}

impl ColorMap {
    /// The map of this name, in any case; `_r` at the end reverses it.
    pub fn named(name: &str) -> Option<Self> {
        let name = name.to_ascii_lowercase();
        if let Some(forward) = name.strip_suffix("_r") {
            return Self::named(forward).map(Self::reversed);
        }
        let formula = FORMULAS.iter().find(|(known, _)| *known == name);
        let stops = match formula {
            Some((_, gradient)) => stops(&*gradient()),
            None => table().find(|(known, _)| *known == name)?.1.split(' ').map_while(stop).collect(),
        };
        Some(ColorMap { stops })
    }

    /// The other way round.
    pub fn reversed(mut self) -> Self {
        self.stops.reverse();
        self.stops.iter_mut().for_each(|(place, _)| *place = 1.0 - *place);
        self
    }

    /// The stops' places, rising from 0 to 1.
    pub fn places(&self) -> impl Iterator<Item = f64> {
        self.stops.iter().map(|(place, _)| *place)
    }

    /// Linear RGB at a place, the first or last one's outside.
    pub fn at(&self, place: f64) -> [f64; 3] {
        let place = place.clamp(0.0, 1.0);
        let above = self.stops.partition_point(|(stop, _)| *stop <= place);
        let low = above.saturating_sub(1).min(self.stops.len() - 2);
        let ((from, low), (to, high)) = (self.stops[low], self.stops[low + 1]);
        let w = (place - from) / (to - from);
        std::array::from_fn(|k| low[k] + w * (high[k] - low[k]))
    }
}

/// Few of a gradient's [`STEPS`], between which lines in linear light are [`NEAR`] all others: from the start on, each
/// line is as long as it can be.
fn stops(gradient: &dyn Gradient) -> Vec<(f64, [f64; 3])> {
    let colors: Vec<_> = (0..=STEPS).map(|i| gradient.at(i as f32 / STEPS as f32)).collect();
    let light: Vec<[f64; 3]> = colors.iter().map(linear).collect();
    let is_near = |first: usize, last: usize| {
        (first + 1..last).all(|i| {
            let w = (i - first) as f64 / (last - first) as f64;
            let line: [f64; 3] = std::array::from_fn(|k| light[first][k] + w * (light[last][k] - light[first][k]));
            let [r, g, b] = line.map(|c| c as f32);
            let [r, g, b, _] = colorgrad::Color::from_linear_rgba(r, g, b, 1.0).to_array();
            let srgb = [r - colors[i].r, g - colors[i].g, b - colors[i].b];
            line.iter().zip(light[i]).all(|(a, b)| (a - b).abs() <= NEAR)
                && srgb.iter().all(|off| off.abs() <= NEAR as f32)
        })
    };
    let stop = |i: usize| (i as f64 / STEPS as f64, light[i]);
    let (mut stops, mut last) = (vec![stop(0)], 0);
    while last < STEPS {
        let first = last;
        last = (first + 2..=STEPS).take_while(|last| is_near(first, *last)).last().unwrap_or(first + 1);
        stops.push(stop(last));
    }
    stops
}

/// Names and stops of the table's maps.
fn table() -> impl Iterator<Item = (&'static str, &'static str)> {
    TABLE.lines().filter(|line| !line.starts_with('#')).filter_map(|line| line.split_once(' '))
}

/// A stop of the table: the entry's number of 256, and its colour.
fn stop(text: &str) -> Option<(f64, [f64; 3])> {
    let (entry, color) = text.split_once(':')?;
    Some((entry.parse::<f64>().ok()? / 255.0, css(&format!("#{color}"))?))
}

/// Whether there is a colour map of this name.
pub fn is_color_map(name: &str) -> bool {
    ColorMap::named(name).is_some()
}

/// The colours of a map at `count` places from its beginning to its end, at least two, in 8-bit sRGB.
pub fn color_map_stops(name: &str, count: usize) -> Option<Vec<[u8; 3]>> {
    let map = ColorMap::named(name)?;
    let last = count.max(2) - 1;
    Some((0..=last).map(|k| srgb8(map.at(k as f64 / last as f64))).collect())
}

/// Names of the colour maps.
pub fn color_maps() -> &'static str {
    &MAPS
}

static MAPS: LazyLock<String> = LazyLock::new(|| {
    let mut names: Vec<_> = FORMULAS.iter().map(|(name, _)| *name).chain(table().map(|(name, _)| name)).collect();
    names.sort_unstable();
    names.join(", ")
});

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_are_linear_light() {
        assert_eq!(css("#ffffff"), Some([1.0; 3]));
        assert!((css("#808080").unwrap()[0] - 0.2159).abs() < 1e-3);
        assert_eq!(css("rgb(0 0 0 / 50%)"), None);
        assert_eq!(css("no colour"), None);
    }

    #[test]
    fn every_listed_map_is_whole() {
        let names: Vec<&str> = MAPS.split(", ").collect();
        assert!(names.len() == FORMULAS.len() + 73 && names.is_sorted_by(|a, b| a < b), "{names:?}");
        for name in names {
            let map = ColorMap::named(name).unwrap();
            let places: Vec<f64> = map.places().collect();
            assert!(places.is_sorted_by(|a, b| a < b) && (places[0], places[places.len() - 1]) == (0.0, 1.0), "{name}");
            assert!(places.len() > 5, "{name}");
        }
        assert!(ColorMap::named("jet2").is_none() && ColorMap::named("viridis_r_").is_none());
    }

    #[test]
    fn maps_have_the_colours_that_their_makers_gave_them() {
        for (name, place, color) in [
            ("viridis", 0.0, "#440154"),
            ("thermal", 1.0, "#e8fa5b"),
            ("batlow", 0.0, "#011959"),
            ("vik", 0.0, "#001261"),
            ("coolwarm", 1.0, "#b40426"),
        ] {
            let (found, expected) = (ColorMap::named(name).unwrap().at(place), css(color).unwrap());
            assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 0.01), "{name}: {found:?}, {expected:?}");
        }
    }

    #[test]
    fn formulas_have_few_stops_near_their_gradients() {
        for (name, gradient) in FORMULAS {
            let (map, gradient) = (ColorMap::named(name).unwrap(), gradient());
            assert!(map.stops.len() <= 31, "{name}: {} stops", map.stops.len());
            for place in (0..=1000).map(|i| f64::from(i) / 1000.0) {
                let (found, [r, g, b, _]) = (map.at(place), gradient.at(place as f32).to_linear_rgba());
                let off = found.iter().zip([r, g, b]).map(|(a, b)| (a - f64::from(b.clamp(0.0, 1.0))).abs());
                // Turbo is rounded to 8 bits.
                assert!(off.fold(0.0, f64::max) < 1.5 * NEAR, "{name} at {place}");
            }
        }
    }

    #[test]
    fn a_name_may_turn_a_map_round() {
        let [map, turned] = ["Viridis", "viridis_R"].map(|name| ColorMap::named(name).unwrap());
        assert_eq!(turned, map.clone().reversed());
        for place in [-1.0, 0.0, 0.1, 0.5, 0.7, 2.0] {
            let (one, other) = (map.at(place), turned.at(1.0 - place));
            assert!((0..3).all(|k| (one[k] - other[k]).abs() < 1e-12));
        }
        assert_eq!(ColorMap::named("viridis_r_r").unwrap(), map);
    }
}
