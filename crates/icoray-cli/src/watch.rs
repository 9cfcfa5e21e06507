//! `icoray watch`: draws the files of a directory as a model writes them.
//!
//! A time is drawn once, as soon as it is whole, unless its pictures exist: a watch that is started again continues.

mod folder;
mod page;
mod plan;
mod session;
mod viewers;

use crate::failure::CommandResult;
use crate::input::{self, DataOptions, LayerOption};
use crate::overrides::Overrides;
use crate::ranks::RankTeam;
use crate::render::Target;
use crate::{gpu, isolated};
use folder::Folder;
use glob::Pattern;
use icoray::{Error, ErrorKind, Renderer, Result, Script};
use icoray_dataset::{Mesh, Series};
use icoray_progress::Progress;
use page::Page;
use plan::{History, Lacking, Moment, TimeId};
use session::Session;
use std::collections::{HashMap, HashSet};
use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

/// Arguments of `icoray watch`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  icoray watch RUN --files 'history.*.nc' --mesh init.nc --scene scene.toml -o pictures"
)]
pub struct Args {
    /// Directory that the model writes to
    #[arg(value_name = "DIR")]
    directory: PathBuf,
    /// Names of the files to draw, with * and ?; those that begin with a dot are never taken
    #[arg(long, value_name = "NAMES", default_value = "*.nc", value_parser = Pattern::new)]
    files: Pattern,
    /// File with what the files lack: the mesh, as in the run's init or grid file, or the heights of layers; may be
    /// given several times. It is taken not to change
    #[arg(long, value_name = "MESH.nc")]
    mesh: Vec<PathBuf>,
    #[command(flatten)]
    data_options: DataOptions,
    /// The scene file
    #[arg(long, value_name = "SCENE.toml")]
    scene: PathBuf,
    /// Directory for pictures, named by the scene or else by date and time's number, and for report.csv
    #[arg(short, long, value_name = "DIR", default_value = ".", hide_default_value = true)]
    output: PathBuf,
    /// Draw also times whose pictures exist when the watch begins
    #[arg(long)]
    redraw: bool,
    /// Time between two looks at the directory
    #[arg(long, value_name = "SECONDS", default_value = "5", value_parser = seconds)]
    poll: Duration,
    /// Time without a change of a file after which its last time is taken to be whole
    #[arg(long, value_name = "SECONDS", default_value = "5", value_parser = seconds)]
    settle: Duration,
    /// End when no file has changed and nothing was drawn for this time
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    until_idle: Option<Duration>,
    /// End when all files have settled and their whole times are drawn
    #[arg(long)]
    once: bool,
    /// Serve a page on this machine's loopback address that shows each picture, and on which the scene is changed by
    /// hand; not with options that change the scene
    #[arg(long)]
    live: bool,
    /// Port of that page; another one if it is taken [default: 8750 or the next that is free]
    #[arg(long, value_name = "PORT", requires = "live", value_parser = clap::value_parser!(u16).range(1..))]
    port: Option<u16>,
    #[command(flatten)]
    overrides: Overrides,
    #[command(flatten)]
    layer_option: LayerOption,
    /// Print all lines of a picture's summary
    #[arg(short, long)]
    verbose: bool,
    /// Number of threads; 0 is as many as there are cores to use
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
}

fn seconds(text: &str) -> std::result::Result<Duration, String> {
    let number = text.parse().ok().filter(|number| (0.0..=1e9).contains(number));
    number.map(Duration::from_secs_f64).ok_or_else(|| "expected a number of seconds".to_owned())
}

/// A watch that goes on.
struct Watch<'a> {
    args: &'a Args,
    script: Script,
    /// The fields that the script needs.
    needed: Vec<String>,
    target: &'a Target,
    renderer: &'a Renderer,
    progress: &'a Progress,
    folder: Folder,
    history: History,
    /// The time of each picture's name.
    names: HashMap<PathBuf, TimeId>,
    /// Sentences that were printed.
    printed: HashSet<String>,
    /// When a file changed or a time was drawn.
    last_event: Instant,
    page: Option<Page>,
}

/// Draws until it is interrupted, or nothing happens for long enough.
pub fn run(args: &Args, out: &mut impl Write) -> CommandResult {
    isolated::switch_locks_off()?;
    if RankTeam::new()?.ranks().size() > 1 {
        let context = "icoray watch draws on one rank, expected it to be started without mpirun";
        return Err(Error::new(ErrorKind::Unsupported, context).into());
    }
    let Some(script) = args.script()? else {
        return Ok(writeln!(out, "note      nothing is drawn: {} has no keys", args.scene.display())?);
    };
    args.mesh.iter().try_for_each(|path| isolated::try_record(path, 0, &[]))?;
    let progress = Progress::new();
    let renderer = gpu::renderer(args.threads)?.with_progress(progress.tiles());
    let target = Target::directory(&args.output)?;
    let page = args.page(&script)?;
    let mut watch = Watch {
        args,
        needed: script.model_fields(),
        script,
        target: &target,
        renderer: &renderer,
        progress: &progress,
        folder: Folder::new(&args.directory, args.files.clone(), args.settle),
        history: History::default(),
        names: HashMap::new(),
        printed: HashSet::new(),
        last_event: Instant::now(),
        page,
    };
    watch.folder.look(Instant::now())?;
    let count = watch.folder.files().count();
    writeln!(out, "watch     {}: {count} files {}", args.directory.display(), args.files)?;
    if let Some(page) = &watch.page {
        writeln!(out, "live      {}", page.view.address())?;
    }
    out.flush()?;
    let mut next = watch.next(None, out)?;
    while let Some(mut session) = next.take() {
        let mesh = session.file.shared_mesh();
        let grid = match renderer.run(|| mesh.grid()) {
            Ok(grid) => grid,
            Err(error) => {
                session.moments.iter().try_for_each(|moment| watch.fail(moment, error.clone(), out))?;
                next = watch.next(None, out)?;
                continue;
            }
        };
        next = loop {
            watch.draw(&session, &grid, out)?;
            // The files are closed before the next ones are waited for.
            drop(session);
            session = match watch.next(Some(&mesh), out)? {
                Some(following) if following.file.mesh().is_same(&mesh) => following,
                other => break other,
            };
        };
    }
    watch.finish(out)
}

impl Args {
    /// The script of the scene file with the command's changes; `None` if the scene has no keys.
    fn script(&self) -> Result<Option<Script>> {
        let Some(mut script) = input::script(&self.scene)? else { return Ok(None) };
        if script.lacks_field() {
            let context = format!("{}: expected a field in the scene: the files have several", self.scene.display());
            return Err(Error::new(ErrorKind::Scene, context));
        }
        self.overrides.apply(&mut script)?;
        script.name_by_date();
        Ok(Some(script))
    }

    /// The page of `--live`.
    fn page(&self, script: &Script) -> Result<Option<Page>> {
        if !self.live {
            return Ok(None);
        }
        self.overrides.expect_none()?;
        Page::open(&self.directory, self.port, input::scene_text(&self.scene)?, script).map(Some)
    }
}

impl Watch<'_> {
    /// Waits until times are whole and opens their files; `None` when the watch ends.
    fn next(&mut self, known: Option<&Arc<Mesh>>, out: &mut impl Write) -> CommandResult<Option<Session>> {
        loop {
            let now = Instant::now();
            match self.folder.look(now) {
                Ok(true) => self.last_event = now,
                Ok(false) => (),
                Err(error) => self.print_once(&format!("skipped   {}", error.context()), out)?,
            }
            self.progress.wait(format!("watching {}", self.args.directory.display()));
            for error in self.folder.read_outlines(now) {
                let context = error.context();
                self.print_once(&format!("skipped   {context}; it is read again when it changes"), out)?;
            }
            let (folder, settle) = (&self.folder, self.args.settle);
            let (open, lacking) = plan::open_times(folder, &self.needed, &mut self.history, now, settle);
            let moments = self.undrawn(open, out)?;
            if !moments.is_empty() {
                self.last_event = now;
                if let Some(session) = self.open(moments, known, out)? {
                    return Ok(Some(session));
                }
                continue;
            }
            let has_settled = self.folder.has_settled(now);
            if has_settled {
                self.print_lacking(&lacking, out)?;
            }
            if self.hears_viewers() {
                if let Some(session) = self.for_viewers(known) {
                    return Ok(Some(session));
                }
                continue;
            }
            let is_idle = self.args.until_idle.is_some_and(|idle| now.duration_since(self.last_event) >= idle);
            if is_idle || self.args.once && has_settled {
                return Ok(None);
            }
            match &self.page {
                Some(page) => page.view.wait(self.args.poll),
                None => thread::sleep(self.args.poll),
            }
        }
    }

    /// The first of the times that have no pictures, with those after it that are read from the same files.
    fn undrawn(&mut self, open: Vec<Moment>, out: &mut impl Write) -> CommandResult<Vec<Moment>> {
        let (mut moments, mut kept): (Vec<Moment>, usize) = (Vec::new(), 0);
        for moment in open {
            if moments.first().is_some_and(|first| !first.shares_files(&moment)) {
                break;
            }
            match self.names_of(&moment) {
                Ok(names) => {
                    self.expect_own(&moment, &names)?;
                    let is_there = !self.args.redraw && names.iter().all(|name| name.exists());
                    if names.is_empty() || is_there && !moment.is_replaced {
                        kept += usize::from(!names.is_empty());
                        self.history.is_drawn(&moment);
                    } else {
                        moments.push(moment);
                    }
                }
                Err(error) => self.skip(&moment, &error, out)?,
            }
        }
        if kept > 0 {
            let text = format!("kept      {kept} times have their pictures already");
            self.progress.suspend(|| writeln!(out, "{text}"))?;
        }
        Ok(moments)
    }

    fn skip(&mut self, moment: &Moment, error: &Error, out: &mut impl Write) -> CommandResult {
        self.history.has_failed(moment, error.context().to_owned());
        self.print_once(&format!("skipped   {}: {}", moment.id, error.context()), out)
    }

    /// The pictures of a time, as far as they are known before it is read.
    fn names_of(&self, moment: &Moment) -> Result<Vec<PathBuf>> {
        let first = &moment.sources[0];
        let Some(outline) = self.folder.file(&first.path).and_then(|file| file.outline.as_ref()) else {
            return Ok(Vec::new());
        };
        let (dates, seconds) = (&outline.times.dates, outline.times.seconds.clone());
        let series = Series { script: &self.script, dates, times: Vec::new(), is_scheduled: true, seconds };
        let stamp = series.stamp(first.record);
        let shots = series.scheduled(first.record).into_iter().flat_map(|view| view.shots(&stamp));
        shots.map(|shot| self.target.path(&shot.scene.output, &stamp, shot.scene.field())).collect()
    }

    /// Fails where another time has a picture of the same name.
    fn expect_own(&mut self, moment: &Moment, names: &[PathBuf]) -> Result<()> {
        for name in names {
            let owner = self.names.entry(name.clone()).or_insert_with(|| moment.id.clone());
            if *owner != moment.id {
                let context = format!(
                    "output.file names the pictures of {owner} and of {} both {}, expected a date in it, or --files for fewer \
                     files",
                    moment.id,
                    name.display()
                );
                return Err(Error::new(ErrorKind::Scene, context));
            }
        }
        Ok(())
    }

    /// Prints which fields no file has, each once.
    fn print_lacking(&mut self, lacking: &[Lacking], out: &mut impl Write) -> CommandResult {
        let at_a_time = lacking.iter().map(|Lacking { id, field, files }| {
            let files: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
            (field, format!("{id}: {field} is in none of the files that have it: {}", files.join(", ")))
        });
        let outlines: Vec<_> = self.folder.files().filter_map(|file| file.outline.as_ref()).collect();
        let is_absent = |field: &&String| !outlines.is_empty() && outlines.iter().all(|outline| !outline.has(field));
        let directory = self.args.directory.display();
        let absent = self.needed.iter().filter(is_absent);
        let absent = absent.map(|field| (field, format!("{field} is in none of the files of {directory} so far")));
        for (field, what) in at_a_time.chain(absent) {
            if self.printed.insert(format!("lacks {field}")) {
                self.progress.suspend(|| writeln!(out, "waits     {what}"))?;
            }
        }
        Ok(())
    }

    fn print_once(&mut self, sentence: &str, out: &mut impl Write) -> CommandResult {
        if self.printed.insert(sentence.to_owned()) {
            self.progress.suspend(|| writeln!(out, "{sentence}"))?;
        }
        Ok(())
    }

    /// Prints which times were not drawn.
    fn finish(&self, out: &mut impl Write) -> CommandResult {
        self.progress.finish();
        for (id, reason) in self.history.failures() {
            writeln!(out, "not drawn {id}: {reason}")?;
        }
        let cut_off = plan::cut_off(&self.folder, &self.needed);
        for (id, file) in cut_off.filter(|(id, _)| !self.history.has(id)) {
            writeln!(out, "not drawn {id}: {} ends before it", file.path.display())?;
        }
        Ok(())
    }
}
