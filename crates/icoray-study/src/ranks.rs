//! Load balance and communication of ranks, simulated in one process.
//!
//! Ranks are threads that compute one after the other ([`sequential`]), so that the seconds of each are those of a
//! processor of its own. The network is not simulated: bytes are reported instead.

use crate::results::{Table, number, progress, say};
use crate::scenes::multi_scale;
use icoray::ranks::{local_team, on_threads};
use icoray::{
    Decomposition, DistributedGrid, Error, ErrorKind, Field, FrameReport, Grid, Location, Ranks, Rendered, Renderer,
    Result, Scene,
};
use icoray_reference::sphere::{self, Sphere};
use partition::MeshPart;
pub use partition::Sharing;
pub(crate) use partition::morton;
use sequential::sequential_team;
use std::io::Write;
use std::path::PathBuf;
use std::thread;
use std::time::Instant;

mod partition;
mod sequential;

/// Options of the measurement.
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Bisections of the icosahedron; 8 gives the paper's 655,362 cells.
    #[arg(long, default_value_t = 8)]
    pub level: u32,
    /// Layers.
    #[arg(long, default_value_t = 99)]
    pub layers: usize,
    /// Width and height of the picture.
    #[arg(long, default_value_t = 512)]
    pub size: u32,
    /// Numbers of ranks.
    #[arg(long, value_delimiter = ',', default_values_t = [1, 2, 4, 8, 16, 32, 64])]
    pub ranks: Vec<usize>,
    /// The distribution of the work over ranks.
    #[arg(long, value_delimiter = ',', value_enum, default_values_t = [Sharing::Tiles, Sharing::Patches, Sharing::Rows, Sharing::Random])]
    pub sharing: Vec<Sharing>,
    /// Ranks of a node, which put their parts together; 0 for all of them.
    #[arg(long, default_value_t = 0)]
    pub node_ranks: usize,
    /// Frames after the first, which gives the costs for the assignment of tiles; the frame with the fastest busiest
    /// rank is reported.
    #[arg(long, default_value_t = 3)]
    pub frames: usize,
    /// Directory of ranks.csv.
    #[arg(long, default_value = "out/ranks")]
    pub out: PathBuf,
}

const COLUMNS: &str = "transfer,sharing,ranks,busiest_s,speedup,balance,least_tiles,most_tiles,-fragments_per_rank,\
    fragments_per_pixel,-sent_bytes_per_rank,sent_bytes_per_pixel,rank_0_received_bytes,compose_s,\
    copied_bytes_per_rank,copy_s";

/// Draws and prints a line per transfer function, sharing and number of ranks.
pub fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    if options.ranks.contains(&0) {
        return Err(Error::new(ErrorKind::Scene, "0 ranks, expected at least 1"));
    }
    let sphere = Sphere::new(options.level, options.layers, [1.0, 1.15], sphere::multi_scale)?;
    let processors = thread::available_parallelism().map_or(1, usize::from);
    let (cells, size) = (sphere.mesh.cells(), options.size);
    say!(
        out,
        "{cells} cells x {} layers, {size} x {size} pixels, f32; ranks are threads of one process that compute one after the\n\
             other, on {processors} processors: seconds are of a rank's own work, range of the field included, without a network. Of {}\n\
             frames after the first, the one with the fastest busiest rank. Balance: mean over maximum of the ranks' seconds.\n\
             tiles: all ranks have all data; patches, rows, random: each has its cells and a halo, in Morton order, in the mesh's or\n\
             anywhere. Ranks of a node put their parts together: bytes that each writes for it, and the seconds of the slowest.",
        options.layers,
        options.frames
    )?;
    let csv = Table::create(options.out.join("ranks.csv"), COLUMNS)?;
    let scenes = multi_scale::TRANSFERS.map(|(_, opacity)| multi_scale::scene(size, opacity, "", ""));
    let scenes: Vec<Scene> = scenes.into_iter().collect::<Result<_>>()?;
    say!(out, "{}", csv.heading())?;
    let mut table = Output { size, csv, alone: vec![None; scenes.len()], out };
    let frames = 1 + options.frames.max(1);
    let bar = progress(options.sharing.len() * options.ranks.len() + 1, "ranks");
    for &sharing in &options.sharing {
        for &ranks in &options.ranks {
            bar.set_message(format!("{ranks} ranks"));
            let simulation = Simulation::new(&sphere, sharing, ranks, &scenes, frames)?;
            for (scene, frame) in simulation.frames(ranks, options.node_ranks)?.into_iter().enumerate() {
                bar.suspend(|| table.row(multi_scale::TRANSFERS[scene].0, scene, sharing, &frame))?;
            }
            bar.inc(1);
        }
    }
    bar.set_message("2 ranks at once");
    let simulation = Simulation::new(&sphere, Sharing::Tiles, 1, &scenes, frames)?;
    let (one, two) = (simulation.wall_s(1)?, simulation.wall_s(2)?);
    bar.finish_and_clear();
    for ((name, _), (one, two)) in multi_scale::TRANSFERS.iter().zip(one.into_iter().zip(two)) {
        let ratio = one / two;
        say!(
            table.out,
            "{name}: 1 rank {one:.3} s, 2 ranks at once {two:.3} s a frame of tiles, {ratio:.2} times less"
        )?;
    }
    Ok(())
}

#[derive(Debug, Clone)]
struct RankFrame {
    busy_s: f64,
    report: FrameReport,
}

fn busiest(frame: &[RankFrame]) -> f64 {
    frame.iter().fold(0.0, |max: f64, rank| max.max(rank.busy_s))
}

/// The model, whole on each rank or distributed over ranks.
pub(crate) struct Simulation<'w> {
    sphere: &'w Sphere,
    parts: Option<Vec<MeshPart>>,
    /// The grid of all ranks if they have no parts.
    whole: Option<Grid<'w>>,
    scenes: &'w [Scene],
    /// Number of frames of each scene.
    frames: usize,
}

impl<'w> Simulation<'w> {
    pub fn new(sphere: &'w Sphere, sharing: Sharing, ranks: usize, scenes: &'w [Scene], frames: usize) -> Result<Self> {
        let parts = (sharing != Sharing::Tiles).then(|| MeshPart::all(sphere, sharing, ranks));
        let whole = if parts.is_none() { Some(sphere.grid()?) } else { None };
        Ok(Simulation { sphere, parts, whole, scenes, frames })
    }

    /// For each scene the frame (of all but the first) with the least seconds of its busiest rank.
    fn frames(&self, ranks: usize, node_ranks: usize) -> Result<Vec<Vec<RankFrame>>> {
        let node_of: Vec<usize> = (0..ranks).map(|rank| rank.checked_div(node_ranks).unwrap_or(0)).collect();
        let of_ranks = on_threads(sequential_team(&node_of), |(team, turns)| {
            turns.begin();
            let mut before = 0.0;
            self.rank(&Renderer::new(1)?, Ranks::new(team), |_, report| {
                let seconds = turns.seconds();
                let busy_s = seconds - std::mem::replace(&mut before, seconds);
                RankFrame { busy_s, report }
            })
        });
        let of_ranks: Vec<Vec<RankFrame>> = of_ranks.into_iter().collect::<Result<_>>()?;
        let frame = |number: usize| of_ranks.iter().map(|of_rank| of_rank[number].clone()).collect::<Vec<_>>();
        let min = |scene: usize| {
            let frames = (scene * self.frames + 1..(scene + 1) * self.frames).map(frame);
            frames.min_by(|a, b| busiest(a).total_cmp(&busiest(b))).expect("there is a frame behind the first")
        };
        Ok((0..self.scenes.len()).map(min).collect())
    }

    /// For each scene the minimum seconds of a frame with ranks that compute at once, each on one thread.
    fn wall_s(&self, ranks: usize) -> Result<Vec<f64>> {
        let of_ranks = on_threads(local_team(ranks), |team| {
            let mut start = Instant::now();
            self.rank(&Renderer::new(1)?, Ranks::new(team), |_, _| {
                std::mem::replace(&mut start, Instant::now()).elapsed().as_secs_f64()
            })
        });
        let min = |frames: &[f64]| frames[1..].iter().fold(f64::INFINITY, |min, s| min.min(*s));
        let of_ranks: Vec<Vec<f64>> = of_ranks.into_iter().collect::<Result<_>>()?;
        Ok(of_ranks[0].chunks_exact(self.frames).map(min).collect())
    }

    /// Renders all frames of all scenes as one rank; returns the results of `on_frame`.
    pub fn rank<R>(
        &self,
        renderer: &Renderer,
        mut ranks: Ranks,
        mut on_frame: impl FnMut(&Ranks, FrameReport) -> R,
    ) -> Result<Vec<R>> {
        let local = self.parts.as_ref().map(|parts| &parts[ranks.rank()]);
        let own = local.map(|part| Grid::new(part.tables.tables())).transpose()?;
        let values = local.map_or(&self.sphere.values, |part| &part.values);
        let field = Field::level_fastest(values, self.sphere.layers.count(), Location::Center)?;
        let decompose = |(part, grid): (&MeshPart, &Grid)| Decomposition::new(&mut ranks, grid, &part.cells());
        let decomposition = local.zip(own.as_ref()).map(decompose).transpose()?;
        let own = own.map(|grid| if ranks.size() > 1 { grid.tables_only() } else { grid });
        let grid = own.as_ref().or(self.whole.as_ref()).expect("ranks have parts or the whole grid");
        let mut results = Vec::new();
        for scene in self.scenes.iter().flat_map(|scene| std::iter::repeat_n(scene, self.frames)) {
            let (layers, decomposition) = (&self.sphere.layers, decomposition.as_ref());
            let data = DistributedGrid { grid, decomposition, layers };
            let report = match renderer.render_decomposed(&mut ranks, scene, data, &field)? {
                Rendered::Here(frame) => frame.report,
                Rendered::AtRoot(report) => report,
            };
            results.push(on_frame(&ranks, report));
        }
        Ok(results)
    }
}

/// Writes a row per frame: a printed line and a row of the CSV file.
struct Output<'o> {
    out: &'o mut dyn Write,
    csv: Table,
    size: u32,
    /// For each scene, the seconds of one rank with all data.
    alone: Vec<Option<f64>>,
}

impl Output<'_> {
    fn row(&mut self, transfer: &str, scene: usize, sharing: Sharing, frame: &[RankFrame]) -> Result<()> {
        let (ranks, pixels, busiest_s) = (frame.len(), f64::from(self.size).powi(2), busiest(frame));
        if sharing == Sharing::Tiles && ranks == 1 {
            self.alone[scene] = Some(busiest_s);
        }
        let sharing = format!("{sharing:?}").to_lowercase();
        let speedup = self.alone[scene].map(|alone| alone / busiest_s);
        // The report of the root covers all ranks.
        let root = &frame[0].report;
        let (fragments, received) = (root.counts.fragments as f64, root.ranks.bytes_received as f64);
        let sent = received + root.counts.fragment_bytes as f64;
        let (each, balance) = (ranks as f64, root.ranks.balance);
        let tiles = || frame.iter().map(|rank| rank.report.ranks.tiles);
        let (min, max) = (tiles().min().unwrap_or(0), tiles().max().unwrap_or(0));
        let compose_s = frame.iter().fold(0.0, |max: f64, rank| max.max(rank.report.ranks.compose_s));
        let copied: f64 = frame.iter().map(|rank| rank.report.bytes_copied as f64).sum();
        let copy_s = frame.iter().fold(0.0, |max: f64, rank| max.max(rank.report.timing.copy_s));
        let speedup = speedup.map_or_else(String::new, number);
        let mut cells = vec![transfer.to_owned(), sharing, ranks.to_string()];
        cells.extend([number(busiest_s), speedup]);
        let numbers = [balance, min as f64, max as f64, fragments / each, fragments / pixels];
        let of_bytes = [sent / each, sent / pixels, received, compose_s, copied / each, copy_s];
        cells.extend(numbers.into_iter().chain(of_bytes).map(number));
        say!(self.out, "{}", self.csv.row(&cells)?)
    }
}
