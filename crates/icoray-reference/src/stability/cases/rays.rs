//! Cameras near and far, and rays that meet the mesh in its special places.

use super::{Case, CaseMesh};
use glam::DVec3;
use icoray::Result;

const TOP: f64 = 1.1;
/// One metre in Earth radii.
const METRE: f64 = 1.0 / 6.371e6;

/// From one metre above the top to 1e4 radii away, inside the shell, on its layers and in a hollow core.
pub fn cameras(mesh: &CaseMesh) -> Result<Vec<Case>> {
    let [a, b, c] = mesh.corners(333);
    let (facet, ridge) = ((a + b + c) / 3.0, (a + b) / 2.0);
    let level = (a - b).normalize();
    let make = |name: String, eye: DVec3, dir: DVec3, fov: f64| Ok(mesh.case("camera", name)?.look(eye, dir, fov, 13));
    let mut cases = Vec::new();
    for (place, over) in [("facet", facet), ("ridge", ridge), ("vertex", a)] {
        let eye = over * (TOP + METRE);
        cases.push(make(format!("1 m above a {place}, down"), eye, -over, 70.0)?);
        cases.push(make(format!("1 m above a {place}, level"), eye, level - 0.02 * over, 70.0)?);
    }
    for distance in [1.2, 10.0, 100.0, 1e3, 1e4] {
        let fov = 2.0 * (1.2f64 / distance).min(1.0).atan().to_degrees();
        let from = DVec3::new(0.3, -0.8, 0.52).normalize();
        cases.push(make(format!("{distance:e} radii away"), from * distance, -from, fov)?);
    }
    for thickness in [1.6e-5, 1.6e-7] {
        let from = DVec3::new(0.3, -0.8, 0.52).normalize();
        let mut case = mesh.case("camera", format!("1e4 radii away, layers of {thickness:e}"))?;
        mesh.shell(&mut case, 6, thickness)?;
        cases.push(case.look(from * 1e4, -from, 2.0 * 1.2e-4f64.atan().to_degrees(), 13));
    }
    let inward = (DVec3::new(0.1, 0.2, 0.3) - facet).normalize();
    cases.push(make("in the shell".into(), facet * 1.05, inward + level, 100.0)?);
    cases.push(make("on a layer's facet".into(), facet * 1.04, inward + 2.0 * level, 100.0)?);
    cases.push(make("on a layer's ridge".into(), ridge * 1.04, level, 100.0)?);
    cases.push(make("on a vertex".into(), a * 1.04, inward + level, 100.0)?);
    cases.push(make("in a hollow core".into(), facet * 0.3, inward, 120.0)?.hollow());
    cases.push(make("at the centre".into(), DVec3::ZERO, facet, 120.0)?.hollow());
    cases.push(make("a hair off the centre".into(), facet * 1e-13, level, 120.0)?.hollow());
    Ok(cases)
}

/// Rays at vertices, edges, facets and the axis: exactly, and within 1e-12 and 1e-5 of it.
pub fn rays(mesh: &CaseMesh) -> Result<Vec<Case>> {
    let mut cases = Vec::new();
    for (name, eye, target) in special(mesh) {
        for (fov, width) in [(1e-10, "1e-12"), (1e-3, "1e-5")] {
            for hollow in [false, true] {
                let inside = if hollow { ", hollow" } else { "" };
                let case = mesh.case("ray", format!("{name}{inside}, within {width}"))?;
                let case = case.look(eye, target - eye, fov, 5);
                cases.push(if hollow { case.hollow() } else { case });
            }
        }
    }
    Ok(cases)
}

/// Eye and target of rays that hit something exactly.
fn special(mesh: &CaseMesh) -> Vec<(&'static str, DVec3, DVec3)> {
    let [a, b, c] = mesh.corners(100);
    let (facet, ridge) = ((a + b + c) / 3.0, (a + b) / 2.0);
    let (along, across) = ((a - b).normalize(), a.cross(b).normalize());
    let aside = DVec3::new(0.7, -1.1, 0.4);
    let middle = 1.04;
    vec![
        ("along the axis", DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO),
        ("parallel to the axis", DVec3::new(1.05, 0.0, 3.0), DVec3::new(1.05, 0.0, 0.0)),
        ("in the equator's plane", DVec3::new(2.5, 1.5, 0.0), DVec3::ZERO),
        ("radial at a vertex", a * 3.0, DVec3::ZERO),
        ("at a vertex", a * 2.0 + aside, a * middle),
        ("at an edge", ridge * 2.0 + aside, ridge * middle),
        ("in an edge's plane", a * 3.0 - b * 1.2, b * middle),
        ("in an edge's plane, grazing", ridge * middle + along * 2.0, ridge * middle),
        ("grazing a vertex", a * middle + aside.reject_from(a), a * middle),
        ("grazing a vertex of the top", a * TOP + aside.reject_from(a), a * TOP),
        ("grazing a ridge", ridge * middle + across, ridge * middle),
        ("grazing a ridge of the top", ridge * TOP + across, ridge * TOP),
        ("grazing the core's ridge", ridge + across, ridge),
        ("in a facet's plane", facet * middle + along + 0.3 * (c - b), facet * middle),
        ("in a facet's plane on top", facet * TOP + along + 0.3 * (c - b), facet * TOP),
        ("in a facet's plane of the core", facet + along + 0.3 * (c - b), facet),
    ]
}
