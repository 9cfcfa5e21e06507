//! Options for the scene: a scene file, or settings of a suggested scene.

use icoray::{Level, suggest};
use std::path::PathBuf;

/// The scene file, or settings of a suggested scene.
#[derive(clap::Args)]
pub struct SceneOptions {
    /// The scene file; without it a scene is suggested for one field of the file
    #[arg(long, value_name = "SCENE.toml")]
    pub scene: Option<PathBuf>,
    /// Field to draw, instead of the first one that looks like a physical field (no heights or other variables of the
    /// grid; those that have layers first, then those that change with time). A 2D field is drawn as a surface.
    /// With --scene the field is shown in its own look; camera, picture and output are those of the scene
    #[arg(long, value_name = "NAME")]
    pub field: Option<String>,
    /// Colour map, such as viridis, vik or rdylbu_r (_r is the other way round)
    #[arg(long, alias = "cmap", value_name = "NAME", conflicts_with = "scene", value_parser = color_map)]
    pub colormap: Option<String>,
    /// Values at the ends of the colour map, such as -7e-5..7e-5; opacities stretch with it
    #[arg(long, value_name = "A..B", conflicts_with = "scene", allow_hyphen_values = true, value_parser = range)]
    pub range: Option<[f64; 2]>,
    /// Draw the values of one layer as a surface instead of a volume: a number from 0, the innermost, or "top" or
    /// "bottom"
    #[arg(long, value_name = "LAYER", conflicts_with = "scene", allow_hyphen_values = true, value_parser = level)]
    pub surface: Option<Level>,
    /// Draw the surface on which the field has this value instead of a volume
    #[arg(long, value_name = "VALUE", conflicts_with_all = ["scene", "surface", "range", "colormap"],
        allow_hyphen_values = true)]
    pub isosurface: Option<f64>,
    /// Write the suggested scene, with comments, to this file: with --scene it draws the same picture
    #[arg(long, value_name = "SCENE.toml", conflicts_with = "scene")]
    pub save_scene: Option<PathBuf>,
}

type Parsed<T> = Result<T, String>;

fn color_map(text: &str) -> Parsed<String> {
    suggest::check_color_map(text).map(|()| text.to_owned()).map_err(|e| e.context().to_owned())
}

fn range(text: &str) -> Parsed<[f64; 2]> {
    let number = |text: &str| text.parse().ok().filter(|number: &f64| number.is_finite());
    let ends = text.split_once("..").and_then(|(low, high)| Some([number(low)?, number(high)?]));
    ends.filter(|[low, high]| low < high)
        .ok_or_else(|| "expected two numbers, the lower first, such as -7e-5..7e-5".to_owned())
}

fn level(text: &str) -> Parsed<Level> {
    match text {
        "top" => Ok(Level::Top),
        "bottom" => Ok(Level::Layer(0)),
        number => number
            .parse()
            .map(Level::Layer)
            .map_err(|_| "expected the number of a layer from 0, the innermost, or \"top\" or \"bottom\"".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_have_two_ends_that_rise() {
        for (text, expected) in [
            ("-7e-5..7e-5", Some([-7e-5, 7e-5])),
            ("0.5..1.5", Some([0.5, 1.5])),
            ("270..", None),
            ("2..1", None),
            ("1..1", None),
            ("nan..1", None),
            ("1,2", None),
        ] {
            assert_eq!(range(text).ok(), expected, "{text}");
        }
    }

    #[test]
    fn levels_are_numbers_or_words() {
        assert_eq!(level("top"), Ok(Level::Top));
        assert_eq!(level("bottom"), level("0"));
        assert_eq!(level("12"), Ok(Level::Layer(12)));
        assert!(level("-1").unwrap_err().contains("from 0"));
    }
}
