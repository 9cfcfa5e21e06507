//! Layers at heights of their own in each column: ground without cracks, and equal heights. Random scenes have mountains.

use icoray::{Heights, Scene};

use crate::common::{LIT, count_beyond, over_columns, rays};
use crate::packets::{TOP, scene, waves};

const LAYERS: usize = 6;

/// A square picture from afar.
fn square(side: u32, keys: &str, light: &str) -> Scene {
    let contents = "[[volumes]]\nfield = \"f\"\ntransfer = { map = \"viridis\", range = [-0.6, 0.6], \
        opacity = [[-0.6, 0.9], [-0.2, 0.6], [0.0, 0.0], [0.15, 0.0], [0.25, 0.8]] }\n";
    let camera = "lon = 20\nlat = 35\ndistance = 3.4\nfov = 45";
    Scene { width: side, height: side, ..scene(contents, &format!("tolerance = 1e-4\n{keys}"), camera, light) }
}

#[test]
fn steep_ground_has_no_cracks() {
    let terrain = waves(4, LAYERS);
    for light in ["", LIT] {
        let scene = square(240, "core = \"#ffffff\"", light);
        let frame = terrain.draw(&scene);
        let mut within = 0;
        for (i, ((eye, dir), pixel)) in rays(&scene).zip(&frame.pixels).enumerate() {
            let nearest = (eye - eye.dot(dir) * dir).length();
            // Facets between vertices on the sphere lie a little inside.
            if nearest < 0.995 {
                within += 1;
                assert!((pixel[3] - 1.0).abs() < 1e-6, "pixel {i}: {pixel:?}");
            }
            assert!(pixel.iter().all(|c| c.is_finite()), "pixel {i}: {pixel:?}");
        }
        assert!(within > 10_000, "{within}");
    }
}

#[test]
fn equal_heights_are_concentric_layers() {
    let mut terrain = waves(3, LAYERS);
    terrain.heights = over_columns(terrain.grid.cells(), LAYERS, |_, layer| TOP * layer as f64 / (LAYERS - 1) as f64);
    for light in ["", LIT] {
        let native = square(64, "precision = \"f64\"", light);
        let mut mean = native.clone();
        mean.scenery.heights = Heights::Mean;
        let (a, b) = (terrain.draw(&native), terrain.draw(&mean));
        // Normals of the ground are means of facets', which are not quite round.
        let slack = if native.lighting.is_some() { 5e-4 } else { 1e-5 };
        let wrong = count_beyond(&a, &b, slack);
        let few = if native.lighting.is_some() { 5 } else { 0 };
        assert!(wrong <= few, "{light}: {wrong} pixels");
    }
}
