//! Voronoi cells and dual triangles.

use super::paint::LineStyle;
use super::screen_jacobian::{ScreenJacobian, distance};
use glam::{DVec2, DVec3};
use icoray_grid::Grid;
use icoray_grid::grid::unit_vector;

/// The fraction of the pixel that edges of Voronoi cells cover over `triangle`: those that run from its corner across its
/// sides, and those of a neighbour whose corner lies on this side of the common one. Other triangles do not matter, so
/// that parts of a grid have the lines of the whole.
pub(super) fn cells(grid: &Grid, triangle: u32, jacobian: &ScreenJacobian, pen: LineStyle) -> f64 {
    let shown = if grid.is_triangle(triangle) { pen.shows(gap(&sides(grid, triangle, jacobian))) } else { 0.0 };
    if shown == 0.0 {
        return 0.0;
    }
    let here = corner(grid, triangle);
    let mut nearest = f64::INFINITY;
    let mut add = |from: DVec3, to: DVec3| nearest = nearest.min(jacobian.distance(from, to));
    for k in 0..3 {
        let beyond = grid.across(triangle, k);
        let is_common = |j: &usize| grid.across(beyond, *j) == triangle;
        let common = grid.is_triangle(beyond).then(|| (0..3).find(is_common)).flatten();
        if common.is_some_and(|j| across(grid, beyond, j).is_none()) {
            let there = corner(grid, beyond);
            add(here, there);
            let others = (0..3).filter(|j| !is_common(j));
            others.filter_map(|j| across(grid, beyond, j)).for_each(|end| add(there, end));
        } else if let Some(end) = across(grid, triangle, k) {
            add(here, end);
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

/// A point of the cells' edge that runs from the corner of `triangle` across its side `k`, beyond that side: the corner's
/// image. `None` if the corner lies beyond the side.
fn across(grid: &Grid, triangle: u32, k: usize) -> Option<DVec3> {
    let [a, b, c] = [0, 1, 2].map(|j| grid.direction(grid.triangle(triangle)[(k + j) % 3]));
    let here = corner(grid, triangle);
    let side = b.cross(c).normalize();
    let height = side.dot(here);
    (height * side.dot(a) > 0.0).then(|| here - 2.0 * height * side)
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
