//! Random scenes of all kinds, every pixel against the oracle.

#[path = "../../../icoray/tests/suite/culled/mod.rs"]
mod culled;
mod draw;

use crate::compare::median;
use crate::oracle::{Data, Oracle, PANEL};
use crate::results::say;
use crate::shading::pixel_direction;
use crate::stability::truth::pixel_error;
use draw::{Drawn, KINDS};
use glam::DVec3;
use icoray::{Error, ErrorKind, Frame, Grid, GridTables, IcosahedralMesh, LonLat, Precision, Renderer, Result};
use icoray_test_support::Random;
use rayon::prelude::*;
use std::io::Write;
use std::time::Instant;

/// Errors below this are those of the picture's single precision.
const ROUNDING: f64 = 1e-7;

/// Number of times that a doubtful pixel's values are moved.
const MOVED: usize = 32;

/// Number of directions in which the eye of a doubtful pixel is moved: a ray through a vertex meets each of the triangles
/// around it.
const STEPS: usize = 16;

/// What was found in the scenes of one kind, light and precision.
#[derive(Debug, Default, Clone)]
struct Group {
    scenes: usize,
    pixels: usize,
    beyond: usize,
    /// Pixels of which the oracle cannot say whether they are beyond.
    undecided: usize,
    /// Largest error by the reported one.
    worst: f64,
    /// Reported by true errors, where these are above rounding.
    ratios: Vec<f64>,
    seconds: f64,
}

/// Draws scenes of the seeds from `seed` on, and checks every pixel.
///
/// # Errors
/// [`ErrorKind::Internal`] where a pixel is farther off than its error.
pub(super) fn run(count: u64, seed: u64, renderer: &Renderer, all: &Renderer, out: &mut dyn Write) -> Result<()> {
    let mut groups = vec![Group::default(); 4 * KINDS.len()];
    for seed in seed..seed + count {
        let drawn = Drawn::new(seed)?;
        let kind = KINDS.iter().position(|kind| *kind == drawn.kind).expect("the kinds are those of the list");
        let is_lit = usize::from(drawn.scene.lighting.is_some());
        let is_double = usize::from(drawn.scene.precision == Precision::F64);
        check(seed, &drawn, [renderer, all], &mut groups[4 * kind + 2 * is_lit + is_double], out)?;
    }
    say!(
        out,
        "{:<17} {:<6} {:<4} {:>6} {:>9} {:>7} {:>10} {:>9} {:>10} {:>8}",
        "kind",
        "light",
        "",
        "scenes",
        "pixels",
        "beyond",
        "undecided",
        "off/told",
        "told/true",
        "seconds"
    )?;
    for (i, group) in groups.iter().enumerate().filter(|(_, group)| group.scenes > 0) {
        say!(
            out,
            "{:<17} {:<6} {:<4} {:>6} {:>9} {:>7} {:>10} {:>9.2} {:>10.1} {:>8.2}",
            KINDS[i / 4],
            ["unlit", "lit"][i / 2 % 2],
            ["f32", "f64"][i % 2],
            group.scenes,
            group.pixels,
            group.beyond,
            group.undecided,
            group.worst,
            median(group.ratios.clone()),
            group.seconds
        )?;
    }
    let sum = |of: fn(&Group) -> usize| groups.iter().map(of).sum::<usize>();
    let (pixels, beyond, undecided) = (sum(|g| g.pixels), sum(|g| g.beyond), sum(|g| g.undecided));
    let found = format!("{beyond} of {pixels} pixels are farther off than their error, {undecided} are undecided");
    say!(out, "{count} scenes: {found}")?;
    if beyond > 0 { Err(Error::new(ErrorKind::Internal, found)) } else { Ok(()) }
}

/// Checks a scene's pixels; prints the worst that is beyond its error, and the scene.
fn check(
    seed: u64,
    drawn: &Drawn,
    [renderer, all]: [&Renderer; 2],
    group: &mut Group,
    out: &mut dyn Write,
) -> Result<()> {
    let (grid, scene) = (drawn.grid(), &drawn.scene);
    let start = Instant::now();
    let frame = renderer.render(scene, &grid, &drawn.layers, drawn.model_fields()?)?;
    group.seconds += start.elapsed().as_secs_f64();
    let data = Data { grid: &grid, layers: &drawn.layers, heights: &drawn.heights, fields: &drawn.fields };
    let oracle = Oracle::new(scene, data, PANEL)?;
    let pixels = 0..frame.pixels.len();
    let mut found: Vec<Found> = all.run(|| pixels.into_par_iter().map(|i| pixel(&frame, i, drawn, &oracle)).collect());
    if found.iter().any(Found::is_beyond) {
        let others: Vec<Vec<_>> =
            (0..MOVED).map(|k| drawn.fields.iter().map(|field| moved(field, k)).collect()).collect();
        let moved = others.iter().map(|fields| Oracle::new(scene, Data { fields, ..data }, PANEL));
        let doubts = moved.chain([Oracle::new(scene, data, 0.5 * PANEL)]).collect::<Result<Vec<_>>>()?;
        let found = found.par_iter_mut().enumerate().filter(|(_, found)| found.is_beyond());
        all.run(|| found.for_each(|(i, found)| found.is_undecided |= is_unsure(i, found, drawn, (&oracle, &doubts))));
    }
    group.scenes += 1;
    group.pixels += found.len();
    let mut worst: Option<(usize, Found)> = None;
    let mut beyond = 0;
    for (i, pixel) in found.into_iter().enumerate() {
        if pixel.is_undecided {
            group.undecided += 1;
            continue;
        }
        if pixel.off > ROUNDING {
            group.ratios.push(pixel.told / pixel.off);
        }
        group.worst = group.worst.max(pixel.ratio());
        beyond += usize::from(pixel.is_beyond());
        if pixel.is_beyond() && worst.is_none_or(|(_, other)| pixel.ratio() > other.ratio()) {
            worst = Some((i, pixel));
        }
    }
    group.beyond += beyond;
    let Some((i, Found { truth, off, told, .. })) = worst else { return Ok(()) };
    let (x, y) = (i as u32 % scene.width, i as u32 / scene.width);
    say!(
        out,
        "seed {seed}, {}: {beyond} pixels beyond their error; pixel {x}, {y} is off by {off:.2e} and tells {told:.2e}\n\
         # shown {:?}, true {truth:?}\n\
         # icoray-study error --random 1 --seed {seed}\n# {}\n{}",
        drawn.kind,
        frame.pixels[i],
        drawn.recipe,
        drawn.text
    )
}

/// A pixel's error.
#[derive(Debug, Clone, Copy)]
struct Found {
    /// The oracle's pixel.
    truth: [f64; 4],
    off: f64,
    told: f64,
    is_undecided: bool,
}

impl Found {
    fn is_beyond(&self) -> bool {
        self.off > self.told || self.told.is_nan()
    }

    fn ratio(&self) -> f64 {
        if self.off > 0.0 { self.off / self.told } else { 0.0 }
    }
}

/// A field with values a few units in the last place of f64 away.
fn moved<'n>((name, values): &(&'n str, Vec<f64>), number: usize) -> (&'n str, Vec<f64>) {
    let by = |i: usize| 8.0 * f64::EPSILON * (Random::at(MOVED * i + number).unit() - 0.5);
    (name, values.iter().enumerate().map(|(i, value)| value * (1.0 + by(i))).collect())
}

/// Compares pixel `i`, which is undecided where the oracle sees none.
fn pixel(frame: &Frame, i: usize, drawn: &Drawn, oracle: &Oracle) -> Found {
    let scene = &drawn.scene;
    let (eye, dir) = (DVec3::from_array(scene.camera.eye()), pixel_direction(scene, i as u32));
    let told = f64::from(frame.error[i]);
    let Some(truth) = oracle.pixel(eye, dir) else {
        return Found { truth: [f64::NAN; 4], off: 0.0, told, is_undecided: true };
    };
    Found { truth, off: pixel_error(frame.pixels[i], &truth), told, is_undecided: false }
}

/// Whether it is undecided if pixel `i` is beyond its error: if the oracle's pixel moves by a quarter of the error or
/// more with panels of half the depth, or with eyes and values that are a few units in the last place away.
fn is_unsure(i: usize, found: &Found, drawn: &Drawn, (oracle, doubts): (&Oracle, &[Oracle])) -> bool {
    let Found { truth, off, .. } = *found;
    let scene = &drawn.scene;
    let (eye, dir) = (DVec3::from_array(scene.camera.eye()), pixel_direction(scene, i as u32));
    let far = 4.0 * f64::EPSILON * (1.0 + eye.length());
    let moves = |oracle: &Oracle, step: DVec3| {
        let again = oracle.pixel(eye + far * step, dir);
        again.is_none_or(|again| (0..4).any(|k| (again[k] - truth[k]).abs() >= 0.25 * off))
    };
    let (aside, across) = dir.any_orthonormal_pair();
    let step = |k: usize| {
        let (sin, cos) = (std::f64::consts::TAU * k as f64 / STEPS as f64).sin_cos();
        cos * aside + sin * across
    };
    off.is_finite()
        && (doubts.iter().any(|oracle| moves(oracle, DVec3::ZERO)) || (0..STEPS).any(|k| moves(oracle, step(k))))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A scene of several volumes, whose pixels are right but for those that are changed.
    #[test]
    fn a_pixel_that_is_beyond_its_error_is_found_and_told_with_its_scene() {
        let renderer = Renderer::new(1).unwrap();
        let mut found = 0;
        for seed in 0..20 {
            let drawn = Drawn::new(seed).unwrap();
            let grid = drawn.grid();
            let data = Data { grid: &grid, layers: &drawn.layers, heights: &drawn.heights, fields: &drawn.fields };
            let oracle = Oracle::new(&drawn.scene, data, PANEL).unwrap();
            let fields = drawn.model_fields().unwrap();
            let mut frame = renderer.render(&drawn.scene, &grid, &drawn.layers, fields).unwrap();
            for i in [0, 7 * 25 + 11] {
                let off = 3.0 * frame.error[i].max(1e-3);
                frame.pixels[i][1] += off;
                let moved = pixel(&frame, i, &drawn, &oracle);
                let is_sure = !moved.is_undecided && !is_unsure(i, &moved, &drawn, (&oracle, &[]));
                found += u32::from(moved.is_beyond() && is_sure && moved.ratio() > 1.9);
                frame.pixels[i][1] = f32::NAN;
                assert!(pixel(&frame, i, &drawn, &oracle).is_beyond());
            }
        }
        // A few lie where an eye that is moved sees something else.
        assert!(found > 36, "{found}");
    }

    #[test]
    fn a_seed_draws_the_same_scene_again_and_all_kinds_are_drawn() {
        let mut kinds: Vec<&str> = Vec::new();
        for seed in 0..80 {
            let [one, again] = [Drawn::new(seed), Drawn::new(seed)].map(Result::unwrap);
            assert_eq!((&one.text, &one.recipe), (&again.text, &again.recipe));
            kinds.push(one.kind);
        }
        assert!(KINDS.iter().all(|kind| kinds.contains(kind)), "{kinds:?}");
    }
}
