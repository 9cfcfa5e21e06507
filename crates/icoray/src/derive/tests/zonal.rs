//! Differences from zonal means, by their definition and over ranks.

use super::*;

/// The difference from zonal means by their definition.
fn from_means(field: &Field, latitude_rad: &[f64], band_deg: f64) -> Vec<f64> {
    let layers = field.shape().layers;
    let bands = (180.0 / band_deg).ceil() as usize;
    let width = 180.0 / bands as f64;
    let latitude = |column: usize| latitude_rad[column].to_degrees() + 90.0;
    let mut all = Vec::new();
    for layer in 0..layers {
        let mean = |band: usize| {
            let of_band = |c: &usize| ((latitude(*c) / width) as usize).min(bands - 1) == band;
            let columns = (0..field.shape().columns).filter(of_band);
            let values: Vec<f64> = columns.map(|c| field.value(c, layer)).filter(|v| !v.is_nan()).collect();
            values.iter().sum::<f64>() / values.len() as f64
        };
        let means: Vec<f64> = (0..bands).map(mean).collect();
        let known = |band: usize| {
            let nearest = |n: usize| [band.checked_sub(n), Some(band + n)].into_iter().flatten();
            let near = (0..bands).flat_map(nearest);
            near.filter_map(|b| means.get(b)).find(|mean| !mean.is_nan()).copied().unwrap_or(f64::NAN)
        };
        all.push((0..bands).map(known).collect::<Vec<f64>>());
    }
    let value = |column: usize, layer: usize| {
        let at = latitude(column) / width - 0.5;
        let (below, above) = (at.floor().max(0.0), at.ceil().min(bands as f64 - 1.0));
        let w = if above > below { at - below } else { 0.0 };
        let mean = |band: f64| all[layer][band as usize];
        field.value(column, layer) - (mean(below) * (1.0 - w) + mean(above) * w)
    };
    places(field.shape().columns, layers).map(|(c, l)| value(c, l)).collect()
}

#[test]
fn zonal_means_are_those_of_the_definition() {
    let world = World::new(4, 3);
    let grid = Grid::new(world.mesh.tables()).unwrap();
    let triangles = grid.triangles();
    // At 1 degree many bands of this grid have no cell.
    for (band_deg, shape) in [(7.0, 0), (180.0, 1), (1.0, 2), (100.0, 3)] {
        for location in [Location::Center, Location::Corner] {
            let (latitude, shape) = match location {
                Location::Center => (&world.mesh.lat_center_rad, world.shapes()[shape]),
                Location::Corner => (&world.mesh.lat_corner_rad, Shape::cell_fastest(triangles, LAYERS)),
            };
            for is_wide in [true, false] {
                let array = array(shape, is_wide, location, |c, l| value(5, c, l));
                let expected = from_means(&array.field(), latitude, band_deg);
                let fields = Fields::new([("q", array.field())]);
                // For values up to 500,000.
                let limit = if is_wide { 1e-7 } else { 0.05 };
                let look = |found: &Fields, _: &DerivedFields| {
                    let eddy = found.get("eddy").unwrap();
                    assert_eq!(eddy.location(), location);
                    for (i, expected) in expected.iter().enumerate() {
                        let value = eddy.value(i / LAYERS, i % LAYERS);
                        assert_eq!(value.is_nan(), expected.is_nan(), "{band_deg} {i}");
                        let is_near = value.is_nan() || (value - expected).abs() < limit;
                        assert!(is_near, "{band_deg} {i}: {value} {expected}");
                    }
                };
                world.make(&DerivedFieldCache::default(), &zonal(band_deg), &fields, look).unwrap();
            }
        }
    }
}

/// A field that is constant along parallels almost vanishes when its mean is subtracted, also where bands meet.
#[test]
fn no_step_is_left_between_bands() {
    let world = World::new(5, 2);
    let latitude = &world.mesh.lat_center_rad;
    let field = array(world.shapes()[0], true, Location::Center, |c, _| 40.0 * latitude[c].sin());
    let fields = Fields::new([("q", field.field())]);
    let left = world.made("eddy", &zonal(5.0), &fields).into_iter().map(f64::from_bits);
    let most = left.fold(0.0, |most: f64, value| most.max(value.abs()));
    // Half a band's width times the slope would be 1.7 without interpolation.
    assert!(most < 0.6, "{most}");
}

/// Sums of many sizes, whose order would show in their last digits.
#[test]
fn threads_and_ranks_change_no_bit() {
    let world = World::new(4, 1);
    let grid = Grid::new(world.mesh.tables()).unwrap();
    for (location, band_deg) in [(Location::Center, 10.0), (Location::Corner, 45.0)] {
        let columns = if location == Location::Center { grid.cells() } else { grid.triangles() };
        let shape = Shape::blocked(columns, LAYERS, 24);
        let make_array = |spoils: &dyn Fn(usize) -> bool| {
            let value = |c: usize, l: usize| if spoils(c) { 1e12 + c as f64 } else { value(9, c, l) };
            array(shape, true, location, value)
        };
        let whole = make_array(&|_| false);
        let scene = zonal(band_deg);
        let alone = |threads: usize| {
            let world = World { threads: Threads::new(threads).unwrap(), ..World::new(4, 1) };
            world.made("eddy", &scene, &Fields::new([("q", whole.field())]))
        };
        let expected = alone(1);
        assert_eq!(alone(5), expected);
        for size in [1, 2, 3] {
            on_ranks(size, |ranks| {
                let part = Part::of_whole(ranks, &grid).unwrap();
                let owns = |column: usize| match location {
                    Location::Center => part.owns(column),
                    Location::Corner => part.has(column as u32),
                };
                // Values of others would be seen in the means.
                let array = make_array(&|column| !owns(column));
                let (fields, part) = (Fields::new([("q", array.field())]), Some(&part));
                let threads = Threads::new(1 + ranks.rank()).unwrap();
                let given =
                    RenderInputs { scene: &scene, grid: &grid, part, mates: None, layers: &layers(), fields: &fields };
                let made = make(ranks, &DerivedFieldCache::default(), &threads, &given, None).unwrap();
                let found = bits(made.fields(&fields).get("eddy").unwrap());
                let own = (0..columns).filter(|c| owns(*c));
                for i in own.flat_map(|c| c * LAYERS..(c + 1) * LAYERS) {
                    assert_eq!(found[i], expected[i], "{size} ranks, {location:?}, value {i}");
                }
            });
        }
    }
}

/// Otherwise a rank would send other numbers than the rest expect.
#[test]
fn ranks_that_derive_other_fields_are_an_error() {
    let world = World::new(2, 1);
    let grid = Grid::new(world.mesh.tables()).unwrap();
    let means = "takes means of a field of 4 layers at Center, but 3 layers at Center on rank 0";
    for (band_deg, layers, expected) in
        [([10.0, 20.0], [LAYERS; 2], "derives \"eddy\" = FromZonalMean"), ([10.0; 2], [LAYERS, LAYERS + 1], means)]
    {
        let errors = on_ranks(2, |ranks| {
            let part = Part::of_whole(ranks, &grid).unwrap();
            let shape = Shape::level_fastest(grid.cells(), layers[ranks.rank()]);
            let array = array(shape, true, Location::Center, |c, l| value(1, c, l));
            let (scene, fields) = (zonal(band_deg[ranks.rank()]), Fields::new([("q", array.field())]));
            let part = Some(&part);
            let given = RenderInputs {
                scene: &scene,
                grid: &grid,
                part,
                mates: None,
                layers: &super::layers(),
                fields: &fields,
            };
            make(ranks, &DerivedFieldCache::default(), &world.threads, &given, None).unwrap_err().to_string()
        });
        let expected = format!("MPI: rank 1: {expected}");
        assert!(errors.iter().all(|error| error.starts_with(&expected)), "{errors:?}");
    }
}
