//! Fragments of packets against those of single rays, ray by ray.

use crate::budget::Budget;
use crate::counts::Counts;
use crate::fragment::Fragment;
use crate::general::{Clips, FieldSource, KernelScene, Levels, Medium, RaySettings, TransferMap};
use crate::ground::Core;
use crate::owned_region::OwnedRegion;
use crate::packet::PacketScene;
use crate::scene_tracer::SceneTracer;
use crate::shade::Shading;
use crate::trace::{PrimaryRay, Tracer};
use crate::transfer::KernelKnot;
use crate::walk::tests::culled::{Culled, Mark, Style, holes};
use fearless_simd::Level;
use glam::DVec3;
use icoray_grid::gradient::{GradientOptions, Gradients, gradients};
use icoray_grid::marks::Marks;
use icoray_grid::occupancy::OccupancyMask;
use icoray_grid::samples::Samples;
use icoray_grid::{Field, Grid, IcosahedralMesh, Location, Shape};
use icoray_scene::Method;
use icoray_test_support::{Random, count};

const RADII: [f64; 6] = [1.0, 1.02, 1.05, 1.09, 1.14, 1.2];
const LAYERS: usize = RADII.len();
const TOLERANCE: f64 = 1e-3;
const SHADING: Shading =
    Shading { ambient: 0.3, diffuse: 0.7, specular: 0.3, shininess: 20.0, towards_light: None, is_packed: false };

/// A field over a grid, part of whose values are clear, and a region of its triangles.
struct Model<'g> {
    grid: &'g Grid<'g>,
    values: Vec<f32>,
    knots: Vec<KernelKnot>,
    /// The visible blocks; everything is visible without them.
    blocks: Vec<u32>,
    own: OwnedRegion<'static>,
}

impl<'g> Model<'g> {
    /// `density` is that of the densest values.
    fn new(grid: &'g Grid<'g>, is_own: impl Fn(DVec3, u32) -> bool, density: f64) -> Self {
        let value = |p: DVec3, layer: usize| (5.0 * p.x).sin() * (6.0 * p.y).cos() + p.z + 0.1 * layer as f64;
        let of_cell = |cell: u32| (0..LAYERS).map(move |layer| value(grid.direction(cell), layer) as f32);
        let values: Vec<f32> = (0..grid.cells() as u32).flat_map(of_cell).collect();
        let knot = |value, color, extinction| KernelKnot { value, color, extinction };
        let knots = vec![
            knot(-1.0, [0.9, 0.2, 0.1], density),
            knot(-0.3, [0.8, 0.8, 0.2], 0.0),
            knot(0.3, [0.3, 0.8, 0.2], 0.0),
            knot(1.5, [0.2, 0.3, 0.9], density),
        ];
        let middle = |t: u32| grid.triangle(t).map(|cell| grid.direction(cell)).into_iter().sum::<DVec3>().normalize();
        let owns = |t: u32| grid.is_triangle(t) && is_own(middle(t), t);
        let own = OwnedRegion::new(grid, Marks::new((0..grid.triangles() as u32).map(owns)));
        Model { grid, values, knots, blocks: Vec::new(), own }
    }

    /// The same with a mask of the gaps in which something shows.
    fn masked(mut self) -> Self {
        let blocks = |triangle: u32| {
            let at =
                |layer: usize| self.grid.triangle(triangle).map(|cell| self.values[cell as usize * LAYERS + layer]);
            let shows = |gap: usize| at(gap - 1).into_iter().chain(at(gap)).any(|value| !(-0.2..0.2).contains(&value));
            (1..LAYERS).map(|gap| u32::from(self.grid.is_triangle(triangle) && shows(gap)) << (gap - 1)).sum()
        };
        self.blocks = (0..self.grid.triangles() as u32).map(blocks).collect();
        self
    }

    fn field(&self) -> Field<'_> {
        let shape = Shape::level_fastest(self.grid.cells(), LAYERS);
        Field::new(self.values.as_slice().into(), shape, Location::Center, None).unwrap()
    }

    fn scene(&self, is_lit: bool, core: Option<[f64; 3]>) -> KernelScene<'_> {
        let map = || TransferMap::new(0, self.knots.clone());
        let wanted = GradientOptions::default();
        let cuts: Vec<f64> = self.knots.iter().map(|knot| knot.value).collect();
        let samples = Samples::new(&self.values, &self.field(), false, [cuts[0], cuts[cuts.len() - 1]]);
        let cells = if is_lit { 0..self.grid.cells() } else { 0..0 };
        let light = gradients(self.grid, &RADII, &samples, cells, wanted, Gradients::none()).unwrap();
        let (outer, full) = (RADII[LAYERS - 1] * (1.0 + 1e-9), OccupancyMask::default().full(LAYERS));
        KernelScene {
            grid: self.grid,
            levels: Levels::concentric(&RADII),
            sources: vec![FieldSource {
                field: self.field(),
                gradients: light.into(),
                cuts,
                value_range: self.field().range().0,
                largest: f64::MAX,
            }],
            media: vec![Medium::new(map(), map())],
            isosurfaces: Vec::new(),
            surface_layers: Vec::new(),
            clips: Clips::default(),
            visible: OccupancyMask { blocks: self.blocks.as_slice().into(), ..full },
            beside: 0,
            normals: Vec::new(),
            core: Core::new(core, None),
            core_radius: [RADII[0]; 2],
            outer,
        }
    }
}

/// The fragments inside `own` of each of `all` rays, of which `rays` are traced: in packets with vector instructions,
/// one after the other without.
fn traced(
    scene: &KernelScene,
    own: &OwnedRegion,
    is_lit: bool,
    level: Option<Level>,
    rays: &[PrimaryRay],
    all: usize,
) -> (Vec<Vec<Fragment>>, Counts) {
    let (mut found, mut counts) = (vec![Vec::new(); all], Counts::default());
    let packets = PacketScene::new(scene, &RADII, false).unwrap();
    let settings = RaySettings {
        scene,
        shading: is_lit.then_some(SHADING),
        budget: Budget::new(TOLERANCE, 1.0, is_lit.then_some(1.0)),
        method: Method::Exact,
        is_coarse: false,
    };
    let packets = level.map(|level| (level, &packets));
    let tracer = SceneTracer { rays: settings, packets, integrates: true };
    tracer.fragments(own, &mut rays.iter().copied(), &mut counts, &mut |ray, all| {
        assert!(found[ray].is_empty() && !all.is_empty());
        found[ray].extend(all);
    });
    (found, counts)
}

/// Rays from an eye towards places in the shell and beside it.
fn rays(eye: DVec3, random: &mut Random) -> Vec<PrimaryRay> {
    let ray = |number: usize| {
        let target = DVec3::from_array(random.direction()) * 1.25 * random.unit();
        PrimaryRay { number, eye, dir: (target - eye).normalize(), begins_row: number.is_multiple_of(16) }
    };
    (0..count(400, 20_000)).map(ray).collect()
}

/// Ends to the bit, light within both errors. Returns whether rounding decided in which fragment the ray ended.
fn assert_alike(single: &[Fragment], packet: &[Fragment], case: &str) -> bool {
    let ends = |all: &[Fragment]| all.iter().map(|fragment| fragment.t).collect::<Vec<_>>();
    let has_ended = |all: &[Fragment]| all.last().is_some_and(|fragment| fragment.t[1] == f64::INFINITY);
    if ends(single) != ends(packet) && (has_ended(single) || has_ended(packet)) {
        return true;
    }
    assert_eq!(ends(single), ends(packet), "{case}");
    // The light that the end of a ray omits may be hidden by the fragments before.
    let left_out = |fragment: &Fragment| if fragment.t[1] == f64::INFINITY { 1.0 - fragment.alpha } else { 0.0 };
    for (a, b) in single.iter().zip(packet) {
        let rounding = 4.0 * (a.variance.sqrt() + b.variance.sqrt()) + f32::EPSILON;
        let off = (0..3).map(|k| (a.color[k] - b.color[k]).abs()).fold((a.alpha - b.alpha).abs(), f32::max);
        assert!(off <= a.error + b.error + rounding, "{case}: {off:e} between {a:?} and {b:?}");
        assert!(b.error - left_out(b) < 2.0 * TOLERANCE as f32, "{case}: {b:?}");
    }
    false
}

#[test]
fn fragments_of_packets_are_those_of_single_rays() {
    let Some(level) = icoray_grid::vectors::packets() else { return };
    let mesh = IcosahedralMesh::new(4).unwrap();
    let whole = Grid::new(mesh.tables()).unwrap();
    let holes = holes(&mesh);
    let culled = Culled::new(&mesh, &holes[holes.len() / 2].1, Style::Corners, Mark::BeforeFirst, 1);
    let with_holes = culled.grid();
    let patch = |p: DVec3, _: u32| p.dot(DVec3::new(0.6, 0.5, 0.3)) > 0.2;
    let scattered = |_: DVec3, t: u32| Random::at(t as usize).below(4) == 0;
    let models = [
        ("patch", Model::new(&whole, patch, 8.0)),
        ("scattered", Model::new(&whole, scattered, 40.0)),
        ("scattered, clear parts left out", Model::new(&whole, scattered, 8.0).masked()),
        ("holes", Model::new(&with_holes, patch, 8.0)),
        ("holes, dense and scattered", Model::new(&with_holes, scattered, 200.0).masked()),
    ];
    let mut random = Random::new(7);
    let (mut fragments, mut ended) = (0, 0);
    for eye in [DVec3::new(2.1, 1.4, 0.9), DVec3::new(0.7, 0.75, 0.4)] {
        let rays = rays(eye, &mut random);
        let some: Vec<PrimaryRay> = rays.iter().rev().filter(|ray| ray.number % 3 == 1).copied().collect();
        for (name, model) in &models {
            for (is_lit, core) in [(false, None), (false, Some([0.5, 0.3, 0.2])), (true, None), (true, Some([0.2; 3]))]
            {
                let case = format!("{name}, eye {eye}, lit {is_lit}, core {core:?}");
                let scene = &model.scene(is_lit, core);
                let trace = |level, some| traced(scene, &model.own, is_lit, level, some, rays.len());
                let (single, single_counts) = trace(None, &rays);
                let (found, counts) = trace(Some(level), &rays);
                let columns = [counts.columns, single_counts.columns];
                assert!(
                    counts.rays == 0 && 1000 * columns[0].abs_diff(columns[1]) <= columns[0],
                    "{case}: {columns:?}"
                );
                let pairs = single.iter().zip(&found).enumerate();
                let others = pairs.filter(|(ray, (a, b))| assert_alike(a, b, &format!("{case}, ray {ray}"))).count();
                assert!(1000 * others <= rays.len(), "{case}: {others} rays end elsewhere");
                // In any order, beside any others.
                let (alone, _) = trace(Some(level), &some);
                assert!(some.iter().all(|ray| alone[ray.number] == found[ray.number]), "{case}");
                let all = || found.iter().flatten();
                assert!(all().any(|fragment| fragment.alpha > 0.1), "{case}");
                fragments += all().count();
                ended += all().filter(|fragment| fragment.t[1] == f64::INFINITY).count();
            }
        }
    }
    assert!(fragments > 10_000 && ended > 500, "{fragments} fragments, {ended} rays ended in them");
}
