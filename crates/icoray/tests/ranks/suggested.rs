//! Suggested scenes of fields that are spread over ranks equal those of the whole field, byte for byte.

use crate::common::{even_heights, icosahedral, level_fastest, over_columns};
use crate::culled::{Culled, Mark, Style, towards};
use crate::spread::{NO_OWNER, Spread};
use icoray::{DistributedGrid, Error, Field, IcosahedralMesh, Layers, Location, Renderer, suggest};
use icoray_test_support::Random;

/// Nodes of the ranks of each run.
const NODES: [&[usize]; 5] = [&[0], &[0, 0], &[0, 1], &[0, 0, 1, 1], &[0, 1, 0, 2]];

/// The value of a cell or corner and a layer.
type Value = fn(usize, usize) -> f64;

const SIGNED: Value = |i, layer| (0.37 * i as f64).sin() + 0.1 * layer as f64;
const DECADES: Value = |i, layer| 10f64.powf(6.0 * Random::at(i).unit() - layer as f64);
const STRATIFIED: Value = |i, layer| 300.0 + 40.0 * layer as f64 + 9.0 * (0.01 * i as f64).sin();
const LAYERED: Value = |i, layer| 300.0 + 40.0 * layer as f64 + if i == 77 { 0.5 } else { 0.0 };
const MISSING: Value = |i, layer| if i % 3 == 0 { f64::NAN } else { SIGNED(i, layer) };
const NOTHING: Value = |_, _| f64::NAN;

/// The text for rows of a grid, whose cells or corners have these numbers in the whole one.
fn suggested(
    (numbers, value): (&[usize], Value),
    (location, layers): (Location, usize),
    text: impl FnOnce(&Layers, &Field) -> Result<Option<String>, Error>,
) -> Result<Option<String>, Error> {
    let values = over_columns(numbers.len(), layers, |column, layer| value(numbers[column], layer));
    let heights = even_heights(layers, 2e3 * (layers - 1) as f64);
    text(&Layers::from_heights(&heights, 6.371e6)?, &level_fastest(&values, layers, location))
}

/// Checks the texts of all ranks against that of one process.
fn check(
    (mesh, stays): (&IcosahedralMesh, &[bool]),
    nodes: &[usize],
    value: Value,
    of: (Location, usize),
    options: &suggest::Options,
) {
    let rows = |part: &Culled| if of.0 == Location::Center { part.cells.clone() } else { part.corners.clone() };
    let whole = Culled::new(mesh, stays, Style::Corners, Mark::BeforeFirst, 1);
    let expected = suggested((&rows(&whole), value), of, |layers, field| {
        match suggest::scene("q", &whole.grid(), layers, field, options) {
            Err(error) if error.context().contains("all values are missing") => Ok(None),
            text => text.map(Some),
        }
    });
    let expected = expected.unwrap();
    let owner = |(cell, stays): (usize, &bool)| if *stays { Random::at(cell).below(nodes.len()) } else { NO_OWNER };
    let owner: Vec<usize> = stays.iter().enumerate().map(owner).collect();
    let spread = Spread::with_corners(mesh, nodes.len(), &owner);
    let texts = spread.on_nodes(nodes, |ranks, part, grid, decomposition| {
        let (decomposition, renderer) = (decomposition.unwrap(), Renderer::new(1).unwrap());
        suggested((&rows(part), value), of, |layers, field| {
            let data = DistributedGrid { grid, decomposition: Some(&decomposition), layers };
            renderer.suggest_decomposed(ranks, data, ("q", field), options).map(|found| found.map(|s| s.text))
        })
    });
    for text in texts {
        assert_eq!(text.unwrap(), expected, "{nodes:?}, {of:?}");
    }
}

#[test]
fn the_text_is_that_of_the_whole_field_on_any_number_of_ranks() {
    let (mesh, grid) = icosahedral(3);
    let is_near = |cell: usize| grid.direction(cell as u32).dot(towards(10.0, 50.0)) > 0.9;
    let region: Vec<bool> = (0..mesh.cells()).map(is_near).collect();
    let everywhere = vec![true; mesh.cells()];
    let (volume, surface) = (suggest::Options::default(), suggest::Options::default().for_2d());
    for nodes in NODES {
        for value in [SIGNED, DECADES, STRATIFIED, LAYERED, MISSING, NOTHING] {
            check((mesh, &everywhere), nodes, value, (Location::Center, 3), &volume);
        }
        check((mesh, &everywhere), nodes, SIGNED, (Location::Corner, 3), &volume);
        check((mesh, &region), nodes, SIGNED, (Location::Center, 3), &volume);
        // The ground is seen beside the region alone.
        for stays in [&everywhere, &region] {
            check((mesh, stays), nodes, SIGNED, (Location::Center, 3), &surface);
        }
    }
}

#[test]
fn of_large_fields_the_same_columns_are_looked_at() {
    // So many values that each second column is.
    let mesh = IcosahedralMesh::new(5).unwrap();
    let everywhere = vec![true; mesh.cells()];
    check((&mesh, &everywhere), &[0, 1], DECADES, (Location::Center, 120), &suggest::Options::default());
}
