//! Frames and grids that do not fit into memory are refused, with the bytes that are missing.

use crate::common::{LIT, at_centers, icosahedral};
use icoray::{ErrorKind, Fields, Grid, IcosahedralMesh, Layers, Plan, Renderer, Scene};
use std::process::Command;

const LAYERS: usize = 4;

fn scene(rest: &str, distance: f64) -> Scene {
    Scene::parse(&format!(
        "field = \"f\"\n[image]\nwidth = 24\nheight = 20\n[camera]\nlon = 20\nlat = 35\ndistance = {distance}\n\
         [transfer]\nmap = \"viridis\"\nrange = [-1, 1]\nopacity = [[-1, 0.5], [1, 0.5]]\n{rest}\n"
    ))
    .unwrap()
}

/// A renderer with a limit of so many bytes below what the plan says, and what comes of two frames.
fn refused(rest: &str, missing: u64) -> [Option<String>; 2] {
    let (_, grid) = icosahedral(4);
    let layers = Layers::from_heights(&[0.0, 100e3, 200e3, 300e3], 6.371e6).unwrap();
    let values: Vec<f32> = (0..grid.cells() * LAYERS).map(|i| (i as f32 * 0.37).sin()).collect();
    let field = at_centers(&values, LAYERS);
    let scene = scene(rest, 3.2);
    let memory = Plan::new(&scene, &grid, &layers, &field).unwrap().memory(&scene, &grid);
    assert_eq!(memory.grid as usize, grid.derived_bytes());
    let taken = memory.total() - memory.grid;
    let renderer = Renderer::new(1).unwrap().with_memory_limit(taken - missing);
    [0, 1].map(|_| {
        let error = renderer.render(&scene, &grid, &layers, &field).err()?;
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
    let (_, grid) = icosahedral(4);
    let layers = Layers::from_heights(&[0.0, 100e3, 200e3, 300e3], 6.371e6).unwrap();
    let values = vec![0.5f32; grid.cells() * LAYERS];
    let field = at_centers(&values, LAYERS);
    let derive = "[[derive]]\nname = \"a\"\nanomaly = \"f\"\nfrom = \"first\"\n[[derive]]\nname = \"b\"\nsum = { a = 2 }\n\
                  [[derive]]\nname = \"c\"\nsum = { b = 2 }\n[[surfaces]]\nfield = \"b\"\n";
    let scene = scene(derive, 3.2);
    let memory = Plan::new(&scene, &grid, &layers, &field).unwrap().memory(&scene, &grid);
    // The first frame, the anomaly of it, and twice that; "c" is not shown.
    assert_eq!(memory.derived as usize, 3 * size_of_val(values.as_slice()));
    assert!(memory.to_string().contains("derived fields "), "{memory}");
    let fields = || Fields::new([("f", field)]);
    let renderer = Renderer::new(1).unwrap().with_memory_limit(memory.derived - 7);
    let error = renderer.render(&scene, &grid, &layers, fields()).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Memory, "{error}");
    assert!(error.context().starts_with("derived fields: ") && error.context().ends_with(" 7 are missing"), "{error}");
    let renderer = Renderer::new(1).unwrap().with_memory_limit(memory.total());
    for _ in 0..2 {
        renderer.render(&scene, &grid, &layers, fields()).unwrap();
    }
}

/// Gradients of a close-up are those of few cells.
#[test]
fn hidden_cells_do_not_count_as_memory() {
    let (_, grid) = icosahedral(5);
    let layers = Layers::from_heights(&[0.0, 1e3, 2e3, 3e3], 6.371e6).unwrap();
    let values = vec![0.5f32; grid.cells() * LAYERS];
    let field = at_centers(&values, LAYERS);
    let gradients = |distance: f64| {
        let scene = scene(LIT, distance);
        Plan::new(&scene, &grid, &layers, &field).unwrap().memory(&scene, &grid).gradients as f64
    };
    let all = (grid.cells() * (LAYERS * 8 + 1)) as f64;
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
