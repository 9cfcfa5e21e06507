//! Opening and drawing of times that are read from the same files.

use super::Watch;
use super::plan::{Moment, TimeId};
use crate::failure::{CommandResult, Failure};
use crate::isolated;
use crate::render::{Job, OutputQueue, Pictures, print_blocks, print_notes};
use icoray::output::Existing;
use icoray::{Error, ErrorKind, Grid, Ranks, Result, Shot};
use icoray_dataset::{Dataset, Drawing, FieldInfo, Mesh, SceneFields, Series};
use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

/// Times of the same files, and these files.
pub struct Session {
    pub moments: Vec<Moment>,
    pub file: Dataset,
    open_s: f64,
    /// Whether its time was drawn before and is drawn again for viewers alone.
    is_for_viewers: bool,
}

/// Whether an error is one of the files, so that others may do.
fn is_of_files(error: &Error) -> bool {
    use ErrorKind::{Field, Grid, Io, Layers, Unsupported};
    matches!(error.kind(), Field | Grid | Io | Layers | Unsupported)
}

impl Watch<'_> {
    /// Opens the files of the first of these times that can be read; `known` is the mesh of the files before.
    pub fn open(
        &mut self,
        moments: Vec<Moment>,
        known: Option<&Arc<Mesh>>,
        out: &mut impl Write,
    ) -> CommandResult<Option<Session>> {
        let start = Instant::now();
        let first = &moments[0];
        self.progress.stage(format!("reading {}", first.sources[0].path.display()));
        if let Err(error) = self.try_reading(first, &[]) {
            return self.fail(first, error, out).map(|()| None);
        }
        match self.model_file(first, known) {
            Ok(file) => {
                let open_s = start.elapsed().as_secs_f64();
                Ok(Some(Session { moments, file, open_s, is_for_viewers: false }))
            }
            Err(error) => moments.iter().try_for_each(|moment| self.fail(moment, error.clone(), out)).map(|()| None),
        }
    }

    /// Reads the time, and `more` fields than the scene needs, in a child first, where that is needed.
    fn try_reading(&self, moment: &Moment, more: &[String]) -> Result<()> {
        let fields = [&self.needed[..], more].concat();
        moment.sources.iter().try_for_each(|source| isolated::try_record(&source.path, source.record, &fields))
    }

    fn model_file(&self, moment: &Moment, known: Option<&Arc<Mesh>>) -> Result<Dataset> {
        // Heights that a file lacks, and the mesh where it has none, may be in those that it is joined with.
        let others_of = |own: &PathBuf| {
            let joined = moment.sources.iter().map(|source| &source.path).filter(|path| *path != own);
            self.args.mesh.iter().chain(joined).collect::<Vec<_>>()
        };
        let first = &moment.sources[0].path;
        let open = |path: &PathBuf, others: &[&PathBuf], mesh: Option<&Arc<Mesh>>| {
            icoray_netcdf::open_all(&[path], others, mesh.cloned(), self.args.data_options.options())
        };
        let own_mesh: Vec<_> = self.args.mesh.iter().collect();
        let given = known.filter(|mesh| self.args.mesh.iter().any(|path| path == mesh.path()));
        let mut file = match given {
            Some(mesh) => open(first, &others_of(first), Some(mesh))?,
            None => match open(first, &own_mesh, None) {
                Ok(alone) if moment.sources.len() == 1 => return Ok(alone),
                Ok(alone) => open(first, &others_of(first), Some(&alone.shared_mesh()))?,
                Err(_) if moment.sources.len() > 1 => open(first, &others_of(first), None)?,
                Err(error) => return Err(error),
            },
        };
        for source in &moment.sources[1..] {
            file.join(open(&source.path, &others_of(&source.path), Some(&file.shared_mesh()))?)?;
        }
        Ok(file)
    }

    /// The files of a time that was drawn, for a scene with `more` fields.
    pub fn reopened(&self, moment: Moment, known: Option<&Arc<Mesh>>, more: &[String]) -> Result<Session> {
        self.try_reading(&moment, more)?;
        let file = self.model_file(&moment, known)?;
        Ok(Session { moments: vec![moment], file, open_s: 0.0, is_for_viewers: true })
    }

    /// Notes that a time cannot be drawn from its files as they are; fails where no file would do.
    pub fn fail(&mut self, moment: &Moment, error: Error, out: &mut impl Write) -> CommandResult {
        if !is_of_files(&error) {
            return Err(error.into());
        }
        if !moment.is_unchanged() {
            self.ask_again(moment);
            return Ok(());
        }
        self.history.has_failed(moment, error.context().to_owned());
        self.print_once(&format!("skipped   {}; it is read again when it changes", error.context()), out)
    }

    /// Leaves a time whose files have changed to the next look.
    fn ask_again(&mut self, moment: &Moment) {
        moment.paths().for_each(|path| self.folder.ask_for(path));
    }

    /// Draws the times of a session on the checked grid of its mesh.
    pub fn draw(&mut self, session: &Session, grid: &Grid, out: &mut impl Write) -> CommandResult {
        if session.is_for_viewers {
            return self.draw_for_viewers(session, grid, out);
        }
        let Session { moments, file, open_s, .. } = session;
        let (args, target, renderer, progress) = (self.args, self.target, self.renderer, self.progress);
        let mut script = self.script.clone();
        script.show_as_surfaces(|name| file.field_info(name).is_ok_and(FieldInfo::is_2d));
        let times = moments.iter().map(|moment| moment.sources[0].record).collect();
        let series = Series::of(file, &script, times, true);
        let read: Result<_> = renderer.run(|| {
            let scene_fields = SceneFields::new(file, &script, &args.layer_option.layers)?;
            let notes = scene_fields.all_notes(&script)?;
            Ok((scene_fields, notes))
        });
        let (scene_fields, notes) = match read {
            Ok(read) => read,
            Err(error) => {
                return moments.iter().try_for_each(|moment| self.fail(moment, error.clone(), out));
            }
        };
        let unknown: Vec<String> = notes.into_iter().filter(|note| self.printed.insert(note.clone())).collect();
        progress.suspend(|| print_notes(&unknown, out))?;
        let queue = OutputQueue::new(target, Existing::Overwrite, None)?;
        if let Some(page) = &self.page {
            queue.pass_on(page.shows());
        }
        let mut queue = Some(queue);
        let drawing = Drawing { scene_fields: &scene_fields, grid, renderer };
        let job = Job { drawing, target, open_s: *open_s, is_verbose: args.verbose };
        let mut pictures = Pictures::new(&series, job, progress);
        let mut ranks = Ranks::alone();
        for (number, moment) in moments.iter().enumerate() {
            let time = moment.sources[0].record;
            let is_same = match &moment.id {
                TimeId::Date(date) => file.times().get(time).is_some_and(|its| its.as_ref() == Some(date)),
                TimeId::Record(..) => true,
            };
            if !is_same || !moment.is_valid() {
                self.ask_again(moment);
                continue;
            }
            let tried = if number == 0 { Ok(()) } else { self.try_reading(moment, &[]) };
            let due = match tried.and_then(|()| pictures.read(time)) {
                Ok(due) => due,
                Err(error) => {
                    self.fail(moment, error, out)?;
                    continue;
                }
            };
            if let Some(field) = due.read.unwritten() {
                self.history.has_failed(moment, format!("{field} has no values yet"));
                continue;
            }
            if !moment.is_valid() {
                self.ask_again(moment);
                continue;
            }
            let stamp = series.stamp(time);
            let wants = |shot: &Shot| {
                let path = target.path(&shot.scene.output, &stamp, shot.scene.field());
                moment.is_replaced || args.redraw || path.is_ok_and(|path| !path.exists())
            };
            match pictures.draw(&due, wants, &mut queue, out, &mut ranks) {
                Ok(()) => {
                    self.history.is_drawn(moment);
                    if let Some(page) = &mut self.page {
                        page.last = Some(moment.clone());
                    }
                }
                // Files were read: an error of the disk is one of a picture.
                Err(Failure::Icoray(error)) if is_of_files(&error) && error.kind() != ErrorKind::Io => {
                    self.fail(moment, error, out)?;
                }
                Err(failure) => return Err(failure),
            }
            self.last_event = Instant::now();
        }
        let blocks = queue.map_or_else(Vec::new, OutputQueue::finish);
        print_blocks(blocks, progress, out)
    }
}
