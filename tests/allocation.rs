//! A counting allocator proves that the model's memory is not copied: allocations of a picture do not grow with the
//! field, in any layout. `tests/c/host_memory.c` checks the bytes of light and of averages in the same way.
//!
//! This program has one test, as allocations of others would be counted too.

use icoray::{Field, Frame, Grid, GridTables, IcosahedralMesh, Layers, Location, Reals, Renderer, Scene};
use icoray_tests::layouts::{LAYOUTS, Layout};
use icoray_tests::{covered, scene};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::alloc::System;

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// What a picture may ask for per layer: the layers' radii, their inverses and those of the gaps.
const PER_LAYER: usize = 64;
/// What may differ besides: longer numbers in the report's words, and the corners of one cell.
const SLACK: usize = 1024;

/// A field of `level` bisections and some layers, as a model holds it.
struct Model {
    mesh: IcosahedralMesh,
    layers: Layers,
    layout: Layout,
    values: Vec<f32>,
}

impl Model {
    fn new(level: u32, layers: usize, layout: Layout) -> Self {
        let mesh = IcosahedralMesh::new(level).unwrap();
        let values = layout.store(mesh.cells(), layers, [f32::NAN, 1e30], |c, l| ((c + 3 * l) % 17) as f32 / 17.0);
        let radii = (0..layers).map(|l| 1.0 + 0.2 * l as f64 / layers as f64).collect();
        Model { mesh, layers: Layers::new(radii, 1.0).unwrap(), layout, values }
    }

    fn bytes(&self) -> usize {
        size_of_val(self.values.as_slice())
    }

    /// The least that drawing asks for: now and then the thread pool takes a block for its queue.
    fn ask(&self, scene: &Scene, draw: impl Fn(&Scene, &Grid, &Layers, &Field) -> Frame) -> (usize, Frame) {
        let grid = Grid::new(self.mesh.tables()).unwrap();
        let shape = (self.layout.shape)(self.mesh.cells(), self.layers.count());
        let field = Field::new(self.values.as_slice().into(), shape, Location::Center, None).unwrap();
        let asked = || {
            let region = Region::new(ALLOCATOR);
            let frame = draw(scene, &grid, &self.layers, &field);
            (region.change().bytes_allocated, frame)
        };
        (0..3).map(|_| asked()).min_by_key(|(bytes, _)| *bytes).expect("three pictures")
    }
}

/// Whether drawing asks for no more than [`PER_LAYER`] bytes per layer and [`SLACK`], whatever the field: with 4 times
/// the layers, and with 4 times the cells.
fn grows(layout: &Layout, scene: &Scene, draw: impl Fn(&Scene, &Grid, &Layers, &Field) -> Frame) -> Result<(), String> {
    const LAYERS: usize = 8;
    let [small, tall, wide] = [(3, LAYERS), (3, 4 * LAYERS), (4, LAYERS)].map(|(n, l)| Model::new(n, l, *layout));
    let asked = |model: &Model| {
        let (bytes, frame) = model.ask(scene, &draw);
        assert!(covered(&frame) > 0.2 && frame.report.bytes_derived == 0, "{}", layout.name);
        bytes
    };
    let small_asked = asked(&small);
    for (model, allowed) in [(&tall, 3 * LAYERS * PER_LAYER + SLACK), (&wide, SLACK)] {
        let asked = asked(model);
        // Nothing is proved by an allowance in which a copy could hide.
        assert!(2 * allowed < model.bytes() - small.bytes());
        if asked.abs_diff(small_asked) > allowed {
            return Err(format!(
                "{}: {small_asked} bytes for a field of {}, {asked} for one of {}, expected a difference of at most {allowed}",
                layout.name,
                small.bytes(),
                model.bytes()
            ));
        }
    }
    Ok(())
}

#[test]
fn pictures_copy_nothing() {
    let camera = "lon = 20\nlat = 35\ndistance = 3.5\nfov = 40";
    let transfer = "unit_length = 0.1\nknots = [ { value = 0, color = \"blue\", opacity = 0.1 }, { value = 1, color = \"red\", opacity = 0.9 } ]";
    let scene = Scene { tolerance: 1e-2, ..scene(32, camera, transfer, "") };
    // One that has drawn before has memory of its last frame.
    let render = |scene: &Scene, grid: &Grid, layers: &Layers, field: &Field| {
        Renderer::new(1).unwrap().render(scene, grid, layers, field).unwrap()
    };
    for layout in LAYOUTS {
        grows(layout, &scene, render).unwrap();
    }
    // It can fail: a renderer that copies the field is found out.
    let careless = |scene: &Scene, grid: &Grid, layers: &Layers, field: &Field| {
        let Reals::F32(values) = field.samples() else { unreachable!("the model's values are f32") };
        let copy = values.to_vec();
        let field = Field::new(copy.as_slice().into(), *field.shape(), field.location(), None).unwrap();
        render(scene, grid, layers, &field)
    };
    for layout in LAYOUTS {
        assert!(grows(layout, &scene, careless).is_err(), "a copy of '{}' went unnoticed", layout.name);
    }
    tables_are_not_copied(&Renderer::new(1).unwrap());
}

/// A checked grid asks for 26 bytes per cell and what the check needs for a while, whatever the width of the tables:
/// less than a copy of them, which in 32 bits would be 96 bytes per cell, would add.
fn tables_are_not_copied(renderer: &Renderer) {
    let asked = |level: u32| {
        let mesh = IcosahedralMesh::new(level).unwrap();
        let wide = [&mesh.cell_corner, &mesh.corner_cell, &mesh.corner_edge, &mesh.edge_corner]
            .map(|table| table.iter().map(|&number| i64::from(number)).collect::<Vec<_>>());
        let [cell_corner, corner_cell, corner_edge, edge_corner] = wide.each_ref().map(|table| table.as_slice().into());
        let wide = GridTables { cell_corner, corner_cell, corner_edge, edge_corner, ..mesh.tables() };
        let bytes = |tables| {
            let check = || {
                let region = Region::new(ALLOCATOR);
                renderer.run(|| Grid::new(tables).unwrap());
                region.change().bytes_allocated
            };
            (0..3).map(|_| check()).min().unwrap()
        };
        let [narrow, wide] = [mesh.tables(), wide].map(bytes);
        assert_eq!(narrow, wide);
        (narrow, mesh.cells())
    };
    let ((small, few), (large, many)) = (asked(4), asked(5));
    let per_cell = (large - small) as f64 / (many - few) as f64;
    println!("a grid's check asks for {per_cell:.1} bytes per cell");
    // 246 in November 2026, most of it given back during the check.
    const MOST_PER_CELL: f64 = 300.0;
    assert!((26.0..MOST_PER_CELL).contains(&per_cell), "{per_cell} bytes per cell");
}
