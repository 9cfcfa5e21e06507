//! Fields of one value per column.

use crate::made::{LAYERS, Made, RADIUS_M, RECORDS, Values, levels, value};
use crate::made_icon::Angles;
use crate::memory::{expect, names, open, values};
use icoray::{Error, ErrorKind, Level, Location, Renderer, Scale, Script, suggest};
use icoray_dataset::{LayerSelection, SceneFields};

#[test]
fn a_2d_field_has_the_same_values_on_any_layers() {
    let file = open(&Made::history());
    let info = file.field_info("surface_pressure").unwrap();
    assert!(info.is_2d() && info.time_dependent && info.layer_dimension.is_empty());
    assert_eq!((info.location, info.columns, info.layers), (Location::Center, 42, 1));
    for time in 0..RECORDS {
        for layers in [0..2, 3..9] {
            let owned = file.read_layers("surface_pressure", time, layers.clone()).unwrap();
            let field = owned.field().unwrap();
            assert_eq!((field.shape().columns, field.shape().layers), (42, layers.len()));
            assert_eq!(owned.bytes(), 42 * 4, "the values are in memory once");
            for (column, layer) in (0..42).flat_map(|c| (0..layers.len()).map(move |l| (c, l))) {
                assert_eq!(field.value(column, layer), value(time, column, 0));
            }
        }
    }
    let whole = file.read_field("surface_pressure", 0).unwrap();
    assert_eq!(whole.field().unwrap().shape().layers, file.layers("surface_pressure").unwrap().count());
    let error = file.read_layers("surface_pressure", 0, 1..1).unwrap_err();
    expect(&error, ErrorKind::Field, &["surface_pressure: layers 1..1"]);
    let error = file.read_field("surface_pressure", 3).unwrap_err();
    expect(&error, ErrorKind::Field, &["time index 3", "expected 0 to 2"]);
}

#[test]
fn a_2d_field_lies_on_the_sphere() {
    let file = open(&Made::history());
    let heights = file.layer_heights("surface_pressure").unwrap();
    assert_eq!((heights.variable.as_str(), heights.height_m[0]), ("sphere", 0.0));
    assert_eq!(heights.layers.radius_m()[0], RADIUS_M);
    assert_eq!(file.find_native_info("surface_pressure").unwrap(), None);
    let error = file.native_info("surface_pressure").unwrap_err();
    expect(&error, ErrorKind::Layers, &["surface_pressure has no native heights", "2D field"]);
    // A mesh on the unit sphere, and a file without heights.
    let mut made = Made::history();
    made.remove("zgrid");
    made.set("sphere_radius", 1.0);
    let layers = open(&made).layers("surface_pressure").unwrap();
    assert_eq!(layers.radius_m(), [1.0, 1.001]);
}

#[test]
fn fields_with_layers_are_likelier() {
    let likely = |made: &Made| {
        let file = open(made);
        file.likely_fields().iter().map(|info| info.name.clone()).collect::<Vec<_>>()
    };
    let mut made = Made::history();
    let cells = made.dimension("nCells");
    made.dimensions.push(("nSoilLevels", 2));
    let levels = ["nCells", "nVertLevels"];
    for (name, dimensions, long_name, units) in [
        ("tslb", &["Time", "nCells", "nSoilLevels"][..], "Soil temperature", "K"),
        ("rho_base", &levels, "Base state density", "kg m^{-3}"),
        ("gh", &levels, "geopotential height", "m"),
        ("layerThickness", &levels, "", "m"),
        ("ter", &["nCells"], "terrain height", "m"),
        ("ssh", &["Time", "nCells"], "sea surface height", "m"),
        ("areaCell", &["nCells"], "", "m^2"),
        ("xCell", &["nCells"], "", "m"),
    ] {
        let values = vec![1.0; RECORDS * LAYERS * cells];
        let values = values[..dimensions.iter().map(|name| made.dimension(name)).product()].to_vec();
        made.add(name, dimensions, Values::F64(values)).attributes =
            vec![("long_name", long_name.into()), ("units", units.into())];
    }
    assert_eq!(likely(&made), ["theta", "w", "vorticity", "tslb", "rho", "surface_pressure", "ssh", "ter"]);
    made.remove_all(&["theta", "w", "vorticity", "rho", "zgrid", "tslb", "rho_base", "gh", "layerThickness", "ssh"]);
    assert_eq!(likely(&made), ["surface_pressure", "ter"]);
    let file = open(&made);
    assert_eq!(names(&file), ["surface_pressure", "ter", "areaCell"], "positions are no fields");
}

#[test]
fn one_layer_is_2d_too() {
    // Shallow water: one level.
    let mut made = Made::mesh(false);
    made.dimensions.extend([("nVertLevels", 1), ("Time", 0)]);
    let h: Vec<f64> = (0..2 * 42).map(f64::from).collect();
    made.add("h", &["Time", "nCells", "nVertLevels"], Values::F64(h));
    let file = open(&made);
    let h = values(&file, "h", 1);
    assert_eq!((h(3, 0), h(3, 1)), (45.0, 45.0));
    // ICON's temperature 2 m above the ground, whose height is one number, and a pressure without one.
    let mut made = Made::icon_data(Angles::Radians);
    made.dimensions.push(("height", 1));
    let counted: Vec<f32> = (0..RECORDS * 80).map(|i| i as f32).collect();
    made.add("t_2m", &["time", "height", "ncells"], Values::F32(counted.clone()));
    made.add("pres_sfc", &["time", "ncells"], Values::F32(counted));
    let file = open(&made);
    for name in ["t_2m", "pres_sfc"] {
        let info = file.field_info(name).unwrap();
        assert!(info.is_2d() && info.location == Location::Corner, "{name}");
        assert_eq!(values(&file, name, 2)(7, 1), 167.0, "{name}");
    }
}

/// Values over decades, most of them small, such as those of ERA5's `tp`.
#[test]
fn precipitation_in_metres_has_the_scale_of_its_values_and_heights_a_linear_one() {
    let mut made = Made::mesh(false);
    made.add("tp", &["nCells"], Values::F64((0..42).map(|i| 0.02 * 10f64.powf(-0.1 * f64::from(i))).collect()));
    for (attribute, name, scale) in [
        ("long_name", "Snow depth", Scale::Linear),
        ("long_name", "Roughness of the terrain", Scale::Linear),
        ("long_name", "Total precipitation", Scale::Log),
        ("long_name", "Convective rain", Scale::Log),
        ("standard_name", "lwe_thickness_of_snowfall_amount", Scale::Log),
    ] {
        made.last().attributes = vec![("units", "m".into()), (attribute, name.into())];
        let file = open(&made);
        let (grid, renderer) = (file.mesh().grid().unwrap(), Renderer::new(1).unwrap());
        let (info, all) = (file.field_info("tp").unwrap(), LayerSelection::default());
        let text = file.suggest_scene(&grid, &renderer, info, 0, &all, suggest::Options::default()).unwrap();
        let scene = Script::parse(&text).unwrap().views()[0].scenes().next().unwrap();
        assert_eq!(scene.paintings().last().unwrap().coloring.unwrap().scale(), scale, "{name}");
    }
}

/// Where there is no water at all there is no sea surface; elsewhere there is, however shallow.
#[test]
fn a_sea_surface_lies_on_water() {
    let file = open(&Made::ocean());
    let owned = file.read_layers("surface_pressure", 0, 0..LAYERS).unwrap();
    let field = owned.field().unwrap();
    for (cell, layer) in (0..42).flat_map(|c| (0..LAYERS).map(move |l| (c, l))) {
        assert_eq!(field.value(cell, layer).is_nan(), levels(cell) == 0, "{cell} {layer}");
    }
}

#[test]
fn integers_over_columns_are_fields_and_tables_are_none() {
    let mut made = Made::history();
    let kinds: Vec<i32> = (0..42).map(|cell| if cell % 5 == 0 { 7 } else { 16 }).collect();
    made.add("ivgtyp", &["nCells"], Values::I32(kinds.clone()));
    let mut flags = vec![3; RECORDS * 42];
    flags[1] = -2_147_483_647;
    made.add("flag", &["Time", "nCells"], Values::I32(flags));
    let file = open(&made);
    let field = values(&file, "ivgtyp", 0);
    assert!(kinds.iter().enumerate().all(|(cell, kind)| field(cell, 1) == f64::from(*kind)));
    let flags = values(&file, "flag", 0);
    assert!(flags(0, 0) == 3.0 && flags(1, 0).is_nan(), "nothing was written there");
    let likely: Vec<&str> = file.likely_fields().iter().map(|info| info.name.as_str()).collect();
    assert!(likely.contains(&"ivgtyp") && likely.contains(&"flag"), "{likely:?}");
    for table in ["nEdgesOnCell", "verticesOnCell"] {
        expect(
            &file.field_info(table).unwrap_err(),
            ErrorKind::Field,
            &[table, "is not a field, expected numbers over"],
        );
    }
    // A table of the mesh over what might be layers does not change.
    let mut made = Made::icon_data(Angles::Degrees);
    let triangles = made.dimension("ncells");
    made.add("neighbours", &["lev", "ncells"], Values::I32(vec![1; 3 * triangles]));
    made.add("cloud", &["time", "lev", "ncells"], Values::I32(vec![1; RECORDS * 3 * triangles]));
    let file = open(&made);
    assert!(file.field_info("neighbours").is_err() && file.field_info("cloud").is_ok());
}

#[test]
fn layers_are_surfaces_without_heights() {
    for (mut made, heights, field, is_last_inner) in
        [(Made::history(), "zgrid", "theta", false), (Made::icon_data(Angles::Degrees), "lev", "ta", true)]
    {
        made.remove(heights);
        let file = open(&made);
        let all = LayerSelection::default();
        let layers_of = |scene: &str| {
            let script = Script::parse(&format!("field = '{field}'\n{scene}")).unwrap();
            let scene_fields = SceneFields::new(&file, &script, &all)?;
            let scene = script.views()[0].scenes().next().unwrap();
            Ok::<_, Error>((scene_fields.layers(&scene)?.clone(), scene_fields.notes(&scene)?.concat()))
        };
        for level in ["0", "2", "'top'", "'bottom'"] {
            let surface = format!("[[surfaces]]\nlayer = {level}\nfield = '{field}'\ntransfer = {{ map = 'magma' }}");
            let (layers, note) = layers_of(&surface).unwrap();
            let radius_m = layers.radius_m();
            let lowest = radius_m.iter().copied().fold(f64::INFINITY, f64::min);
            let inner = if is_last_inner { radius_m.len() - 1 } else { 0 };
            assert_eq!((radius_m[inner], radius_m.len()), (lowest, file.field_info(field).unwrap().layers));
            assert!(note.contains("no heights of the layers: shown on the sphere"), "{note}");
        }
        let surface = format!("[[surfaces]]\nheight_m = 20\nfield = '{field}'\ntransfer = {{ map = 'magma' }}");
        for needs in [surface.as_str(), "transfer = { map = 'magma' }", "[[isosurfaces]]\nvalue = 1"] {
            expect(&layers_of(needs).unwrap_err(), ErrorKind::Layers, &["heights", "as surfaces alone needs none"]);
        }
        let (grid, renderer) = (file.mesh().grid().unwrap(), Renderer::new(1).unwrap());
        let options = suggest::Options { surface: Some(Level::Ground), ..suggest::Options::default() };
        let info = file.field_info(field).unwrap();
        let text = file.suggest_scene(&grid, &renderer, info, 0, &all, options).unwrap();
        assert_eq!(Script::parse(&text).unwrap().views()[0].scenes().next().unwrap().exaggeration, 1.0);
    }
}
