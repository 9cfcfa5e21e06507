//! Colours: CSS names and codes, named colour maps, sRGB and linear light.

use colorgrad::{Gradient, preset};

/// Linear RGB of a CSS colour, `None` when it is none or not opaque.
pub(super) fn css(text: &str) -> Option<[f64; 3]> {
    let color: colorgrad::Color = text.parse().ok()?;
    (color.a == 1.0).then(|| linear(&color))
}

fn linear(color: &colorgrad::Color) -> [f64; 3] {
    let [r, g, b, _] = color.to_linear_rgba();
    [r, g, b].map(|c| f64::from(c).clamp(0.0, 1.0))
}

/// Names of the colour maps.
pub(super) const MAPS: [&str; 14] = [
    "blues", "cividis", "greys", "greens", "inferno", "magma", "plasma", "rdbu", "rdylbu", "spectral",
    "turbo", "viridis", "ylgnbu", "ylorrd",
];

/// `count` + 1 linear colours at equal steps of the named map.
pub(super) fn map(name: &str, count: usize) -> Option<Vec<[f64; 3]>> {
    let gradient: Box<dyn Gradient> = match name {
        "blues" => Box::new(preset::blues()),
        "cividis" => Box::new(preset::cividis()),
        "greys" => Box::new(preset::greys()),
        "greens" => Box::new(preset::greens()),
        "inferno" => Box::new(preset::inferno()),
        "magma" => Box::new(preset::magma()),
        "plasma" => Box::new(preset::plasma()),
        "rdbu" => Box::new(preset::rd_bu()),
        "rdylbu" => Box::new(preset::rd_yl_bu()),
        "spectral" => Box::new(preset::spectral()),
        "turbo" => Box::new(preset::turbo()),
        "viridis" => Box::new(preset::viridis()),
        "ylgnbu" => Box::new(preset::yl_gn_bu()),
        "ylorrd" => Box::new(preset::yl_or_rd()),
        _ => return None,
    };
    Some((0..=count).map(|i| linear(&gradient.at(i as f32 / count as f32))).collect())
}

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
    fn every_listed_map_exists() {
        for name in MAPS {
            assert_eq!(map(name, 8).unwrap().len(), 9, "{name}");
        }
        assert!(map("jet2", 8).is_none());
    }
}
