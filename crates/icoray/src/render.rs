//! The renderer: a scene's work on a thread pool of its own, and on a device where there is one.

use crate::description::Description;
use crate::device::{Device, Devices, Job};
use crate::error::{Error, ErrorKind, Result};
use crate::field::{CenterField, Field};
use crate::frame::{Colors, ErrorSummary, Frame, FrameReport};
use crate::gradient;
use crate::grid::{Grid, Reals};
use crate::kernel::Real;
use crate::kernel::column::Shell;
use crate::kernel::sample::{Sample, Samples};
use crate::kernel::transfer::Spans;
use crate::label::Legend;
use crate::layers::Layers;
use crate::output::Stamp;
use crate::plan::{Plan, Sharing};
use crate::quality::{Deadline, Lights, Quality};
use crate::ranges::{Ranges, Values};
use crate::ranks::{Part, Ranks, Told};
use crate::raster::{Raster, Tile};
use crate::scene::{Backend, Coloring, Precision, Scene, Scheme};
use crate::threads::Threads;
use std::sync::Arc;
use std::time::Instant;

mod columns;
mod device;
mod devices;
mod gradients;
mod parts;
mod spare;
mod work;

use device::OnDevice;
use devices::{Found, One, Opened};
pub(crate) use gradients::Gradients;
use spare::Spare;
pub(crate) use work::brightest;
use work::{Work, asked, certainty, notes};

/// A renderer with threads of its own, which have ended when it is dropped, and a device beside them if it is given one.
#[derive(Debug)]
pub struct Renderer {
    threads: Threads,
    devices: Option<Opened>,
    spare: Spare,
    ranges: Ranges,
}

impl Renderer {
    /// A renderer with `threads` threads, or as many as the affinity mask allows when that is 0.
    ///
    /// # Errors
    /// [`ErrorKind::Io`](crate::ErrorKind::Io) when the threads cannot be made.
    pub fn new(threads: usize) -> Result<Self> {
        Ok(Renderer {
            threads: Threads::new(threads)?,
            devices: None,
            spare: Spare::default(),
            ranges: Ranges::default(),
        })
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

    /// Number of threads.
    pub fn threads(&self) -> usize {
        self.threads.count()
    }

    /// Runs `work` on the renderer's threads: parallel passes inside use them and no others.
    pub fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        self.threads.run(work)
    }

    /// Renders `scene`.
    ///
    /// # Errors
    /// As [`Plan::new`].
    pub fn render(&self, scene: &Scene, grid: &Grid, layers: &Layers, field: &Field) -> Result<Frame> {
        match self.render_over(&mut Ranks::alone(), scene, grid, None, layers, field)? {
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
    pub fn render_over(
        &self,
        ranks: &mut Ranks,
        scene: &Scene,
        grid: &Grid,
        part: Option<&Part>,
        layers: &Layers,
        field: &Field,
    ) -> Result<Rendered> {
        self.render_since(Instant::now(), ranks, scene, &Given { grid, part, layers, field })
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
        let Given { grid, part, layers, field } = *given;
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
                ("has layers of radii (planet radii)", format!("{:?}", plan.radius)),
                ("has a field at", place.into()),
                ("has a scene with backend", format!("{:?}", scene.backend)),
            ]
        })?;
        let share_of_whole = match part {
            None if sharing.scheme == Scheme::Fragments => Some(Part::of_whole(ranks, grid)?),
            _ => None,
        };
        let part = part.or(share_of_whole.as_ref());
        let average = || plan.from_corners.then(|| self.spare.average(grid, field)).transpose();
        let center = ranks.attempt(|| self.run(average));
        let mut center = ranks.together(center)?;
        if let (Some(part), Some(center)) = (part, &mut center) {
            center.fill_halo(ranks, part)?;
        }
        let derived = center.as_ref().map_or(0, CenterField::bytes);
        let field = center.as_ref().map_or(*field, CenterField::field);
        let values = Values { threads: &self.threads, field: &field, part };
        let settled = self.ranges.settle(ranks, scene, values)?;
        let how = scene.coloring.as_ref().map(Coloring::describe);
        let scene = settled.as_ref().unwrap_or(scene);
        let range = scene.coloring.as_ref().and_then(Coloring::fixed);
        let colors = range.zip(how).map(|(range, how)| Colors { range, how });
        if settled.is_some() {
            plan.recolor(scene);
        }
        let device = self.find_device(ranks, scene)?;
        let setting =
            Setting { renderer: self, device, scene, plan: &plan, grid, part, field: &field, start };
        let mut rendered = match (field.samples(), scene.precision) {
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
        self.spare.keep_average(center);
        Ok(rendered)
    }
}

/// What a rank has of a picture that is done.
#[derive(Debug, Clone, PartialEq)]
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
    field: &'f Field<'f>,
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
    start: Instant,
}

/// What is known of a field before the first ray.
struct Prepared<'f> {
    value_range: Option<[f64; 2]>,
    missing_values: u64,
    /// The scene's, or without light where there is no time for gradients.
    quality: Quality,
    deadline: Option<Deadline>,
    gradients: Gradients<'f>,
}

fn prepare<'f, S: Sample>(
    setting: &Setting<'f>,
    ranks: &mut Ranks,
    samples: Samples<'f, S>,
) -> Result<Prepared<'f>> {
    let Setting { renderer, scene, plan, grid, part, field, start, .. } = *setting;
    let counts = |cell: usize| part.is_none_or(|part| part.owns(cell));
    let range = ranks.attempt(|| renderer.run(|| Ok(field.range_over(counts))));
    let mut range = ranks.together(range)?;
    if part.is_some() {
        range = Part::whole_range(ranks, range)?;
    }
    let (value_range, missing_values) = range;
    // Rays through parts are not shared out: each rank traces all of them.
    let deadline = Deadline::of(scene, start, if part.is_some() { 1 } else { ranks.size() });
    let mut quality = asked(scene);
    let sample = move |part: usize, memory: Vec<_>| {
        gradient::gradients(grid, &plan.radius, &samples, 0..grid.cells().div_ceil(part), memory)
    };
    // A device computes its own, but for those of a part.
    let is_asked_for = setting.device.is_err() || part.is_some();
    if let (Some(deadline), true) = (deadline, plan.shading.is_some()) {
        let has_time =
            || !is_asked_for || deadline.has_time_for_gradients(1.0 / 64.0, || drop(sample(64, Vec::new())));
        let is_root = ranks.is_root();
        let has_time = ranks.attempt(|| renderer.run(|| Ok(!is_root || has_time())));
        let mine = has_time.map(|has_time| match has_time {
            true => quality,
            false => Quality { lights: Lights::Off, ..quality },
        });
        quality = ranks.agree_on_quality(mine)?;
    }
    let is_lit = quality.lights != Lights::Off;
    let all = move || if is_lit { sample(1, renderer.spare.gradients()) } else { Vec::new() };
    let mut gradients = Gradients::of(all);
    let computed = ranks.attempt(|| {
        renderer.run(|| {
            if is_asked_for {
                gradients.get();
            }
            Ok(())
        })
    });
    ranks.together(computed)?;
    if let (Some(part), true) = (part, is_lit) {
        let layers = plan.radius.len();
        let all = gradients.get_mut();
        part.fill_halo(ranks, all, |all, cell| &mut all[cell as usize * layers..][..layers])?;
    }
    Ok(Prepared { value_range, missing_values, quality, deadline, gradients })
}

fn draw<T: Real, S: Sample>(setting: &Setting, ranks: &mut Ranks, data: &[S]) -> Result<Rendered> {
    let Setting { renderer, scene, plan, grid, part, field, start, .. } = *setting;
    let spans = Spans::<T>::new(&plan.knots);
    let shell = Shell::<T>::new(&plan.radius);
    let samples = Samples::new(data, field, plan.falling, spans.range());
    let prepared = prepare(setting, ranks, samples)?;
    let Prepared { value_range, missing_values, quality, deadline, gradients } = &prepared;
    let is_lit = quality.lights != Lights::Off;
    let prepare_s = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let work = Work { renderer, scene, plan, grid, shell: &shell, spans: &spans, samples, gradients };
    let job = Job::new(scene, plan, grid, field, gradients, *quality, part.is_some());
    let mut on_device = OnDevice::new(&setting.device, job);
    // What others would measure of the same data is not asked for.
    let deadline = deadline.filter(|_| part.is_some() || ranks.is_root());
    let mut picked = ranks.attempt(|| {
        renderer.run(|| {
            Ok(match is_lit {
                true => work.pick::<4>(*quality, deadline, &mut on_device),
                false => work.pick::<1>(*quality, deadline, &mut on_device),
            })
        })
    });
    if part.is_some() {
        picked = ranks.agree_on_cheapest(picked);
    }
    // Ranks that have different data draw tiles that do not fit each other.
    let facts = || match part {
        Some(part) => vec![("has a part of a grid of cells", part.cells().to_string())],
        None => vec![
            ("has a grid of cells and corners", format!("{} and {}", grid.cells(), grid.triangles())),
            ("has a field of range and missing values", format!("{value_range:?} and {missing_values}")),
        ],
    };
    let share = ranks.deal(picked, work.raster(), facts)?;
    let quality = share.quality;
    let raster = Raster { step: quality.pixel_step, ..work.raster() };
    let exchanged = match part {
        Some(part) if is_lit => Some(work.exchange::<4>(ranks, part, &share, &mut on_device)?),
        Some(part) => Some(work.exchange::<1>(ranks, part, &share, &mut on_device)?),
        None => None,
    };
    let mine = share.tiles_of(ranks.rank());
    let fragments = exchanged.as_ref().map(|e| ranks.together(e.tiles(raster, &mine))).transpose()?;
    let draw = |give: &(dyn Fn(Tile) + Sync)| match (&fragments, is_lit) {
        (Some(fragments), _) => work.put_together(&quality, raster, fragments, give),
        (None, true) => work.trace::<4>(&quality, raster, &mine, &mut on_device, give),
        (None, false) => work.trace::<1>(&quality, raster, &mine, &mut on_device, give),
    };
    let traced_s = exchanged.as_ref().map_or(0.0, |exchanged| exchanged.traced_s);
    let ready_s = start.elapsed().as_secs_f64();
    let gathered = ranks.gather(&renderer.threads, raster, traced_s, draw);
    let is_root = ranks.is_root();
    let (mut picture, mut drawn_s) = (None, 0.0);
    let told = gathered.and_then(|gathered| {
        drawn_s = gathered.drawn_s;
        let (gather_s, balance, bytes_received) =
            (gathered.gather_s, gathered.balance, gathered.bytes_received);
        let mut told = Told { gather_s, balance, bytes_received, ..Told::default() };
        if is_root {
            let (drawn, counts) = ranks.attempt(|| renderer.run(|| Ok(raster.assemble(&gathered.tiles))))?;
            let error: Vec<f32> = drawn.iter().map(|p| p.error).collect();
            told.error = ErrorSummary::of(&error, certainty(scene, &quality));
            told.counts = counts;
            picture = Some((drawn, error));
        }
        Ok(told)
    });
    let told = ranks.conclude(told)?;
    let mut report = FrameReport {
        error: told.error,
        prepare_s,
        render_s: ready_s + drawn_s - traced_s,
        counts: told.counts,
        value_range: *value_range,
        missing_values: *missing_values,
        quality,
        derived_bytes: gradients.bytes(),
        left_out: plan.left_out().to_vec(),
        tiles: mine.len(),
        compose_s: if part.is_some() { drawn_s - traced_s } else { 0.0 },
        gather_s: told.gather_s,
        balance: told.balance,
        bytes_received: told.bytes_received,
        ..FrameReport::default()
    };
    on_device.tell(&mut report);
    renderer.spare.keep_gradients(prepared.gradients.into_memory());
    let Some((drawn, error)) = picture else {
        return Ok(Rendered::AtRoot(report));
    };
    Ok(Rendered::Here(Frame {
        width: scene.width,
        height: scene.height,
        pixels: drawn.iter().map(|p| p.color).collect(),
        error,
        field: scene.field.clone(),
        description: Description::default(),
        legend: Legend::of(scene, &plan.radius),
        notes: notes(scene),
        stamp: Stamp::default(),
        report,
    }))
}
