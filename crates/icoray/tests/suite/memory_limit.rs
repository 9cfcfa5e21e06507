//! Frames and grids that do not fit into memory are refused, with the bytes that are missing.

use crate::common::{LIT, Model, at_centers, even_heights, scene};
use icoray::{ErrorKind, FrameMemory, Grid, IcosahedralMesh, Plan, Renderer, Scene};
use std::process::Command;

const LAYERS: usize = 4;
const FADING: &str = "map = \"viridis\"\nrange = [-1, 1]\nopacity = [[-1, 0.5], [1, 0.5]]";

fn shown(tables: &str, distance: f64) -> Scene {
    let camera = format!("lon = 20\nlat = 35\ndistance = {distance}");
    scene(&camera, FADING, &format!("image = {{ width = 24, height = 20 }}|{tables}"))
}

fn waves(level: u32) -> Model {
    Model::new(level, &even_heights(LAYERS, 0.05), |cell, _, layer| [((cell * LAYERS + layer) as f64 * 0.37).sin()])
}

fn memory(data: &Model, scene: &Scene) -> FrameMemory {
    Plan::new(scene, &data.grid, &data.layers, &at_centers(&data.values[0], LAYERS)).unwrap().memory(scene, &data.grid)
}

/// A renderer with a limit of so many bytes below what the plan says, and what comes of two frames.
fn refused(rest: &str, missing: u64) -> [Option<String>; 2] {
    let (data, scene) = (waves(4), shown(rest, 3.2));
    let memory = memory(&data, &scene);
    assert_eq!(memory.grid as usize, data.grid.derived_bytes());
    let renderer = Renderer::new(1).unwrap().with_memory_limit(memory.total() - memory.grid - missing);
    [0, 1].map(|_| {
        let error = renderer.render(&scene, &data.grid, &data.layers, data.fields()).err()?;
        assert_eq!(error.kind(), ErrorKind::Memory, "{error}");
        Some(error.context().to_owned())
    })
}

#[test]
fn a_frame_that_does_not_fit_is_refused_with_the_missing_bytes() {
    for rest in ["", LIT, "[[surfaces]]\nlayer = \"top\"\ncolor = \"red\"\nopacity = 0.5"] {
        assert_eq!(refused(rest, 0), [None, None], "{rest}");
        for error in refused(rest, 7) {
            let error = error.expect("it does not fit");
            assert!(error.starts_with("a frame (") && error.ends_with(" 7 are missing"), "{error}");
        }
    }
    let [lit, _] = refused(LIT, 1000);
    assert!(lit.as_ref().is_some_and(|error| error.contains("gradients ")), "{lit:?}");
}

#[test]
fn derived_fields_that_do_not_fit_are_refused_before_they_are_made() {
    let data = waves(4);
    let derive = "[[derive]]\nname = \"a\"\nanomaly = \"f\"\nfrom = \"first\"\n[[derive]]\nname = \"b\"\nsum = { a = 2 }\n\
                  [[derive]]\nname = \"c\"\nsum = { b = 2 }\n[[surfaces]]\nfield = \"b\"\n";
    let scene = shown(derive, 3.2);
    let memory = memory(&data, &scene);
    // The first frame, the anomaly of it, and twice that; "c" is not shown.
    assert_eq!(memory.derived as usize, 3 * size_of_val(data.values[0].as_slice()));
    assert!(memory.to_string().contains("derived fields "), "{memory}");
    let draw = |renderer: &Renderer| renderer.render(&scene, &data.grid, &data.layers, data.fields());
    let error = draw(&Renderer::new(1).unwrap().with_memory_limit(memory.derived - 7)).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Memory, "{error}");
    assert!(error.context().starts_with("derived fields: ") && error.context().ends_with(" 7 are missing"), "{error}");
    let renderer = Renderer::new(1).unwrap().with_memory_limit(memory.total());
    for _ in 0..2 {
        draw(&renderer).unwrap();
    }
}

/// Gradients of a close-up are those of few cells.
#[test]
fn hidden_cells_do_not_count_as_memory() {
    let data = Model::new(5, &even_heights(LAYERS, 5e-4), |_, _, _| [0.5]);
    let gradients = |distance: f64| memory(&data, &shown(LIT, distance)).gradients as f64;
    let all = (data.grid.cells() * (LAYERS * 8 + 1)) as f64;
    // The limb is 72 degrees from the point below the camera; and somewhat beyond is seen.
    assert!((0.3..0.5).contains(&(gradients(3.2) / all)), "{} of {all}", gradients(3.2));
    assert!(gradients(1.1) < 0.15 * all, "{} of {all}", gradients(1.1));
}

/// Runs itself again with a limited address space.
#[cfg(target_os = "linux")]
#[test]
fn a_grid_that_does_not_fit_is_refused_and_the_process_lives() {
    const CHILD: &str = "ICORAY_TEST_LIMITED";
    if std::env::var_os(CHILD).is_some() {
        return in_little_memory();
    }
    let name = "memory_limit::a_grid_that_does_not_fit_is_refused_and_the_process_lives";
    let program = std::env::current_exe().unwrap();
    let mut child = Command::new("sh");
    child.args(["-c", "ulimit -v 2000000; exec \"$0\" --exact \"$1\" --nocapture"]).arg(program).arg(name);
    let output = child.env(CHILD, "1").output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && text.contains("1 passed"), "{text}{}", String::from_utf8_lossy(&output.stderr));
}

fn in_little_memory() {
    let error = IcosahedralMesh::new(11).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Memory);
    assert!(error.context().starts_with("a generated mesh: 7046431056 bytes (6.56 GiB) are needed, "), "{error}");
    let mesh = IcosahedralMesh::new(9).unwrap();
    let left = icoray::memory::available().expect("Linux reports it");
    let taken = vec![0u8; left as usize - (100 << 20)];
    let error = Grid::new(mesh.tables()).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Memory);
    assert!(
        error.context().contains("tables derived from the grid") && error.context().contains(" are missing"),
        "{error}"
    );
    drop(taken);
    assert_eq!(Grid::new(mesh.tables()).unwrap().cells(), 2_621_442);
}
