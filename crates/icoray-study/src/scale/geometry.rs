//! The work of nodes and the fragments of rays, from the geometry of a partition: for grids that no machine at hand
//! holds. Rays are sampled, and each is followed in steps of a fraction of a cell.

use crate::ranks::morton;
use glam::DVec3;
use icoray::Scene;
use rayon::prelude::*;
use std::f64::consts::PI;

/// A partition of the cells over nodes, of equal numbers of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Partition {
    /// Compact patches around places that are spread evenly, as METIS makes them.
    Patches,
    /// Stretches of a space-filling curve.
    Curve,
    /// Bands of latitude.
    Bands,
}

/// A grid of `cells` cells per layer in the shell between these radii.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shell {
    pub cells: f64,
    pub layers: usize,
    pub radius: [f64; 2],
}

/// What a picture's rays meet.
pub(super) struct Work {
    /// Frusta per pixel, and the share of each node in them.
    pub frusta: f64,
    pub shares: Vec<f64>,
    /// Fragments per pixel: stretches of a ray within a node's cells.
    pub fragments: f64,
}

impl Work {
    /// Mean over maximum of the nodes' work.
    pub fn balance(&self) -> f64 {
        1.0 / (self.shares.len() as f64 * self.shares.iter().fold(0.0, |max: f64, share| max.max(*share)))
    }
}

/// The nodes of directions.
enum Nodes {
    /// Middles of the patches.
    Patches(Vec<DVec3>),
    /// The first place on the curve of each node but the first.
    Curve(Vec<u64>),
    Bands(usize),
}

impl Nodes {
    fn new(partition: Partition, nodes: usize) -> Self {
        match partition {
            Partition::Patches => Nodes::Patches(lattice(nodes).collect()),
            Partition::Bands => Nodes::Bands(nodes),
            Partition::Curve => {
                let count = 200 * nodes;
                let mut codes: Vec<u64> = lattice(count).map(code).collect();
                codes.sort_unstable();
                Nodes::Curve((1..nodes).map(|node| codes[node * count / nodes]).collect())
            }
        }
    }

    fn of(&self, direction: DVec3) -> usize {
        match self {
            Nodes::Patches(middles) => {
                let near = |k: &usize| middles[*k].dot(direction);
                (0..middles.len()).max_by(|a, b| near(a).total_cmp(&near(b))).unwrap_or(0)
            }
            Nodes::Curve(firsts) => firsts.partition_point(|first| *first <= code(direction)),
            Nodes::Bands(count) => (((1.0 - direction.z) / 2.0 * *count as f64) as usize).min(count - 1),
        }
    }
}

/// Places of equal areas: Fibonacci's lattice.
fn lattice(count: usize) -> impl Iterator<Item = DVec3> {
    (0..count).map(move |k| {
        let z = 1.0 - (2 * k + 1) as f64 / count as f64;
        let (sin, cos) = (k as f64 * 2.399_963_229_728_653).sin_cos();
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * cos, r * sin, z)
    })
}

fn code(direction: DVec3) -> u64 {
    morton(direction.y.atan2(direction.x), direction.z.asin())
}

/// Follows `side` x `side` rays of a scene's picture.
pub(super) fn work(scene: &Scene, shell: Shell, partition: Partition, nodes: usize, side: u32) -> Work {
    let places = Nodes::new(partition, nodes);
    let eye = DVec3::from_array(scene.camera.eye());
    let pixels = side * side;
    let of_pixel = |mut sum: (f64, Vec<f64>, f64), pixel: u32| {
        let dir = DVec3::from_array(scene.camera.direction(pixel % side, pixel / side, side, side));
        for stretch in stretches(eye, dir, shell.radius, scene.core.is_some()) {
            along(&mut sum, &places, shell, eye, dir, stretch);
        }
        sum
    };
    let nothing = || (0.0, vec![0.0; nodes], 0.0);
    let (frusta, mut shares, fragments) =
        (0..pixels).into_par_iter().fold(nothing, of_pixel).reduce(nothing, |mut a, b| {
            a.1.iter_mut().zip(b.1).for_each(|(a, b)| *a += b);
            (a.0 + b.0, a.1, a.2 + b.2)
        });
    shares.iter_mut().for_each(|share| *share /= frusta);
    Work { frusta: frusta / f64::from(pixels), shares, fragments: fragments / f64::from(pixels) }
}

/// Adds the frusta and the fragments of a stretch of a ray within the shell.
fn along(
    (frusta, of_nodes, fragments): &mut (f64, Vec<f64>, f64),
    nodes: &Nodes,
    shell: Shell,
    eye: DVec3,
    dir: DVec3,
    [from, to]: [f64; 2],
) {
    let spacing = (4.0 * PI / shell.cells).sqrt();
    let layer = (shell.radius[1] - shell.radius[0]) / shell.layers as f64;
    // A hundredth of the mean patch, and no less than a cell.
    let step = spacing.max((4.0 * PI / of_nodes.len() as f64).sqrt() / 100.0);
    let steps = ((to - from) / step).ceil().max(1.0);
    let step = (to - from) / steps;
    let mut last = None;
    for k in 0..steps as usize {
        let at = eye + (from + (k as f64 + 0.5) * step) * dir;
        let (rho, up) = (at.length(), at.normalize());
        let climb = dir.dot(up);
        // Edges of the triangles are 2 sqrt(3) per area and distance of cells; a line meets 2 / pi of them per length.
        let across = (1.0 - climb * climb).max(0.0).sqrt() / rho * 2.2 / spacing;
        let met = step * (across + climb.abs() / layer);
        let node = nodes.of(up);
        of_nodes[node] += met;
        *frusta += met;
        if last.replace(node) != Some(node) {
            *fragments += 1.0;
        }
    }
}

/// The stretches of a ray between two spheres, the second of them behind the inner one if that is no core.
fn stretches(eye: DVec3, dir: DVec3, [inner, outer]: [f64; 2], has_core: bool) -> Vec<[f64; 2]> {
    let middle = -eye.dot(dir);
    let nearest = (eye + middle * dir).length_squared();
    let half = |radius: f64| (radius * radius - nearest).max(0.0).sqrt();
    let (near, far) = (middle - half(outer), middle + half(outer));
    let stretches = match [inner, outer].map(|radius| nearest < radius * radius) {
        [false, false] => [[0.0; 2]; 2],
        [false, true] => [[near, far], [0.0; 2]],
        [true, _] => [[near, middle - half(inner)], if has_core { [0.0; 2] } else { [middle + half(inner), far] }],
    };
    stretches.into_iter().map(|[from, to]| [from.max(0.0), to]).filter(|[from, to]| to > from).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::multi_scale;

    const SHELL: Shell = Shell { cells: 40_962.0, layers: 30, radius: [1.0, 1.15] };

    #[test]
    fn one_node_has_one_fragment_per_ray_and_all_work() {
        let scene = multi_scale::scene(64, |_| 0.5, "", "").unwrap();
        for partition in [Partition::Patches, Partition::Curve, Partition::Bands] {
            let work = work(&scene, SHELL, partition, 1, 64);
            assert!((work.balance() - 1.0).abs() < 1e-12);
            // The disc of the globe in the picture, 3.2 radii away in a view of 45 degrees.
            let radius = (1.15f64 / 3.2).asin().tan() / 22.5f64.to_radians().tan();
            assert!((work.fragments - PI / 4.0 * radius * radius).abs() < 0.01, "{}", work.fragments);
        }
    }

    #[test]
    fn nodes_of_every_partition_have_equal_areas() {
        for partition in [Partition::Patches, Partition::Curve, Partition::Bands] {
            let nodes = Nodes::new(partition, 24);
            let mut counts = [0; 24];
            lattice(100_000).for_each(|place| counts[nodes.of(place)] += 1);
            assert!(counts.iter().all(|count| (3_300..5_000).contains(count)), "{partition:?}: {counts:?}");
        }
    }
}
