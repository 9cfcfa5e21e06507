use super::*;
use crate::ground::screen_jacobian::SurfaceHit;
use icoray_scene::Camera;
use icoray_test_support::Random;

/// Cameras from which coasts are at either scale.
fn views() -> [View; 2] {
    [4.0, 1.05].map(|distance| View::new(Camera::above(0.0, 0.0, distance, 30.0).unwrap(), 700))
}

#[test]
fn islands_that_are_small_are_seen_from_near() {
    let [far, near] = views().map(|view| LineMap::of_coasts(&view));
    for (name, lon, lat) in [("Mallorca", 3.0, 39.6), ("Gotland", 18.5, 57.4)] {
        assert!(!far.is_land(lon, lat) && near.is_land(lon, lat), "{name}");
    }
}

#[test]
fn places_are_where_they_are() {
    let coasts = views().map(|view| LineMap::of_coasts(&view));
    let land = [
        ("Paris", 2.35, 48.86),
        ("Ulaanbaatar", 106.9, 47.9),
        ("Amundsen-Scott", 0.0, -90.0),
        ("Vostok", 106.8, -78.46),
        ("the Antarctic at 180", 180.0, -85.5),
        ("the Antarctic at -180", -180.0, -85.5),
        ("Egvekinot", -179.1, 66.6),
        ("Chukotka at 180", 180.0, 67.0),
        ("Chukotka at -180", -180.0, 67.0),
        ("Anadyr", 176.0, 65.5),
        ("Vanua Levu", 179.6, -16.5),
        ("Wrangel, east of 180", -179.5, 71.2),
        ("Wrangel, west of 180", 179.5, 71.2),
        ("Greenland", -40.0, 83.0),
        ("Madagascar", 47.0, -19.0),
    ];
    let sea = [
        ("the Pacific", -150.0, 0.0),
        ("the Caspian", 51.0, 42.0),
        ("the North Pole", 0.0, 90.0),
        ("the North Pole at -180", -180.0, 90.0),
        ("the Ross Sea at 180", 180.0, -75.0),
        ("the Ross Sea at -180", -180.0, -75.0),
        ("east of Fiji", -178.5, -16.3),
        ("the Chukchi Sea", 180.0, 70.0),
        ("the Bering Sea", 180.0, 60.0),
        ("the Gulf of Guinea", 0.0, 0.0),
        ("Hudson Bay", -85.0, 60.0),
    ];
    for (name, lon, lat) in land {
        assert!(coasts.iter().all(|coast| coast.is_land(lon, lat)), "{name}");
    }
    for (name, lon, lat) in sea {
        assert!(!coasts.iter().any(|coast| coast.is_land(lon, lat)), "{name}");
    }
}

/// Pixels to the nearest border, if it is within a quarter of a degree.
fn distance_to_border(lon: f64, lat: f64) -> Option<f64> {
    let view = View::new(Camera::above(lon, lat, 1.05, 30.0).unwrap(), 700);
    let place = unit_vector(lon.to_radians(), lat.to_radians());
    let jacobian = ScreenJacobian::new(&view, &SurfaceHit::round(place)).unwrap();
    LineMap::of_borders(&view).distance(&jacobian, 0.25_f64.to_radians() * jacobian.min_stretch(), 1.0)
}

#[test]
fn borders_lie_between_countries_and_on_no_coast() {
    let between = [
        ("the Rhine at Strasbourg", 7.8, 48.58),
        ("the 49th parallel", -110.0, 49.0),
        ("Egypt and Sudan", 29.0, 22.0),
        ("the Russian-Mongolian border", 107.8, 49.7),
        ("Argentina and Chile on Tierra del Fuego", -68.61, -53.5),
    ];
    for (name, lon, lat) in between {
        assert!(distance_to_border(lon, lat).is_some(), "{name}");
    }
    let inside = [
        ("Paris", 2.35, 48.86),
        ("the coast of Portugal", -9.2, 38.7),
        ("Chukotka at 180", 180.0, 67.0),
        ("the South Pole", 0.0, -90.0),
        ("the Antarctic at 180", 180.0, -84.5),
        ("the Pacific", -150.0, 0.0),
    ];
    for (name, lon, lat) in inside {
        assert_eq!(distance_to_border(lon, lat), None, "{name}");
    }
}

#[test]
fn a_way_that_crosses_an_odd_number_of_coasts_leads_from_land_to_sea() {
    let [view, _] = views();
    let (coast, all) = (LineMap::of_coasts(&view), segments(COASTS[scale(&view)]));
    let mut random = Random::new(1);
    let cross =
        |a: [f64; 2], b: [f64; 2], c: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0;
    let mut found = [0; 2];
    for _ in 0..2000 {
        let mut place = || [360.0 * random.unit() - 180.0, 180.0 * random.unit() - 90.0];
        let (from, to) = (place(), place());
        let crosses =
            |[a, b]: &&Segment| cross(from, to, *a) != cross(from, to, *b) && cross(*a, *b, from) != cross(*a, *b, to);
        let changes = all.iter().filter(crosses).count() % 2 == 1;
        let is = [from, to].map(|[lon, lat]| coast.is_land(lon, lat));
        assert_eq!(is[0] != is[1], changes, "{from:?} to {to:?}");
        found[usize::from(changes)] += 1;
    }
    assert!(found[0] > 500 && found[1] > 500, "{found:?}");
}

#[test]
fn a_part_of_the_earth_is_land() {
    let coast = LineMap::of_coasts(&views()[1]);
    let mut random = Random::new(1);
    let count = 40_000;
    let is_land = |_: &i32| {
        let (lon, z) = (360.0 * random.unit() - 180.0, 2.0 * random.unit() - 1.0);
        coast.is_land(lon, z.asin().to_degrees())
    };
    let part = (0..count).filter(is_land).count() as f64 / f64::from(count);
    // With ice shelves, and lakes as land.
    assert!((part - 0.29).abs() < 0.012, "{part}");
}

/// The angle to the nearest of many points on all lines.
fn brute(place: DVec3, all: &[Segment]) -> f64 {
    let mut nearest = 0.0f64;
    for segment in all {
        for piece in pieces(segment) {
            let [a, b] = piece.map(|[lon, lat]| unit_vector(lon.to_radians(), lat.to_radians()));
            for part in 0..=100 {
                nearest = nearest.max(a.lerp(b, f64::from(part) / 100.0).normalize().dot(place));
            }
        }
    }
    nearest.min(1.0).acos()
}

#[test]
fn distances_are_those_to_the_nearest_of_all_coasts() {
    let [view, _] = views();
    let (coast, all) = (LineMap::of_coasts(&view), segments(COASTS[scale(&view)]));
    let mut random = Random::new(1);
    let mut near = 0;
    let poles = [[0.0, -90.0], [10.0, 90.0], [180.0, -84.5], [-180.0, -16.2], [179.99, 68.9], [-179.99, 65.0]];
    let coasts = (0..40).map(|i| {
        // Beside a coast somewhere.
        let [lon, lat] = all[i * 127][0];
        [lon + 4.0 * random.unit() - 2.0, lat + 4.0 * random.unit() - 2.0]
    });
    for [lon, lat] in coasts.chain(poles).collect::<Vec<_>>() {
        let (lat, height) = (lat.clamp(-90.0, 90.0), 1000);
        let camera = Camera::above(lon, lat, 1.5, 60.0).unwrap();
        let place = unit_vector(lon.to_radians(), lat.to_radians());
        let jacobian = ScreenJacobian::new(&View::new(camera, height), &SurfaceHit::round(place)).unwrap();
        let truth = brute(place, &all) * jacobian.min_stretch();
        for reach in [3.0, 20.0, 60.0] {
            let found = coast.distance(&jacobian, reach, 10.0);
            assert_eq!(found.is_some(), truth < reach, "{lon} {lat}: {found:?}, {truth}");
            if let Some(found) = found {
                near += 1;
                assert!((found - truth).abs() < 0.01 + 1e-3 * truth, "{lon} {lat}: {found}, {truth}");
            }
        }
        assert_eq!(coast.distance(&jacobian, 60.0, 1.0), None, "60 pixels are more than a degree");
    }
    assert!(near > 40, "{near}");
}
