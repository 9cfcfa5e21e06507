//! The cells whose columns rays of a picture can pass: a conservative set, on which no picture depends.

use crate::grid::Grid;
use glam::DVec3;
use std::f64::consts::FRAC_PI_2;

/// The cells of the triangles over which rays from one place, between four planes, pass the shell.
#[derive(Debug, Clone, Copy)]
pub struct VisibleCells {
    eye: DVec3,
    /// Inward normals of the four planes through the eye that enclose all rays.
    sides: [DVec3; 4],
    /// Unit vector from the sphere's centre to the eye.
    towards: DVec3,
    /// Least cosine of the angle between that and a cell.
    min_cos: f64,
    /// Lower bound of the radius of the lowest facets, and the radius of the highest layer.
    shell: [f64; 2],
    /// Upper bound of the distance of any place over a cell's triangles from the cell's own ray, at radius 1.
    extent: f64,
}

impl VisibleCells {
    /// The set for rays from `eye` between the planes through it that have the inward unit normals `sides`, in a shell
    /// between two radii, in planet radii. An opaque core hides the space beyond its limb.
    pub fn new(grid: &Grid, eye: DVec3, sides: [DVec3; 4], [inner, outer]: [f64; 2], has_core: bool) -> Self {
        // More than the rounding of a ray and of a side.
        let extent = 1.001 * grid.longest_side() + 1e-6;
        let distance = eye.length();
        // The facets of the lowest layer lie below its sphere. A ray that touches the core at its limb passes the shell
        // as far round as the place where it leaves the highest layer.
        let core = inner * extent.min(FRAC_PI_2).cos();
        let farthest = (core / distance).min(1.0).acos() + (core / outer).acos();
        let min_cos = if has_core && distance > inner { farthest.cos() } else { -1.0 };
        VisibleCells { eye, sides, towards: eye.normalize_or_zero(), min_cos, shell: [core, outer], extent }
    }

    /// Whether a ray can pass over a triangle of the cell in this direction.
    #[inline]
    pub fn contains(&self, direction: DVec3) -> bool {
        let [core, outer] = self.shell;
        // The cosine of an angle changes by no more than the angle.
        if direction.dot(self.towards) < self.min_cos - self.extent {
            return false;
        }
        let low = core * direction - self.eye;
        let high = outer * direction - self.eye;
        let margin = -outer * self.extent;
        self.sides.iter().all(|side| side.dot(low) >= margin || side.dot(high) >= margin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::array::MapInline;
    use crate::grid::IcosahedralMesh;

    const SHELL: [f64; 2] = [1.0, 1.2];

    /// Normals of the planes around rays that look from `eye` to `target`, with a half width of the picture.
    fn sides(eye: DVec3, target: DVec3, half: f64) -> ([DVec3; 4], [DVec3; 3]) {
        let forward = (target - eye).normalize();
        let right = forward.cross(DVec3::new(0.1, 0.2, 1.0)).normalize();
        let up = right.cross(forward);
        let sides = [half * forward + right, half * forward - right, half * forward + up, half * forward - up];
        (sides.map_inline(DVec3::normalize), [forward, right, up])
    }

    /// Places along many rays from outside, from inside the shell and from the hollow core: each cell of the triangle
    /// over a place is in the set, and of close-ups the set has few cells.
    #[test]
    fn the_cells_over_all_places_of_rays_are_in_the_set() {
        let mesh = IcosahedralMesh::new(4).unwrap();
        let grid = Grid::new(mesh.tables()).unwrap();
        let cameras = [
            (DVec3::new(3.0, 0.5, 0.2), DVec3::ZERO, 0.5, true, 0.7),
            (DVec3::new(3.0, 0.5, 0.2), DVec3::ZERO, 0.5, false, 1.1),
            (DVec3::new(1.6, 0.0, 0.0), DVec3::new(0.9, 0.3, 0.3), 0.05, true, 0.3),
            (DVec3::new(0.0, 1.1, 0.0), DVec3::new(0.3, 1.0, 0.4), 0.4, true, 0.5),
            (DVec3::new(0.1, 0.2, 0.0), DVec3::new(0.9, 0.3, 0.3), 0.3, false, 0.6),
            (DVec3::new(50.0, 9.0, 20.0), DVec3::new(0.2, 0.9, 0.1), 0.005, true, 0.6),
        ];
        for (eye, target, half, has_core, max_share) in cameras {
            let (sides, [forward, right, up]) = sides(eye, target, half);
            let cells = VisibleCells::new(&grid, eye, sides, SHELL, has_core);
            let seen: Vec<bool> = (0..grid.cells() as u32).map(|cell| cells.contains(grid.direction(cell))).collect();
            let count = seen.iter().filter(|seen| **seen).count();
            assert!((count as f64) < max_share * grid.cells() as f64, "{eye}: {count} cells");
            let mut places = 0;
            for (i, j) in (0..=40).flat_map(|i| (0..=40).map(move |j| (i, j))) {
                let [x, y] = [i, j].map_inline(|k| half * (f64::from(k) / 20.0 - 1.0));
                let dir = (forward + x * right + y * up).normalize();
                for step in 0..400 {
                    let nearest = (eye.length() - SHELL[1]).max(0.0);
                    let place = eye + dir * (nearest + f64::from(step) * 0.0075);
                    if has_core && place.length() < SHELL[0] {
                        break;
                    }
                    if !(SHELL[0]..SHELL[1]).contains(&place.length()) || step % 7 != (i + j) % 7 {
                        continue;
                    }
                    let over = place.normalize();
                    let is_over = |triangle: &u32| {
                        let [a, b, c] = grid.triangle(*triangle).map_inline(|cell| grid.direction(cell));
                        let turn = a.cross(b).dot(c).signum();
                        [(a, b), (b, c), (c, a)].iter().all(|(a, b)| turn * a.cross(*b).dot(over) >= 0.0)
                    };
                    let triangle = (0..grid.triangles() as u32).find(is_over).expect("the mesh covers the sphere");
                    assert!(grid.triangle(triangle).iter().all(|cell| seen[*cell as usize]), "{eye}: {place}");
                    places += 1;
                }
            }
            assert!(places > 500, "{eye}: {places}");
        }
    }
}
