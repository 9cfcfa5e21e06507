//! Fields, rays, ranks that are threads, and comparisons of frames and errors.

#![allow(dead_code, reason = "each crate that includes this takes what it needs of it")]

use super::culled::directions;
use glam::DVec3;
use icoray::ranks::on_local_nodes;
use icoray::{
    Error, ErrorKind, Field, Fields, Frame, FrameReport, Grid, IcosahedralMesh, Knot, Layers, Location, OwnedReals,
    Ranks, Reals, Rendered, Renderer, Scene, Shape, TransferFunction,
};
use std::fmt::Debug;

pub const FAR: &str = "lon = 20\nlat = 35\ndistance = 3.2\nfov = 45";
pub const NEAR: &str = "lon = -100\nlat = -60\ndistance = 1.9\nfov = 60";
pub const LIT: &str = "[light]\nkind = \"headlight\"";
/// In the shell.
pub const INSIDE: &str = "eye = [1.02, 0.3, 0.1]\ntarget = [0, 1.2, 0.3]\nfov = 100";
pub const SHELL: &str = "knots = [ { value = 0.1, color = \"red\", extinction = 0 }, { value = 0.3, color = \"green\", extinction = 40 }, \
     { value = 0.5, color = \"blue\", extinction = 0 } ]";
pub const DENSE: &str = "knots = [ { value = -0.8, color = \"blue\", extinction = 4 }, { value = -0.2, color = \"white\", extinction = 1 }, \
     { value = 0.3, color = \"yellow\", extinction = 1 }, { value = 0.8, color = \"red\", extinction = 9 } ]";

/// In the shell of [`earth_layers`], which ends at 1.19 radii with an exaggeration of 60.
pub const IN_SHELL: &str = "lon = 26\nlat = 33\ndistance = 1.1\nfov = 110";
/// Metres.
pub const HEIGHT_M: [f64; 4] = [0.0, 5e3, 12e3, 20e3];

pub fn earth_layers() -> Layers {
    Layers::from_heights(&HEIGHT_M, 6371e3).unwrap()
}

/// A transfer function for values from -1.5 to 2.5, as those of [`waves`].
pub const HAZE: &str =
    "map = \"viridis\"\nrange = [-1.5, 2.5]\nopacity = [[-1.5, 0.5], [0, 0.05], [0.4, 0.8], [2.5, 0.3]]";

/// A scene of the field f, in which `rest` has further keys and, behind a bar, further tables.
pub fn scene(camera: &str, transfer: &str, rest: &str) -> Scene {
    let (keys, tables) = rest.split_once('|').unwrap_or((rest, ""));
    scene_of(camera, &format!("field = \"f\"\n{keys}"), &format!("[transfer]\n{transfer}\n{tables}"))
}

/// A scene with these keys and tables; of 72 times 60 pixels, if the keys have no other size.
pub fn scene_of(camera: &str, keys: &str, tables: &str) -> Scene {
    let image = if keys.contains("image = ") { "" } else { "image = { width = 72, height = 60 }" };
    let text = format!("{keys}\n{image}\n[camera]\n{camera}\n{tables}\n");
    Scene::parse(&text).unwrap_or_else(|error| panic!("{error}:\n{text}"))
}

/// An icosahedral mesh of `level` bisections and its grid, which stay until the process ends.
pub fn icosahedral(level: u32) -> (&'static IcosahedralMesh, Grid<'static>) {
    let mesh: &IcosahedralMesh = Box::leak(Box::new(IcosahedralMesh::new(level).unwrap()));
    (mesh, Grid::new(mesh.tables()).unwrap())
}

/// The values of each column and layer, level-fastest.
pub fn over_columns<V>(columns: usize, layers: usize, value: impl Fn(usize, usize) -> V) -> Vec<V> {
    (0..columns * layers).map(|i| value(i / layers, i % layers)).collect()
}

/// A field at all cells or corners, level-fastest.
pub fn waves(mesh: &IcosahedralMesh, location: Location, layers: usize) -> Vec<f64> {
    let at = match location {
        Location::Center => directions(&mesh.lon_center_rad, &mesh.lat_center_rad),
        Location::Corner => directions(&mesh.lon_corner_rad, &mesh.lat_corner_rad),
    };
    let wave = |p: DVec3, layer: usize| (3.0 * p.x).sin() * (4.0 * p.y).cos() + p.z + 0.3 * layer as f64;
    over_columns(at.len(), layers, |column, layer| wave(at[column], layer))
}

/// A grid with the field f and maybe a field g on layers, which may lie at heights of their own.
pub struct Model {
    pub mesh: &'static IcosahedralMesh,
    pub grid: Grid<'static>,
    pub layers: Layers,
    /// Of f and of g, level-fastest.
    pub values: Vec<Vec<f32>>,
    /// Of the layers over each cell, level-fastest.
    pub heights: Vec<f64>,
}

impl Model {
    /// Over layers at these heights, in planet radii; `values` gives those of the fields of a cell, at a direction, on
    /// a layer.
    pub fn new<const N: usize>(level: u32, heights: &[f64], values: impl Fn(usize, DVec3, usize) -> [f64; N]) -> Self {
        let (mesh, grid) = icosahedral(level);
        let value = |cell: usize, layer: usize| values(cell, grid.direction(cell as u32), layer);
        let all = over_columns(grid.cells(), heights.len(), value);
        let values = (0..N).map(|k| all.iter().map(|values| values[k] as f32).collect()).collect();
        Model { layers: Layers::from_heights(heights, 1.0).unwrap(), values, heights: Vec::new(), mesh, grid }
    }

    pub fn fields(&self) -> Fields<'_> {
        let layers = |values: usize| values / self.grid.cells();
        let fields = self.values.iter().map(|values| at_centers(values, layers(values.len())));
        let fields = Fields::new(["f", "g"].into_iter().zip(fields));
        let heights = (!self.heights.is_empty()).then(|| at_centers(&self.heights, layers(self.heights.len())));
        fields.with_heights(heights)
    }

    pub fn draw(&self, scene: &Scene) -> Frame {
        self.draw_by(&Renderer::new(2).unwrap(), scene)
    }

    pub fn draw_by(&self, renderer: &Renderer, scene: &Scene) -> Frame {
        renderer.render(scene, &self.grid, &self.layers, self.fields()).unwrap()
    }

    pub fn draw_over(&self, renderer: &Renderer, scene: &Scene, ranks: &mut Ranks) -> Result<Rendered, Error> {
        renderer.render_over(ranks, scene, &self.grid, &self.layers, self.fields())
    }

    /// Over ranks of one thread each, which all have the whole grid.
    pub fn draw_on(&self, scene: &Scene, ranks: usize) -> (Frame, Vec<FrameReport>) {
        picture(on_ranks(ranks, |ranks| self.draw_over(&Renderer::new(1).unwrap(), scene, ranks).unwrap()))
    }

    /// Checks that pixels, errors and reports are the same on any threads and ranks, and returns the picture.
    pub fn draw_anywhere(&self, scene: &Scene, name: &str) -> Frame {
        let expected = self.draw(scene);
        let on_threads = [1, 8].map(|threads| (self.draw_by(&Renderer::new(threads).unwrap(), scene), Vec::new()));
        for (frame, reports) in on_threads.into_iter().chain([2, 5].map(|ranks| self.draw_on(scene, ranks))) {
            assert!(bits(&frame) == bits(&expected), "{name} on {} ranks", reports.len());
            assert!(frame.sampling_error == expected.sampling_error, "{name} on {} ranks", reports.len());
            assert_eq!(frame.report.counts.rays, expected.report.counts.rays, "{name}");
            for report in reports.iter().chain([&frame.report]) {
                assert_eq!(report.sampling, expected.report.sampling, "{name}");
                assert_eq!(report.edge_pixels, expected.report.edge_pixels, "{name}");
            }
        }
        expected
    }
}

/// `count` heights from 0 to `top`.
pub fn even_heights(count: usize, top: f64) -> Vec<f64> {
    (0..count).map(|layer| top * layer as f64 / (count - 1) as f64).collect()
}

/// A field without missing values, level-fastest.
pub fn level_fastest<S>(values: &[S], layers: usize, location: Location) -> Field<'_>
where
    for<'v> Reals<'v>: From<&'v [S]>,
{
    Field::level_fastest(values, layers, location).unwrap()
}

pub fn at_centers<S>(values: &[S], layers: usize) -> Field<'_>
where
    for<'v> Reals<'v>: From<&'v [S]>,
{
    level_fastest(values, layers, Location::Center)
}

/// An array with the value of each column and layer where `shape` puts it, and `gap` between them.
pub fn laid_out<S: Copy>(shape: &Shape, gap: S, value: impl Fn(usize, usize) -> S) -> Vec<S> {
    let (_, last) = shape.extent().unwrap_or((0, -1));
    let mut array = vec![gap; (last + 1) as usize];
    let block = if shape.block == 0 { shape.columns.max(1) } else { shape.block };
    for column in 0..shape.columns {
        let inside = (column % block) as isize * shape.column_stride;
        let start = shape.offset as isize + inside + (column / block) as isize * shape.block_stride;
        for layer in 0..shape.layers {
            array[(start + layer as isize * shape.layer_stride) as usize] = value(column, layer);
        }
    }
    array
}

/// An array of a field, in f32 or f64.
#[derive(Debug)]
pub struct Array {
    pub values: OwnedReals,
    pub shape: Shape,
    pub location: Location,
    /// The mark of what is missing, as it is in f64.
    pub missing: Option<f64>,
}

impl Array {
    /// The values of columns and layers, with a large number between columns, which must not be read.
    pub fn new(
        shape: Shape,
        is_wide: bool,
        location: Location,
        missing: Option<f64>,
        value: impl Fn(usize, usize) -> f64,
    ) -> Self {
        let values = match is_wide {
            true => OwnedReals::F64(laid_out(&shape, 1e30, value)),
            false => OwnedReals::F32(laid_out(&shape, 1e30, |column, layer| value(column, layer) as f32)),
        };
        Array { values, shape, location, missing }
    }

    pub fn fill(&mut self, value: f64) {
        match &mut self.values {
            OwnedReals::F64(values) => values.fill(value),
            OwnedReals::F32(values) => values.fill(value as f32),
        }
    }

    pub fn field(&self) -> Field<'_> {
        let is_wide = matches!(self.values, OwnedReals::F64(_));
        let fill = self.missing.map(|fill| if is_wide { fill } else { f64::from(fill as f32) });
        Field::new(self.values.as_reals(), self.shape, self.location, fill).unwrap()
    }
}

/// Arrays by the names of their fields, and `heights`.
pub type Arrays = Vec<(&'static str, Array)>;

pub fn fields(arrays: &Arrays) -> Fields<'_> {
    let all = arrays.iter().map(|(name, array)| (*name, array.field()));
    let (heights, named): (Vec<_>, Vec<_>) = all.partition(|(name, _)| *name == "heights");
    Fields::new(named).with_heights(heights.first().map(|(_, heights)| *heights))
}

/// The columns `rows` of `all`, level-fastest.
pub fn columns_of<S: Copy>(all: &[S], rows: &[usize], layers: usize) -> Vec<S> {
    rows.iter().flat_map(|row| &all[row * layers..][..layers]).copied().collect()
}

/// The mean of `many` × `many` pixels for each.
pub fn averaged(fine: &Frame, many: u32) -> Vec<[f64; 4]> {
    let side = fine.width / many;
    let mut all = vec![[0.0; 4]; (side * side) as usize];
    for (at, pixel) in (0..).zip(&fine.pixels) {
        let (x, y) = (at % fine.width / many, at / fine.width / many);
        for (sum, value) in all[(y * side + x) as usize].iter_mut().zip(pixel) {
            *sum += f64::from(*value) / f64::from(many * many);
        }
    }
    all
}

/// The largest difference of a channel of each pixel from that of a reference in double precision.
pub fn distances(frame: &Frame, exact: &[[f64; 4]]) -> Vec<f64> {
    let far = |(p, q): (&[f32; 4], &[f64; 4])| (0..4).map(|k| (f64::from(p[k]) - q[k]).abs()).fold(0.0, f64::max);
    frame.pixels.iter().zip(exact).map(far).collect()
}

/// Eye and direction of the ray through the middle of each pixel, row by row.
pub fn rays(scene: &Scene) -> impl Iterator<Item = (DVec3, DVec3)> {
    let (camera, width, height) = (scene.camera, scene.width, scene.height);
    let direction = move |i: u32| camera.direction(i % width, i / width, width, height);
    (0..width * height).map(move |i| (camera.eye().into(), direction(i).into()))
}

/// The results of `work` on each rank, a thread each; `node_of` has the node of each rank.
pub fn on_nodes<R: Send>(node_of: &[usize], work: impl Fn(&mut Ranks) -> R + Sync) -> Vec<R> {
    on_local_nodes(node_of, |team| work(&mut Ranks::new(team)))
}

/// [`on_nodes`] with all ranks on one node.
pub fn on_ranks<R: Send>(ranks: usize, work: impl Fn(&mut Ranks) -> R + Sync) -> Vec<R> {
    on_nodes(&vec![0; ranks], work)
}

/// The picture, which one rank has, and the reports of all ranks.
pub fn picture(rendered: Vec<Rendered>) -> (Frame, Vec<FrameReport>) {
    let (mut picture, mut reports) = (None, Vec::new());
    for rendered in rendered {
        match rendered {
            Rendered::Here(frame) => {
                reports.push(frame.report.clone());
                assert!(picture.replace(frame).is_none());
            }
            Rendered::AtRoot(report) => reports.push(report),
        }
    }
    (picture.unwrap(), reports)
}

/// The picture and the reports of each of several frames.
pub fn pictures<const N: usize>(rendered: Vec<[Rendered; N]>) -> [(Frame, Vec<FrameReport>); N] {
    let mut frames = [const { Vec::new() }; N];
    for of_rank in rendered {
        frames.iter_mut().zip(of_rank).for_each(|(frame, rendered)| frame.push(rendered));
    }
    frames.map(picture)
}

/// Pixels and errors bit by bit: NaN is equal to itself.
pub fn bits(frame: &Frame) -> Vec<[u32; 5]> {
    let pixels = frame.pixels.iter().zip(&frame.error);
    pixels.map(|([r, g, b, a], e)| [r, g, b, a, e].map(|value| value.to_bits())).collect()
}

pub fn knot(value: f64, color: [f64; 3], extinction: f64) -> Knot {
    Knot { value, color, extinction }
}

pub fn transfer(knots: &[Knot]) -> TransferFunction {
    TransferFunction { knots: knots.to_vec(), unit_length: None }
}

/// The largest difference of a channel.
pub fn difference(one: &Frame, other: &Frame) -> f32 {
    assert_eq!(one.pixels.len(), other.pixels.len());
    (0..one.pixels.len()).map(|i| pixel_difference(one, other, i)).fold(0.0, f32::max)
}

/// The largest difference of a channel of pixel `i`.
pub fn pixel_difference(one: &Frame, other: &Frame, i: usize) -> f32 {
    let channels = one.pixels[i].iter().zip(other.pixels[i]);
    channels.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// Number of pixels that differ by more than their errors allow and `slack`.
pub fn count_beyond(one: &Frame, other: &Frame, slack: f32) -> usize {
    let most = |i: usize| one.error[i] + other.error[i] + slack;
    (0..one.pixels.len()).filter(|i| pixel_difference(one, other, *i) > most(*i)).count()
}

/// Kind and words of the error that `result` is.
pub fn refusal<T: Debug>(result: Result<T, Error>) -> (ErrorKind, String) {
    let error = result.unwrap_err();
    (error.kind(), error.context().to_string())
}

/// Checks that tables are refused with an error that has these words.
pub fn assert_grid_error(grid: Result<Grid, Error>, words: &[&str], name: &str) {
    let error = grid.err().unwrap_or_else(|| panic!("{name} passed"));
    assert_eq!(error.kind(), ErrorKind::Grid, "{name}: {error}");
    for word in words {
        assert!(error.to_string().contains(word), "{name}: '{word}' is not in '{error}'");
    }
}

/// Checks that all ranks have the same error, of this kind, with words that begin so.
pub fn assert_same_refusal(refusals: &[(ErrorKind, String)], kind: ErrorKind, start: &str) {
    assert!(refusals.iter().all(|refusal| *refusal == refusals[0] && refusal.0 == kind), "{refusals:?}");
    assert!(refusals[0].1.starts_with(start), "{}", refusals[0].1);
}
