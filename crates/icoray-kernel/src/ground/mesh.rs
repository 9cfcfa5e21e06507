//! Voronoi cells and dual triangles.

use super::paint::LineStyle;
use super::screen_jacobian::{ScreenJacobian, distance};
use glam::{DVec2, DVec3};
use icoray_grid::Grid;
use icoray_grid::grid::unit_vector;

/// The fraction of the pixel that edges of Voronoi cells cover over `triangle`: those that begin at its corner and, if
/// a corner lies outside of its triangle, at those of its neighbours. Holes have none; beside one, the edge that leads
/// into it runs across the side of which it is the bisector.
pub(super) fn cells(grid: &Grid, triangle: u32, jacobian: &ScreenJacobian, pen: LineStyle) -> f64 {
    let shown = if grid.is_triangle(triangle) { pen.shows(gap(&sides(grid, triangle, jacobian))) } else { 0.0 };
    if shown == 0.0 {
        return 0.0;
    }
    let here = corner(grid, triangle);
    let mut nearest = f64::INFINITY;
    for k in 0..3 {
        let beyond = grid.across(triangle, k);
        if !grid.is_triangle(beyond) {
            let [a, b, c] = [0, 1, 2].map(|j| grid.direction(grid.triangle(triangle)[(k + j) % 3]));
            let side = b.cross(c).normalize();
            let height = side.dot(here);
            if height * side.dot(a) > 0.0 {
                nearest = nearest.min(jacobian.distance(here, here - 2.0 * height * side));
            }
            continue;
        }
        let there = corner(grid, beyond);
        nearest = nearest.min(jacobian.distance(here, there));
        for next in neighbours(grid, beyond).filter(|next| *next != triangle) {
            nearest = nearest.min(jacobian.distance(there, corner(grid, next)));
        }
    }
    shown * pen.covers(nearest)
}

/// The fraction of the pixel that sides of `triangle` cover.
pub(super) fn triangles(grid: &Grid, triangle: u32, jacobian: &ScreenJacobian, pen: LineStyle) -> f64 {
    if !grid.is_triangle(triangle) {
        return 0.0;
    }
    let sides = sides(grid, triangle, jacobian);
    let nearest = sides.iter().map(|[from, to]| distance(*from, *to)).fold(f64::INFINITY, f64::min);
    pen.shows(gap(&sides)) * pen.covers(nearest)
}

fn neighbours(grid: &Grid, triangle: u32) -> impl Iterator<Item = u32> {
    [0, 1, 2].map(|k| grid.across(triangle, k)).into_iter().filter(|beyond| grid.is_triangle(*beyond))
}

fn sides(grid: &Grid, triangle: u32, jacobian: &ScreenJacobian) -> [[DVec2; 2]; 3] {
    let [a, b, c] = grid.triangle(triangle).map(|cell| jacobian.pixels(grid.direction(cell)));
    [[a, b], [b, c], [c, a]]
}

/// The least height of a triangle: the distance between lines that run along such triangles.
fn gap(sides: &[[DVec2; 2]; 3]) -> f64 {
    let [[a, b], [_, c], _] = *sides;
    let longest = sides.iter().map(|[from, to]| from.distance(*to)).fold(0.0, f64::max);
    (b - a).perp_dot(c - a).abs() / longest
}

/// The direction of the corner of `triangle`.
fn corner(grid: &Grid, triangle: u32) -> DVec3 {
    let place = &grid.tables().corner;
    let row = triangle as usize;
    unit_vector(place.lon_rad.get(row), place.lat_rad.get(row))
}
