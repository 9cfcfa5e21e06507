//! Meshes with holes, made from whole ones as models make them, and the holes that are tried.
//!
//! The parent module brings `Grid`, `GridTables`, `IcosahedralMesh`, `LonLat`.

#![allow(dead_code, reason = "each test takes what it needs of this")]

use super::{Grid, GridTables, IcosahedralMesh, LonLat};
use glam::DVec3;
use icoray_test_support::Random;

/// How a table says that something is missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// The number before the first: 0 in tables that count from 1.
    BeforeFirst,
    MinusOne,
    /// The number behind the last.
    BehindLast,
}

/// Which rows stay beside a hole.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Style {
    /// As MPAS-Tools cull: every corner and edge of a cell that stays.
    Corners,
    /// Triangles only: corners and edges without data are left out.
    Triangles,
}

/// A mesh without some of its cells, renumbered.
#[derive(Debug, Clone)]
pub struct Culled {
    pub base: i32,
    pub lon_lat: [Vec<f64>; 4],
    pub cell_corner: Vec<i32>,
    pub corner_cell: Vec<i32>,
    pub corner_edge: Vec<i32>,
    pub edge_corner: Vec<i32>,
    /// The whole mesh's number of each cell and corner.
    pub cells: Vec<usize>,
    pub corners: Vec<usize>,
}

impl Culled {
    /// `mesh` with those cells that `stays` is true for.
    pub fn new(mesh: &IcosahedralMesh, stays: &[bool], style: Style, mark: Mark, base: i32) -> Self {
        let cells_of = |corner: usize| &mesh.corner_cell[3 * corner..3 * corner + 3];
        let corner_stays = |corner: usize| {
            let mut cells = cells_of(corner).iter().map(|&cell| stays[cell as usize]);
            if style == Style::Corners { cells.any(|s| s) } else { cells.all(|s| s) }
        };
        let kept =
            |count: usize, stays: &dyn Fn(usize) -> bool| -> Vec<usize> { (0..count).filter(|&i| stays(i)).collect() };
        let cells = kept(mesh.cells(), &|cell| stays[cell]);
        let corners = kept(mesh.corner_cell.len() / 3, &corner_stays);
        let edge_stays = |edge: usize| {
            let ends = [2 * edge, 2 * edge + 1].map(|i| mesh.edge_corner[i] as usize);
            let joins = |cell: &&i32| cells_of(ends[1]).contains(cell) && stays[**cell as usize];
            match style {
                // The two cells that an edge parts are those of both its corners.
                Style::Corners => cells_of(ends[0]).iter().any(|cell| joins(&cell)),
                Style::Triangles => ends.into_iter().any(corner_stays),
            }
        };
        let edges = kept(mesh.edge_corner.len() / 2, &edge_stays);
        let numbers = |kept: &[usize], count: usize| {
            let missing = match mark {
                Mark::BeforeFirst => base - 1,
                Mark::MinusOne => -1,
                Mark::BehindLast => kept.len() as i32 + base,
            };
            let mut numbers = vec![missing; count];
            (base..).zip(kept).for_each(|(number, &i)| numbers[i] = number);
            numbers
        };
        let cell = numbers(&cells, mesh.cells());
        let corner = numbers(&corners, mesh.corner_cell.len() / 3);
        let edge = numbers(&edges, mesh.edge_corner.len() / 2);
        let rows = |table: &[i32], width: usize, kept: &[usize], numbers: &[i32]| -> Vec<i32> {
            let rows = kept.iter().flat_map(|&row| &table[row * width..(row + 1) * width]);
            rows.map(|&i| numbers[i as usize]).collect()
        };
        let pick = |values: &[f64], kept: &[usize]| kept.iter().map(|&i| values[i]).collect::<Vec<f64>>();
        Culled {
            base,
            lon_lat: [
                pick(&mesh.lon_center_rad, &cells),
                pick(&mesh.lat_center_rad, &cells),
                pick(&mesh.lon_corner_rad, &corners),
                pick(&mesh.lat_corner_rad, &corners),
            ],
            cell_corner: rows(&mesh.cell_corner, 6, &cells, &corner),
            corner_cell: rows(&mesh.corner_cell, 3, &corners, &cell),
            corner_edge: rows(&mesh.corner_edge, 3, &corners, &edge),
            edge_corner: rows(&mesh.edge_corner, 2, &edges, &corner),
            cells,
            corners,
        }
    }

    pub fn tables(&self) -> GridTables<'_> {
        let [lon, lat, lon_corner, lat_corner] = &self.lon_lat;
        GridTables {
            index_base: self.base,
            center: LonLat { lon_rad: lon.as_slice().into(), lat_rad: lat.as_slice().into() },
            corner: LonLat { lon_rad: lon_corner.as_slice().into(), lat_rad: lat_corner.as_slice().into() },
            cell_corner: self.cell_corner.as_slice().into(),
            cell_corner_row: 6,
            cell_corner_count: None,
            corner_cell: self.corner_cell.as_slice().into(),
            corner_edge: self.corner_edge.as_slice().into(),
            edge_corner: self.edge_corner.as_slice().into(),
        }
    }

    /// Turns and mirrors rows of tables, each by itself.
    pub fn shuffle(&mut self) {
        let tables = [(&mut self.corner_cell, 3), (&mut self.corner_edge, 3), (&mut self.edge_corner, 2)];
        for (k, (table, width)) in tables.into_iter().enumerate() {
            for (i, row) in table.chunks_exact_mut(width).enumerate() {
                if (i * 7 + k).is_multiple_of(3) {
                    row.swap(0, 1);
                }
                row.rotate_left((i + k) % width);
            }
        }
    }

    pub fn grid(&self) -> Grid<'_> {
        Grid::new(self.tables()).unwrap_or_else(|e| panic!("{e}"))
    }
}

/// A direction at a longitude and latitude in degrees.
pub fn towards(lon_deg: f64, lat_deg: f64) -> DVec3 {
    let ((sin_lon, cos_lon), (sin_lat, cos_lat)) = (lon_deg.to_radians().sin_cos(), lat_deg.to_radians().sin_cos());
    DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat)
}

/// Whether a direction is within `degrees` of a place.
pub fn is_near(p: DVec3, lon_deg: f64, lat_deg: f64, degrees: f64) -> bool {
    p.angle_between(towards(lon_deg, lat_deg)) < degrees.to_radians()
}

pub fn directions(lon_rad: &[f64], lat_rad: &[f64]) -> Vec<DVec3> {
    lon_rad.iter().zip(lat_rad).map(|(lon, lat)| towards(lon.to_degrees(), lat.to_degrees())).collect()
}

/// A name and which cells stay.
pub type Hole = (&'static str, Vec<bool>);

pub fn holes(mesh: &IcosahedralMesh) -> Vec<Hole> {
    let at = directions(&mesh.lon_center_rad, &mesh.lat_center_rad);
    let by = |stays: &dyn Fn(usize, DVec3) -> bool| -> Vec<bool> {
        at.iter().enumerate().map(|(cell, p)| stays(cell, *p)).collect()
    };
    let continents =
        |p: DVec3| is_near(p, 20.0, 35.0, 28.0) || is_near(p, -70.0, 0.0, 35.0) || is_near(p, 130.0, -25.0, 18.0);
    vec![
        ("a single cell", by(&|cell, _| cell != 40)),
        ("both poles", by(&|_, p| p.z.abs() < 0.9)),
        ("continents with a lake", by(&|_, p| !continents(p) || is_near(p, -70.0, 5.0, 16.0))),
        ("a limited area", by(&|_, p| is_near(p, 30.0, 40.0, 25.0))),
        ("a limited area at a pole", by(&|_, p| p.z > 0.8)),
        ("all but a cap", by(&|_, p| !is_near(p, 25.0, 30.0, 20.0))),
        ("half of the sphere", by(&|_, p| p.x > 0.0)),
        ("a belt", by(&|_, p| p.z.abs() < 0.35)),
        ("patches", by(&|_, p| continents(p) || is_near(p, 60.0, 60.0, 12.0))),
        ("every third cell missing", by(&|cell, _| Random::at(cell).unit() > 0.33)),
        ("half of the cells missing", by(&|cell, _| Random::at(cell).unit() > 0.5)),
        ("nearly all cells missing", by(&|cell, _| Random::at(cell).unit() > 0.8)),
        ("islands of one cell", by(&|cell, _| cell % 37 == 5)),
    ]
}
