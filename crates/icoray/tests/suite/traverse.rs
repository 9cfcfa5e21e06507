//! The stretches of a ray join, lie on the ray and in their layer, and cover the whole ray.

use crate::common::icosahedral;
use glam::DVec3;
use icoray::{ErrorKind, Frustum, Grid, Stretch, Traversal};
use icoray_test_support::Random;
use std::ops::ControlFlow;

const RADIUS: [f64; 6] = [0.8, 0.85, 1.0, 1.01, 1.2, 1.5];

fn direction(random: &mut Random) -> DVec3 {
    DVec3::from_array(random.direction())
}

fn stretches(traversal: &Traversal, eye: DVec3, dir: DVec3, hint: &mut u32) -> Vec<Stretch> {
    let mut list = Vec::new();
    traversal.ray(eye, dir, hint, |stretch| {
        list.push(*stretch);
        ControlFlow::Continue(())
    });
    list
}

fn check(grid: &Grid, eye: DVec3, dir: DVec3, f: &Frustum) {
    assert!(f.t[0] <= f.t[1], "{f:?}");
    assert!(f.layer + 1 < RADIUS.len(), "{f:?}");
    let at = f.cells.map(|cell| grid.direction(cell));
    for (t, alpha) in f.t.into_iter().zip(f.alpha) {
        let point = at[0] * alpha[0] + at[1] * alpha[1] + at[2] * alpha[2];
        let off = point.distance(eye + t * dir);
        assert!(off < 1e-12, "{off:e} off the ray: {f:?}");
        let rho: f64 = alpha.iter().sum();
        let [low, high] = [RADIUS[f.layer], RADIUS[f.layer + 1]];
        assert!(rho > low - 1e-12 && rho < high + 1e-12, "height {rho}, layers {low} to {high}: {f:?}");
        assert!(alpha.iter().all(|a| *a > -1e-12), "outside the triangle: {f:?}");
    }
}

/// Length of the ray, from its eye on, inside the convex polyhedron of the facets at radius `r`.
fn chord(grid: &Grid, r: f64, eye: DVec3, dir: DVec3) -> f64 {
    let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
    for t in 0..grid.triangles() as u32 {
        let [a, b, c] = grid.triangle(t).map(|cell| grid.direction(cell) * r);
        let normal = (b - a).cross(c - a);
        let normal = normal * normal.dot(a).signum();
        let (gap, speed) = ((a - eye).dot(normal), dir.dot(normal));
        if speed < 0.0 {
            enter = enter.max(gap / speed);
        } else {
            leave = leave.min(gap / speed);
        }
    }
    (leave - enter).max(0.0)
}

#[test]
fn stretches_join_and_lie_on_the_ray() {
    let (_, grid) = icosahedral(3);
    let traversal = Traversal::new(&grid, &RADIUS).unwrap();
    let mut random = Random::new(7);
    let (mut frusta, mut cores, mut inside) = (0, 0, 0);
    for i in 0..6000 {
        // From far away, inside the shell, inside the hollow core.
        let distance = [3.5, 0.8 + 0.7 * random.unit(), 0.8 * random.unit()][i % 3];
        let eye = direction(&mut random) * distance;
        let aim = direction(&mut random) * 1.5;
        let dir = if i % 3 == 0 { (aim - eye).normalize() } else { direction(&mut random) };
        let (mut end, mut length): (Option<f64>, f64) = (None, 0.0);
        let list = stretches(&traversal, eye, dir, &mut 0);
        for (n, stretch) in list.iter().enumerate() {
            match stretch {
                Stretch::Frustum(f) => {
                    check(&grid, eye, dir, f);
                    if let Some(end) = end {
                        assert!((f.t[0] - end).abs() < 1e-12, "a gap of {:e} at {n}", f.t[0] - end);
                    }
                    assert!(n > 0 || f.t[0] > -1e-12, "behind the eye: {f:?}");
                    inside += usize::from(n == 0 && f.t[0].abs() < 1e-12);
                    length += f.t[1] - f.t[0];
                    end = Some(f.t[1]);
                    frusta += 1;
                }
                Stretch::Core { t } => {
                    if let Some(end) = end {
                        assert!((t - end).abs() < 1e-12, "the core is {:e} off", t - end);
                    }
                    end = None;
                    cores += 1;
                }
            }
        }
        // Nothing is left out: what is inside the shell is what plane geometry says.
        let expected = chord(&grid, 1.5, eye, dir) - chord(&grid, 0.8, eye, dir);
        assert!((length - expected).abs() < 1e-11, "{length} inside, expected {expected}: {eye} {dir}");
    }
    assert!(frusta > 50_000 && cores > 2000 && inside > 1000, "{frusta} {cores} {inside}");
}

#[test]
fn the_core_is_listed_where_it_is_met_and_left() {
    let (_, grid) = icosahedral(3);
    let traversal = Traversal::new(&grid, &RADIUS).unwrap();
    let (eye, aim) = (DVec3::new(3.0, 0.4, -0.2), DVec3::new(0.1, 0.0, 0.2));
    let dir = (aim - eye).normalize();
    let list = stretches(&traversal, eye, dir, &mut 0);
    let is_core = |s: &Stretch| matches!(s, Stretch::Core { .. });
    let (first, last) = (list.iter().position(is_core).unwrap(), list.iter().rposition(is_core).unwrap());
    assert!(list[first..=last].iter().all(is_core), "the core is met once");
    let (Stretch::Frustum(before), Stretch::Core { t }, Stretch::Frustum(after)) =
        (list[first - 1], list[first], list[last + 1])
    else {
        panic!("{list:?}")
    };
    assert_eq!((before.layer, after.layer), (0, 0));
    assert!((before.t[1] - t).abs() < 1e-12);
    let hole = after.t[0] - before.t[1];
    assert!((hole - chord(&grid, RADIUS[0], eye, dir)).abs() < 1e-12, "{hole}");
    // A break at the core ends the list.
    let mut visited = 0;
    traversal.ray(eye, dir, &mut 0, |stretch| {
        visited += 1;
        if is_core(stretch) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert_eq!(visited, first + 1);
}

#[test]
fn any_hint_leads_to_the_same_stretches() {
    let (_, grid) = icosahedral(3);
    let traversal = Traversal::new(&grid, &RADIUS).unwrap();
    let mut random = Random::new(11);
    for i in 0..200 {
        let eye = direction(&mut random) * 2.5;
        let dir = (direction(&mut random) - eye).normalize();
        let plain = stretches(&traversal, eye, dir, &mut 0);
        let mut hint = i * 6;
        assert_eq!(stretches(&traversal, eye, dir, &mut hint), plain);
        assert!((hint as usize) < grid.triangles());
    }
}

#[test]
fn radii_that_do_not_rise_are_refused() {
    let (_, grid) = icosahedral(1);
    for radius in [&[1.0][..], &[1.0, 1.0], &[1.2, 1.0], &[0.0, 1.0], &[1.0, f64::INFINITY], &[f64::NAN, 1.0]] {
        let error = Traversal::new(&grid, radius).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Layers, "{radius:?}");
    }
}
