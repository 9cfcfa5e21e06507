//! A counting allocator proves that the model's memory is not copied: allocations of a picture do not grow with the
//! field, in any layout, and derived data grow by exactly the reported bytes.
//!
//! This program has one test, as allocations of others would be counted too.

use icoray::{Field, Frame, Grid, IcosahedralMesh, Layers, Location, Reals, Renderer, Scene};
use icoray_tests::layouts::{LAYOUTS, Layout, Numbered};
use icoray_tests::{covered, scene};
use std::alloc::{GlobalAlloc, Layout as Memory, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Bytes that were ever asked for; what is freed is not taken off.
static ASKED: AtomicUsize = AtomicUsize::new(0);

struct Counting;

// SAFETY: every call is passed on to the system's allocator unchanged; counting allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, memory: Memory) -> *mut u8 {
        ASKED.fetch_add(memory.size(), Relaxed);
        // SAFETY: the caller keeps the contract of `alloc`, which is System's.
        unsafe { System.alloc(memory) }
    }

    unsafe fn alloc_zeroed(&self, memory: Memory) -> *mut u8 {
        ASKED.fetch_add(memory.size(), Relaxed);
        // SAFETY: as for `alloc`.
        unsafe { System.alloc_zeroed(memory) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, memory: Memory) {
        // SAFETY: `pointer` came from System through this allocator.
        unsafe { System.dealloc(pointer, memory) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, memory: Memory, size: usize) -> *mut u8 {
        ASKED.fetch_add(size, Relaxed);
        // SAFETY: as for `dealloc`.
        unsafe { System.realloc(pointer, memory, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// What a picture may ask for per layer: the layers' radii, their inverses and those of the gaps.
const PER_LAYER: usize = 64;
/// The same with gradients: columns of values over a cell and its neighbours too, for each of a few parts of the work.
const PER_LAYER_LIT: usize = 1024;
/// What may differ besides: longer numbers in the report's words, and the corners of one cell.
const SLACK: usize = 1024;

/// A field of `level` bisections and some layers, as a model holds it.
struct Model {
    mesh: IcosahedralMesh,
    layers: Layers,
    layout: Layout,
    location: Location,
    columns: usize,
    values: Vec<f32>,
}

impl Model {
    fn new(level: u32, layers: usize, layout: Layout, location: Location) -> Self {
        let mesh = IcosahedralMesh::new(level).unwrap();
        let columns = if location == Location::Center { mesh.cells() } else { mesh.lon_corner_rad.len() };
        let values = layout.store(columns, layers, [f32::NAN, 1e30], |c, l| ((c + 3 * l) % 17) as f32 / 17.0);
        let radii = (0..layers).map(|l| 1.0 + 0.2 * l as f64 / layers as f64).collect();
        Model { mesh, layers: Layers::new(radii, 1.0).unwrap(), layout, location, columns, values }
    }

    fn bytes(&self) -> usize {
        size_of_val(self.values.as_slice())
    }

    /// The least that drawing asks for: now and then the thread pool takes a block for its queue.
    fn ask(&self, scene: &Scene, draw: impl Fn(&Scene, &Grid, &Layers, &Field) -> Frame) -> (usize, Frame) {
        let grid = Grid::new(self.mesh.tables()).unwrap();
        let shape = (self.layout.shape)(self.columns, self.layers.count());
        let field = Field::new(self.values.as_slice().into(), shape, self.location, None).unwrap();
        let asked = || {
            let before = ASKED.load(Relaxed);
            let frame = draw(scene, &grid, &self.layers, &field);
            (ASKED.load(Relaxed) - before, frame)
        };
        (0..3).map(|_| asked()).min_by_key(|(bytes, _)| *bytes).expect("three pictures")
    }
}

/// Whether drawing asks for no more than `per_layer` bytes per layer, [`SLACK`] and what its report says, whatever the
/// field: with 4 times the layers, and with 4 times the cells.
fn grows(
    layout: &Layout,
    location: Location,
    scene: &Scene,
    per_layer: usize,
    draw: impl Fn(&Scene, &Grid, &Layers, &Field) -> Frame,
) -> Result<(), String> {
    const LAYERS: usize = 8;
    let [small, tall, wide] =
        [(3, LAYERS), (3, 4 * LAYERS), (4, LAYERS)].map(|(n, l)| Model::new(n, l, *layout, location));
    let beside = |model: &Model| {
        let (bytes, frame) = model.ask(scene, &draw);
        assert!(covered(&frame) > 0.2, "{}", layout.name);
        bytes.checked_sub(frame.report.bytes_derived).ok_or("less than the report says".to_string())
    };
    let (small_asked, tall_asked, wide_asked) = (beside(&small)?, beside(&tall)?, beside(&wide)?);
    for (model, asked, allowed) in [(&tall, tall_asked, 3 * LAYERS * per_layer + SLACK), (&wide, wide_asked, SLACK)] {
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
    let scene = |light: &str| {
        let fine = scene(32, camera, &format!("{transfer}\n{light}"), "");
        Scene { tolerance: 1e-2, ..fine }
    };
    let (unlit, lit) = (scene(""), scene("[light]\nkind = \"headlight\""));
    // One that has drawn before has memory of its last frame.
    let render = |scene: &Scene, grid: &Grid, layers: &Layers, field: &Field| {
        Renderer::new(1).unwrap().render(scene, grid, layers, field).unwrap()
    };
    for layout in LAYOUTS {
        grows(layout, Location::Center, &unlit, PER_LAYER, render).unwrap();
        grows(layout, Location::Corner, &unlit, PER_LAYER, render).unwrap();
        grows(layout, Location::Center, &lit, PER_LAYER_LIT, render).unwrap();
    }
    derived_bytes_are_those_of_averages_and_gradients(&unlit, &lit, render);
    // It can fail: a renderer that copies the field is found out.
    let careless = |scene: &Scene, grid: &Grid, layers: &Layers, field: &Field| {
        let Reals::F32(values) = field.samples() else { unreachable!("the model's values are f32") };
        let copy = values.to_vec();
        let field = Field::new(copy.as_slice().into(), *field.shape(), field.location(), None).unwrap();
        render(scene, grid, layers, &field)
    };
    for layout in LAYOUTS {
        let found = grows(layout, Location::Center, &unlit, PER_LAYER, careless);
        assert!(found.is_err(), "a copy of '{}' went unnoticed", layout.name);
    }
    tables_are_not_copied(&Renderer::new(1).unwrap());
}

fn derived_bytes_are_those_of_averages_and_gradients(
    unlit: &Scene,
    lit: &Scene,
    render: impl Fn(&Scene, &Grid, &Layers, &Field) -> Frame + Copy,
) {
    let derived = |location, scene| Model::new(3, 8, LAYOUTS[0], location).ask(scene, render).1.report.bytes_derived;
    let values = 642 * 8;
    assert_eq!(derived(Location::Center, unlit), 0);
    assert_eq!(derived(Location::Corner, unlit), values * size_of::<f32>());
    // Gradients are packed in 8 bytes, with a byte per cell that says whether they are computed.
    assert_eq!(derived(Location::Center, lit), values * 8 + 642);
    assert_eq!(derived(Location::Corner, lit), values * (size_of::<f32>() + 8) + 642);
}

/// A checked grid asks for 26 bytes per cell and what the check needs for a while, whatever the width of the tables:
/// less than a copy of them, which in 32 bits would be 96 bytes per cell, would add.
fn tables_are_not_copied(renderer: &Renderer) {
    let asked = |level: u32| {
        let mesh = IcosahedralMesh::new(level).unwrap();
        let (narrow, wide) = (Numbered::<i32>::new(&mesh, 1), Numbered::<i64>::new(&mesh, 1));
        let bytes = |tables| {
            let check = || {
                let before = ASKED.load(Relaxed);
                renderer.run(|| Grid::new(tables).unwrap());
                ASKED.load(Relaxed) - before
            };
            (0..3).map(|_| check()).min().unwrap()
        };
        let [narrow, wide] = [narrow.tables(&mesh), wide.tables(&mesh)].map(bytes);
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
