//! The kernel piece by piece, on one thread: `cargo bench -p icoray`. Whole frames are `icoray-study speed`'s.
//!
//! Rates are of columns, frusta, pieces, values and cells.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use glam::DVec3;
use icoray::device::Span;
use icoray::{Field, Grid, IcosahedralMesh, Layers, Location, Method, Renderer, Scene, Stretch, Traversal};
use icoray_kernel::lit::{FrustumInterpolant, Lit};
use icoray_kernel::piece::{self, ErrorBudget, Radiance};
use icoray_kernel::segment::Segment;
use icoray_kernel::shade;
use std::ops::ControlFlow;
use std::sync::LazyLock;

fn main() {
    divan::main();
}

const LEVEL: u32 = 6;
const LAYERS: usize = 40;

static MESH: LazyLock<IcosahedralMesh> = LazyLock::new(|| IcosahedralMesh::new(LEVEL).unwrap());
static GRID: LazyLock<Grid<'static>> = LazyLock::new(|| Grid::new(MESH.tables()).unwrap());
static LAYER_RADII: LazyLock<Layers> = LazyLock::new(|| Layers::new(radii(LAYERS), 1.0).unwrap());

/// Waves of many sizes, level-fastest, in [-1, 1].
static VALUES: LazyLock<Vec<f32>> = LazyLock::new(|| {
    let wave = |cell: usize, layer: usize| {
        let p = GRID.direction(cell as u32) * (1.0 + 0.5 * layer as f64 / LAYERS as f64);
        0.6 * (7.0 * p.x).sin() * (5.0 * p.y).cos() + 0.4 * (23.0 * p.z).sin()
    };
    (0..GRID.cells() * LAYERS).map(|i| wave(i / LAYERS, i % LAYERS) as f32).collect()
});

/// `count` radii from 1 to 1.15.
fn radii(count: usize) -> Vec<f64> {
    (0..count).map(|l| 1.0 + 0.15 * l as f64 / (count - 1) as f64).collect()
}

fn field() -> Field<'static> {
    Field::level_fastest(VALUES.as_slice(), LAYERS, Location::Center).unwrap()
}

/// Counts the frusta that a row of rays meets in front of the core; the first one is searched from `hint`.
fn meet(traversal: &Traversal, mut hint: u32) -> u64 {
    let mut met = 0;
    let eye = DVec3::new(3.0, 0.2, 0.1);
    for ray in 0..64 {
        let target = DVec3::new(0.0, f64::from(ray) / 64.0, 0.3);
        traversal.ray(black_box(eye), (target - eye).normalize(), &mut hint, |stretch| match stretch {
            Stretch::Frustum(frustum) => {
                black_box(frustum);
                met += 1;
                ControlFlow::Continue(())
            }
            Stretch::Core { .. } => ControlFlow::Break(()),
        });
    }
    met
}

/// Rays over columns of as many layers: with 2 that is the walk, with more the crossing of layers.
#[divan::bench(args = [2, 40, 160])]
fn traverse(bencher: Bencher, layers: usize) {
    let traversal = Traversal::new(&GRID, &radii(layers)).unwrap();
    let mut hint = 0;
    traversal.ray(DVec3::new(3.0, 0.2, 0.1), DVec3::NEG_X, &mut hint, |_| ControlFlow::Break(()));
    let met = meet(&traversal, hint);
    bencher.counter(ItemsCount::new(met)).bench_local(|| meet(&traversal, hint));
}

fn scene(pixels: u32, light: &str) -> Scene {
    let light = if light == "lit" { "[light]" } else { "" };
    let text = format!(
        "field = \"f\"\n[image]\nwidth = {pixels}\nheight = {pixels}\n[camera]\nlon = 30\nlat = 25\ndistance = 3.2\nfov = 45\n\
         [transfer]\nmap = \"viridis\"\nrange = [-1, 1]\nopacity = [[-1, 0.5], [-0.3, 0.0], [0.3, 0.0], [1, 0.5]]\n{light}"
    );
    Scene::parse(&text).unwrap()
}

fn draw(bencher: Bencher, renderer: Renderer, scene: &Scene) {
    let render = || renderer.render(scene, &GRID, &LAYER_RADII, &field()).unwrap();
    let frusta = render().report.counts.frusta;
    bencher.counter(ItemsCount::new(frusta)).bench_local(render);
}

/// Frusta that a frame's rays walk to and interpolate in, and that is all.
#[divan::bench(sample_count = 20)]
fn walk_and_interpolate(bencher: Bencher) {
    let mut scene = scene(96, "unlit");
    let knots = &mut scene.volumes[0].transfer.knots;
    *knots = [0, knots.len() - 1].map(|k| knots[k]).to_vec();
    draw(bencher, Renderer::new(1).unwrap().without_integrals(), &scene);
}

/// Frusta of a frame.
#[divan::bench(args = ["unlit", "lit"], sample_count = 20)]
fn frame(bencher: Bencher, light: &str) {
    draw(bencher, Renderer::new(1).unwrap(), &scene(96, light));
}

/// Values that are read before the first ray: range, what can be seen, and gradients where there is light.
#[divan::bench(args = ["unlit", "lit"], sample_count = 20)]
fn prepare(bencher: Bencher, light: &str) {
    let (renderer, scene) = (Renderer::new(1).unwrap(), scene(1, light));
    let render = || renderer.render(&scene, &GRID, &LAYER_RADII, &field()).unwrap();
    bencher.counter(ItemsCount::new(VALUES.len())).bench_local(render);
}

/// Values whose range is found.
#[divan::bench]
fn range(bencher: Bencher) {
    let renderer = Renderer::new(1).unwrap();
    bencher.counter(ItemsCount::new(VALUES.len())).bench_local(|| renderer.run(|| field().range()));
}

/// Cells whose tables are checked and derived.
#[divan::bench]
fn check_tables(bencher: Bencher) {
    let renderer = Renderer::new(1).unwrap();
    let check = || renderer.run(|| Grid::new(MESH.tables()).unwrap());
    bencher.counter(ItemsCount::new(GRID.cells())).bench_local(check);
}

const SPAN: Span = Span {
    low: -1.0,
    high: 1.0,
    anchor: 0.0,
    extinction: 1.0,
    extinction_slope: 1.0,
    color: [0.2, 0.5, 0.8],
    color_slope: [0.5, -0.3, 0.1],
    steepest: 0.5,
    brightest: 1.0,
    is_clear: false,
};

/// A piece of this optical depth.
fn piece(depth: f32) -> Segment<f32> {
    Segment { f0: 0.1, f1: 0.3, kappa: 0.02, eps: 1e-3, length: depth / 1.2 }
}

const ALLOWANCE: ErrorBudget<f32> =
    ErrorBudget { color_tolerance: 5e-4, min_transmittance: 5e-4, transmittance: 1.0, reach: 1e-7 };

/// Pieces by the rule that their optical depth asks for.
#[divan::bench(args = [("thin", 0.05), ("gauss", 0.7), ("panels", 3.0), ("halves", 200.0)])]
fn integrate(bencher: Bencher, (_, depth): (&str, f32)) {
    let piece = piece(depth);
    let one = || piece::integrate(Method::Exact, &black_box(piece), black_box(&SPAN), &ALLOWANCE);
    bencher.counter(ItemsCount::new(1usize)).bench_local(one);
}

/// Pieces under a headlight, whose gradient turns by so much: the second is cut.
#[divan::bench(args = [0.01, 1.0])]
fn integrate_lit(bencher: Bencher, turn: f32) {
    let (ambient, diffuse, specular, shininess) = (0.3, 0.7, 0.2, 20.0);
    let shading = shade::Shading { ambient, diffuse, specular, shininess, towards_light: None, is_packed: false };
    let shading = &shading.along::<f32>(DVec3::Z);
    let (from, to) = ([0.0, 0.2, 0.1, 1.0], [0.0, 0.2 + turn, 0.1 - turn, 1.0]);
    let interpolant = FrustumInterpolant { from, to, kappa: [0.0; 4], eps: 1e-3 };
    let one = || {
        let (piece, interpolant) = (black_box(piece(0.05)), &black_box(interpolant));
        let (method, allowance, span) = (Method::Exact, &ALLOWANCE, &SPAN);
        let lit = Lit::<f32, 4> { method, allowance, shading, span, interpolant, gradient_size: 0.0 };
        lit.light(&piece, [0.0, 1.0], Lit::<f32, 4>::MAX_CUTS, &Radiance::none())
    };
    bencher.counter(ItemsCount::new(1usize)).bench_local(one);
}
