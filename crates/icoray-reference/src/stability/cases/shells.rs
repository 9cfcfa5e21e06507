//! Meshes from coarse to fine, shells from thick to thin, and the Earth to scale.

use super::{Case, CaseMesh};
use glam::DVec3;
use icoray::{Layers, Result};

/// The whole globe on this mesh, the surroundings of pentagons, and layers that are given from the top.
pub fn meshes(mesh: &CaseMesh) -> Result<Vec<Case>> {
    let n = mesh.level;
    let make = |what: &str| {
        let mut case = mesh.case("mesh", format!("n = {n}, {what}"))?;
        if n > 5 {
            mesh.shell(&mut case, 3, 0.02)?;
            (case.scene.width, case.scene.height) = (5, 5);
        }
        Ok(case)
    };
    let size = if n > 5 { 3 } else { 9 };
    let mut cases = vec![make("whole globe")?];
    // The icosahedron's own twelve cells come first and stay pentagons.
    let pentagons: &[u32] = if n == 3 { &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11] } else { &[5] };
    for &cell in pentagons {
        let above = mesh.grid.direction(cell);
        let slanted = (-above + 0.4 * above.any_orthonormal_vector()).normalize();
        let wide = 60.0 / f64::from(1u32 << n);
        let case = make(&format!("around pentagon {cell}"))?;
        cases.push(case.look(1.05 * above - slanted, slanted, wide, size));
    }
    let first = mesh.grid.direction(0);
    let ray = make("limb, hollow")?.hollow();
    let side = first.any_orthonormal_vector();
    cases.push(ray.look(1.03 * first - 2.0 * side, side, 2.0, size));
    if n == 2 {
        let mut case = make("layers from the top")?;
        case.layers = Layers::new(case.layers.radius_m().iter().rev().copied().collect(), 1.0)?;
        cases.push(case);
    }
    Ok(cases)
}

/// Layers from a tenth of a radius to one metre on Earth; the globe, and the limb where the ridge between two facets
/// is grazed.
pub fn thickness(mesh: &CaseMesh) -> Result<Vec<Case>> {
    let mut cases = Vec::new();
    for (thickness, text) in [
        (1e-1, "1e-1"),
        (1e-2, "1e-2"),
        (1e-3, "1e-3"),
        (1e-4, "1e-4"),
        (1.6e-5, "1.6e-5 (100 m on Earth)"),
        (1.6e-6, "1.6e-6 (10 m)"),
        (1.6e-7, "1.6e-7 (1 m)"),
    ] {
        let mut globe = mesh.case("shell", format!("layers of {text}, globe"))?;
        mesh.shell(&mut globe, 6, thickness)?;
        let mut limb = globe.clone();
        limb.name = format!("layers of {text}, limb");
        cases.push(globe);
        cases.push(graze(mesh, limb, 5.0 * thickness));
        let mut hollow = cases[cases.len() - 1].clone().hollow();
        hollow.name = format!("layers of {text}, limb, hollow");
        cases.push(hollow);
    }
    for (name, heights) in [
        ("layers of 1 m to a tenth together, from below", [0.0, 1.6e-7, 1e-5, 1e-3, 0.1]),
        ("layers of 1 m to a tenth together, from above", [0.0, 0.099, 0.099_99, 0.1 - 1.6e-7, 0.1]),
    ] {
        let mut case = mesh.case("shell", name)?;
        mesh.shell(&mut case, heights.len(), 0.02)?;
        case.layers = Layers::new(heights.map(|h| 1.0 + h).to_vec(), 1.0)?;
        cases.push(case);
    }
    Ok(cases)
}

/// Looks across the ridge of two facets, `depth` of which fills a third of the picture.
fn graze(mesh: &CaseMesh, case: Case, depth: f64) -> Case {
    let [a, b, _] = mesh.corners(100);
    let (ridge, across) = (0.5 * (a + b), a.cross(b).normalize());
    let across = (across - 0.2 * (a - b)).normalize();
    let eye: DVec3 = ridge * (1.0 + 0.5 * depth) - 0.4 * across;
    case.look(eye, across, (3.0 * depth / 0.4).atan().to_degrees(), 13)
}

/// The Earth with layers of 100 m, nothing exaggerated, and the same with a shell of a tenth of the radius.
pub fn earth(mesh: &CaseMesh) -> Result<Vec<Case>> {
    let mut cases = Vec::new();
    for (thickness, text) in [(100.0 / 6.371e6, "100 m layers, to scale"), (0.1 / 40.0, "a 10% shell")] {
        let mut globe = mesh.case("Earth", format!("{text}: globe"))?;
        mesh.shell(&mut globe, 41, thickness)?;
        let mut limb = globe.clone();
        limb.name = format!("{text}: limb");
        cases.push(globe);
        cases.push(graze(mesh, limb, 40.0 * thickness));
    }
    Ok(cases)
}
