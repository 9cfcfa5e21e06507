//! Meshes with tables that are derived from others.

use crate::made::{Made, Values};
use crate::made_icon::{Angles, LAYERS};
use crate::memory::{direction, direction_of, expect, names, open, opened, spoilt, values};
use icoray::{ErrorKind, Grid, IcosahedralMesh, Location};
use icoray_dataset::MeshLayout;

/// The cells of each triangle, sorted, by the triangle's number.
fn triangles(grid: &Grid) -> Vec<[u32; 3]> {
    let of = |t| {
        let mut cells = grid.triangle(t);
        cells.sort_unstable();
        cells
    };
    (0..grid.triangles() as u32).map(of).collect()
}

#[test]
fn tables_that_others_determine_are_made() {
    let whole = open(&Made::mesh(false));
    let expected = triangles(&whole.mesh().grid().unwrap());
    for lacking in [
        &["cellsOnVertex"][..],
        &["verticesOnCell"],
        &["nEdgesOnCell"],
        &["edgesOnVertex"],
        &["verticesOnEdge"],
        &["verticesOnCell", "nEdgesOnCell"],
        &["edgesOnVertex", "verticesOnEdge"],
        &["cellsOnVertex", "edgesOnVertex", "verticesOnEdge", "cellsOnEdge"],
        &["cellsOnVertex", "verticesOnCell", "nEdgesOnCell", "edgesOnVertex"],
        &["cellsOnVertex", "verticesOnCell", "verticesOnEdge"],
        &["verticesOnCell", "nEdgesOnCell", "edgesOnVertex", "verticesOnEdge", "cellsOnEdge"],
    ] {
        let mut made = Made::mesh(false);
        made.remove_all(lacking);
        let file = opened(&made, &[]).unwrap_or_else(|e| panic!("{lacking:?}: {e}"));
        let grid = file.mesh().grid().unwrap_or_else(|e| panic!("{lacking:?}: {e}"));
        assert_eq!(triangles(&grid), expected, "{lacking:?}");
        assert_eq!((grid.void_triangles(), file.mesh().edges()), (0, 120), "{lacking:?}");
    }
}

#[test]
fn tables_that_nothing_determines_are_named() {
    for lacking in [
        &["cellsOnVertex", "verticesOnCell", "cellsOnEdge"][..],
        &["cellsOnVertex", "verticesOnCell", "verticesOnEdge", "edgesOnVertex"],
    ] {
        let error = spoilt(Made::mesh(false), |made| made.remove_all(lacking));
        expect(&error, ErrorKind::Grid, &["made.nc", "cellsOnVertex is missing", "another file"]);
    }
    let error = spoilt(Made::mesh(false), |made| {
        made.remove("cellsOnVertex");
        made.i32s("verticesOnCell")[9] = 81;
    });
    expect(&error, ErrorKind::Grid, &["cell 1: corner 80, expected 0 to 79"]);
    let error = spoilt(Made::mesh(false), |made| {
        made.remove_all(&["verticesOnEdge", "verticesOnCell"]);
        made.i32s("edgesOnVertex")[9] = i32::MAX;
    });
    expect(&error, ErrorKind::Grid, &["made.nc", "edge 2147483646, expected 0 to 239"]);
}

#[test]
fn positions_may_be_cartesian() {
    let expected = open(&Made::mesh(false));
    let mut made = Made::mesh(false);
    for (of_cells, names) in [
        (["lonCell", "latCell"], ["xCell", "yCell", "zCell"]),
        (["lonVertex", "latVertex"], ["xVertex", "yVertex", "zVertex"]),
    ] {
        let [lon, lat] = of_cells.map(|name| made.f64s(name).clone());
        let dimension = if names[0] == "xCell" { "nCells" } else { "nVertices" };
        let radius = 6_371_229.0;
        let places: Vec<[f64; 3]> = lon.iter().zip(&lat).map(|(lon, lat)| direction(*lon, *lat)).collect();
        for (k, name) in names.into_iter().enumerate() {
            made.add(name, &[dimension], Values::F64(places.iter().map(|place| radius * place[k]).collect()));
        }
        made.remove_all(&of_cells);
    }
    let file = open(&made);
    file.mesh().grid().unwrap();
    let [found, expected] = [&file, &expected].map(|file| file.mesh().tables().corner);
    for i in 0..80 {
        assert!((found.lat_rad.get(i) - expected.lat_rad.get(i)).abs() < 1e-12, "{i}");
        assert!((found.lon_rad.get(i).cos() - expected.lon_rad.get(i).cos()).abs() < 1e-12, "{i}");
    }
}

/// An ocean: of every seventh cell nothing is left, nor corners and edges that no other cell has.
#[test]
fn corners_of_cells_show_where_holes_are() {
    let mesh = IcosahedralMesh::new(3).unwrap();
    let kept: Vec<usize> = (0..mesh.cells()).filter(|cell| cell % 7 != 0).collect();
    let mut number = vec![0i32; mesh.lon_corner_rad.len()];
    let (mut corners, mut rows, mut count) = (Vec::new(), Vec::new(), Vec::new());
    for &cell in &kept {
        let mut row: Vec<i32> = Vec::new();
        for &corner in &mesh.cell_corner[6 * cell..6 * cell + 6] {
            let corner = corner as usize;
            if number[corner] == 0 {
                corners.push(corner);
                number[corner] = corners.len() as i32;
            }
            if !row.contains(&number[corner]) {
                row.push(number[corner]);
            }
        }
        count.push(row.len() as i32);
        row.resize(6, 0);
        rows.extend(row);
    }
    let whole = |corner: &&usize| (0..3).all(|k| mesh.corner_cell[3 * **corner + k] % 7 != 0);
    let expected = corners.iter().filter(whole).count();
    let at = |angles: &[f64], of: &[usize]| Values::F64(of.iter().map(|i| angles[*i]).collect());
    let mut made = Made::of(
        [("nCells", kept.len()), ("nVertices", corners.len()), ("maxEdges", 6)],
        [("sphere_radius", 6_371_229.0.into())],
    );
    made.add("lonCell", &["nCells"], at(&mesh.lon_center_rad, &kept));
    made.add("latCell", &["nCells"], at(&mesh.lat_center_rad, &kept));
    made.add("lonVertex", &["nVertices"], at(&mesh.lon_corner_rad, &corners));
    made.add("latVertex", &["nVertices"], at(&mesh.lat_corner_rad, &corners));
    made.add("nEdgesOnCell", &["nCells"], Values::I32(count));
    made.add("verticesOnCell", &["nCells", "maxEdges"], Values::I32(rows));
    let file = open(&made);
    let grid = file.mesh().grid().unwrap();
    let there = (0..grid.triangles() as u32).filter(|t| grid.is_triangle(*t)).count();
    assert_eq!((grid.cells(), grid.triangles(), there), (kept.len(), corners.len(), expected));
    assert!(grid.void_triangles() > 50, "{}", grid.void_triangles());
}

/// extpar's files have points of triangles and no middles.
#[test]
fn points_of_triangles_are_enough() {
    let whole = open(&Made::icon_data(Angles::Radians));
    let mut made = Made::icon_data(Angles::Radians);
    made.remove_all(&["clon", "clat"]);
    for (old, new) in [("clon_bnds", "clon_vertices"), ("clat_bnds", "clat_vertices")] {
        made.variable(old).attributes = vec![("units", "radian".into())];
        made.variable(old).name = new;
    }
    made.dimensions.push(("cell", 80));
    made.add("topography_c", &["ncells"], Values::F32((0..80).map(|i| i as f32).collect()));
    let file = open(&made);
    let (grid, expected) = (file.mesh().grid().unwrap(), whole.mesh().grid().unwrap());
    assert_eq!((triangles(&grid), file.mesh().layout()), (triangles(&expected), MeshLayout::Triangles));
    assert_eq!(file.likely_fields()[0].name, "ta");
    assert!(file.field_info("topography_c").unwrap().is_2d());
    // The middles are as far from each of their points.
    let tables = file.mesh().tables();
    for triangle in 0..80 {
        let middle = direction_of(tables.corner, triangle);
        let cosines = grid.triangle(triangle as u32).map(|cell| {
            let point = direction_of(tables.center, cell as usize);
            (0..3).map(|k| middle[k] * point[k]).sum::<f64>()
        });
        assert!(cosines.iter().all(|c| *c > 0.8 && (c - cosines[0]).abs() < 1e-7), "{cosines:?}");
    }
}

#[test]
fn hexagons_with_bounds_are_a_mesh() {
    for angles in [Angles::Radians, Angles::Degrees, Angles::Degrees32] {
        for has_middles in [true, false] {
            let mut made = Made::dynamico(angles);
            if !has_middles {
                made.remove("lon");
                made.remove("lat");
            }
            let file = open(&made);
            assert_eq!(file.mesh().layout(), MeshLayout::Polygons);
            let grid = file.mesh().grid().unwrap();
            assert_eq!((grid.cells(), grid.triangles(), file.mesh().edges()), (162, 320, 480));
            assert_eq!(grid.void_triangles(), 0);
            let info = file.field_info("ta").unwrap();
            assert_eq!((info.location, info.columns, info.layers), (Location::Center, 162, LAYERS));
            assert!(file.layer_heights("ta").unwrap().is_of_pressure);
            assert!(file.field_info("ps").unwrap().is_2d());
            assert_eq!(values(&file, "ta", 1)(5, 1), 1005.125);
            assert_eq!(names(&file), ["ta", "ps"]);
        }
    }
}

#[test]
fn polygons_that_are_none_are_named() {
    let error = spoilt(Made::dynamico(Angles::Degrees), |made| made.f64s("lat_bnds")[13] = f64::NAN);
    expect(&error, ErrorKind::Grid, &["the bounds of cell 2 are", "NaN", "three different points"]);
}

/// Squares meet four at a point: the four middles are two triangles.
#[test]
fn corners_of_four_polygons_are_cut() {
    let mut made = Made::of([("cell", 4), ("nv", 4)], []);
    let corner = |c: i32| [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(x, y)| (x + c % 2, y + c / 2));
    let squares: Vec<(i32, i32)> = (0..4).flat_map(corner).collect();
    let (lon, lat) = squares.iter().map(|(x, y)| (f64::from(20 * x), f64::from(20 * y))).unzip();
    made.add("lon_bnds", &["cell", "nv"], Values::F64(lon));
    made.add("lat_bnds", &["cell", "nv"], Values::F64(lat));
    let file = open(&made);
    let grid = file.mesh().grid().unwrap();
    assert_eq!((grid.cells(), grid.triangles(), file.mesh().corners_in_file()), (4, 2, 9));
}
