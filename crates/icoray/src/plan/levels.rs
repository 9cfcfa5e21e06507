//! Checks that the layers that a scene names exist.

use icoray_grid::{Error, ErrorKind, Result};
use icoray_scene::{Level, Scene};

/// Checks them against the first field's number of layers.
pub(super) fn check(scene: &Scene, layers: usize) -> Result<()> {
    let scenery = &scene.scenery;
    let of_level = |key, level: &Level| match level {
        Level::Layer(layer) => Some((key, *layer)),
        Level::Ground | Level::Top | Level::Height(_) => None,
    };
    let surfaces = scenery.surfaces.iter().filter_map(|surface| of_level("surfaces.layer", &surface.at));
    let lines = scenery.lines.iter().filter_map(|lines| of_level("lines.on", &lines.on));
    let clips = scenery.clips.iter().filter_map(|clip| Some(("clip.layers", clip.layers?[1])));
    match surfaces.chain(lines).chain(clips).find(|(_, layer)| *layer >= layers) {
        None => Ok(()),
        Some((key, layer)) => {
            let (last, field) = (layers - 1, scene.field());
            let message = format!("key {key}: layer {layer}, expected 0 to {last}, as {field:?} has {layers} layers");
            Err(Error::new(ErrorKind::Scene, message))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_are_those_of_the_field() {
        let surface = "[[surfaces]]\ncolor = \"red\"\nlayer = ";
        let lines = "[[lines]]\npattern = \"cells\"\non = ";
        let clip = "[[lines]]\npattern = \"coast\"\n[[clip]]\ncut = \"inside\"\nlayers = ";
        let scene = |text: &str| Scene::parse(&format!("field = 'q'\n{text}")).unwrap();
        for (text, key) in [
            (format!("{surface}9"), "surfaces.layer"),
            (format!("{lines}9"), "lines.on"),
            (format!("{clip}[2, 9]"), "clip.layers"),
        ] {
            check(&scene(&text), 10).unwrap();
            let error = check(&scene(&text), 9).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::Scene);
            let words = format!("key {key}: layer 9, expected 0 to 8, as \"q\" has 9 layers");
            assert_eq!(error.context(), words);
        }
        for word in ["\"top\"", "\"bottom\""] {
            check(&scene(&format!("{surface}{word}\n{lines}{word}")), 2).unwrap();
        }
    }
}
