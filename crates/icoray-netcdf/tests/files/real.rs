//! Real files, where they are: in the folder that `ICORAY_TEST_DATA` names, or in `shared/data` beside the repository.

use crate::refused::expect;
use icoray::{CenterField, ErrorKind, Location};
use icoray_netcdf::{ModelFile, Precision};
use std::path::{Path, PathBuf};

/// The path of a test file; says so where there is none.
fn data(name: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("ICORAY_TEST_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"), PathBuf::from);
    let path = folder.join(name);
    if !path.is_file() {
        eprintln!("skipped: no {}", path.display());
        return None;
    }
    Some(path)
}

#[test]
fn jablonowski_williamson_wave() {
    let Some(path) = data("mpas_jw_10242.nc") else {
        return;
    };
    let file = ModelFile::open(path).unwrap();
    let grid = file.mesh().grid().unwrap();
    assert_eq!((grid.cells(), grid.triangles(), file.mesh().edges()), (10242, 20480, 30720));
    assert_eq!(file.sphere_radius_m(), 6_371_229.0);
    let times: Vec<&str> = file.times().iter().flatten().map(String::as_str).collect();
    assert_eq!(times, ["0000-01-01_00:00:00", "0000-01-07_00:00:00", "0000-01-10_00:00:00"]);

    let heights = file.layer_heights("theta").unwrap();
    assert_eq!((heights.variable.as_str(), heights.layers.count()), ("zgrid", 27));
    assert!(heights.height_m[26] > 20_000.0 && heights.height_m[26] < 60_000.0, "{heights:?}");

    let of = |name: &str| {
        let info = file.field_info(name).unwrap();
        (info.location, info.layers, info.precision, info.time_dependent)
    };
    assert_eq!(of("theta"), (Location::Center, 26, Precision::F32, true));
    assert_eq!(of("w"), (Location::Center, 27, Precision::F32, true));
    assert_eq!(of("vorticity"), (Location::Corner, 26, Precision::F32, true));
    for info in file.fields() {
        heights.layers.for_field(info.layers).unwrap();
    }

    // A stable atmosphere: potential temperature rises in every column.
    let theta = file.read_field("theta", 2).unwrap();
    let theta = theta.field().unwrap();
    for cell in (0..grid.cells()).step_by(97) {
        assert!((1..26).all(|layer| theta.value(cell, layer) > theta.value(cell, layer - 1)), "cell {cell}");
    }
    // The wave grows, so the records differ.
    let fastest = |time| {
        let w = file.read_field("w", time).unwrap();
        let ([low, high], missing) = (w.field().unwrap().range().0.unwrap(), w.field().unwrap().range().1);
        assert_eq!(missing, 0);
        high.max(-low)
    };
    assert!(fastest(2) > 2.0 * fastest(0), "{} {}", fastest(2), fastest(0));
    let vorticity = file.read_field("vorticity", 1).unwrap();
    let center = CenterField::average(&grid, &vorticity.field().unwrap()).unwrap();
    assert_eq!(center.field().range().1, 0);
}

#[test]
fn a_cut_off_history_is_an_error() {
    let Some(path) = data("mpas_jw_10242.nc") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let cut = folder.path().join("cut.nc");
    let whole = std::fs::read(path).unwrap();
    std::fs::write(&cut, &whole[..12_000_000]).unwrap();
    let file = ModelFile::open(&cut).unwrap();
    file.read_field("theta", 0).unwrap();
    expect(&file.read_field("theta", 2).unwrap_err(), ErrorKind::Io, &["cut.nc", "theta", "cut off"]);
    assert_eq!(file.times()[2], None);
    std::fs::write(&cut, &whole[..100_000]).unwrap();
    expect(&ModelFile::open(&cut).unwrap_err(), ErrorKind::Io, &["cut.nc", "cut off"]);
}

#[test]
fn a_bare_mesh_on_the_unit_sphere() {
    let Some(path) = data("mesh.QU.1920km.151026.nc") else {
        return;
    };
    let file = ModelFile::open(path).unwrap();
    assert_eq!(file.mesh().grid().unwrap().cells(), 162);
    assert_eq!((file.sphere_radius_m(), file.fields().len(), file.times()), (1.0, 0, &[None][..]));
    expect(&file.layers("theta").unwrap_err(), ErrorKind::Field, &["fields in the file: none"]);
    expect(&file.read_field("theta", 0).unwrap_err(), ErrorKind::Field, &["fields in the file: none"]);
}

/// An ocean without land, as MPAS-Tools cull it: 0 for cells in cellsOnVertex and for edges in edgesOnVertex.
#[test]
fn an_ocean_has_holes() {
    let Some(path) = data("spherical_grid_500km_landculled.nc") else {
        return;
    };
    let file = ModelFile::open(path).unwrap();
    let grid = file.mesh().grid().unwrap();
    assert_eq!((grid.cells(), grid.triangles(), file.mesh().max_edges()), (1735, 3924, 8));
    let there = (0..3924).filter(|&corner| grid.is_triangle(corner)).count();
    assert_eq!(there, 3924 - 933);
    assert!((300..2000).contains(&grid.void_triangles()), "{}", grid.void_triangles());
    for cell in 0..1735 {
        for corner in grid.corners_of(cell).filter(|&corner| grid.is_triangle(corner)) {
            assert!(grid.triangle(corner).contains(&cell));
        }
    }
}

#[test]
fn meshes_that_are_not_rendered_are_refused() {
    if let Some(path) = data("favba_planar_mesh.nc") {
        expect(&ModelFile::open(path).unwrap_err(), ErrorKind::Unsupported, &["on_a_sphere is NO"]);
    }
}
