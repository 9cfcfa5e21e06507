//! Closes a mesh with holes: covers the rest of the sphere with *void* triangles, which are walked over and never
//! sampled.
//!
//! For an ocean without land, a limited area or a rank's part, the table's triangles end at a rim: sides beyond which a
//! cell or corner is missing. The walk must not end there, as a ray may come back over the rim, and it relies on a
//! closed, consistently wound surface around the centre.
//!
//! **Why the result is one.** The rim's cells are inserted into a triangulation of the whole sphere and every rim side
//! becomes a side of it ([`ConstrainedDelaunay`], exact predicates); by construction this is closed, wound one way and
//! clear of the centre. It is cut along the rim: the faces beyond rim sides, found without crossing one, are kept as
//! void; faces on the data's side would be a contradiction and are refused. So every rim side has its data triangle on
//! one side and one void triangle on the other, wound alike, every other side two triangles of its own kind, and no
//! side is open. `check::covers` then sums areas over both kinds: a surface without folds whose areas sum to 4π once
//! covers each direction once. Holes may touch in a vertex, lie in each other, contain a pole or all of the sphere: the
//! argument does not depend on loops.
//!
//! Synthetic points keep void triangles from reaching across the sphere. Those under data disappear with the faces that
//! data replace; if one lies on a rim side or a cell, all are turned slightly and the procedure is repeated.

use super::constrained_delaunay::{ConstrainedDelaunay, ConstraintError};
use super::half_edges::{HalfEdges, half_edge};
use super::table_names::{named_row, number_of, rows};
use super::tables::GridTables;
use crate::error::{Error, Result};
use glam::{DMat3, DVec3};
use std::collections::HashMap;

/// Bisections of the icosahedron that gives the synthetic points: 162 of them, 17° apart. With 2562 a ray over a rank's
/// part of a mesh passed twice as many columns.
const LEVEL: u32 = 2;
/// Maximum number of positions of the synthetic points that are tried.
const TURNS: u32 = 8;
/// Stripes by which the rim's cells are sorted, so that each is near the previous one.
const STRIPES: f64 = 64.0;

/// A rim side in its data triangle: from one cell to the next counter-clockwise.
#[derive(Debug, Clone, Copy)]
struct Side {
    from: u32,
    to: u32,
    triangle: u32,
    /// The vertex opposite the side.
    opposite: usize,
}

impl Side {
    fn name(&self, t: &GridTables) -> String {
        format!("side between cells {} and {}", number_of(t, self.from), number_of(t, self.to))
    }
}

/// Closes the mesh: adds void triangles behind those of the table, with the half-edges between them and the rim, and the
/// synthetic points that they use to `direction`.
///
/// # Errors
/// [`ErrorKind::Grid`](crate::ErrorKind::Grid) names the rows of `corner_cell` whose triangles overlap, and cells in
/// each other's place.
pub(super) fn fill_holes(t: &GridTables, direction: &mut Vec<[f64; 3]>, half_edges: &mut Vec<HalfEdges>) -> Result<()> {
    let sides = rim(half_edges);
    let mut by_ends = HashMap::with_capacity(sides.len());
    for (i, side) in sides.iter().enumerate() {
        if let Some(other) = by_ends.insert((side.from, side.to), i) {
            return Err(overlap(t, side, &sides[other]));
        }
    }
    for side in &sides {
        if let Some(&other) = by_ends.get(&(side.to, side.from)) {
            return Err(Error::grid(format!(
                "{}: both have a {} beyond which a cell or corner is missing; expected an edge that joins the two",
                rows(t, "corner_cell", side.triangle as usize, sides[other].triangle as usize),
                side.name(t)
            )));
        }
    }
    let cells = sorted_cells(&sides, direction);
    for attempt in 0..TURNS {
        if let Some(patched) = patched(t, &cells, &sides, direction, attempt)? {
            return cut(t, direction, half_edges, &sides, &patched);
        }
    }
    Err(Error::grid("corner_cell: the rim of the mesh cannot be closed, expected triangles that do not overlap"))
}

/// All sides of data triangles beyond which there is no triangle.
fn rim(half_edges: &[HalfEdges]) -> Vec<Side> {
    let mut sides = Vec::new();
    for (triangle, of) in (0..).zip(half_edges).filter(|(_, of)| of.is_triangle()) {
        for opposite in (0..3).filter(|&k| of.is_rim(k)) {
            let [from, to] = [1, 2].map(|next| of.vertices()[(opposite + next) % 3]);
            sides.push(Side { from, to, triangle, opposite });
        }
    }
    sides
}

/// The rim's cells, up and down stripes of latitude.
fn sorted_cells(sides: &[Side], direction: &[[f64; 3]]) -> Vec<u32> {
    let mut cells: Vec<u32> = sides.iter().flat_map(|side| [side.from, side.to]).collect();
    let place = |cell: &u32| {
        let [x, y, z] = direction[*cell as usize];
        let stripe = (STRIPES * (1.0 + z)) as u32;
        let lon = y.atan2(x);
        (stripe, if stripe.is_multiple_of(2) { lon } else { -lon })
    };
    cells.sort_unstable();
    cells.dedup();
    cells.sort_by(|a, b| {
        let (a, b) = (place(a), place(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    cells
}

/// The whole sphere with the rim in it.
struct PatchedSphere {
    triangulation: ConstrainedDelaunay,
    /// The vertex of each cell of the rim.
    vertex: HashMap<u32, u32>,
}

/// Inserts the rim; `None` if a synthetic point is in the way.
fn patched(
    t: &GridTables,
    cells: &[u32],
    sides: &[Side],
    direction: &[[f64; 3]],
    attempt: u32,
) -> Result<Option<PatchedSphere>> {
    // About three axes: no mesh made by formula has its points, or its equator, at the resulting positions.
    let turn = 0.371 + 0.0137 * f64::from(attempt);
    let rotation = DMat3::from_rotation_z(turn)
        * DMat3::from_rotation_x(1.7 * turn + 0.2)
        * DMat3::from_rotation_z(0.9 * turn + 0.1);
    let mut triangulation = ConstrainedDelaunay::new(LEVEL, rotation)?;
    let synthetic = triangulation.vertices() as u32;
    let mut vertex = HashMap::with_capacity(cells.len());
    // Cells were added in order, so a vertex determines its cell.
    let in_the_way = |clash| match clash {
        ConstraintError::Vertex(v) | ConstraintError::Side(v, _) => v.checked_sub(synthetic).map(|i| cells[i as usize]),
        ConstraintError::Endless => None,
    };
    for &cell in cells {
        match triangulation.insert(DVec3::from_array(direction[cell as usize])) {
            Ok(v) => vertex.insert(cell, v),
            Err(clash) => {
                let Some(other) = in_the_way(clash) else { return Ok(None) };
                return Err(Error::grid(format!(
                    "{}: the same place {:?}, expected cells apart from each other",
                    rows(t, "center", other as usize, cell as usize),
                    direction[other as usize]
                )));
            }
        };
    }
    for side in sides {
        if let Err(clash) = triangulation.insert_constraint(vertex[&side.from], vertex[&side.to]) {
            let Some(cell) = in_the_way(clash) else { return Ok(None) };
            return Err(Error::grid(format!(
                "{}: the {} runs through the triangles at cell {}, expected triangles that do not overlap",
                named_row(t, "corner_cell", side.triangle as usize),
                side.name(t),
                number_of(t, cell)
            )));
        }
    }
    Ok(Some(PatchedSphere { triangulation, vertex }))
}

/// Cuts the triangulation along the rim and keeps the part beyond.
fn cut(
    t: &GridTables,
    direction: &mut Vec<[f64; 3]>,
    half_edges: &mut Vec<HalfEdges>,
    sides: &[Side],
    PatchedSphere { triangulation, vertex }: &PatchedSphere,
) -> Result<()> {
    const COVERED: u32 = u32::MAX;
    let ends = |side: &Side| (vertex[&side.from], vertex[&side.to]);
    let of_rim: HashMap<(u32, u32), usize> = sides.iter().enumerate().map(|(i, s)| (ends(s), i)).collect();
    let corner = |face: u32, k: usize| triangulation.faces[face as usize].vertices[k % 3];
    let mut number = vec![COVERED; triangulation.faces.len()];
    let mut kept: Vec<u32> = Vec::new();
    let first_void = t.corners() as u32;
    let mut keep = |face: u32, kept: &mut Vec<u32>| {
        if number[face as usize] == COVERED {
            number[face as usize] = first_void + kept.len() as u32;
            kept.push(face);
        }
    };
    if sides.is_empty() {
        // There is no triangle: all is void.
        (0..triangulation.faces.len() as u32).for_each(|face| keep(face, &mut kept));
    }
    // The face beyond a side of the rim, and its vertex opposite the side.
    let beyond_side = |side: &Side| {
        let (from, to) = ends(side);
        triangulation.left_of(to, from).expect("rim sides are sides of the triangulation")
    };
    sides.iter().for_each(|side| keep(beyond_side(side).0, &mut kept));
    let mut next = 0;
    while let Some(&face) = kept.get(next) {
        next += 1;
        for k in 0..3 {
            let (a, b) = (corner(face, k + 1), corner(face, k + 2));
            if let Some(&i) = of_rim.get(&(a, b)) {
                return Err(overlap(t, &sides[i], &sides[i]));
            }
            if !of_rim.contains_key(&(b, a)) {
                keep(triangulation.faces[face as usize].beyond[k], &mut kept);
            }
        }
    }
    if first_void as usize + kept.len() > HalfEdges::MAX_TRIANGLES {
        return Err(Error::grid(format!(
            "corner: {first_void} rows and {} void triangles, expected at most {}",
            kept.len(),
            HalfEdges::MAX_TRIANGLES
        )));
    }
    // The half-edge of a face or of a triangle that leads through its side opposite vertex k.
    let through = |triangle: u32, k: usize| half_edge(triangle, (k + 1) % 3);
    for side in sides {
        let (face, k) = beyond_side(side);
        half_edges[side.triangle as usize].set_beyond(side.opposite, through(number[face as usize], k));
    }
    // Vertices become cells, or synthetic points in the order of their occurrence.
    let mut cell: HashMap<u32, u32> = vertex.iter().map(|(cell, v)| (*v, *cell)).collect();
    for &face in &kept {
        let cells = triangulation.faces[face as usize].vertices.map(|v| {
            *cell.entry(v).or_insert_with(|| {
                direction.push(triangulation.point(v).to_array());
                direction.len() as u32 - 1
            })
        });
        let beyond = [0, 1, 2].map(|k| {
            let side = of_rim.get(&(corner(face, k + 2), corner(face, k + 1)));
            let other = triangulation.faces[face as usize].beyond[k];
            side.map_or_else(
                || through(number[other as usize], triangulation.place_of(other, face)),
                |&i| through(sides[i].triangle, sides[i].opposite),
            )
        });
        half_edges.push(HalfEdges::new(cells, beyond));
    }
    Ok(())
}

fn overlap(t: &GridTables, a: &Side, b: &Side) -> Error {
    Error::grid(format!(
        "{}: other triangles lie over the {}, beyond which a cell or corner is missing; expected triangles that do not \
         overlap",
        rows(t, "corner_cell", a.triangle as usize, b.triangle as usize),
        a.name(t)
    ))
}
