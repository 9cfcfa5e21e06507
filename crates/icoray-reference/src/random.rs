//! Random scenes of all kinds, every pixel against the oracle.

mod draw;
mod levels;
mod scene_text;

pub use draw::RandomScene;
pub use levels::check_levels;
pub use scene_text::KINDS;

use crate::comparison::pixel_error;
use crate::oracle::{Data, NamedField, Oracle, PANEL};
use crate::ray::Ray;
use glam::DVec3;
use icoray::{Frame, Renderer, Result};
use icoray_test_support::Random;
use rayon::prelude::*;
use std::time::Instant;

/// Errors below this are those of the picture's single precision.
const ROUNDING: f64 = 1e-7;

/// Number of times that a doubtful pixel's values are moved.
const MOVED: usize = 32;

/// Number of directions in which the eye of a doubtful pixel is moved: a ray through a vertex meets each of the
/// triangles around it.
const STEPS: usize = 16;

/// The pixels of a scene, or of several.
#[derive(Debug, Default, Clone)]
pub struct Checked {
    /// Number of scenes.
    pub scenes: usize,
    /// Number of pixels.
    pub pixels: usize,
    /// Pixels whose error is above the reported one.
    pub beyond: usize,
    /// Pixels with too uncertain an error of the oracle for a comparison with the reported one.
    pub undecided: usize,
    /// Largest error relative to the reported one.
    pub worst: f64,
    /// Reported errors relative to true ones, where these are above rounding.
    pub ratios: Vec<f64>,
    /// Seconds of the renderer.
    pub seconds: f64,
    /// For each scene with pixels beyond, the worst one and the scene.
    pub failures: Vec<String>,
}

impl Checked {
    /// Adds the pixels of other scenes.
    pub fn add(&mut self, other: Self) {
        self.scenes += other.scenes;
        self.pixels += other.pixels;
        self.beyond += other.beyond;
        self.undecided += other.undecided;
        self.worst = self.worst.max(other.worst);
        self.ratios.extend(other.ratios);
        self.seconds += other.seconds;
        self.failures.extend(other.failures);
    }
}

/// Renders a scene and checks every pixel on the threads of `all`.
///
/// # Errors
/// As [`Renderer::render`] and [`Oracle::new`].
pub fn check(drawn: &RandomScene, renderer: &Renderer, all: &Renderer) -> Result<Checked> {
    let (grid, scene) = (drawn.grid(), &drawn.scene);
    let start = Instant::now();
    let frame = renderer.render(scene, &grid, &drawn.layers, drawn.model_fields()?)?;
    let seconds = start.elapsed().as_secs_f64();
    let data = drawn.data(&grid);
    let oracle = Oracle::new(scene, data, PANEL)?;
    let count = frame.pixels.len();
    let mut pixels: Vec<Pixel> =
        all.run(|| (0..count).into_par_iter().map(|i| Pixel::new(&frame, i, drawn, &oracle)).collect());
    if pixels.iter().any(Pixel::is_beyond) {
        let moved: Vec<Vec<_>> =
            (0..MOVED).map(|k| drawn.fields.iter().map(|field| moved(field, k)).collect()).collect();
        let moved = moved.iter().map(|fields| Oracle::new(scene, Data { fields, ..data }, PANEL));
        let others = moved.chain([Oracle::new(scene, data, 0.5 * PANEL)]).collect::<Result<Vec<_>>>()?;
        let doubtful = pixels.par_iter_mut().filter(|pixel| pixel.is_beyond());
        all.run(|| doubtful.for_each(|pixel| pixel.is_undecided |= pixel.is_unsure(&oracle, &others)));
    }
    let decided = || pixels.iter().filter(|pixel| !pixel.is_undecided);
    let beyond = || decided().filter(|pixel| pixel.is_beyond());
    let number = beyond().count();
    let worst = beyond().max_by(|a, b| a.ratio().total_cmp(&b.ratio()));
    Ok(Checked {
        scenes: 1,
        pixels: count,
        beyond: number,
        undecided: count - decided().count(),
        worst: decided().map(Pixel::ratio).fold(0.0, f64::max),
        ratios: decided().filter(|pixel| pixel.error > ROUNDING).map(|pixel| pixel.reported / pixel.error).collect(),
        seconds,
        failures: worst.map(|pixel| failure(drawn, &frame, number, pixel)).into_iter().collect(),
    })
}

fn failure(drawn: &RandomScene, frame: &Frame, beyond: usize, pixel: &Pixel) -> String {
    let Pixel { number, truth, error, reported, .. } = *pixel;
    let RandomScene { seed, kind, recipe, text, scene, .. } = drawn;
    let (x, y) = (number as u32 % scene.width, number as u32 / scene.width);
    format!(
        "seed {seed}, {kind}: {beyond} pixels beyond their error; pixel {x}, {y}: {error:.2e}, reported {reported:.2e}\n\
         # shown {:?}, true {truth:?}\n# icoray-study error --random 1 --seed {seed}\n# {recipe}\n{text}",
        frame.pixels[number]
    )
}

/// A pixel's error.
struct Pixel {
    number: usize,
    ray: Ray,
    truth: [f64; 4],
    error: f64,
    reported: f64,
    is_undecided: bool,
}

/// A field with values a few units in the last place of f64 away.
fn moved<'n>(field: &NamedField<'n>, number: usize) -> NamedField<'n> {
    let by = |i: usize| 8.0 * f64::EPSILON * (Random::at(MOVED * i + number).unit() - 0.5);
    let values = field.values.iter().enumerate().map(|(i, value)| value * (1.0 + by(i))).collect();
    NamedField { values, ..*field }
}

impl Pixel {
    /// Compares a pixel, which is undecided where the oracle finds a gap.
    fn new(frame: &Frame, number: usize, drawn: &RandomScene, oracle: &Oracle) -> Self {
        let ray = Ray::of_pixel(&drawn.scene, number as u32);
        let (truth, is_undecided) = oracle.pixel(&ray).map_or(([f64::NAN; 4], true), |truth| (truth, false));
        let error = if is_undecided { 0.0 } else { pixel_error(frame.pixels[number], &truth) };
        Pixel { number, ray, truth, error, reported: f64::from(frame.error[number]), is_undecided }
    }

    fn is_beyond(&self) -> bool {
        self.error > self.reported || self.reported.is_nan()
    }

    fn ratio(&self) -> f64 {
        if self.error > 0.0 { self.error / self.reported } else { 0.0 }
    }

    /// Whether it is undecided if the pixel is beyond its error: if the oracle's pixel moves by a quarter of the error
    /// or more in one of the `others`, with panels of half the depth or values a few units in the last place away, or
    /// with an eye as far away.
    fn is_unsure(&self, oracle: &Oracle, others: &[Oracle]) -> bool {
        let far = 4.0 * f64::EPSILON * (1.0 + self.ray.eye.length());
        let moves = |oracle: &Oracle, step: DVec3| {
            let again = oracle.pixel(&Ray { eye: self.ray.eye + far * step, ..self.ray });
            again.is_none_or(|again| (0..4).any(|k| (again[k] - self.truth[k]).abs() >= 0.25 * self.error))
        };
        let (aside, across) = self.ray.dir.any_orthonormal_pair();
        let step = |k: usize| {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / STEPS as f64).sin_cos();
            cos * aside + sin * across
        };
        self.error.is_finite()
            && (others.iter().any(|oracle| moves(oracle, DVec3::ZERO)) || (0..STEPS).any(|k| moves(oracle, step(k))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Scenes of all kinds, whose pixels are right but for those that are changed.
    #[test]
    fn a_pixel_beyond_its_error_is_found_and_reported_with_its_scene() {
        let renderer = Renderer::new(1).unwrap();
        let mut found = 0;
        for seed in 0..20 {
            let drawn = RandomScene::new(seed).unwrap();
            let grid = drawn.grid();
            let oracle = Oracle::new(&drawn.scene, drawn.data(&grid), PANEL).unwrap();
            let fields = drawn.model_fields().unwrap();
            let mut frame = renderer.render(&drawn.scene, &grid, &drawn.layers, fields).unwrap();
            for i in [0, 7 * 25 + 11] {
                frame.pixels[i][1] += 3.0 * frame.error[i].max(1e-3);
                let moved = Pixel::new(&frame, i, &drawn, &oracle);
                let is_sure = !moved.is_undecided && !moved.is_unsure(&oracle, &[]);
                found += u32::from(moved.is_beyond() && is_sure && moved.ratio() > 1.9);
                let text = failure(&drawn, &frame, 1, &moved);
                assert!(text.starts_with(&format!("seed {seed}, ")) && text.ends_with(&drawn.text), "{text}");
                frame.pixels[i][1] = f32::NAN;
                assert!(Pixel::new(&frame, i, &drawn, &oracle).is_beyond());
            }
        }
        // A few lie where an eye that is moved sees something else.
        assert!(found > 36, "{found}");
    }

    #[test]
    fn a_seed_draws_the_same_scene_again_and_all_kinds_are_drawn() {
        let mut kinds: Vec<&str> = Vec::new();
        for seed in 0..80 {
            let [one, again] = [RandomScene::new(seed), RandomScene::new(seed)].map(Result::unwrap);
            assert_eq!((&one.text, &one.recipe), (&again.text, &again.recipe));
            kinds.push(one.kind);
        }
        assert!(KINDS.iter().all(|kind| kinds.contains(kind)), "{kinds:?}");
    }
}
