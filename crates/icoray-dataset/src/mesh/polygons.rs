//! Mesh tables from the corners of each cell.

use icoray::{Connectivity, Error, ErrorKind, Result, cut_polygon};
use std::collections::HashMap;

/// Marks missing entries in tables numbered from 0.
pub(super) const NONE: i32 = -1;

/// Each cell's corners, in order around it and numbered from 0, in rows of one length.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Polygons {
    pub corners: Vec<i32>,
    pub row: usize,
    /// Number of valid entries of each row.
    pub count: Vec<i32>,
}

impl Polygons {
    /// Converts rows in which a corner may occur several times: repeated corners, and negative entries, are left out.
    pub fn of_rows(rows: &[i32], row: usize) -> Self {
        let row = row.max(1);
        let (mut corners, mut count) = (Vec::with_capacity(rows.len()), Vec::new());
        for entries in rows.chunks_exact(row) {
            let start = corners.len();
            for &corner in entries.iter().filter(|corner| **corner >= 0) {
                if !corners[start..].contains(&corner) {
                    corners.push(corner);
                }
            }
            count.push((corners.len() - start) as i32);
            corners.resize(start + row, NONE);
        }
        Polygons { corners, row, count }
    }

    /// The corners of each cell.
    fn each(&self) -> impl Iterator<Item = &[i32]> {
        self.corners.chunks_exact(self.row).zip(&self.count).map(|(row, count)| &row[..*count as usize])
    }

    /// Whether a corner joins more than 3 cells.
    pub fn joins_more_than_3(&self, corners: usize) -> bool {
        let mut cells = vec![0u8; corners];
        let around = self.each().flatten().filter_map(|corner| usize::try_from(*corner).ok());
        around.filter(|corner| *corner < corners).any(|corner| {
            cells[corner] += 1;
            cells[corner] > 3
        })
    }

    /// Triangles of cells, and the corner of each: the polygon of the cells around a corner, whose middles are `at`, is
    /// cut by Delaunay's rule ([`cut_polygon`]). At the mesh's rim a corner of one or two cells has none.
    pub fn triangles(&self, corners: usize, at: impl Fn(i32) -> [f64; 3]) -> Result<(Vec<i32>, Vec<u32>)> {
        // For each cell at a corner: the cell, and the corners before and behind in its row.
        let mut start = vec![0; corners + 1];
        for (cell, around) in self.each().enumerate() {
            for &corner in around {
                places(&mut start, corner, corners, 1).map_err(|e| e.within(format!("cell {cell}")))?[0] += 1;
            }
        }
        let mut sum = 0;
        start.iter_mut().for_each(|first| sum += std::mem::replace(first, sum));
        let (mut next, mut wedges) = (start.clone(), vec![Wedge::default(); sum]);
        for (cell, around) in self.each().enumerate() {
            for (k, &corner) in around.iter().enumerate() {
                let [before, behind] = [around.len() - 1, 1].map(|turn| around[(k + turn) % around.len()]);
                let place = &mut next[corner as usize];
                wedges[*place] = Wedge { cell: cell as i32, sides: [before, behind] };
                *place += 1;
            }
        }
        let (mut triangles, mut corner_of) = (Vec::new(), Vec::new());
        for corner in 0..corners {
            for ring in rings(&mut wedges[start[corner]..start[corner + 1]]) {
                let cells: Vec<i32> = ring.iter().map(|wedge| wedge.cell).collect();
                let cut = cut_polygon(&cells, &at);
                corner_of.extend(std::iter::repeat_n(corner as u32, cut.len()));
                triangles.extend(cut.into_flattened());
            }
        }
        Ok((triangles, corner_of))
    }

    /// The cells around each corner, which joins at most 3 ([`Self::joins_more_than_3`]): 3 for each, with marks for
    /// missing ones.
    pub fn corner_cells(&self, corners: usize) -> Result<Vec<i32>> {
        let mut table = vec![NONE; 3 * corners];
        for (cell, around) in self.each().enumerate() {
            for &corner in around {
                let place = places(&mut table, corner, corners, 3).map_err(|e| e.within(format!("cell {cell}")))?;
                let is_put = put(place, cell as i32);
                assert!(is_put, "corner {corner} has more than 3 cells");
            }
        }
        Ok(table)
    }

    /// The tables of a mesh of these cells: the edges of each corner, 3 for each, and the two corners of each edge.
    /// Each side of a cell is an edge.
    pub fn connectivity(self, corners: usize) -> Result<Connectivity> {
        let (mut corner_edge, mut edge_corner) = (vec![NONE; 3 * corners], Vec::new());
        let mut known: HashMap<[i32; 2], i32> = HashMap::new();
        for around in self.each() {
            for (k, &one) in around.iter().enumerate() {
                let other = around[(k + 1) % around.len()];
                let number = (edge_corner.len() / 2) as i32;
                if *known.entry([one.min(other), one.max(other)]).or_insert(number) != number {
                    continue;
                }
                edge_corner.extend([one, other]);
                for corner in [one, other] {
                    if !put(places(&mut corner_edge, corner, corners, 3)?, number) {
                        let what = format!("corner {corner} has more than 3 edges");
                        return Err(Error::new(ErrorKind::Unsupported, what));
                    }
                }
            }
        }
        let Polygons { corners: cell_corner, row: cell_corner_row, count: cell_corner_count } = self;
        Ok(Connectivity { corner_edge, edge_corner, cell_corner, cell_corner_row, cell_corner_count })
    }

    /// Each cell's corners, put in order by the edges between them.
    pub fn of_edges(corner_cell: &[i32], edge_corner: &[i32], cells: usize) -> Result<Self> {
        let mut around: Vec<Vec<i32>> = vec![Vec::new(); cells];
        for (i, &cell) in corner_cell.iter().enumerate() {
            if let Some(corners) = usize::try_from(cell).ok().and_then(|cell| around.get_mut(cell)) {
                corners.push((i / 3) as i32);
            }
        }
        let mut beside: HashMap<i32, Vec<i32>> = HashMap::new();
        for pair in edge_corner.chunks_exact(2).filter(|pair| pair[0] >= 0 && pair[1] >= 0) {
            beside.entry(pair[0]).or_default().push(pair[1]);
            beside.entry(pair[1]).or_default().push(pair[0]);
        }
        let row = around.iter().map(Vec::len).max().unwrap_or(0).max(3);
        let (mut corners, mut count) = (Vec::with_capacity(cells * row), Vec::with_capacity(cells));
        for (cell, mut left) in around.into_iter().enumerate() {
            count.push(left.len() as i32);
            let start = corners.len();
            while !left.is_empty() {
                let last = corners[start..].last();
                let near = last.and_then(|last| beside.get(last));
                let next = left.iter().position(|corner| near.is_some_and(|near| near.contains(corner)));
                if next.is_none() && last.is_some() {
                    let what = format!("the corners of cell {cell} are not joined by edges to a polygon");
                    return Err(Error::new(ErrorKind::Grid, what));
                }
                corners.push(left.swap_remove(next.unwrap_or(0)));
            }
            corners.resize(start + row, NONE);
        }
        Ok(Polygons { corners, row, count })
    }
}

/// A cell at a corner, with the corners beside that one in the cell's row: the far ends of the two sides that meet
/// there.
#[derive(Debug, Clone, Copy, Default)]
struct Wedge {
    cell: i32,
    sides: [i32; 2],
}

/// Orders cells around a corner, each next to the one that it shares a side with: one run, or several if the mesh
/// touches itself in the corner. Runs begin at the rim, if they have one.
fn rings(wedges: &mut [Wedge]) -> impl Iterator<Item = &[Wedge]> {
    fn are_neighbours(one: &Wedge, other: &Wedge) -> bool {
        one.sides.iter().any(|side| other.sides.contains(side))
    }
    for at in 0..wedges.len() {
        let left = &wedges[at..];
        let beside =
            at.checked_sub(1).and_then(|last| left.iter().position(|next| are_neighbours(&wedges[last], next)));
        let is_rim = |side: &i32| wedges.iter().filter(|wedge| wedge.sides.contains(side)).count() == 1;
        let first = || left.iter().position(|wedge| wedge.sides.iter().any(is_rim)).unwrap_or(0);
        let next = beside.unwrap_or_else(first);
        wedges.swap(at, at + next);
    }
    wedges.chunk_by(are_neighbours)
}

/// The two corners of each edge, from the edges of each corner.
pub(super) fn ends_of_edges(corner_edge: &[i32]) -> Result<Vec<i32>> {
    let edges = corner_edge.iter().max().map_or(0, |max| max + 1).max(0) as usize;
    if edges > corner_edge.len() {
        let what = format!("edge {}, expected 0 to {}", edges - 1, corner_edge.len() as i64 - 1);
        return Err(Error::new(ErrorKind::Grid, what));
    }
    let mut table = vec![NONE; 2 * edges];
    for (i, &edge) in corner_edge.iter().enumerate().filter(|(_, edge)| **edge >= 0) {
        let ends = &mut table[2 * edge as usize..2 * edge as usize + 2];
        if !put(ends, (i / 3) as i32) {
            return Err(Error::new(ErrorKind::Grid, format!("edge {edge} has more than two corners")));
        }
    }
    Ok(table)
}

/// The cells around each corner, from the cells beside each edge.
pub(super) fn cells_of_corners(edge_corner: &[i32], edge_cell: &[i32], corners: usize) -> Result<Vec<i32>> {
    let mut table = vec![NONE; 3 * corners];
    for (ends, cells) in edge_corner.chunks_exact(2).zip(edge_cell.chunks_exact(2)) {
        for (&corner, &cell) in ends.iter().flat_map(|corner| cells.iter().map(move |cell| (corner, cell))) {
            if corner < 0 || cell < 0 {
                continue;
            }
            let place = places(&mut table, corner, corners, 3)?;
            if !place.contains(&cell) && !put(place, cell) {
                let what = format!("corner {corner} has more than 3 cells");
                return Err(Error::new(ErrorKind::Unsupported, what));
            }
        }
    }
    Ok(table)
}

/// Stores an entry in the first free place; returns whether there is one.
fn put(places: &mut [i32], entry: i32) -> bool {
    let free = places.iter_mut().find(|place| **place == NONE);
    free.map(|place| *place = entry).is_some()
}

/// The entries of a corner in a table with rows of `row`.
fn places<E>(table: &mut [E], corner: i32, corners: usize, row: usize) -> Result<&mut [E]> {
    let start = usize::try_from(corner).ok().filter(|corner| *corner < corners).map(|corner| row * corner);
    match start {
        Some(start) => Ok(&mut table[start..start + row]),
        None => {
            let what = format!("corner {corner}, expected 0 to {}", corners as i64 - 1);
            Err(Error::new(ErrorKind::Grid, what))
        }
    }
}
