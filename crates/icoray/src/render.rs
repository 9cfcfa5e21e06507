//! The renderer: a scene's work on a thread pool of its own, and on a device where there is one.

use crate::derive::{self, Kept};
use crate::device::{Device, Devices, Job};
use crate::edges::Edges;
use crate::error::{Error, ErrorKind, Result};
use crate::field::{CenterField, Field};
use crate::fields::Fields;
use crate::frame::{Colors, Frame, FrameReport};
use crate::gradient::Gradients;
use crate::grid::{Grid, Reals};
use crate::ground::Ground;
use crate::kernel::Real;
use crate::kernel::column::Shell;
use crate::kernel::leap::Visible;
use crate::kernel::ray::packets;
use crate::kernel::sample::{AnySamples, Sample, Samples};
use crate::kernel::transfer::Spans;
use crate::layers::Layers;
use crate::plan::{Plan, Savings, Sharing};
use crate::ranges::{Ranges, Values};
use crate::ranks::{Part, Ranks};
use crate::scene::{Backend, Precision, Scene, Scenery, Scheme};
use crate::threads::Threads;
use fearless_simd::Level;
use std::sync::Arc;
use std::time::Instant;

mod columns;
mod derived;
mod device;
mod devices;
mod mixed;
mod parts;
mod picture;
mod prepare;
mod progress;
mod round;
mod shown;
mod spare;
mod summary;
mod unchanged;
mod work;

pub(crate) use derived::Derived;
use device::OnDevice;
use devices::{Found, One, Opened};
use prepare::Known;
use progress::Progress;
use shown::Other;
use spare::{Source, Spare};
use unchanged::Last;
pub(crate) use work::allowed;
use work::{Carrying, Plain, Rays, Work};

/// A renderer with its own threads, which end when it is dropped, and optionally a device.
///
/// ```
/// use icoray::{Field, Grid, IcosahedralMesh, Layers, Location, Renderer, Scene, Shape};
///
/// let mesh = IcosahedralMesh::new(2)?;
/// let grid = Grid::new(mesh.tables())?;
/// let layers = Layers::from_heights(&[0.0, 1e6], 6.371e6)?;
/// let values = vec![1.0f32; 2 * grid.cells()];
/// let shape = Shape::cell_fastest(grid.cells(), 2);
/// let field = Field::new(values.as_slice().into(), shape, Location::Center, None)?;
/// let scene = Scene::parse(
///     "field = 'one'
///      image = { width = 8, height = 8 }
///      camera = { lon = 0, lat = 0, distance = 3 }
///      transfer = { map = 'viridis', range = [0, 2], opacity = [[0, 0.5], [2, 0.5]] }",
/// )?;
/// let renderer = Renderer::new(1)?;
/// let frame = renderer.render(&scene, &grid, &layers, &field)?;
/// // Premultiplied linear RGBA, row by row from the top left.
/// assert_eq!((frame.width, frame.height, frame.pixels.len()), (8, 8, 64));
/// assert!(f64::from(frame.error[0]) <= 1e-3);
/// # Ok::<(), icoray::Error>(())
/// ```
#[derive(Debug)]
pub struct Renderer {
    threads: Threads,
    devices: Option<Opened>,
    savings: Savings,
    integrates: bool,
    progress: Option<Progress>,
    spare: Spare,
    last: Last,
    ranges: Ranges,
    derived: Kept,
}

impl Renderer {
    /// A renderer with `threads` threads, or as many as the affinity mask allows when that is 0.
    ///
    /// # Errors
    /// [`ErrorKind::Io`](crate::ErrorKind::Io) when the threads cannot be made.
    pub fn new(threads: usize) -> Result<Self> {
        let (devices, savings) = (None, Savings::ALL);
        let (threads, spare, last) = (Threads::new(threads)?, Spare::default(), Last::default());
        let (ranges, derived) = (Ranges::default(), Kept::default());
        Ok(Renderer {
            threads,
            devices,
            savings,
            integrates: true,
            progress: None,
            spare,
            last,
            ranges,
            derived,
        })
    }

    /// The same, but leaving out what `savings` say: for measurements.
    #[must_use]
    pub fn with_savings(self, savings: Savings) -> Self {
        Renderer { savings, spare: self.spare.with_reuse(savings.reuse), ..self }
    }

    /// The same, but rays only walk and interpolate: frusta of unlit `exact` scenes are laid aside to be integrated together,
    /// and are not. For measurements.
    #[doc(hidden)]
    #[must_use]
    pub fn without_integrals(self) -> Self {
        Renderer { integrates: false, ..self }
    }

    /// The machine's vector instructions, where rays are traced in packets.
    fn vectors(&self) -> Option<Level> {
        self.savings.lanes.then(packets).flatten()
    }

    /// The same renderer with devices, which trace what they can of scenes that ask for it ([`Scene::backend`]).
    #[must_use]
    pub fn with_devices(self, devices: Arc<dyn Devices>) -> Self {
        Renderer { devices: Some(Opened::new(devices)), ..self }
    }

    /// The same renderer with one device.
    #[must_use]
    pub fn with_device(self, device: Arc<dyn Device>) -> Self {
        self.with_devices(Arc::new(One(device)))
    }

    /// The same renderer, which calls `report(finished, total)` after each tile of a picture that this process draws, from the
    /// thread that drew it. `total` is the number of these tiles. The calls of one picture come in no order, and none comes for
    /// probes of a time budget and for pixels at edges, which are traced again after the last tile.
    ///
    /// ```
    /// use std::sync::Arc;
    ///
    /// let renderer = icoray::Renderer::new(1)?
    ///     .with_progress(Arc::new(|finished, total| eprintln!("{finished} of {total} tiles")));
    /// # Ok::<(), icoray::Error>(())
    /// ```
    #[must_use]
    pub fn with_progress(self, report: Arc<dyn Fn(usize, usize) + Send + Sync>) -> Self {
        Renderer { progress: Some(Progress(report)), ..self }
    }

    /// Number of threads.
    pub fn threads(&self) -> usize {
        self.threads.count()
    }

    /// Runs `work` on the renderer's threads: parallel passes inside use them and no others.
    pub fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        self.threads.run(work)
    }

    /// Renders `scene` of its fields, or of one field.
    ///
    /// # Errors
    /// As [`Plan::new`], and [`ErrorKind::Scene`](crate::ErrorKind::Scene) where the scene shows a field that is not there.
    pub fn render<'f>(
        &self,
        scene: &Scene,
        grid: &Grid,
        layers: &Layers,
        fields: impl Into<Fields<'f>>,
    ) -> Result<Frame> {
        let fields = fields.into();
        // Within a time budget frames are as good as there is time for.
        if self.savings.unchanged && scene.time_budget_ms.is_none() && scene.scenery == Scenery::default() {
            return self.render_if_changed(scene, grid, layers, fields.first(&scene.field)?);
        }
        self.render_anew(scene, grid, layers, &fields)
    }

    fn render_anew(&self, scene: &Scene, grid: &Grid, layers: &Layers, fields: &Fields) -> Result<Frame> {
        let given = Given { grid, part: None, layers, fields };
        match self.render_since(Instant::now(), &mut Ranks::alone(), scene, &given)? {
            Rendered::Here(frame) => Ok(frame),
            Rendered::AtRoot(_) => unreachable!("who draws alone is rank 0"),
        }
    }

    /// Renders `scene` together with the other ranks; the picture is at rank 0. Collective: all ranks give the same scene
    /// and layers.
    ///
    /// Without a `part` all give copies of the same grid and field, each draws some tiles, and the picture is bitwise that
    /// of [`Self::render`]. With one, each gives its own part of the grid and the field's values there, halo included, and
    /// the picture is as near to the exact integral as its errors say. [`Sharing`] has what a scene can ask for.
    ///
    /// Within a time budget the quality is what rank 0 picks, or of parts the cheapest that any rank picks.
    ///
    /// # Errors
    /// The same on all ranks: as [`Plan::new`] on any of them, [`ErrorKind::Internal`](crate::ErrorKind::Internal) where
    /// one of several panicked, and [`ErrorKind::Mpi`](crate::ErrorKind::Mpi) where they have not the same data or the
    /// transport fails.
    pub fn render_over<'f>(
        &self,
        ranks: &mut Ranks,
        scene: &Scene,
        grid: &Grid,
        part: Option<&Part>,
        layers: &Layers,
        fields: impl Into<Fields<'f>>,
    ) -> Result<Rendered> {
        let given = Given { grid, part, layers, fields: &fields.into() };
        self.render_since(Instant::now(), ranks, scene, &given)
    }

    /// The device for a picture, if there is one and it can. Collective.
    fn find_device(&self, ranks: &mut Ranks, scene: &Scene) -> Result<Found> {
        if scene.backend == Backend::Cpu {
            return Ok(Err(None));
        }
        let node_rank = ranks.node_rank()?;
        // On a thread of icoray's: those that a driver makes are no more the host's than they are.
        Ok(self.run(|| self.device_for(scene, node_rank)))
    }

    /// [`Self::render_over`] of a frame that was begun at `start`.
    fn render_since(
        &self,
        start: Instant,
        ranks: &mut Ranks,
        scene: &Scene,
        given: &Given,
    ) -> Result<Rendered> {
        let Given { grid, part, layers, fields } = *given;
        let of = derive::Given { scene, fields, grid, part, threads: &self.threads };
        let made = derive::make(ranks, &self.derived, &of)?;
        let with_derived = made.as_ref().map(|made| made.fields(fields));
        let fields = with_derived.as_ref().unwrap_or(fields);
        let field = ranks.attempt(|| fields.first(&scene.field));
        let field = ranks.together(field)?;
        let plan = ranks.attempt(|| {
            if part.is_none() && grid.cells() == 0 {
                return Err(Error::new(ErrorKind::Grid, "0 cells, expected at least 1"));
            }
            Ok((Plan::new(scene, grid, layers, field)?, Sharing::new(scene, part)?))
        });
        let (mut plan, sharing) = ranks.of_one_mind(plan, |(plan, sharing)| {
            let place = if plan.from_corners { "corners" } else { "centres" };
            vec![
                ("draws", sharing.to_string()),
                (
                    "has layers",
                    format!(
                        "{}, {} of the field, exaggeration {}",
                        layers.told(),
                        plan.radius.len(),
                        scene.exaggeration
                    ),
                ),
                ("has a field at", place.into()),
                ("has a scene with backend", format!("{:?}", scene.backend)),
            ]
        })?;
        let share_of_whole = match part {
            None if sharing.scheme == Scheme::Fragments => Some(Part::of_whole(ranks, grid)?),
            _ => None,
        };
        let part = part.or(share_of_whole.as_ref());
        let source = Source::new(grid, field);
        let average = || plan.from_corners.then(|| self.spare.average(&source, grid, field)).transpose();
        let center = ranks.attempt(|| self.run(average));
        let mut center = ranks.together(center)?;
        if let (Some(part), Some(center)) = (part, &mut center) {
            center.fill_halo(ranks, part)?;
        }
        let derived = center.as_ref().map_or(0, CenterField::bytes);
        let field = center.as_ref().map_or(*field, CenterField::field);
        let beside = self.others(ranks, scene, &Given { part, fields, ..*given })?;
        let derived = derived + beside.iter().map(Other::bytes).sum::<usize>();
        let others: Vec<(&str, Field)> = beside.iter().map(|other| (other.name(), other.field())).collect();
        let values = |name: &str| {
            let other = others.iter().find(|(known, _)| *known == name);
            Ok(Values { threads: &self.threads, field: other.map_or(&field, |(_, other)| other), part })
        };
        let settled = self.ranges.settle(ranks, scene, &values)?;
        let colors = Colors::of(scene, settled.as_ref().unwrap_or(scene));
        let scene = settled.as_ref().unwrap_or(scene);
        if settled.is_some() {
            scene.check_values()?;
            plan.recolor(scene);
        }
        let device = self.find_device(ranks, scene)?;
        let setting =
            Setting { renderer: self, device, scene, plan: &plan, grid, part, field: &field, source, start };
        let mut rendered = match (field.samples(), scene.precision) {
            _ if !scene.scenery.is_plain() => mixed::draw(&setting, ranks, layers, &others, fields.heights()),
            (Reals::F32(data), Precision::F32) => draw::<f32, f32>(&setting, ranks, data),
            (Reals::F32(data), Precision::F64) => draw::<f64, f32>(&setting, ranks, data),
            (Reals::F64(data), Precision::F32) => draw::<f32, f64>(&setting, ranks, data),
            (Reals::F64(data), Precision::F64) => draw::<f64, f64>(&setting, ranks, data),
        }?;
        let report = rendered.report_mut();
        report.derived_bytes += derived;
        report.threads = self.threads();
        report.ranks = ranks.size();
        report.colors = colors;
        report.sharing = (!ranks.is_alone()).then_some(sharing);
        let source = setting.source;
        if let Some(center) = center {
            self.spare.keep_average(source, center);
        }
        beside.into_iter().for_each(|other| other.leave(&self.spare, grid));
        if let Some(made) = made {
            report.derived_bytes += made.bytes();
            self.derived.keep(made);
        }
        Ok(rendered)
    }
}

/// What a rank has of a picture that is done.
#[derive(Debug, Clone, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "there is one for each picture")]
pub enum Rendered {
    /// The picture: this is rank 0.
    Here(Frame),
    /// What it cost and met; the picture is at rank 0. Errors, counts and the gathering are those of the whole picture,
    /// seconds, threads and tiles this rank's.
    AtRoot(FrameReport),
}

impl Rendered {
    fn report_mut(&mut self) -> &mut FrameReport {
        match self {
            Rendered::Here(frame) => &mut frame.report,
            Rendered::AtRoot(report) => report,
        }
    }
}

/// What the caller gives to draw of.
struct Given<'f> {
    grid: &'f Grid<'f>,
    part: Option<&'f Part>,
    layers: &'f Layers,
    fields: &'f Fields<'f>,
}

/// What a picture is drawn of, before its types are known.
struct Setting<'f> {
    renderer: &'f Renderer,
    device: Found,
    scene: &'f Scene,
    plan: &'f Plan,
    grid: &'f Grid<'f>,
    part: Option<&'f Part>,
    field: &'f Field<'f>,
    /// The field as it was given, before it was averaged.
    source: Source,
    start: Instant,
}

impl Setting<'_> {
    /// Whether the CPU computes gradients in any case: a device has its own, but for those of a part.
    fn needs_gradients(&self) -> bool {
        self.device.is_err() || self.part.is_some()
    }
}

/// Least and greatest radius of the facets of a layer of `radius`, where edges are anti-aliased.
fn facets(setting: &Setting, radius: f64) -> Option<[f64; 2]> {
    let Setting { renderer, scene, grid, part, .. } = *setting;
    let lowest = || part.map_or_else(|| renderer.run(|| grid.lowest_facet()), Part::lowest_facet);
    scene.antialias.then(|| [radius * lowest(), radius])
}

fn draw<T: Real, S: Sample>(setting: &Setting, ranks: &mut Ranks, data: &[S]) -> Result<Rendered> {
    let Setting { renderer, scene, plan, grid, part, field, .. } = *setting;
    let spans = Spans::<T>::new(&plan.knots);
    let shell = Shell::<T>::new(&plan.radius);
    let samples = Samples::new(data, field, plan.falling, spans.range());
    let known = Known::of(setting, ranks, &samples)?;
    let is_lit = known.is_lit();
    let (sight_key, visible) = prepare::sight(setting, &known, &spans, samples);
    let (light_key, mut gradients) =
        prepare::gradients(setting, &known, samples, spans.range(), (&sight_key, &visible));
    prepare::complete(setting, ranks, &visible, &mut gradients, is_lit)?;
    let job = Job::new(scene, plan, grid, field, &gradients, known.quality, part.is_some());
    let on_device = OnDevice::new(&setting.device, job);
    let radius = [shell.inner(), shell.outer()];
    let ground = Ground::new(scene);
    let ground = ground.as_ref();
    let (shell, spans) = (&shell, &spans);
    let plain = Plain {
        renderer,
        scene,
        plan,
        grid,
        shell,
        spans,
        samples: AnySamples::new(field, plan.falling, spans.range()),
        visible: &visible,
        gradients: &gradients,
        ground,
    };
    let (lit, unlit) = (Carrying::<T, 4>(&plain), Carrying::<T, 1>(&plain));
    let rays: &dyn Rays = if is_lit { &lit } else { &unlit };
    let [core, top] = radius.map(|radius| facets(setting, radius));
    let edges = Edges::new(scene, core.filter(|_| scene.core.is_some()), top, false);
    let work = Work { renderer, scene, plan, radius, ground, rays, edges };
    let mut rendered = picture::draw(setting, ranks, &known, &work, on_device)?;
    rendered.report_mut().derived_bytes =
        gradients.known().map_or(0, Gradients::bytes) + visible.known().map_or(0, Visible::bytes);
    if let (Some(key), Some(gradients)) = (light_key, gradients.into_known()) {
        renderer.spare.keep_gradients(key, gradients);
    }
    if let Some(visible) = visible.into_known() {
        renderer.spare.keep_visible(sight_key, visible);
    }
    Ok(rendered)
}
