//! Layers at heights of their own in each column, against brute force: points along rays, each looked up by its
//! definition.

use glam::{DMat3, DVec3};
use icoray::{Heights, Scene};

use crate::common::{LIT, Model, count_beyond, over_columns, rays};
use crate::packets::{EARTH_M, EXAGGERATION, TOP, scene, waves};

const LAYERS: usize = 6;

impl Model {
    /// The value at a point, or nothing above all layers; `None` on or below the ground.
    fn look_up(&self, inverses: &[DMat3], at: DVec3, hint: &mut usize) -> Option<Option<f64>> {
        let alpha = |triangle: usize| inverses[triangle] * at;
        let holds = |triangle: usize| alpha(triangle).min_element() >= 0.0;
        if !holds(*hint) {
            // On a side rounding may leave a point in neither triangle: that in which it is least outside.
            let outside = |t: &usize| alpha(*t).min_element();
            *hint = (0..inverses.len()).max_by(|a, b| outside(a).total_cmp(&outside(b))).unwrap();
        }
        let alpha = alpha(*hint).max(DVec3::ZERO).to_array();
        let cells = self.grid.triangle(*hint as u32).map(|cell| cell as usize);
        let radius = |k: usize, layer: usize| 1.0 + EXAGGERATION * self.heights[cells[k] * LAYERS + layer] / EARTH_M;
        let psi = |layer: usize| (0..3).map(|k| alpha[k] / radius(k, layer)).sum::<f64>();
        let on = |layer: usize| {
            let value = |k: usize| f64::from(self.values[0][cells[k] * LAYERS + layer]);
            (0..3).map(|k| alpha[k] / radius(k, layer) * value(k)).sum::<f64>() / psi(layer)
        };
        if psi(0) < 1.0 {
            return None;
        }
        let above = (1..LAYERS).find(|layer| psi(*layer) < 1.0);
        Some(above.map(|above| {
            // Along the radius facets lie at 1/ψ times the point.
            let [low, high] = [1.0 / psi(above - 1), 1.0 / psi(above)];
            let w = (1.0 - low) / (high - low);
            on(above - 1) + w * (on(above) - on(above - 1))
        }))
    }
}

/// A square picture from afar.
fn square(side: u32, keys: &str, light: &str) -> Scene {
    let contents = "[[volumes]]\nfield = \"f\"\ntransfer = { map = \"viridis\", range = [-0.6, 0.6], \
        opacity = [[-0.6, 0.9], [-0.2, 0.6], [0.0, 0.0], [0.15, 0.0], [0.25, 0.8]] }\n";
    let camera = "lon = 20\nlat = 35\ndistance = 3.4\nfov = 45";
    Scene { width: side, height: side, ..scene(contents, &format!("tolerance = 1e-4\n{keys}"), camera, light) }
}

#[test]
fn mountains_and_the_layers_above_match_single_points() {
    let terrain = waves(2, LAYERS);
    let scene = square(20, "core = \"#405060\"", "");
    let frame = terrain.draw(&scene);
    let grid = &terrain.grid;
    let inverses: Vec<DMat3> = (0..grid.triangles() as u32)
        .map(|triangle| {
            let [a, b, c] = grid.triangle(triangle).map(|cell| grid.direction(cell));
            DMat3::from_cols(a, b, c).inverse()
        })
        .collect();
    let unit = scene.volumes[0].transfer.unit_length.unwrap_or(EXAGGERATION * TOP / EARTH_M);
    let mut off = Vec::new();
    for ((eye, dir), pixel) in rays(&scene).zip(&frame.pixels) {
        let (mut color, mut through, mut hint) = ([0.0; 3], 1.0f64, 0);
        const STEP: f64 = 2e-4;
        let along = -eye.dot(dir);
        for step in 0..(2.6 / STEP) as usize {
            let at = eye + (along - 1.3 + (step as f64 + 0.5) * STEP) * dir;
            if at.length() > 1.25 {
                continue;
            }
            let Some(value) = terrain.look_up(&inverses, at, &mut hint) else {
                let core = scene.core.unwrap();
                color = [0, 1, 2].map(|k| color[k] + through * core[k]);
                through = 0.0;
                break;
            };
            let Some(value) = value else { continue };
            let (c, extinction) = scene.volumes[0].transfer.at(value);
            let opacity = -(-extinction / unit * STEP).exp_m1();
            color = [0, 1, 2].map(|k| color[k] + through * opacity * c[k]);
            through *= 1.0 - opacity;
        }
        let expected = [color[0], color[1], color[2], 1.0 - through];
        off.push((0..4).map(|k| (f64::from(pixel[k]) - expected[k]).abs()).fold(0.0, f64::max));
    }
    let mean = off.iter().sum::<f64>() / off.len() as f64;
    let most = off.iter().copied().fold(0.0, f64::max);
    // Steps end up to one of them behind the ground.
    assert!(mean < 2e-3 && most < 2e-2, "{mean} in the mean, {most} at most");
    assert!(frame.pixels.iter().filter(|p| p[3] > 0.999).count() > 50);
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
