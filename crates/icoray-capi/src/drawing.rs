//! Frames on their way: drawn in the call or by a thread, written by another, and what became of them.

use crate::borrow::argument;
use crate::boundary::{Failure, Outcome};
use crate::context::Subject;
use crate::host::without_signals;
use crate::log::{Level, Log};
use crate::policy::Policy;
use crate::types::{icoray_config, icoray_frame_report, icoray_status};
use icoray_core::output::{Stamp, Writer};
use icoray_core::{
    Backend, Background, Error, Fields, Frame, FrameReport, Job, Ranks, Renderer, Scene, Script,
};
use std::sync::Arc;
use std::thread::{ThreadId, current};

mod devices;
mod errors;
mod options;
mod report;
mod together;

use devices::Devices;
use errors::Errors;

/// The threads of a context, and the frames that they have.
pub(crate) struct Drawing {
    renderer: Arc<Renderer>,
    writer: Arc<Writer>,
    /// The thread that opened the context: MPI may be called there.
    home: ThreadId,
    /// Whether the config says that frames are drawn while the model goes on.
    is_async: bool,
    /// Does that; over several ranks once they have joined.
    background: Option<Background>,
    policy: Policy,
    /// Whether this process has the writer's news: it is rank 0.
    is_root: bool,
    /// With several ranks: what they last agreed on.
    is_on_for_all: Option<bool>,
    log: Log,
    devices: Devices,
    errors: Errors,
    /// The first failure that no call has told of.
    untold: Option<Failure>,
    last: Option<(Stamp, FrameReport)>,
    /// Of the call whose frame that is.
    call: Call,
    /// Whether the call has yet to draw its first frame.
    is_new_call: bool,
    /// The step that the background draws, and what handing it over cost the model.
    handed_over: Option<(i64, f64)>,
    totals: Totals,
}

/// Of the frames that one call has drawn.
#[derive(Debug, Clone, Copy, Default)]
struct Call {
    frames: u64,
    waited_s: f64,
    copy_s: f64,
    bytes_copied: u64,
}

/// Of all frames so far.
#[derive(Debug, Clone, Copy, Default)]
struct Totals {
    written: u64,
    failed: u64,
    dropped: u64,
    host_s: f64,
    write_s: f64,
    /// Of the frame that was drawn last.
    last_host_s: f64,
    /// Of the frame that was written last.
    last_write_s: f64,
}

impl Call {
    fn add(&mut self, report: &FrameReport) {
        self.frames += 1;
        self.waited_s += report.waited_s;
        self.copy_s += report.copy_s;
        self.bytes_copied += report.bytes_copied;
    }
}

impl Drawing {
    /// `threads` is the number of threads where the config has none.
    pub fn new(config: &icoray_config, output_dir: &str, ranks: &Ranks, threads: usize) -> Outcome<Self> {
        let asked = usize::try_from(config.threads).ok().filter(|n| *n <= 4096).ok_or_else(|| {
            argument(format!("icoray_config.threads: {}, expected 0 to 4096", config.threads))
        })?;
        let threads = if asked == 0 { threads } else { asked };
        let options = options::of_writer(config, output_dir)?;
        let policy = Policy::new(config, ranks.is_root())?;
        if !Log::LEVELS.contains(&config.log_level) {
            return Err(argument(format!("icoray_config.log_level: {}, expected 0 to 4", config.log_level)));
        }
        let log = Log::new(config.log, config.log_user, config.log_level);
        let (renderer, writer, background) = without_signals(|| -> Outcome<_> {
            let renderer = Renderer::new(threads)?;
            #[cfg(feature = "gpu")]
            let renderer = renderer.with_devices(Arc::new(icoray_gpu::Gpus));
            let renderer = Arc::new(renderer);
            let writer = Arc::new(Writer::new(options)?);
            let is_begun = config.async_render != 0 && ranks.is_alone();
            let draws = is_begun.then(|| Background::new(renderer.clone(), writer.clone()));
            Ok((renderer, writer, draws.transpose()?))
        })?;
        let (untold, last, handed_over, totals) = (None, None, None, Totals::default());
        let is_on_for_all = (!ranks.is_alone()).then_some(true);
        Ok(Drawing {
            renderer,
            writer,
            home: current().id(),
            is_async: config.async_render != 0,
            background,
            policy,
            is_root: ranks.is_root(),
            is_on_for_all,
            log,
            devices: Devices::default(),
            errors: Errors::default(),
            untold,
            last,
            call: Call::default(),
            is_new_call: false,
            handed_over,
            totals,
        })
    }

    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// Whether frames are still drawn.
    pub fn is_on(&self) -> bool {
        self.is_on_for_all.unwrap_or(self.policy.is_on())
    }

    pub fn refuse_if_off(&self) -> Outcome<()> {
        self.policy.refuse_if_off()
    }

    /// Whether the log takes warnings.
    pub fn is_warned(&self) -> bool {
        self.log.takes(Level::Warn)
    }

    pub fn warn(&self, message: &str) {
        self.log.say(Level::Warn, message);
    }

    /// Refuses a directory in which no picture could be written. Only who writes need ask.
    pub fn check_directory(&self) -> Outcome<()> {
        Ok(self.writer.check_directory()?)
    }

    /// Refuses names that no picture could have, by those of each view's first one. Only who writes need ask.
    pub fn check_folders(&self, script: &Script) -> Outcome<()> {
        let stamp = Stamp { date: Some("0001-01-01_00:00:00".into()), ..Stamp::default() };
        for shot in script.views().iter().filter_map(|view| view.shots(&stamp).next()) {
            let checked = self.writer.check_folders(&shot.scene.output, &stamp, &shot.scene.field);
            let named = |failure: Failure| match shot.name.as_str() {
                "" => failure,
                name => failure.within(format_args!("view {name:?}")),
            };
            checked.map_err(|error| named(error.into()))?;
        }
        Ok(())
    }

    /// Whether frames are to be drawn while the model goes on.
    pub fn is_async(&self) -> bool {
        self.is_async
    }

    /// Whether a thread draws while the model goes on.
    pub fn is_in_background(&self) -> bool {
        self.background.is_some()
    }

    /// The model has called for the frames of a step.
    pub fn begin_call(&mut self) {
        self.is_new_call = true;
    }

    /// The call returns after so many seconds.
    pub fn end_call(&mut self, host_s: f64) {
        self.totals.host_s += host_s;
        match &mut self.handed_over {
            Some((_, seconds)) if self.background.is_some() && !self.is_new_call => *seconds = host_s,
            _ if !self.is_new_call => self.totals.last_host_s = host_s,
            _ => {}
        }
    }

    /// Whether a frame's files may be made. Only who writes need ask.
    pub fn check_names(&self, scene: &Scene, stamp: &Stamp) -> Outcome<()> {
        self.writer.check(&scene.output, stamp, &scene.field)?;
        Ok(())
    }

    /// Draws a frame, or what is this rank's of it, and queues it to be written.
    pub fn draw(&mut self, ranks: &mut Ranks, stamp: &Stamp, subject: Subject) -> Outcome<()> {
        self.devices.is_asked = subject.scene.backend == Backend::Gpu;
        if !ranks.is_alone() {
            return self.draw_together(ranks, stamp, subject);
        }
        // What one process holds is the whole grid and fields.
        let Subject { view, scene, grid, held: _, layers, fields, description, descriptions } = subject;
        let mut frame = self.renderer.render(&scene, &grid, &layers, fields)?;
        (frame.description, frame.descriptions) = (description, descriptions);
        frame.notes.extend(notes(view));
        self.hand_on(frame, &scene, stamp);
        Ok(())
    }

    /// Hands the frames of a step to the background, if any; what is wrong with some of them keeps none of the others.
    /// Collective.
    pub fn hand_over(
        &mut self,
        ranks: &mut Ranks,
        subjects: Vec<Subject>,
        stamp: &Stamp,
    ) -> Outcome<Vec<Failure>> {
        let (Some(background), false) = (&mut self.background, subjects.is_empty()) else {
            return Ok(Vec::new());
        };
        self.devices.is_asked = subjects.iter().any(|subject| subject.scene.backend == Backend::Gpu);
        let (mut jobs, mut views, mut all) = (Vec::new(), Vec::new(), Fields::default());
        for Subject { view, scene, grid, held, layers, fields, description, descriptions } in subjects {
            all = all.with(fields);
            views.push(view.clone());
            let (stamp, notes) = (stamp.clone(), notes(view).into_iter().collect());
            jobs.push(Job { scene, grid, held, layers, stamp, description, descriptions, notes });
        }
        let (count, mut refused) = (jobs.len(), Vec::new());
        let accepted = background.submit_all(ranks, jobs, all, &mut refused);
        // The frames before were waited for; their cost is to be taken before these ones' takes its place.
        self.collect();
        if refused.len() < count {
            accepted.map_err(|error| Failure::from(error).at_step(stamp.step))?;
            (self.handed_over, self.is_new_call) = (Some((stamp.step, 0.0)), false);
        }
        let failures = refused.into_iter();
        Ok(failures
            .map(|(number, error)| Failure::from(error).of_picture(&views[number], stamp.step))
            .collect())
    }

    /// A picture of this call failed. That a file is not to be modified is as the user asked for.
    pub fn picture_failed(&mut self, failure: &Failure) {
        use icoray_status::{ICORAY_ERR_DISABLED, ICORAY_ERR_EXISTS};
        if ![ICORAY_ERR_DISABLED, ICORAY_ERR_EXISTS].contains(&failure.status) {
            self.fail(failure);
        }
    }

    /// A frame that is drawn goes to the writer.
    fn hand_on(&mut self, frame: Frame, scene: &Scene, stamp: &Stamp) {
        let mut report = frame.report.clone();
        self.devices.tell(stamp, &report, &self.log);
        let view = frame.notes.iter().find(|(key, _)| *key == "view").map(|(_, view)| view.as_str());
        self.errors.tell(view, stamp, &report, &self.log);
        self.describe(stamp, &report);
        let submitted = self.writer.submit(frame, scene.output.clone(), stamp.clone());
        report.waited_s = submitted.waited_s;
        self.drop_frame(submitted.dropped.as_ref());
        self.drew(stamp, report);
    }

    /// A frame of this call is drawn.
    fn drew(&mut self, stamp: &Stamp, report: FrameReport) {
        if std::mem::take(&mut self.is_new_call) {
            self.call = Call::default();
        }
        self.call.add(&report);
        self.last = Some((stamp.clone(), report));
    }

    /// Takes in what became of the frames of before.
    pub fn collect(&mut self) {
        // What is written by now was drawn before what was drawn last.
        let written = self.writer.take_outcomes();
        self.totals.written += written.more_done;
        self.totals.failed += written.more_failed;
        for written in written.kept {
            self.totals.write_s += written.write_s;
            self.totals.last_write_s = written.write_s;
            match written.result {
                Ok(path) => {
                    self.totals.written += 1;
                    self.policy.succeeded();
                    if self.log.takes(Level::Info) {
                        let (step, seconds) = (written.stamp.step, written.write_s);
                        self.log
                            .say(Level::Info, &format!("step {step}: {} ({seconds:.3} s)", path.display()));
                    }
                }
                Err(error) => self.fail_late(&written.stamp, error),
            }
        }
        if let Some(background) = &mut self.background {
            let drawn = background.take_outcomes();
            self.totals.failed += drawn.more_failed;
            for drawn in drawn.kept {
                self.drop_frame(drawn.dropped.as_ref());
                if drawn.is_first {
                    self.call = Call::default();
                }
                match drawn.result {
                    Ok(report) => {
                        self.devices.tell(&drawn.stamp, &report, &self.log);
                        self.errors.tell(drawn.view.as_deref(), &drawn.stamp, &report, &self.log);
                        self.describe(&drawn.stamp, &report);
                        self.call.add(&report);
                        self.last = Some((drawn.stamp, report));
                    }
                    // Rank 0 tells all of it.
                    Err(error) if drawn.is_of_all && !self.is_root => {
                        self.fail(&Failure::from(error).at_step(drawn.stamp.step));
                    }
                    Err(error) => self.fail_late(&drawn.stamp, error),
                }
            }
            self.call.frames += drawn.more_done;
        }
        let is_last = |step: i64| self.last.as_ref().is_some_and(|(stamp, _)| stamp.step == step);
        if let Some((_, host_s)) = self.handed_over.take_if(|(step, _)| is_last(*step)) {
            self.totals.last_host_s = host_s;
        }
    }

    fn describe(&self, stamp: &Stamp, report: &FrameReport) {
        if self.log.takes(Level::Debug) {
            let (step, left_out) = (stamp.step, report.left_out.join("; "));
            let seconds = report.prepare_s + report.render_s;
            let shared =
                report.sharing.map_or_else(String::new, |sharing| format!(" over ranks ({sharing})"));
            let line = format!("step {step}: drawn in {seconds:.3} s{shared}, left out: {left_out}");
            self.log.say(Level::Debug, &line);
        }
    }

    /// A frame of an earlier call failed.
    fn fail_late(&mut self, stamp: &Stamp, error: Error) {
        let failure = Failure::from(error).at_step(stamp.step);
        self.fail(&failure);
        // A call tells of one, of the first or of a bug, which ends the context; the log tells of all.
        let is_bug = failure.status == icoray_status::ICORAY_ERR_INTERNAL;
        let other = match &mut self.untold {
            untold @ None => untold.replace(failure),
            Some(first) if is_bug => Some(std::mem::replace(first, failure)),
            Some(_) => Some(failure),
        };
        if let Some(other) = other {
            self.policy.log_failure(&other, &self.log);
        }
    }

    fn fail(&mut self, failure: &Failure) {
        self.totals.failed += 1;
        self.policy.failed(failure, &self.log);
    }

    fn drop_frame(&mut self, dropped: Option<&Stamp>) {
        if let Some(stamp) = dropped {
            self.totals.dropped += 1;
            let message = format!("step {}: dropped, the writer is behind", stamp.step);
            self.log.say(Level::Warn, &message);
        }
    }

    /// The failure that is due to be told.
    pub fn tell(&mut self) -> Outcome<()> {
        self.untold.take().map_or(Ok(()), Err)
    }

    pub fn log_failure(&self, failure: &Failure) {
        self.policy.log_failure(failure, &self.log);
    }

    /// Waits until no thread reads the model's tables.
    pub fn finish_rendering(&mut self) {
        if let Some(background) = &mut self.background {
            background.wait();
        }
    }

    /// Waits until all is on disk.
    pub fn finish(&mut self) -> Outcome<()> {
        self.finish_rendering();
        self.writer.wait();
        self.collect();
        self.tell()
    }

    pub fn report(&mut self) -> Outcome<icoray_frame_report> {
        self.collect();
        let none = || Failure::new(icoray_status::ICORAY_ERR_ORDER, "no frame has been rendered yet");
        let (stamp, report) = self.last.as_ref().ok_or_else(none)?;
        Ok(report::crossing(stamp, report, &self.call, &self.totals))
    }
}

/// What else a picture's file says.
fn notes(view: String) -> Option<(&'static str, String)> {
    (!view.is_empty()).then_some(("view", view))
}
