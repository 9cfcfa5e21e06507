//! Files of CAM, FESOM and XIOS, data of another mesh, and the units of coordinates.

use crate::made::{LAYERS, Made, RADIUS_M, RECORDS, Values, value};
use crate::made_icon::Angles;
use crate::memory::{expect, names, open, opened, opened_with, source, values};
use icoray::{ErrorKind, IcosahedralMesh, Location};
use icoray_dataset::{Combined, Dataset, DatasetOptions, MeshLayout};

/// Longitudes and latitudes of the cells of [`Made::mesh`] and of the same mesh a quarter of a turn to the east.
fn places(turn: f64) -> [Vec<f64>; 2] {
    let mesh = IcosahedralMesh::new(1).unwrap();
    let lon = mesh.lon_center_rad.iter().map(|lon| (lon + turn).to_degrees()).collect();
    [lon, mesh.lat_center_rad.iter().map(|lat| lat.to_degrees()).collect()]
}

/// A history of CAM on MPAS's mesh: `PS` and `T` over `ncol`, with places.
fn cam(turn: f64) -> Made {
    let mut made = Made { path: "cam.nc", ..Made::of([("time", 0), ("ncol", 42), ("lev", LAYERS)], []) };
    let [lon, lat] = places(turn);
    made.add("lon", &["ncol"], Values::F64(lon));
    made.add("lat", &["ncol"], Values::F64(lat));
    made.add("lev", &["lev"], Values::F64(vec![100.0, 300.0, 700.0, 950.0])).attributes = vec![("units", "hPa".into())];
    made.add("T", &["time", "lev", "ncol"], Values::F64((0..LAYERS * 42).map(|i| value(0, i % 42, i / 42)).collect()));
    made.add("PS", &["time", "ncol"], Values::F64((0..42).map(|c| value(0, c, 0)).collect()));
    made
}

#[test]
fn columns_of_cam_are_the_cells_of_mpas() {
    let file = opened(&cam(0.0), &[&Made::history()]).unwrap();
    assert_eq!(names(&file), ["T", "PS"]);
    assert_eq!(values(&file, "T", 0)(41, 3), value(0, 41, 3));
    let heights = file.layer_heights("T").unwrap();
    assert!(heights.is_of_pressure && heights.variable == "lev" && heights.layers.is_falling(), "{heights:?}");
    // zgrid is of MPAS's levels, and begins at the ground.
    assert_eq!(file.find_native_info("T").unwrap(), None);
}

#[test]
fn data_of_another_mesh_of_the_same_size_are_refused() {
    let error = opened(&cam(1.0), &[&Made::history()]).unwrap_err();
    let parts =
        ["lon, lat of column 1 are [57.30, 26.57]", "mesh of made.nc has it at [0.00, 26.57]", "different meshes"];
    expect(&error, ErrorKind::Grid, &parts);
    let named = |mut made: Made, name: &str| {
        made.set("uuidOfHGrid", name);
        made
    };
    let mut data = Made::icon_data(Angles::Degrees);
    data.remove_all(&["clon", "clat", "clon_bnds", "clat_bnds"]);
    let (one, grid) = (named(data.clone(), "1111"), Made::icon_grid());
    for same in [named(grid.clone(), "1111"), grid.clone()] {
        assert_eq!(opened(&one, &[&same]).unwrap().fields().len(), 1);
    }
    let other = named(grid, "2222");
    let parts = ["uuidOfHGrid is 2222, that of made.nc is 1111", "give the grid file of the data as `mesh`"];
    expect(&opened(&one, &[&other]).unwrap_err(), ErrorKind::Grid, &parts);
    expect(&Combined::of(vec![source(&one), source(&other)]).unwrap_err(), ErrorKind::Grid, &parts);
}

#[test]
fn times_of_xios_are_times() {
    let with_times = |name: &'static str| {
        let mut made = Made::dynamico(Angles::Degrees);
        made.dimensions.retain(|(dimension, _)| *dimension != "time");
        made.dimensions.push((name, 0));
        for variable in ["ta", "ps"] {
            made.variable(variable).dimensions[0] = name;
        }
        made
    };
    let is_timed = |made: &Made| open(made).field_info("ta").is_ok_and(|info| info.time_dependent);
    assert!(is_timed(&with_times("time_counter")) && !is_timed(&with_times("t")));
    for attribute in [("axis", "T"), ("standard_name", "time"), ("units", "days since 2000-01-01")] {
        let mut made = with_times("t");
        made.add("t", &["t"], Values::F64(vec![0.0; RECORDS])).attributes = vec![(attribute.0, attribute.1.into())];
        assert!(is_timed(&made), "{attribute:?}");
    }
    for name in ["time_counter", "t"] {
        let mut made = with_times(name);
        made.add(name, &[name], Values::F64((0..RECORDS).map(|t| 86_400.0 * t as f64).collect()));
        let units = ("units", "seconds since 2000-02-28 00:00:00".into());
        made.last().attributes = vec![units, ("axis", "T".into()), ("calendar", "noleap".into())];
        // Another dimension of time that has one record.
        made.dimensions.push(("time_2", 1));
        made.add("orography", &["time_2", "cell"], Values::F64(vec![7.0; 162]));
        made.add("time_2", &["time_2"], Values::F64(vec![0.0])).attributes = vec![("axis", "T".into())];
        let file = open(&made);
        let dates: Vec<_> = file.times().iter().map(|date| date.as_deref().unwrap()).collect();
        assert_eq!(dates, ["2000-02-28_00:00:00", "2000-03-01_00:00:00", "2000-03-02_00:00:00"]);
        assert_eq!(file.seconds().unwrap(), [0.0, 86_400.0, 172_800.0]);
        assert!(file.field_info("ps").unwrap().is_2d() && file.field_info("ps").unwrap().time_dependent, "{name}");
        assert_eq!(values(&file, "ta", 2)(5, 1), value(2, 5, 1));
        assert_eq!(values(&file, "orography", 2)(5, 1), 7.0);
        let twice = Combined::of(vec![source(&made), source(&made)]).unwrap();
        assert_eq!(
            Dataset::new(twice, Vec::new(), None, DatasetOptions::default()).unwrap().times().len(),
            RECORDS,
            "each date once"
        );
    }
}

/// FESOM's mesh.diag, with elements by place in them or by element, and `levels`, the interfaces of each node.
fn fesom(is_by_place: bool) -> Made {
    let mesh = IcosahedralMesh::new(1).unwrap();
    let mut made = Made::of([("nod2", 42), ("elem", 80), ("n2", 2), ("n3", 3), ("nz1", 3), ("nz", 4)], []);
    let place = |i: usize| if is_by_place { 3 * (i % 80) + i / 80 } else { i };
    let dimensions = if is_by_place { ["n3", "elem"] } else { ["elem", "n3"] };
    made.add("elements", &dimensions, Values::I32((0..240).map(|i| mesh.corner_cell[place(i)] + 1).collect()));
    made.add("nodes", &["n2", "nod2"], Values::F64([mesh.lon_center_rad, mesh.lat_center_rad].concat()));
    made.add("nz1", &["nz1"], Values::F64(vec![50.0, 200.0, 600.0]));
    made.last().attributes = vec![("long_name", "depth of layers".into())];
    made.add("nlevels_nod2D", &["nod2"], Values::I32((0..42).map(|node| 1 + node % 4).collect()));
    made.add("nlevels", &["elem"], Values::I32((0..80).map(|element| 1 + element % 4).collect()));
    made
}

#[test]
fn nodes_of_fesom_are_cells_with_a_floor() {
    let mut data = Made::of([("time", 0), ("nod2", 42), ("nz1", 3), ("nz", 4), ("elem", 80)], []);
    data.add("temp", &["time", "nod2", "nz1"], Values::F64((0..126).map(|i| value(0, i / 3, i % 3)).collect()));
    data.add("w", &["time", "nz", "nod2"], Values::F64(vec![0.0; 42 * 4]));
    data.add("u", &["time", "nz1", "elem"], Values::F64(vec![0.0; 80 * 3]));
    let tables = [true, false].map(|is_by_place| {
        let file = opened(&data, &[&fesom(is_by_place)]).unwrap();
        assert_eq!((file.mesh().layout(), file.mesh().cells(), file.mesh().corners()), (MeshLayout::Triangles, 42, 80));
        file.mesh().grid().unwrap();
        assert_eq!(file.mesh().format(), "FESOM2");
        assert_eq!(file.layer_heights("temp").unwrap().height_m, [-50.0, -200.0, -600.0]);
        for (name, columns, layers, more) in [("temp", 42, 3, 0), ("w", 42, 4, 1), ("u", 80, 3, 0)] {
            let field = values(&file, name, 0);
            for (column, layer) in (0..columns).flat_map(|c| (0..layers).map(move |l| (c, l))) {
                let is_wet = column % 4 > 0 && layer < column % 4 + more;
                assert_eq!(field(column, layer).is_finite(), is_wet, "{name} {column} {layer}");
            }
        }
        assert_eq!(file.field_info("u").unwrap().location, Location::Corner);
        // A level that is picked has its floor.
        let options = DatasetOptions { at: vec![("nz1".into(), 2)], ..DatasetOptions::default() };
        let level = values(&opened_with(&data, &[&fesom(is_by_place)], options).unwrap(), "temp", 0);
        assert!((0..42).all(|node| level(node, 0).is_finite() == (node % 4 == 3)));
        file.shared_mesh()
    });
    assert!(tables[0].is_same(&tables[1]));
    let mut spoilt = fesom(true);
    spoilt.i32s("elements")[85] = 43;
    let error = opened(&data, &[&spoilt]).unwrap_err();
    expect(&error, ErrorKind::Grid, &["made.nc: elements: node 43 of element 5, expected 1 to 42"]);
}

/// Longitudes and latitudes of all cells as a file has them, where `edit` has changed it.
fn read_places(edit: impl Fn(&mut Made)) -> Vec<f64> {
    let mut made = Made::mesh(false);
    edit(&mut made);
    let (file, grid) = (open(&made), Made::mesh(false));
    let center = file.mesh().tables().center;
    let expected = open(&grid);
    let its = expected.mesh().tables().center;
    let off = |i| [center.lon_rad.get(i) - its.lon_rad.get(i), center.lat_rad.get(i) - its.lat_rad.get(i)];
    (0..42).flat_map(off).collect()
}

#[test]
fn degrees_and_radians_are_decided_for_both_coordinates() {
    let degrees = |made: &mut Made, names: &[&'static str]| {
        for name in names {
            made.f64s(name).iter_mut().for_each(|angle| *angle = angle.to_degrees());
        }
    };
    let all = ["lonCell", "latCell"];
    assert!(read_places(|made| degrees(made, &all)).iter().all(|difference| difference.abs() < 1e-12), "beyond 2 pi");
    // A region near the meridian of Greenwich: only its latitudes exceed 2 pi.
    let region = |made: &mut Made| {
        made.f64s("lonCell").iter_mut().for_each(|lon| *lon *= 0.01);
        degrees(made, &all);
    };
    let largest = |places: Vec<f64>, first: usize| {
        places.into_iter().skip(first).step_by(2).fold(0.0, |max: f64, difference| max.max(difference.abs()))
    };
    let [lons, lats] = [0, 1].map(|first| largest(read_places(region), first));
    assert!(lons > 5.0 && lats < 1e-12, "{lons} {lats}");
    // One unit is that of both.
    let one_unit = |made: &mut Made| {
        degrees(made, &all);
        made.variable("latCell").attributes = vec![("units", "degrees_north".into())];
        made.f64s("lonCell").iter_mut().for_each(|lon| *lon *= 0.01);
    };
    let lons = largest(read_places(one_unit), 0);
    assert!((lons - 0.99 * 341.7f64.to_radians()).abs() < 0.01, "{lons}");
}

#[test]
fn a_radius_is_that_of_positions_or_of_the_earth() {
    let radius = |edit: &dyn Fn(&mut Made)| {
        let mut made = Made::history();
        made.remove("sphere_radius");
        edit(&mut made);
        let file = open(&made);
        (file.sphere_radius_m(), file.layers("theta").unwrap().planet_radius_m())
    };
    assert_eq!(radius(&|_| ()), (RADIUS_M, RADIUS_M));
    let positions = |made: &mut Made, radius: f64| {
        for (name, part) in [("xCell", 0.6), ("yCell", 0.0), ("zCell", 0.8)] {
            made.add(name, &["nCells"], Values::F64(vec![part * radius; 42]));
        }
    };
    assert_eq!(radius(&|made| positions(made, 3.39e6)), (3.39e6, 3.39e6));
    // Heights in metres are not those of a sphere of one metre.
    assert_eq!(radius(&|made| positions(made, 1.0)), (1.0, RADIUS_M));
    assert_eq!(radius(&|made| made.set("sphere_radius", 1.0)), (1.0, RADIUS_M));
}

/// One variable per file, as of FESOM2 and CESM, where the others came as those that have the mesh.
#[test]
fn fields_of_other_files_of_the_same_times_are_read_there() {
    let mut own = Made::history();
    own.variables.retain(|variable| variable.name != "w");
    let mut other = Made::history();
    other.variables.retain(|variable| !["theta", "rho"].contains(&variable.name));
    let all = opened(&own, &[&other]).unwrap();
    assert_eq!(values(&all, "w", 1)(7, 1), value(1, 7, 1));
    // At other times it is not known which record belongs to which.
    other.variable("xtime").values =
        Values::Text(format!("{:<64}", "1999-01-01_00:00:00").repeat(RECORDS).into_bytes());
    let error = opened(&own, &[&other]).unwrap().read_field("w", 1).unwrap_err();
    expect(&error, ErrorKind::Field, &["no field w, but made.nc has w"]);
}
