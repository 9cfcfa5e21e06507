//! The second and later frames of a grid allocate nothing that grows with the grid, and a rank keeps nothing of the
//! cells of its node's other ranks.

use culled::{Culled, Mark, Style};
use icoray::ranks::on_local_nodes;
use icoray::{
    Decomposition, DistributedGrid, Field, Fields, Grid, GridTables, Heights, IcosahedralMesh, Layers, Location,
    LonLat, Owned, PartCells, Ranks, Renderer, Scene, Volume,
};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::alloc::System;
use std::f64::consts::TAU;
use std::sync::{Barrier, Mutex};

#[path = "suite/culled/mod.rs"]
mod culled;

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

const LAYERS: usize = 12;

fn scene(rest: &str) -> Scene {
    let text = format!(
        "field = \"f\"\nexaggeration = 60\ncore = \"#303030\"\n[image]\nwidth = 48\nheight = 40\n\
         [camera]\nlon = 20\nlat = 40\ndistance = 4\n[transfer]\nmap = \"viridis\"\nrange = [-1, 1]\n\
         opacity = [[-1, 0.2], [0, 0], [0.5, 0], [1, 0.8]]\n{rest}\n"
    );
    Scene::parse(&text).unwrap_or_else(|e| panic!("{e}"))
}

/// Cells and layers of a sphere of `level` bisections, and the bytes that the third frame allocates. The field f lies
/// on the layers; with `others` beside it, midway between them: g and h at centres and at corners in their own
/// precision each, and heights.
fn bytes_of_a_later_frame(level: u32, scene: &Scene, location: Location, others: bool) -> (usize, usize) {
    let mesh = IcosahedralMesh::new(level).unwrap();
    let grid = Grid::new(mesh.tables()).unwrap();
    let heights: Vec<f64> = (0..LAYERS + usize::from(others)).map(|k| 1000.0 * k as f64).collect();
    let layers = Layers::from_heights(&heights, 6_371_000.0).unwrap();
    let wave = |count: usize| (0..count).map(|i| (i as f64 * 1e-3).sin());
    let (cells, corners) = (grid.cells(), grid.triangles());
    let columns = if location == Location::Center { cells } else { corners };
    let f: Vec<f32> = wave(columns * LAYERS).map(|value| value as f32).collect();
    let g: Vec<f64> = wave(cells * (LAYERS + 1)).collect();
    let h: Vec<f32> = wave(corners * (LAYERS + 1)).map(|value| value as f32).collect();
    let lifted: Vec<f64> = (0..cells).flat_map(|_| heights.clone()).collect();
    let renderer = Renderer::new(1).unwrap();
    // Fields of their own each, as a model that computes on has.
    let draw = || {
        let mut fields = Fields::new([("f", Field::level_fastest(&f, LAYERS, location).unwrap())]);
        if others {
            let g = Field::level_fastest(&g, LAYERS + 1, Location::Center).unwrap();
            let h = Field::level_fastest(&h, LAYERS + 1, Location::Corner).unwrap();
            let lifted = Field::level_fastest(&lifted, LAYERS + 1, Location::Center).unwrap();
            fields = fields.with(Fields::new([("g", g), ("h", h)])).with_heights(lifted);
        }
        renderer.render(scene, &grid, &layers, fields).unwrap();
    };
    draw();
    draw();
    let region = Region::new(ALLOCATOR);
    draw();
    (cells * LAYERS, region.change().bytes_allocated)
}

/// One test alone in its process, as the allocator counts for all threads.
#[test]
fn later_frames_allocate_nothing_that_grows_with_the_grid() {
    general_frames_make_no_array_anew();
    ranks_of_a_node_share_what_they_derive();
    let lit = "[light]\nkind = \"headlight\"";
    for (name, rest, location) in [
        ("unlit", "", Location::Center),
        ("lit", lit, Location::Center),
        ("corners", "", Location::Corner),
        ("corners, lit", lit, Location::Corner),
    ] {
        let [(_, small), (_, large)] = [3, 6].map(|level| bytes_of_a_later_frame(level, &scene(rest), location, false));
        println!("{name}: {small} bytes with 642 cells, {large} with 40,962");
        // Of 40,320 cells more, not a byte each.
        assert!(large < small + 20_000, "{name}: {small} and {large} bytes");
    }
}

/// Single rays allocate some memory in each frustum. Of those through a few pixels it is less than a
/// byte for each value of the grid, of which the smallest array has four.
fn general_frames_make_no_array_anew() {
    let more = "[[isosurfaces]]\nfield = \"h\"\nvalue = 0.3\ncolor = \"red\"\n[light]\nkind = \"headlight\"";
    for heights in ["mean", "native"] {
        let mut scene = scene(more);
        (scene.width, scene.height) = (2, 2);
        let (field, transfer) = ("g".into(), scene.volumes[0].transfer.clone());
        scene.volumes.extend([Volume { field, transfer, coloring: None, opacity: None }]);
        scene.scenery.heights = if heights == "mean" { Heights::Mean } else { Heights::Native };
        let (values, bytes) = bytes_of_a_later_frame(6, &scene, Location::Corner, true);
        println!("several fields, {heights} heights: {bytes} bytes of {values} values each");
        assert!(bytes < values, "{heights} heights: {bytes} bytes of {values} values each");
    }
}

/// Of a node's mesh, and of what lit frames of a derived field compute, there is one copy, whatever the number of
/// ranks: more of them keep no more for each cell.
fn ranks_of_a_node_share_what_they_derive() {
    let mesh = IcosahedralMesh::new(6).unwrap();
    for (nodes, heights) in [(1, Heights::Mean), (2, Heights::Mean), (1, Heights::Native), (2, Heights::Native)] {
        let [few, many] = [2, 8].map(|of_node| bytes_of_nodes(&mesh, nodes, of_node, heights));
        for (what, [few, many]) in [("parts", [few[0], many[0]]), ("a lit frame", [few[1], many[1]])] {
            let of_cell_and_rank = (many - few) as f64 / (mesh.cells() * 6) as f64;
            println!(
                "{nodes} nodes, {heights:?} heights, {what}: {few} bytes of 2 ranks, {many} of 8, {of_cell_and_rank:.2} \
                 per cell and rank"
            );
            // Halos along the borders of ranks.
            assert!(of_cell_and_rank < 5.0, "{nodes} nodes, {heights:?} heights, {what}: {of_cell_and_rank}");
        }
    }
}

/// Bytes that the ranks of nodes, `of_node` of each, keep of the parts on which they have agreed, and then after a lit
/// frame of two volumes.
fn bytes_of_nodes(mesh: &IcosahedralMesh, nodes: usize, of_node: usize, heights: Heights) -> [isize; 2] {
    let ranks = nodes * of_node;
    // Slices between meridians.
    let owner = |cell: usize| (mesh.lon_center_rad[cell].rem_euclid(TAU) / TAU * ranks as f64) as usize % ranks;
    let part = |rank: usize| {
        let mut is_here: Vec<bool> = (0..mesh.cells()).map(|cell| owner(cell) == rank).collect();
        for row in mesh.corner_cell.as_chunks::<3>().0.iter().map(|row| row.map(|cell| cell as usize)) {
            if row.into_iter().any(|cell| owner(cell) == rank) {
                row.into_iter().for_each(|cell| is_here[cell] = true);
            }
        }
        Culled::new(mesh, &is_here, Style::Triangles, Mark::MinusOne, 0)
    };
    let parts: Vec<Culled> = (0..ranks).map(part).collect();
    let node_of: Vec<usize> = (0..ranks).map(|rank| rank / of_node).collect();
    let (meeting, bytes) = (Barrier::new(ranks), Mutex::new(Vec::new()));
    let lit = "[light]\nkind = \"headlight\"\n[[derive]]\nname = \"d\"\nmagnitude = [\"f\", \"f\"]";
    let mut scene = scene(lit);
    scene.volumes[0].field = "d".into();
    scene.volumes.extend([Volume { field: "f".into(), ..scene.volumes[0].clone() }]);
    scene.scenery.heights = heights;
    let layers = Layers::from_heights(&Vec::from_iter((0..LAYERS).map(|k| 1000.0 * k as f64)), 6_371_000.0).unwrap();
    // Some of it is in the clear range of the transfer function.
    let values = |cell: &usize| (0..LAYERS).map(move |layer| ((cell + layer) as f32 * 1e-3).sin()).collect::<Vec<_>>();
    let fields: Vec<Vec<f32>> = parts.iter().map(|part| part.cells.iter().flat_map(values).collect()).collect();
    let lifted = |cell: usize| (0..LAYERS).map(move |layer| 1e3 * layer as f64 + (cell % 100) as f64);
    let lifted: Vec<Vec<f64>> =
        parts.iter().map(|part| part.cells.iter().copied().flat_map(lifted).collect()).collect();
    let count = |region: &Region<System>| {
        meeting.wait();
        let change = region.change();
        meeting.wait();
        change.bytes_allocated as isize - change.bytes_deallocated as isize
    };
    let region = Region::new(ALLOCATOR);
    on_local_nodes(&node_of, |team| {
        let mut ranks = Ranks::new(team);
        let rank = ranks.rank();
        let cells = &parts[rank].cells;
        let global: Vec<i32> = cells.iter().map(|cell| *cell as i32).collect();
        let owned: Vec<i32> = cells.iter().map(|cell| i32::from(owner(*cell) == rank)).collect();
        let grid = Grid::new(parts[rank].tables()).unwrap();
        let cells = PartCells { global: global.as_slice().into(), owned: Owned::Marked(&owned) };
        let decomposition = Decomposition::new(&mut ranks, &grid, &cells).unwrap();
        let grid = grid.tables_only();
        let of_parts = count(&region);
        let renderer = Renderer::new(1).unwrap();
        let data = DistributedGrid { grid: &grid, decomposition: Some(&decomposition), layers: &layers };
        let field = Field::level_fastest(&fields[rank], LAYERS, Location::Center).unwrap();
        let lifted = Field::level_fastest(&lifted[rank], LAYERS, Location::Center).unwrap();
        let fields = Fields::new([("f", field)]).with_heights(lifted);
        renderer.render_decomposed(&mut ranks, &scene, data, fields).unwrap();
        let of_frame = count(&region) - of_parts;
        if rank == 0 {
            *bytes.lock().unwrap() = vec![of_parts, of_frame];
        }
    });
    bytes.into_inner().unwrap().try_into().unwrap()
}
