//! Derived fields of synthetic ones, against their definitions, in all layouts, over threads and ranks.

use super::*;
use crate::common::{Array, on_ranks};
use crate::ranks::Part;
use crate::render::Renderer;
use icoray_grid::{Grid, IcosahedralMesh, Layers, Location};
use icoray_scene::Opacity;

mod zonal;

const LAYERS: usize = 3;
const FILL: f64 = -9999.0;

/// A scene that shows `name` first, of which `derived` are known.
fn scene(name: &str, derived: &[(&str, How)]) -> Scene {
    let mut scene = Scene::parse(&format!(
        "field = {name:?}\n[camera]\nlon = 0\nlat = 0\ndistance = 3\n[transfer]\nrange = [0, 1]\n\
         opacity = [[0, 0.0], [1, 0.5]]"
    ))
    .unwrap();
    let derived = derived.iter().map(|(name, how)| Derivation { name: (*name).into(), how: how.clone() });
    scene.scenery.derived = derived.collect();
    scene
}

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(ToString::to_string).collect()
}

/// Values of several sizes and signs; some are missing.
fn value(seed: usize, column: usize, layer: usize) -> f64 {
    let i = (column * LAYERS + layer) * 7919 + seed * 104_729;
    match i % 41 {
        0 => FILL,
        1 => f64::NAN,
        2 => f64::INFINITY,
        k => ((i % 1013) as f64 - 500.0) * 10f64.powi(k as i32 / 8 - 2) + layer as f64,
    }
}

fn array(shape: Shape, is_wide: bool, location: Location, value: impl Fn(usize, usize) -> f64) -> Array {
    Array::new(shape, is_wide, location, Some(FILL), value)
}

struct World {
    mesh: IcosahedralMesh,
    threads: Threads,
}

impl World {
    fn new(level: u32, threads: usize) -> Self {
        World { mesh: IcosahedralMesh::new(level).unwrap(), threads: Threads::new(threads).unwrap() }
    }

    fn shapes(&self) -> [Shape; 4] {
        let cells = self.mesh.cells();
        let padded = Shape { offset: 2, column_stride: 5, ..Shape::level_fastest(cells, LAYERS) };
        let level_fastest = Shape::level_fastest(cells, LAYERS);
        [level_fastest, Shape::cell_fastest(cells, LAYERS), Shape::blocked(cells, LAYERS, 32), padded]
    }

    /// A field over one of [`Self::shapes`], of [`value`]s at centres.
    fn array(&self, seed: usize, shape: usize, is_wide: bool) -> Array {
        array(self.shapes()[shape], is_wide, Location::Center, |c, l| value(seed, c, l))
    }

    /// The bits of the field `name` that is made of `fields` for `scene`.
    fn made(&self, name: &str, scene: &Scene, fields: &Fields) -> Vec<u64> {
        self.make(&DerivedFieldCache::default(), scene, fields, |found, _| bits(found.get(name).unwrap())).unwrap()
    }

    /// Computes the scene's derived fields and passes them to `look`.
    fn make<R>(
        &self,
        kept: &DerivedFieldCache,
        scene: &Scene,
        fields: &Fields,
        look: impl FnOnce(&Fields, &DerivedFields) -> R,
    ) -> Result<R> {
        let grid = Grid::new(self.mesh.tables()).unwrap();
        let given = RenderInputs { scene, grid: &grid, part: None, mates: None, layers: &layers(), fields };
        let made = make(&mut Ranks::alone(), kept, &self.threads, &given, None)?;
        let found = look(&made.fields(fields), &made);
        kept.keep(&mut Ranks::alone(), made);
        Ok(found)
    }
}

/// Layers, which derived fields do not read.
fn layers() -> Layers {
    Layers::from_heights(&[0.0, 1.0], 6.371e6).unwrap()
}

/// All columns and layers, level-fastest.
fn places(columns: usize, layers: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..columns).flat_map(move |c| (0..layers).map(move |l| (c, l)))
}

/// Every value of a field as bits: NaN is equal to itself.
fn bits(field: &Field) -> Vec<u64> {
    let Shape { columns, layers, .. } = *field.shape();
    places(columns, layers).map(|(c, l)| rounded(field.value(c, l), true)).collect()
}

fn rounded(value: f64, is_wide: bool) -> u64 {
    let value = if is_wide { value } else { f64::from(value as f32) };
    if value.is_nan() { 1 } else { value.to_bits() }
}

#[test]
fn values_are_those_of_the_definition_in_every_layout() {
    let world = World::new(3, 3);
    let [flat, layerwise, blocked, padded] = world.shapes();
    for (shapes, wide) in [
        ([flat, flat, flat], [false; 3]),
        ([layerwise, blocked, padded], [false, false, true]),
        ([blocked, flat, layerwise], [true; 3]),
    ] {
        let arrays = [0, 1, 2].map(|i| array(shapes[i], wide[i], Location::Center, |c, l| value(i, c, l)));
        let fields = Fields::new(["u", "v", "w"].into_iter().zip(arrays.iter().map(Array::field)));
        let is_wide = wide.contains(&true);
        let of = |i: usize, (c, l): (usize, usize)| arrays[i].field().value(c, l);
        let all: Vec<_> = places(flat.columns, LAYERS).collect();
        let derived = [
            ("speed", How::Magnitude(names(&["u", "v", "w"]))),
            ("mixed", How::Combination(vec![(0.5, "u".into()), (-2.0, "v".into()), (3.0, "w".into())])),
            ("unused", How::Magnitude(names(&["nowhere"]))),
            ("both", How::Combination(vec![(1.0, "speed".into()), (1.0, "mixed".into())])),
        ];
        let look = |found: &Fields, made: &DerivedFields| {
            let per_field = all.len() * if is_wide { 8 } else { 4 };
            assert_eq!((made.fields.len(), made.bytes()), (3, 3 * per_field));
            let missing = all.iter().filter(|at| (0..3).any(|i| of(i, **at).is_nan())).count();
            assert!(missing > 100 && missing < all.len() / 2);
            for at in &all {
                let [u, v, w] = [0, 1, 2].map(|i| of(i, *at));
                let now = ["speed", "mixed", "both"].map(|name| found.get(name).unwrap().value(at.0, at.1));
                let expected = [(u * u + v * v + w * w).sqrt(), 0.5 * u - 2.0 * v + 3.0 * w, now[0] + now[1]];
                assert_eq!(now.map(|v| rounded(v, true)), expected.map(|v| rounded(v, is_wide)), "{at:?}");
            }
            assert!(found.get("unused").is_err());
            assert_eq!(bits(found.get("u").unwrap()), bits(&arrays[0].field()));
        };
        world.make(&DerivedFieldCache::default(), &scene("both", &derived), &fields, look).unwrap();
    }
}

/// Lengths whose squares f64 does not have.
#[test]
fn long_and_short_vectors_have_a_length() {
    let world = World::new(0, 1);
    let sizes = [1e300, 1e-300, 1e155, 1e-155, 1.0, 0.0, 5e-324, 1.7e308];
    let shape = Shape::level_fastest(12, LAYERS);
    let size = |c: usize, l: usize| sizes[(c * LAYERS + l) % sizes.len()];
    let [u, v] = [3.0, -4.0].map(|k| array(shape, true, Location::Center, |c, l| k / 4.0 * size(c, l)));
    let fields = Fields::new([("u", u.field()), ("v", v.field())]);
    let length = scene("length", &[("length", How::Magnitude(names(&["u", "v"])))]);
    let made = world.made("length", &length, &fields);
    for ((c, l), found) in places(12, LAYERS).zip(made.into_iter().map(f64::from_bits)) {
        // The longest is longer than f64 has: the largest number. The shortest has one digit.
        let expected = match size(c, l) {
            size if size > 1e308 => f64::MAX,
            5e-324 => 5e-324,
            size => 1.25 * size,
        };
        assert!((found - expected).abs() <= 1e-15 * expected, "{found:e}, expected {expected:e}");
    }
}

fn zonal(band_deg: f64) -> Scene {
    scene("eddy", &[("eddy", How::FromZonalMean { field: "q".into(), band_deg })])
}

#[test]
fn first_frames_are_remembered_by_field_and_shape() {
    let world = World::new(2, 2);
    let kept = DerivedFieldCache::default();
    let how = How::FromFirst("q".into());
    let of_q = scene("change", &[("change", how.clone())]);
    let at = |step: usize, shape: Shape, is_wide| {
        let array = array(shape, is_wide, Location::Center, |c, l| value(step, c, l));
        let fields = Fields::new([("q", array.field())]);
        let found = world.make(&kept, &of_q, &fields, |found, made| (bits(found.get("change").unwrap()), made.bytes()));
        (array, found.unwrap())
    };
    let shapes = world.shapes();
    let (first, (zero, bytes)) = at(1, shapes[1], false);
    let known = |i: usize| !first.field().value(i / LAYERS, i % LAYERS).is_nan();
    assert!((0..zero.len()).all(|i| zero[i] == u64::from(!known(i))));
    assert_eq!(bytes, 2 * 4 * zero.len());
    // Another layout is the same field, and a frame later the first is still the first.
    for (step, shape) in [(2, shapes[2]), (3, shapes[0])] {
        let (array, (change, _)) = at(step, shape, false);
        for (i, change) in change.into_iter().enumerate() {
            let [now, then] = [&array, &first].map(|a| a.field().value(i / LAYERS, i % LAYERS));
            assert_eq!(change, rounded(now - then, false), "{step} {i}");
        }
    }
    // One of another shape begins anew, and the other is still known.
    let fewer = Shape::level_fastest(shapes[0].columns, LAYERS - 1);
    assert!(at(4, fewer, true).1.0.iter().all(|change| *change <= 1));
    assert!(at(5, shapes[0], false).1.0.iter().any(|change| *change > 1));
    // Fields of the same name, but with another derivation.
    let array = world.array(8, 0, false);
    let fields = Fields::new([("q", array.field())]);
    for factor in [2.0, 3.0] {
        let scaled = ("scaled", How::Combination(vec![(factor, "q".into())]));
        let scene = scene("change", &[scaled, ("change", How::FromFirst("scaled".into()))]);
        let made = world.make(&kept, &scene, &fields, |found, _| bits(found.get("change").unwrap()));
        assert!(made.unwrap().iter().all(|change| *change <= 1));
    }
}

#[test]
fn unnamed_fields_are_inputs_of_derived_fields() {
    let world = World::new(2, 2);
    let array = world.array(1, 0, true);
    let twice = ("twice", How::Combination(vec![(2.0, "q".into())]));
    let four = ("four", How::Combination(vec![(2.0, "twice".into())]));
    let field = array.field();
    let unnamed = Fields::from(&field);
    let shown = scene("four", &[twice.clone(), four.clone()]);
    let made = world.made("four", &shown, &unnamed.needed_by(&shown).unwrap());
    let expected = |factor: f64| -> Vec<u64> {
        places(array.shape.columns, LAYERS).map(|(c, l)| rounded(factor * field.value(c, l), true)).collect()
    };
    assert_eq!(made, expected(4.0));
    // The scene's first is the field itself, under any name; others are derived from fields by name.
    let mut beside = scene("anything", &[twice]);
    beside.volumes[0].opacity = Some(Opacity { field: "twice".into(), transfer: beside.volumes[0].transfer.clone() });
    let error = unnamed.needed_by(&beside).unwrap_err();
    let found = "the scene shows field \"q\", and there is only the first";
    assert!(error.to_string().contains(found), "{error}");
    let named = Fields::new([("anything", field), ("q", field)]);
    assert_eq!(world.made("twice", &beside, &named), expected(2.0));
}

#[test]
fn errors_name_fields_that_do_not_fit() {
    let world = World::new(2, 1);
    let cells = world.mesh.cells();
    let array = |columns, layers, location| {
        array(Shape::level_fastest(columns, layers), false, location, |c, l| value(1, c, l))
    };
    let arrays = [
        array(cells, 3, Location::Center),
        array(cells, 4, Location::Center),
        array(320, 3, Location::Corner),
        array(cells + 1, 3, Location::Center),
    ];
    let fields = Fields::new(["q", "interfaces", "corners", "more"].into_iter().zip(arrays.iter().map(Array::field)));
    let error = |how: How| {
        let scene = scene("odd", &[("odd", how)]);
        world.make(&DerivedFieldCache::default(), &scene, &fields, |_, _| ()).unwrap_err()
    };
    for (odd, found) in [
        ("interfaces", "162 columns of 4 layers at Center, expected 162 columns of 3 layers at Center"),
        ("corners", "320 columns of 3 layers at Corner, expected 162"),
        ("more", "163 columns of 3 layers at Center, expected 162"),
    ] {
        let error = error(How::Magnitude(names(&["q", odd])));
        assert_eq!(error.kind(), ErrorKind::Field);
        let expected = format!("\"odd\": field {odd:?} has {found}");
        assert!(error.to_string().contains(&expected), "{error}");
    }
    let unknown = error(How::FromFirst("odd".into())).to_string();
    assert!(unknown.contains("\"odd\": the scene shows field \"odd\", and there is"), "{unknown}");
    assert!(error(How::Magnitude(Vec::new())).to_string().contains("made of 0 fields"));
    let mean = |field: &str, band_deg| error(How::FromZonalMean { field: field.into(), band_deg }).to_string();
    assert!(mean("more", 5.0).contains("163 columns at Center, expected 162: one for each"));
    for band_deg in [0.0, -1.0, 200.0, f64::NAN] {
        assert!(mean("q", band_deg).contains(&format!("bands of {band_deg} degrees, expected 0.1 to 180")));
    }
    let twice = [("q2", How::FromFirst("q".into())), ("q2", How::FromFirst("interfaces".into()))];
    // The first counts, and the second is never made.
    world
        .make(&DerivedFieldCache::default(), &scene("q2", &twice), &fields, |_, made| {
            assert_eq!(made.fields.len(), 1);
        })
        .unwrap();
}

#[test]
fn memory_is_used_again() {
    let world = World::new(2, 1);
    let kept = DerivedFieldCache::default();
    let place = |scene: &Scene, step: usize, is_wide| {
        let array = world.array(step, 0, is_wide);
        let fields = Fields::new([("q", array.field())]);
        let place = |_: &Fields, made: &DerivedFields| match made.fields[0].values.field().samples() {
            Reals::F32(values) => values.as_ptr().addr(),
            Reals::F64(values) => values.as_ptr().addr(),
        };
        world.make(&kept, scene, &fields, place).unwrap()
    };
    let other = scene("p", &[("p", How::Combination(vec![(2.0, "q".into())]))]);
    for is_wide in [false, true] {
        let first = place(&zonal(10.0), 1, is_wide);
        assert_eq!(place(&other, 2, is_wide), first);
        assert_eq!(place(&zonal(10.0), 3, is_wide), first);
    }
}

/// A renderer draws derived fields as it draws the same values given as a field, and remembers its first frame.
#[test]
fn pictures_of_derived_fields_are_those_of_their_values() {
    let world = World::new(3, 1);
    let grid = Grid::new(world.mesh.tables()).unwrap();
    let layers = Layers::from_heights(&[0.0, 1e4, 3e4], 6.4e6).unwrap();
    let renderer = Renderer::new(2).unwrap();
    for (location, columns) in [(Location::Center, grid.cells()), (Location::Corner, grid.triangles())] {
        let shape = Shape::cell_fastest(columns, LAYERS);
        let part = |step: usize| move |c: usize, l: usize| ((c * 7 + l * 3 + step * 11) % 100) as f64 / 100.0;
        for step in 1..4 {
            let [now, then] = [step, 1].map(|step| array(shape, false, location, part(step)));
            let change = |c, l| now.field().value(c, l) - then.field().value(c, l);
            let known = array(shape, false, location, change);
            let derived = scene("change", &[("change", How::FromFirst("q".into()))]);
            let plain = Scene { scenery: icoray_scene::Scenery::default(), ..derived.clone() };
            let draw = |scene: &Scene, field: &Field| {
                let fields = Fields::new([(if scene == &plain { "change" } else { "q" }, *field)]);
                renderer.render(scene, &grid, &layers, fields).unwrap()
            };
            let (found, expected) = (draw(&derived, &now.field()), draw(&plain, &known.field()));
            assert_eq!(found.pixels, expected.pixels, "{location:?}, step {step}");
            assert_eq!(found.report.value_range.is_some(), columns > 0);
            assert!(step == 1 || found.pixels.iter().any(|pixel| *pixel != found.pixels[0]));
            // The change, and the first frame of each location so far.
            let more = found.report.bytes_derived - expected.report.bytes_derived;
            let first = if location == Location::Corner { grid.cells() } else { 0 };
            assert_eq!(more, 4 * LAYERS * (2 * columns + first));
        }
    }
}
