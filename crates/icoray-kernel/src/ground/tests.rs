//! Lines against pictures of hard lines, sampled 16 × 16 times in each pixel.

mod sampled;

use super::line_map::{BORDERS, COASTS};
use super::*;
use crate::walk::locate;
use glam::DVec3;
use icoray_grid::grid::unit_vector;
use icoray_grid::{Grid, IcosahedralMesh};
use icoray_scene::{Camera, Lines, LonLatBox, Outlines, Pattern};
use sampled::{Off, Sampled, Surface};

/// Lines that turn, meet and run at an angle through their pixels are no more than this from the sampled ones.
const RMS: f64 = 0.05;

/// A scene of lines on the ground, or on their own level.
fn scene(camera: Camera, lines: Vec<Lines>) -> Scene {
    let mut scene = Scene::parse(
        "field = \"q\"\nimage = { width = 160, height = 160 }\n\
         transfer = { map = \"viridis\", range = [0, 1], opacity = [[0, 0.0], [1, 0.0]] }\n",
    )
    .unwrap();
    (scene.camera, scene.scenery.lines) = (camera, lines);
    scene
}

/// A camera that looks straight down from two radii above the place at 0, 0.
fn above_zero() -> Camera {
    Camera::above(0.0, 0.0, 3.0, 40.0).unwrap()
}

/// The part of a pixel that lines on the ground of a round sphere cover at a place.
fn covered(scene: &Scene, at: [f64; 2]) -> f64 {
    Painter::new(scene, Level::Ground).unwrap().paint(&SurfaceHit::round(place(at)), None)[3]
}

/// Compares painted lines with sampled ones, of which more than `least` pixels are seen; `grid` is that of lines along
/// its cells or triangles.
fn assert_sampled(what: &str, sampled: &Sampled, polylines: &[Vec<DVec3>], grid: Option<&Grid>, least: f64) -> Off {
    let painter = Painter::new(sampled.scene, Level::Ground).unwrap();
    let at = |hit: &SurfaceHit| grid.map(|grid| (grid, locate(grid, 0, hit.position)));
    let off = sampled.compare(polylines, |hit| painter.paint(hit, at(hit))[3]);
    assert!(off.ink > least && off.rms < RMS, "{what}: {off:?}");
    assert!((off.drawn - off.ink).abs() < 0.03 * off.ink, "{what}: {off:?}");
    off
}

fn lines(pattern: Pattern, width_px: f64) -> Lines {
    Lines { pattern, on: Level::Ground, color: [1.0; 3], width_px, opacity: 1.0, region: None }
}

fn place([lon, lat]: [f64; 2]) -> DVec3 {
    unit_vector(lon.to_radians(), lat.to_radians())
}

/// Points in steps of a twentieth of a degree.
fn polyline(from: [f64; 2], to: [f64; 2]) -> Vec<DVec3> {
    let count = (20.0 * (to[0] - from[0]).abs().max((to[1] - from[1]).abs())).ceil().max(1.0);
    let at = |i: i32| [0, 1].map(|k| from[k] + f64::from(i) / count * (to[k] - from[k]));
    (0..=count as i32).map(|i| place(at(i))).collect()
}

fn graticule(spacing: i32) -> Vec<Vec<DVec3>> {
    let last = (89 / spacing) * spacing;
    let parallels = (-last..=last).step_by(spacing as usize);
    let parallels = parallels.map(|lat| polyline([-180.0, lat.into()], [180.0, lat.into()]));
    let meridians = (-180..180).step_by(spacing as usize).map(|lon| {
        let end = f64::from(if lon % 90 == 0 { 90 } else { last });
        polyline([lon.into(), -end], [lon.into(), end])
    });
    parallels.chain(meridians).collect()
}

fn map_lines(runs: [&[u8]; 2], camera: Camera) -> Vec<Vec<DVec3>> {
    let scale = line_map::scale(&View::of(&scene(camera, Vec::new())));
    line_map::segments(runs[scale]).iter().map(|[from, to]| polyline(*from, *to)).collect()
}

fn arc(from: DVec3, to: DVec3) -> Vec<DVec3> {
    (0..=60).map(|i| from.lerp(to, f64::from(i) / 60.0).normalize()).collect()
}

/// A camera over `towards` that looks at the limb north-east of it.
fn at_limb(lon: f64, lat: f64, fov: f64) -> Camera {
    let eye = 3.0 * place([lon, lat]);
    let east = DVec3::new(-lon.to_radians().sin(), lon.to_radians().cos(), 0.0);
    let aside = (east + 0.7 * DVec3::Z).normalize();
    let aside = (aside - eye * (aside.dot(eye) / 9.0)).normalize();
    // The place at which a line from the eye touches the sphere.
    let limb = eye / 9.0 + aside * (8.0f64 / 9.0).sqrt();
    Camera::look_at(eye.to_array(), (0.985 * limb).to_array(), [0.0, 0.0, 1.0], fov).unwrap()
}

#[test]
fn lines_are_those_of_a_picture_sampled_many_times() {
    let graticule_of = |spacing_deg| Pattern::Graticule { spacing_deg };
    let globe = Camera::above(20.0, 35.0, 3.0, 45.0).unwrap();
    let pole = Camera::above(30.0, 88.0, 1.5, 40.0).unwrap();
    let near = Camera::above(12.3, 41.0, 1.3, 5.0).unwrap();
    let alps = Camera::above(9.0, 47.0, 1.3, 10.0).unwrap();
    let at_180 = Camera::above(180.0, -17.0, 1.3, 9.0).unwrap();
    let limb = at_limb(80.0, 10.0, 6.0);
    let file = std::env::temp_dir().join(format!("icoray-lines-{}.geojson", std::process::id()));
    let ring = [[170.0, -20.0], [195.0, -14.0], [188.0, -25.0], [170.0, -20.0]];
    std::fs::write(&file, format!(r#"{{"type": "Polygon", "coordinates": [{ring:?}]}}"#)).unwrap();
    let outlines = Outlines::read(&file).unwrap();
    std::fs::remove_file(file).unwrap();
    let ring = ring.windows(2).map(|pair| polyline(pair[0], pair[1])).collect();
    let cases = [
        ("globe", globe, graticule_of(15.0), 1.5, graticule(15)),
        ("thin", globe, graticule_of(30.0), 0.4, graticule(30)),
        ("wide angle", Camera::above(70.0, -20.0, 1.2, 100.0).unwrap(), graticule_of(5.0), 1.0, graticule(5)),
        ("pole", pole, graticule_of(10.0), 2.0, graticule(10)),
        ("limb", at_limb(20.0, 35.0, 5.0), graticule_of(5.0), 2.0, graticule(5)),
        ("limb at 180", at_limb(130.0, 0.0, 8.0), graticule_of(3.0), 1.5, graticule(3)),
        ("coast", near, Pattern::Coast, 1.5, map_lines(COASTS, near)),
        ("coast at 180", at_180, Pattern::Coast, 1.0, map_lines(COASTS, at_180)),
        ("borders", alps, Pattern::Borders, 1.5, map_lines(BORDERS, alps)),
        ("outlines", at_180, Pattern::Outlines(outlines), 1.5, ring),
        ("coast at the limb", limb, Pattern::Coast, 1.2, map_lines(COASTS, limb)),
    ];
    for (name, camera, pattern, width, polylines) in cases {
        let scene = scene(camera, vec![lines(pattern.clone(), width)]);
        let apart = |lat: f64| match pattern {
            Pattern::Graticule { spacing_deg } => spacing_deg * lat.to_radians().cos().max(0.17),
            _ => 5.0,
        };
        let sampled = Sampled { scene: &scene, surface: Surface::Sphere, width, apart: &apart };
        assert_sampled(name, &sampled, &polylines, None, 40.0);
    }
}

#[test]
fn cells_and_triangles_are_those_of_the_grid() {
    let mesh = IcosahedralMesh::new(3).unwrap();
    let grid = Grid::new(mesh.tables()).unwrap();
    let corner = |t: u32| unit_vector(mesh.lon_corner_rad[t as usize], mesh.lat_corner_rad[t as usize]);
    let (mut edges, mut sides) = (Vec::new(), Vec::new());
    for triangle in 0..grid.triangles() as u32 {
        let cells = grid.triangle(triangle).map(|cell| grid.direction(cell));
        sides.extend([0, 1, 2].map(|k| arc(cells[k], cells[(k + 1) % 3])));
        edges.extend([0, 1, 2].map(|k| arc(corner(triangle), corner(grid.across(triangle, k)))));
    }
    for (pattern, polylines) in [(Pattern::Cells, edges), (Pattern::Triangles, sides)] {
        for camera in [Camera::above(20.0, 35.0, 3.0, 30.0).unwrap(), at_limb(20.0, 35.0, 8.0)] {
            let scene = scene(camera, vec![lines(pattern.clone(), 2.0)]);
            let sampled = Sampled { scene: &scene, surface: Surface::Sphere, width: 2.0, apart: &|_| 5.5 };
            assert_sampled(&format!("{pattern:?}"), &sampled, &polylines, Some(&grid), 100.0);
        }
    }
}

#[test]
fn edges_that_reach_over_from_a_neighbour_are_drawn() {
    let mut mesh = IcosahedralMesh::new(2).unwrap();
    let (triangle, beyond, there) = {
        let grid = Grid::new(mesh.tables()).unwrap();
        let beyond = grid.across(7, 1);
        let [_, b, c] = grid.triangle(7).map(|cell| grid.direction(cell));
        // Behind the common side, within the triangle.
        let centre = grid.triangle(7).map(|cell| grid.direction(cell)).iter().sum::<DVec3>().normalize();
        (7, beyond, (0.7 * (b + c).normalize() + 0.3 * centre).normalize())
    };
    mesh.lon_corner_rad[beyond as usize] = there.y.atan2(there.x);
    mesh.lat_corner_rad[beyond as usize] = there.z.asin();
    let grid = Grid::new(mesh.tables()).unwrap();
    for k in (0..3).filter(|k| grid.across(beyond, *k) != triangle) {
        let [from, to] = [1, 2].map(|j| grid.direction(grid.triangle(beyond)[(k + j) % 3]));
        let side = from.cross(to).normalize();
        let on_edge = (there - 0.1 * side.dot(there) * side).normalize();
        assert_eq!(locate(&grid, 0, on_edge), triangle);
        let camera = Camera::look_at((3.0 * on_edge).to_array(), [0.0; 3], [0.1, 0.2, 1.0], 40.0).unwrap();
        let scene = scene(camera, vec![lines(Pattern::Cells, 1.0)]);
        let painter = Painter::new(&scene, Level::Ground).unwrap();
        let covered = painter.paint(&SurfaceHit::round(on_edge), Some((&grid, triangle)))[3];
        assert!(covered > 0.999, "{k}: {covered}");
    }
}

#[test]
fn lines_on_a_slope_are_as_wide_as_elsewhere() {
    let pattern = Pattern::Graticule { spacing_deg: 1.0 };
    let up = place([10.5, 30.5]);
    let east = DVec3::Z.cross(up);
    // Steep, facing the north-west, and seen from above and aside.
    let normal = (0.5 * up - 0.6 * east + 0.5 * DVec3::Z).normalize();
    let eye = up + 0.5 * (normal + 0.4 * up + 0.7 * east);
    let camera = Camera::look_at(eye.to_array(), up.to_array(), [0.0, 0.0, 1.0], 9.0).unwrap();
    let scene = scene(camera, vec![lines(pattern, 1.5)]);
    let painter = Painter::new(&scene, Level::Ground).unwrap();
    let surface = Surface::Plane { on: up, normal };
    let sampled = Sampled { scene: &scene, surface, width: 1.5, apart: &|_| 0.8 };
    let off = assert_sampled("slope", &sampled, &graticule(1), None, 100.0);
    let round = sampled.compare(&graticule(1), |hit| painter.paint(&SurfaceHit::round(hit.position), None)[3]);
    assert!(round.rms > 2.0 * off.rms, "a slope taken for level ground: {round:?}");
}

#[test]
fn a_region_ends_lines_at_its_sides_and_not_before() {
    let mut shown = lines(Pattern::Graticule { spacing_deg: 10.0 }, 2.0);
    shown.region = Some(LonLatBox { lon_deg: [160.0, 200.0], lat_deg: [0.0, 20.0] });
    let scene = scene(Camera::above(178.0, 10.0, 3.0, 30.0).unwrap(), vec![shown]);
    for at in [[180.0, 5.0], [-170.0, 15.0], [165.0, 10.0], [-165.0, 20.0], [160.0, 7.0], [-160.0, 0.0]] {
        assert!(covered(&scene, at) > 0.999, "{at:?}: {}", covered(&scene, at));
    }
    for at in [[180.0, 25.0], [150.0, 5.0], [-150.0, 5.0], [-155.0, 10.0], [155.0, 0.0], [170.0, -5.0]] {
        assert_eq!(covered(&scene, at), 0.0, "{at:?}");
    }
}

#[test]
fn crowded_lines_fade() {
    let graticule = |spacing_deg| scene(above_zero(), vec![lines(Pattern::Graticule { spacing_deg }, 1.0)]);
    // A pixel is 0.52 degrees where the camera looks straight down.
    for (spacing_deg, expected) in [(6.0, 1.0..=1.0), (1.0, 0.4..=0.75), (0.4, 0.0..=0.0)] {
        let here = covered(&graticule(spacing_deg), [0.0; 2]);
        assert!(expected.contains(&here), "{spacing_deg}: {here}");
    }
    // Towards the limb meridians crowd, and on the equator the parallel stays.
    let scene = graticule(5.0);
    assert_eq!([0.0, 20.0, 69.0].map(|lon| covered(&scene, [lon, 0.0])), [1.0; 3]);
    let beside = [20.0, 70.0].map(|lon| covered(&scene, [lon, 2.5]));
    assert!(beside[0] == 1.0 && beside[1] < 0.2, "{beside:?}");
}

#[test]
fn later_lines_lie_over_earlier_ones_and_only_on_their_level() {
    let graticule = lines(Pattern::Graticule { spacing_deg: 10.0 }, 3.0);
    let red = Lines { color: [1.0, 0.0, 0.0], ..graticule.clone() };
    let half = Lines { color: [0.0, 0.0, 1.0], opacity: 0.25, ..graticule.clone() };
    let top = Lines { on: Level::Top, ..graticule };
    let scene = scene(above_zero(), vec![red, half, top]);
    let hit = SurfaceHit::round(place([0.0, 0.0]));
    let painted = |level| Painter::new(&scene, level).unwrap().paint(&hit, None);
    assert_eq!(painted(Level::Ground), [0.75, 0.0, 0.25, 1.0]);
    assert_eq!(painted(Level::Top), [1.0; 4]);
    assert!(Painter::new(&scene, Level::Layer(0)).is_none());
}

#[test]
fn invisible_hits_are_not_painted() {
    let shown = [Pattern::Coast, Pattern::Graticule { spacing_deg: 10.0 }].map(|pattern| lines(pattern, 1.0));
    let scene = scene(above_zero(), shown.to_vec());
    let painter = Painter::new(&scene, Level::Ground).unwrap();
    let odd = [
        SurfaceHit::round(DVec3::ZERO),
        SurfaceHit::round(DVec3::NAN),
        SurfaceHit { position: DVec3::X, normal: DVec3::ZERO },
        SurfaceHit { position: DVec3::X, normal: DVec3::Y },
        SurfaceHit::round(DVec3::X * 3.0),
        SurfaceHit::round(DVec3::X * 4.0),
    ];
    for hit in odd {
        assert_eq!(painter.paint(&hit, None), [0.0; 4], "{hit:?}");
    }
    for pole in [DVec3::Z, DVec3::NEG_Z] {
        assert!(painter.paint(&SurfaceHit::round(pole), None).iter().all(|part| (0.0..=1.0).contains(part)));
    }
}
