//! Parts over ranks of one node and of several: the picture of one process, for any values in halos.

use super::*;
use crate::common::refusal;
use crate::culled::{Culled, Mark, Style, holes};
use crate::spread::{Spread, partitions, without_holes};
use icoray::{DistributedGrid, ErrorKind, Precision, Probe, ScenePart};
use icoray_test_support::is_long;
use std::f64::consts::TAU;

/// Every other one of `all`, from the first or the second on in turn; in the long run all.
fn some<T>(all: Vec<T>, turn: usize) -> impl Iterator<Item = T> {
    all.into_iter().skip(count(turn % 2, 0)).step_by(count(2, 1))
}

/// A rank's own arrays of some steps.
fn own_of(mesh: &IcosahedralMesh, spread: &Spread, location: Location, rank: usize) -> Vec<Arrays> {
    [0, 1].map(|step| arrays(mesh, step, [&spread.cells[rank], &spread.corners[rank]], location)).into()
}

/// The arrays over a grid with holes.
fn of_culled(mesh: &IcosahedralMesh, step: usize, culled: &Culled) -> Arrays {
    let [cells, corners] = [&culled.cells, &culled.corners].map(|rows| Rows::own(rows.clone()));
    arrays(mesh, step, [&cells, &corners], Location::Center)
}

/// Checks what parts on nodes make of the second of two frames: on one node the picture to the bit, on several so few
/// pixels beyond their errors, and so little, that it may be lines which reach over a node's border by a part of their
/// width.
fn assert_parts(
    mesh: &IcosahedralMesh,
    scene: &Scene,
    (expected, location): (&Frame, Location),
    owner: &[usize],
    node_of: &[usize],
    trying: &str,
) {
    let spread = Spread::new(mesh, node_of.len(), owner);
    let (frame, reports) = spread.draw(node_of, scene, &layers(), |rank| own_of(mesh, &spread, location, rank));
    let [found, whole] = [&frame, expected].map(|frame| (frame.report.missing_values, frame.report.value_range));
    assert_eq!(found, whole, "{trying}");
    let is_one = node_of.iter().all(|node| *node == 0);
    let scheme =
        if is_one { "tiles: each node has the whole grid" } else { "fragments: each node has its part of the grid" };
    let sharing = format!("{scheme}, its ranks' parts and the field are assembled once per node");
    assert_eq!(frame.report.ranks.sharing.unwrap().to_string(), sharing, "{trying}");
    assert!(reports.iter().map(|report| report.bytes_copied).sum::<u64>() > 0, "{trying}");
    if is_one {
        assert!(bits(&frame) == bits(expected), "{trying}");
        return;
    }
    let (wrong, most) = (count_beyond(&frame, expected, 1e-6), difference(&frame, expected));
    println!("{trying}: {wrong} beyond, {most:e} at most");
    assert!(wrong <= 4 && most < 0.05, "{trying}: {wrong}, {most:e}");
}

#[test]
fn parts_make_the_pictures_of_one_process() {
    let (mesh, grid) = icosahedral(3);
    let nodes: [&[usize]; 5] = [&[0, 1], &[0, 1, 0], &[0, 1, 2], &[0, 1, 1, 0], &[2, 0, 2, 1, 2]];
    for location in [Location::Center, Location::Corner] {
        let steps = steps(mesh, location);
        let draw = |scene: &Scene| draw(&Renderer::new(2).unwrap(), &grid, scene, &steps);
        for (i, (name, scene)) in scenes().into_iter().enumerate() {
            let expected = draw(&scene);
            let ranks = 2 + i % 3;
            for (partition, owner) in some(partitions(mesh, ranks), i) {
                let trying = format!("{name}, {location:?}, {partition} on {ranks}");
                assert_parts(mesh, &scene, (&expected, location), &owner, &vec![0; ranks], &trying);
            }
            // Lines that reach over a border would be smoothed on one side of it.
            let exact = Scene { antialias: false, ..scene };
            let packets = Scene { precision: Precision::F32, ..exact.clone() };
            let drawn = [&exact, &packets].map(|scene| (scene, draw(scene)));
            for (k, node_of) in nodes.into_iter().enumerate().filter(|(k, _)| is_long() || (i + k) % 2 == 0) {
                let (scene, expected) = &drawn[k / 2 % 2];
                let (partition, owner) = partitions(mesh, node_of.len()).swap_remove((i + k) % 4);
                let trying = format!("{name}, {location:?}, {partition} on {node_of:?}");
                assert_parts(mesh, scene, (expected, location), &owner, node_of, &trying);
            }
        }
    }
}

/// A rank whose positions of cells are not those of the other node.
#[test]
fn halos_that_lie_elsewhere_than_on_their_owners_are_refused() {
    let mesh = IcosahedralMesh::new(3).unwrap();
    for (_, owner) in partitions(&mesh, 2) {
        let mut spread = Spread::new(&mesh, 2, &owner);
        spread.parts[1].lon_lat[0].iter_mut().for_each(|lon| *lon = (*lon + 0.5) % TAU);
        let refusals = spread.on_nodes(&[0, 1], |_, _, _, decomposition| refusal(decomposition));
        assert!(refusals.iter().all(|refused| *refused == refusals[0]), "{refusals:?}");
        let (kind, message) = &refusals[0];
        assert!(*kind == ErrorKind::Grid && message.contains("degrees in the halo of rank"), "{message}");
        // The same position in another turn, and with another rounding.
        spread.parts[1].lon_lat[0].iter_mut().for_each(|lon| *lon = (*lon - 0.5 + 1e-7) % TAU);
        assert!(
            spread.on_nodes(&[0, 1], |_, _, _, decomposition| decomposition.is_ok()).into_iter().all(|is_fit| is_fit)
        );
    }
}

/// The mesh's own holes beside those that parts have; of corners beside a hole some are no triangles. In single and in
/// double precision.
#[test]
fn holes_of_the_whole_are_those_of_its_parts() {
    let mesh = IcosahedralMesh::new(3).unwrap();
    let scenes = scenes();
    for (i, (hole, stays)) in holes(&mesh).iter().enumerate() {
        let culled = Culled::new(&mesh, stays, Style::Corners, Mark::BeforeFirst, 1);
        let steps = [0, 1].map(|step| of_culled(&mesh, step, &culled));
        let draw = |scene: &Scene| (draw(&Renderer::new(2).unwrap(), &culled.grid(), scene, &steps), Location::Center);
        let (name, scene) = &scenes[i % scenes.len()];
        let check = |scene: &Scene, (expected, location): &(Frame, Location), owner: Vec<usize>, node_of: &[usize]| {
            let trying = format!("{hole}, {name} on {node_of:?}");
            assert_parts(&mesh, scene, (expected, *location), &without_holes(owner, stays), node_of, &trying);
        };
        let (expected, ranks) = (draw(scene), 2 + i % 2);
        for (_, owner) in some(partitions(&mesh, ranks), i) {
            check(scene, &expected, owner, &vec![0; ranks]);
        }
        let precision = [Precision::F64, Precision::F32][i / 2 % 2];
        let scene = &Scene { antialias: false, precision, ..scene.clone() };
        let (_, owner) = partitions(&mesh, ranks).swap_remove(i % 3);
        check(scene, &draw(scene), owner, &(0..ranks).collect::<Vec<_>>());
    }
}

/// Checks that the parts of a picture that both probes have seen are the same at the same places.
fn assert_same_probe(found: &Option<Probe>, expected: &Option<Probe>, trying: &str) {
    let (Some(found), Some(expected)) = (found, expected) else {
        assert!(found.is_none() && expected.is_none(), "{trying}: {found:?} for {expected:?}");
        return;
    };
    let is_near = |a: f64, b: f64, limit: f64| (a - b).abs() < limit || a.is_nan() && b.is_nan();
    for one in expected.contributions.iter().filter(|one| one.weight > 1e-3 && one.part != ScenePart::Lines) {
        let other = found.contributions.iter().find(|other| other.part == one.part);
        let other = other.unwrap_or_else(|| panic!("{trying}: no {one:?}"));
        assert!(is_near(other.weight, one.weight, 1e-3), "{trying}: {other:?} for {one:?}");
        if !matches!(one.part, ScenePart::Volume(_)) {
            let [value, expected] = [other, one].map(|one| one.value.unwrap_or(f64::NAN));
            assert!(
                is_near(value, expected, 1e-5) && is_near(other.height_m, one.height_m, 1.0),
                "{trying}: {other:?}"
            );
        }
    }
    assert!(is_near(found.alpha, expected.alpha, 1e-3), "{trying}");
    if found.part == expected.part {
        let places = found.lon_lat_deg.iter().zip(&expected.lon_lat_deg);
        assert!(places.clone().all(|(a, b)| is_near(*a, *b, 1.0)), "{trying}: {places:?}");
        assert_eq!((&found.field, found.column.len()), (&expected.field, expected.column.len()), "{trying}");
        let rows = found.column.iter().zip(&expected.column);
        let is_same = rows.clone().all(|(a, b)| is_near(a[0], b[0], 1.0) && is_near(a[1], b[1], 1e-5));
        assert!(is_same || found.lon_lat_deg != expected.lon_lat_deg, "{trying}: {rows:?}");
    }
}

/// What one process finds at some places of the second step, after checking that ranks find it too.
fn probed(
    grid: &Grid,
    whole: &Arrays,
    (spread, node_of): (&Spread, &[usize]),
    scene: &Scene,
    places: &[[f64; 2]],
    own: impl Fn(usize) -> Vec<Arrays> + Sync,
    trying: &str,
) -> Vec<Option<Probe>> {
    let renderer = Renderer::new(1).unwrap();
    let probe = |at: &[f64; 2]| renderer.probe(scene, grid, &layers(), fields(whole), *at).unwrap();
    let expected: Vec<Option<Probe>> = places.iter().map(probe).collect();
    let found = spread.on_nodes(node_of, |ranks, _, grid, decomposition| {
        let (own, renderer, layers) = (own(ranks.rank()), Renderer::new(1).unwrap(), layers());
        let data = DistributedGrid { grid, decomposition: Some(&decomposition.unwrap()), layers: &layers };
        let probe = |at: &[f64; 2]| renderer.probe_decomposed(ranks, scene, data, fields(&own[1]), *at).unwrap();
        places.iter().map(probe).collect::<Vec<_>>()
    });
    assert!(found[1..].iter().flatten().all(Option::is_none));
    for ((found, expected), at) in found[0].iter().zip(&expected).zip(places) {
        assert_same_probe(found, expected, &format!("{trying}, {at:?}"));
    }
    expected
}

#[test]
fn probes_over_nodes_are_those_of_one_process() {
    let (mesh, grid) = icosahedral(3);
    let places: Vec<[f64; 2]> = (0..20).map(|k| [0.05 + 0.05 * f64::from(k % 19), 0.1 + 0.04 * f64::from(k)]).collect();
    let nodes: [&[usize]; 3] = [&[0, 0], &[0, 1, 0], &[0, 1, 2, 1]];
    let (mut hits, mut columns) = (0, 0);
    for location in [Location::Center, Location::Corner] {
        let [_, whole] = steps(mesh, location);
        for (i, (name, scene)) in scenes().into_iter().enumerate().filter(|(_, (name, _))| !name.contains("derived")) {
            for (k, node_of) in nodes.into_iter().enumerate() {
                let (partition, owner) = partitions(mesh, node_of.len()).swap_remove((i + k) % 4);
                let spread = Spread::new(mesh, node_of.len(), &owner);
                let trying = format!("{name}, {location:?}, {partition} on {node_of:?}");
                let own = |rank: usize| own_of(mesh, &spread, location, rank);
                let found = probed(&grid, &whole, (&spread, node_of), &scene, &places, own, &trying);
                hits += found.iter().flatten().count();
                columns += found.iter().flatten().filter(|found| !found.column.is_empty()).count();
            }
        }
    }
    assert!(hits > 200 && columns > 9 * hits / 10, "{columns} of {hits}");
}

#[test]
fn probes_find_the_core_below_holes_over_nodes() {
    let mesh = IcosahedralMesh::new(3).unwrap();
    let (_, scene) = scenes().swap_remove(0);
    let places: Vec<[f64; 2]> =
        (0..100).map(|k| [0.05 + 0.1 * f64::from(k % 10), 0.05 + 0.1 * f64::from(k / 10)]).collect();
    let mut below = 0;
    for (i, (hole, stays)) in holes(&mesh).iter().enumerate() {
        let culled = Culled::new(&mesh, stays, Style::Corners, Mark::BeforeFirst, 1);
        let whole = of_culled(&mesh, 1, &culled);
        let (partition, owner) = partitions(&mesh, 3).swap_remove(i % 4);
        let spread = Spread::new(&mesh, 3, &without_holes(owner, stays));
        let (trying, parts) = (format!("{hole}, {partition}"), (&spread, &[0, 1, 1][..]));
        let own = |rank: usize| own_of(&mesh, &spread, Location::Center, rank);
        let found = probed(&culled.grid(), &whole, parts, &scene, &places, own, &trying);
        below += found.iter().flatten().filter(|probe| probe.along.is_empty()).count();
    }
    assert!(below > 50, "{below}");
}

/// Rays that cross several nodes end where each of these says, and those of the whole grid where all of it says.
#[test]
fn pictures_of_several_nodes_differ_by_less_than_the_tolerance() {
    let (mesh, grid) = icosahedral(4);
    let steps = steps(mesh, Location::Center);
    for tolerance in [1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
        let mut scene = scene(NEAR, &format!("tolerance = {tolerance}"), "");
        scene.volumes.truncate(1);
        scene.scenery = icoray::Scenery::default();
        for knot in &mut scene.volumes[0].transfer.knots {
            knot.extinction *= 10.0;
        }
        let expected = draw(&Renderer::new(2).unwrap(), &grid, &scene, &steps);
        for (partition, owner) in partitions(mesh, 4) {
            let spread = Spread::new(mesh, 4, &owner);
            let own = |rank: usize| own_of(mesh, &spread, Location::Center, rank);
            let (frame, _) = spread.draw(&[0, 1, 2, 3], &scene, &layers(), own);
            let most = difference(&frame, &expected);
            println!("tolerance {tolerance:e}, {partition}: {most:.1e}");
            assert!(f64::from(most) <= tolerance + 1e-6, "tolerance {tolerance:e}, {partition}: {most:e}");
        }
    }
}
