//! Damaged grid tables are refused or drawn, without a panic or an endless ray. Half of the meshes have holes.
//!
//! Correct meshes are damaged at random, 2,000 times, or 60,000 in the long run, each from its own seed, so that a
//! failure can be repeated.

use crate::common::{icosahedral, scene};
use crate::culled::{Culled, Mark, Style, holes};
use icoray::{
    ErrorKind, Field, Frame, Grid, GridTables, IcosahedralMesh, Indices, Layers, Location, LonLat, Renderer, Scene,
    Shape,
};
use icoray_test_support::{Random, count};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// A grid's tables, to be damaged.
#[derive(Clone)]
struct Tables {
    /// lon and lat of centres and corners.
    reals: [Vec<f64>; 4],
    /// cell_corner, corner_cell, corner_edge, edge_corner, cell_corner_count.
    rows: [Vec<i64>; 5],
    has_count: bool,
    row: usize,
    base: i32,
    is_wide: bool,
}

/// How many entries a row of each table of indices has.
const WIDTHS: [usize; 5] = [6, 3, 3, 2, 1];

impl Tables {
    /// Of a whole mesh or one with holes, in some style.
    fn new(mesh: &IcosahedralMesh, random: &mut Random, has_holes: bool) -> Self {
        let [base, is_wide, has_count] = [(); 3].map(|()| random.below(2));
        let (all, holes) = (vec![true; mesh.cells()], holes(mesh));
        let stays = &holes[random.below(holes.len())].1;
        let stays = if has_holes && stays.contains(&true) { stays } else { &all };
        let style = [Style::Corners, Style::Triangles][random.below(2)];
        let mark = [Mark::BeforeFirst, Mark::MinusOne, Mark::BehindLast][random.below(3)];
        let culled = Culled::new(mesh, stays, style, mark, base as i32);
        let rows = [&culled.cell_corner, &culled.corner_cell, &culled.corner_edge, &culled.edge_corner];
        let [cell_corner, corner_cell, corner_edge, edge_corner] =
            rows.map(|table| table.iter().map(|v| i64::from(*v)).collect::<Vec<i64>>());
        // A pentagon's last corner stands twice.
        let count = cell_corner.chunks_exact(6).map(|row| if row[4] == row[5] { 5 } else { 6 }).collect();
        Tables {
            rows: [cell_corner, corner_cell, corner_edge, edge_corner, count],
            reals: culled.lon_lat,
            has_count: has_count == 1,
            row: 6,
            base: base as i32,
            is_wide: is_wide == 1,
        }
    }

    fn damage(&mut self, random: &mut Random) {
        let table = random.below(5);
        let width = WIDTHS[table];
        let limit = [self.reals[2].len(), self.reals[0].len(), self.rows[3].len() / 2][random.below(3)] as i64;
        let rows = &mut self.rows[table];
        let (at, other) = (random.below(rows.len()), random.below(rows.len()));
        let (row, other_row) = (random.below(rows.len() / width), random.below(rows.len() / width));
        match random.below(16) {
            0 if !rows.is_empty() => rows[at] ^= 1 << random.below(if self.is_wide { 64 } else { 31 }),
            1 if !rows.is_empty() => rows.swap(at, other),
            2 if !rows.is_empty() => rows[at] = rows[at].wrapping_add(1 - 2 * random.below(2) as i64),
            3 if !rows.is_empty() => {
                let odd = [i64::MIN, i64::MAX, -1, 0, limit, limit + 1, limit - 1, 1 << 31, 1 << 40, -2];
                rows[at] = odd[random.below(odd.len())];
            }
            4 if !rows.is_empty() => rows[at] = random.below(limit as usize) as i64 + i64::from(self.base),
            5 if rows.len() >= width => rows.copy_within(row * width..(row + 1) * width, other_row * width),
            6 if rows.len() >= width => {
                (0..width).for_each(|k| rows.swap(row * width + k, other_row * width + k));
            }
            7 => rows.truncate(at),
            8 => rows.extend(vec![i64::from(self.base); width * (1 + random.below(3))]),
            9 => self.rows.swap(table, random.below(4)),
            kind @ 10..=12 => {
                let odd = [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e300, 5e-324, 0.0, -3.2, 1.7, 7.0];
                let reals = &mut self.reals[random.below(4)];
                let (a, b) = (random.below(reals.len()), random.below(reals.len()));
                match (kind, random.below(3)) {
                    (12, _) => reals.resize(random.below(reals.len() + 3), 0.5),
                    _ if reals.is_empty() => (),
                    (10, _) => reals[a] = odd[random.below(odd.len())],
                    // A centre where another is too, near it, or in its place.
                    (_, 0) => reals[a] = reals[b],
                    (_, 1) => reals[a] += 1e-3 * (random.below(1000) as f64 - 500.0),
                    _ => reals.swap(a, b),
                }
            }
            13 => self.reals.swap(random.below(4), random.below(4)),
            14 if rows.len() >= width => {
                rows[row * width..(row + 1) * width].rotate_left(random.below(width));
            }
            _ => match random.below(4) {
                0 => self.row = [0, 1, 2, 3, 5, 7, 1 << 40, usize::MAX][random.below(8)],
                1 => self.base = [-1, 0, 1, 2, i32::MIN, i32::MAX][random.below(6)],
                2 => self.has_count = !self.has_count,
                _ => self.rows[4].iter_mut().for_each(|v| *v = random.below(9) as i64),
            },
        }
    }

    /// Whether the grid is taken; `draw` gets it then.
    fn with<R>(&self, draw: impl FnOnce(icoray::Result<Grid>) -> R) -> R {
        let narrow = |table: &Vec<i64>| table.iter().map(|v| *v as i32).collect::<Vec<i32>>();
        let narrowed = [0, 1, 2, 3, 4].map(|k| narrow(&self.rows[k]));
        let table = |k: usize| -> Indices {
            if self.is_wide { self.rows[k].as_slice().into() } else { narrowed[k].as_slice().into() }
        };
        let at = |k: usize| LonLat {
            lon_rad: self.reals[k].as_slice().into(),
            lat_rad: self.reals[k + 1].as_slice().into(),
        };
        draw(Grid::new(GridTables {
            index_base: self.base,
            center: at(0),
            corner: at(2),
            cell_corner: table(0),
            cell_corner_row: self.row,
            cell_corner_count: self.has_count.then(|| table(4)),
            corner_cell: table(1),
            corner_edge: table(2),
            edge_corner: table(3),
        }))
    }
}

fn lit(kind: &str) -> Scene {
    let transfer = "map = \"viridis\"\nrange = [-1.5, 1.5]\nopacity = [[-1.5, 0.8], [0, 0.1], [1.5, 0.9]]";
    let keys = "exaggeration = 40\ntolerance = 1e-2\nimage = { width = 8, height = 8 }";
    scene("lon = 20\nlat = 35\ndistance = 3.2", transfer, &format!("{keys}|[light]\nkind = \"{kind}\""))
}

/// Names of which an error must have one.
const NAMES: [&str; 9] = [
    "center",
    "corner",
    "cell_corner",
    "cell_corner_count",
    "corner_cell",
    "corner_edge",
    "edge_corner",
    "index_base",
    "a closed sphere",
];

#[test]
fn damaged_tables_are_refused_or_drawn() {
    let count: u64 = count(2_000, 60_000);
    let meshes = [0, 1, 2].map(|level| IcosahedralMesh::new(level).unwrap());
    let renderer = Renderer::new(2).unwrap();
    let layers = Layers::from_heights(&[0.0, 6e3, 20e3], 6371e3).unwrap();
    let scenes = ["none", "headlight"].map(lit);
    let (mut taken, mut refused) = (0, 0);
    // Panics are reported with their seed; the hook would only be in the way.
    for seed in 0..count {
        let mut random = Random::new(seed);
        let mesh = &meshes[random.below(3)];
        let mut tables = Tables::new(mesh, &mut random, seed % 2 == 1);
        // The first of all are right.
        let damages = if seed < 100 { 0 } else { 1 + random.below(4) };
        for _ in 0..damages {
            tables.damage(&mut random);
        }
        let corners = random.below(2) == 1;
        let outcome = catch_unwind(AssertUnwindSafe(|| {
            tables.with(|grid| {
                let grid = grid?;
                let corners = corners && grid.triangles() > 0;
                let columns = if corners { grid.triangles() } else { grid.cells() };
                let values: Vec<f32> = (0..columns * 3).map(|i| (i as f32 * 0.7).sin()).collect();
                let (shape, location) = if corners {
                    (Shape::cell_fastest(columns, 3), Location::Corner)
                } else {
                    (Shape::level_fastest(columns, 3), Location::Center)
                };
                let field = Field::new(values.as_slice().into(), shape, location, None)?;
                renderer.render(&scenes[random.below(2)], &grid, &layers, &field)
            })
        }));
        match outcome.unwrap_or_else(|_| panic!("seed {seed} panics")) {
            Ok(frame) => {
                taken += 1;
                assert_bounded(&frame, &format!("seed {seed}"));
            }
            Err(error) => {
                refused += 1;
                assert!(damages > 0, "seed {seed}: {error}");
                let message = error.to_string();
                let kinds = [ErrorKind::Grid, ErrorKind::Argument];
                assert!(kinds.contains(&error.kind()), "seed {seed}: {message}");
                assert!(NAMES.iter().any(|name| message.contains(name)), "seed {seed}: {message}");
            }
        }
    }
    println!("{count} damages: {refused} refused, {taken} drawn");
    // A damage may be harmless (a swap of rows that are alike), most are not.
    assert!(refused > count / 2 && taken > 100, "{refused} refused, {taken} drawn");
}

/// Fails unless rays were traced to finite pixels, and with bounded work: ten times what sound scenes of these meshes
/// take.
fn assert_bounded(frame: &Frame, what: &str) {
    assert!(frame.pixels.as_flattened().iter().all(|c| c.is_finite()), "{what}: a pixel is not finite");
    let counts = &frame.report.counts;
    assert!(counts.rays > 0, "{what}");
    assert!(counts.columns < 40 * counts.rays, "{what}: {counts:?}");
    assert!(counts.scalar_pieces < 40 * counts.rays, "{what}: {counts:?}");
}

/// Fields that no model should have, under light: bounded work, and finite pixels.
#[test]
fn extreme_values_are_drawn_in_bounded_work() {
    let (_, grid) = icosahedral(2);
    let layers = Layers::from_heights(&[0.0, 6e3, 20e3], 6371e3).unwrap();
    let renderer = Renderer::new(2).unwrap();
    let odd: [&[f64]; 6] = [
        &[1e-42, 3.4e38, -3.4e38, 1e-38],
        &[0.0, 1e308, -1e308],
        &[5e-324, 1e-310, 0.0, -0.0],
        &[f64::MAX, f64::MIN, f64::MIN_POSITIVE, 1.0],
        &[1.0, f64::NAN, 3.0, f64::INFINITY, f64::NEG_INFINITY],
        &[0.5],
    ];
    for values in odd {
        for scene in ["none", "headlight"].map(lit) {
            let double: Vec<f64> = (0..grid.cells() * 3).map(|i| values[i % values.len()]).collect();
            let single: Vec<f32> = double.iter().map(|v| *v as f32).collect();
            for samples in [double.as_slice().into(), single.as_slice().into()] {
                let shape = Shape::level_fastest(grid.cells(), 3);
                let field = Field::new(samples, shape, Location::Center, None).unwrap();
                let frame = renderer.render(&scene, &grid, &layers, &field).unwrap();
                assert_bounded(&frame, &format!("{values:?}"));
                assert!(frame.report.error.max.is_finite(), "{values:?}");
            }
        }
    }
}
