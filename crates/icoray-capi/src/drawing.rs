//! Rendering and writing of frames: in the call or on a background thread, with their outcomes and totals.

use crate::borrow::config_error;
use crate::boundary::{Failure, Outcome};
use crate::host::without_signals;
use crate::log::{Level, Log};
use crate::memory;
use crate::policy::{Policy, writer_options};
use crate::types::{icoray_config, icoray_frame_report, icoray_status};
use icoray_core::output::{Stamp, Writer};
use icoray_core::{
    Backend, Background, Error, Frame, FrameInputs, FrameReport, FrameSetup, Quality, Ranks, Rendered, Renderer, Scene,
    Script,
};
use std::sync::Arc;
use std::thread::{ThreadId, current};

mod collective;
mod devices;
mod errors;

pub(crate) use collective::RootState;
use devices::DeviceLog;
use errors::ErrorWarnings;

/// A key and a text in a picture's file.
type Note = (&'static str, String);

/// Renderer, writer and background thread of a context, with what they report.
pub(crate) struct Drawing {
    renderer: Arc<Renderer>,
    writer: Arc<Writer>,
    /// The thread that opened the context, on which MPI may be called.
    opening_thread: ThreadId,
    /// `async_render` of the config.
    is_async: bool,
    /// Renders while the model computes; with several ranks it exists once they have joined.
    background: Option<Background>,
    policy: Policy,
    /// Whether this process is rank 0, which writes the pictures.
    is_root: bool,
    /// With several ranks: whether frames are rendered, as last agreed.
    is_on_for_all: Option<bool>,
    log: Log,
    devices: DeviceLog,
    errors: ErrorWarnings,
    /// The first failure that no call has returned yet.
    unreported: Option<Failure>,
    last: Option<(Stamp, FrameReport)>,
    /// Sums over the frames of the call that `last` belongs to, and over all frames.
    host: icoray_frame_report,
    /// Whether the current call has not rendered a frame yet.
    is_new_call: bool,
    /// The step that the background renders.
    submitted_step: Option<SubmittedStep>,
    /// A note in all pictures from now on.
    pub note: Option<Note>,
    /// What frames cost, where that is asked for.
    costs: Option<Vec<PictureCost>>,
}

/// A step that the background renders.
struct SubmittedStep {
    step: i64,
    /// Seconds that submitting it took the model.
    host_s: f64,
}

/// The time of a frame, from its beginning to its last pixel.
#[cfg_attr(not(feature = "live"), expect(dead_code, reason = "the budgets of viewers alone read it"))]
pub(crate) struct PictureCost {
    /// Name of its view.
    pub view: String,
    pub step: i64,
    pub ms: f64,
    /// Whether it has the fewest pixels that a frame may have.
    pub is_coarsest: bool,
}

impl Drawing {
    /// `threads` is the number of threads where the config has none.
    pub fn new(config: &icoray_config, output_dir: &str, ranks: &Ranks, threads: usize) -> Outcome<Self> {
        let asked = usize::try_from(config.threads).ok().filter(|n| *n <= 4096);
        let asked = asked.ok_or_else(|| config_error("threads", config.threads, "0 to 4096"))?;
        let threads = if asked == 0 { threads } else { asked };
        let options = writer_options(config, output_dir)?;
        let policy = Policy::new(config, ranks.is_root())?;
        if !Log::LEVELS.contains(&config.log_level) {
            return Err(config_error("log_level", config.log_level, "0 to 4"));
        }
        let log = Log::new(config.log, config.log_user, config.log_level);
        let (renderer, writer, background) = without_signals(|| -> Outcome<_> {
            let renderer = Renderer::new(threads)?;
            #[cfg(feature = "gpu")]
            let renderer = renderer.with_devices(Arc::new(icoray_gpu::Gpus));
            let renderer = Arc::new(renderer);
            let writer = Arc::new(Writer::new(options)?);
            let is_begun = config.async_render != 0 && ranks.is_alone();
            let background = is_begun.then(|| Background::new(renderer.clone(), writer.clone()));
            Ok((renderer, writer, background.transpose()?))
        })?;
        let is_on_for_all = (!ranks.is_alone()).then_some(true);
        Ok(Drawing {
            renderer,
            writer,
            opening_thread: current().id(),
            is_async: config.async_render != 0,
            background,
            policy,
            is_root: ranks.is_root(),
            is_on_for_all,
            log,
            devices: DeviceLog::default(),
            errors: ErrorWarnings::default(),
            unreported: None,
            last: None,
            host: icoray_frame_report::default(),
            is_new_call: false,
            submitted_step: None,
            note: None,
            costs: None,
        })
    }

    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// Whether frames are rendered: the context has not switched itself off.
    pub fn is_on(&self) -> bool {
        self.is_on_for_all.unwrap_or(self.policy.is_on())
    }

    pub fn refuse_if_disabled(&self) -> Outcome<()> {
        self.policy.refuse_if_disabled()
    }

    /// Whether warnings are logged.
    pub fn is_warned(&self) -> bool {
        self.log.takes(Level::Warn)
    }

    pub fn warn(&self, message: &str) {
        self.log.say(Level::Warn, message);
    }

    /// Where pictures are written; absolute.
    #[cfg(feature = "live")]
    pub fn directory(&self) -> &std::path::Path {
        &self.writer.options().directory
    }

    /// Gives each frame to `next` once it is written, and keeps what each costs; `None` ends that.
    #[cfg(feature = "live")]
    pub fn pass_frames_on(&mut self, next: Option<Box<dyn FnMut(Frame) + Send>>) {
        self.costs = next.is_some().then(Vec::new);
        self.writer.pass_on(next);
    }

    /// What frames have cost since the last call.
    #[cfg(feature = "live")]
    pub fn take_costs(&mut self) -> Vec<PictureCost> {
        self.costs.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Keeps what a frame costs, if that is asked for.
    fn record_cost(&mut self, view: &str, stamp: &Stamp, report: &FrameReport) {
        let Some(costs) = &mut self.costs else { return };
        let timing = &report.timing;
        costs.push(PictureCost {
            view: view.to_owned(),
            step: stamp.step,
            ms: 1e3 * (timing.copy_s + timing.prepare_s + timing.render_s),
            is_coarsest: report.quality.pixel_step >= Quality::LARGEST_STEP,
        });
    }

    /// Checks that pictures can be written to the output directory. For the writing rank.
    pub fn check_directory(&self) -> Outcome<()> {
        Ok(self.writer.check_directory()?)
    }

    /// Checks the file names of each view's first picture. For the writing rank.
    pub fn check_folders(&self, script: &Script) -> Outcome<()> {
        let stamp = Stamp { date: Some("0001-01-01_00:00:00".into()), ..Stamp::default() };
        for shot in script.views().iter().filter_map(|view| view.shots(&stamp).next()) {
            let checked = self.writer.check_folders(&shot.scene.output, &stamp, shot.scene.field());
            checked.map_err(|error| Failure::from(error).of_view(&shot.name))?;
        }
        Ok(())
    }

    /// Whether the config asks for rendering in the background.
    pub fn is_async(&self) -> bool {
        self.is_async
    }

    /// Whether frames are rendered in the background.
    pub fn is_in_background(&self) -> bool {
        self.background.is_some()
    }

    /// Begins an icoray_execute.
    pub fn begin_call(&mut self) {
        self.is_new_call = true;
    }

    /// Ends an icoray_execute that took `host_s` seconds.
    pub fn end_call(&mut self, host_s: f64) {
        self.host.host_total_s += host_s;
        match &mut self.submitted_step {
            Some(submitted) if self.background.is_some() && !self.is_new_call => submitted.host_s = host_s,
            _ if !self.is_new_call => self.host.host_s = host_s,
            _ => {}
        }
    }

    /// Checks that a frame's files may be written. For the writing rank.
    pub fn check_names(&self, scene: &Scene, stamp: &Stamp) -> Outcome<()> {
        self.writer.check(&scene.output, stamp, scene.field())?;
        Ok(())
    }

    /// Renders a frame, or this rank's share of it, and queues it for the writer. Collective; the outcome is equal on
    /// all ranks.
    pub fn draw(&mut self, ranks: &mut Ranks, FrameInputs { setup, fields }: FrameInputs) -> Outcome<()> {
        self.devices.is_asked = setup.scene.backend == Backend::Gpu;
        let drawn = self.renderer.render_decomposed(ranks, &setup.scene, setup.distributed_grid(), fields);
        match drawn.map_err(|error| Failure::from(error).of_picture(&setup.view, setup.stamp.step))? {
            Rendered::Here(mut frame) => {
                setup.describe(&mut frame);
                self.submit_to_writer(frame, &setup);
            }
            Rendered::AtRoot(report) => {
                self.devices.log_frame(&setup.stamp, &report, &self.log);
                self.log_details(&setup.stamp, &report);
                self.record_frame(&setup.stamp, report);
            }
        }
        Ok(())
    }

    /// Submits the frames of a step to the background; returns the failures of those that it refuses. Collective.
    pub fn submit_to_background(
        &mut self,
        ranks: &mut Ranks,
        frames: Vec<FrameInputs>,
        stamp: &Stamp,
    ) -> Outcome<Vec<Failure>> {
        let (Some(background), false) = (&mut self.background, frames.is_empty()) else {
            return Ok(Vec::new());
        };
        self.devices.is_asked = frames.iter().any(|frame| frame.setup.scene.backend == Backend::Gpu);
        let views: Vec<String> = frames.iter().map(|frame| frame.setup.view.clone()).collect();
        let mut refused = Vec::new();
        let accepted = background.submit(ranks, frames, &mut refused);
        // The previous frames are complete; their cost is recorded before that of these replaces it.
        self.collect();
        if refused.len() < views.len() {
            accepted.map_err(|error| Failure::from(error).at_step(stamp.step))?;
            self.submitted_step = Some(SubmittedStep { step: stamp.step, host_s: 0.0 });
            self.is_new_call = false;
        }
        let failures = refused.into_iter();
        Ok(failures.map(|(number, error)| Failure::from(error).of_picture(&views[number], stamp.step)).collect())
    }

    /// Counts a failed picture of this call. Existing files that must not be modified are no failure.
    pub fn picture_failed(&mut self, failure: &Failure) {
        use icoray_status::{ICORAY_ERR_DISABLED, ICORAY_ERR_EXISTS};
        if ![ICORAY_ERR_DISABLED, ICORAY_ERR_EXISTS].contains(&failure.status) {
            self.record_failure(failure);
        }
    }

    /// Submits a rendered frame to the writer.
    fn submit_to_writer(&mut self, frame: Frame, FrameSetup { view, scene, stamp, .. }: &FrameSetup) {
        let mut report = frame.report.clone();
        self.log_picture(view, stamp, &report);
        let submitted = self.writer.submit(frame, scene.output.clone(), stamp.clone());
        report.timing.waited_s = submitted.waited_s;
        self.record_dropped(submitted.dropped.as_ref());
        self.record_frame(stamp, report);
    }

    /// Logs what a rendered picture reports, and keeps its cost if that is asked for.
    fn log_picture(&mut self, view: &str, stamp: &Stamp, report: &FrameReport) {
        self.devices.log_frame(stamp, report, &self.log);
        self.errors.log_frame(view, stamp, report, &self.log);
        self.record_cost(view, stamp, report);
        self.log_details(stamp, report);
    }

    /// Records a rendered frame of this call.
    fn record_frame(&mut self, stamp: &Stamp, report: FrameReport) {
        if std::mem::take(&mut self.is_new_call) {
            self.host.begin_call();
        }
        self.host.add(&report);
        self.last = Some((stamp.clone(), report));
    }

    /// Records the outcomes of earlier frames.
    pub fn collect(&mut self) {
        // Frames that are written by now were rendered before the last outcomes of the background.
        let written = self.writer.take_outcomes();
        self.host.frames_written += written.more_done;
        self.host.frames_failed += written.more_failed;
        for written in written.kept {
            self.host.write_total_s += written.write_s;
            self.host.write_s = written.write_s;
            match written.result {
                Ok(path) => {
                    self.host.frames_written += 1;
                    self.policy.succeeded();
                    if self.log.takes(Level::Info) {
                        let (step, seconds) = (written.stamp.step, written.write_s);
                        self.log
                            .say(Level::Info, &format!("step {step}: {} (written in {seconds:.3} s)", path.display()));
                    }
                }
                Err(error) => self.record_late_failure(&written.stamp, error),
            }
        }
        if let Some(background) = &mut self.background {
            let drawn = background.take_outcomes();
            self.host.frames_failed += drawn.more_failed;
            for drawn in drawn.kept {
                self.record_dropped(drawn.dropped.as_ref());
                if drawn.is_first {
                    self.host.begin_call();
                }
                match drawn.result {
                    Ok(report) => {
                        self.log_picture(&drawn.view, &drawn.stamp, &report);
                        self.host.add(&report);
                        self.last = Some((drawn.stamp, report));
                    }
                    // Rank 0 reports it.
                    Err(error) if drawn.is_of_all && !self.is_root => {
                        self.record_failure(&Failure::from(error).at_step(drawn.stamp.step));
                    }
                    Err(error) => self.record_late_failure(&drawn.stamp, error),
                }
            }
            self.host.frames += drawn.more_done;
        }
        let is_last = |step: i64| self.last.as_ref().is_some_and(|(stamp, _)| stamp.step == step);
        if let Some(SubmittedStep { host_s, .. }) = self.submitted_step.take_if(|submitted| is_last(submitted.step)) {
            self.host.host_s = host_s;
        }
    }

    fn log_details(&self, stamp: &Stamp, report: &FrameReport) {
        if self.log.takes(Level::Debug) {
            let (step, left_out) = (stamp.step, report.left_out.join("; "));
            let seconds = report.timing.prepare_s + report.timing.render_s;
            let shared = report.ranks.sharing.map_or_else(String::new, |sharing| format!(" over ranks ({sharing})"));
            let line = format!("step {step}: drawn in {seconds:.3} s{shared}, left out: {left_out}");
            self.log.say(Level::Debug, &line);
        }
    }

    /// Records the failure of a frame of an earlier call.
    fn record_late_failure(&mut self, stamp: &Stamp, error: Error) {
        let failure = Failure::from(error).at_step(stamp.step);
        self.record_failure(&failure);
        // A call returns one of them: the first, or an internal error, which ends the context. The others are logged.
        let is_bug = failure.status == icoray_status::ICORAY_ERR_INTERNAL;
        let other = match &mut self.unreported {
            unreported @ None => unreported.replace(failure),
            Some(first) if is_bug => Some(std::mem::replace(first, failure)),
            Some(_) => Some(failure),
        };
        if let Some(other) = other {
            self.policy.log_failure(&other, &self.log);
        }
    }

    fn record_failure(&mut self, failure: &Failure) {
        self.host.frames_failed += 1;
        self.policy.failed(failure, &self.log);
    }

    fn record_dropped(&mut self, dropped: Option<&Stamp>) {
        if let Some(stamp) = dropped {
            self.host.frames_dropped += 1;
            let message = format!("step {}: dropped, the writer is behind", stamp.step);
            self.log.say(Level::Warn, &message);
        }
    }

    /// Returns the failure of an earlier frame that no call has returned yet.
    pub fn take_unreported(&mut self) -> Outcome<()> {
        self.unreported.take().map_or(Ok(()), Err)
    }

    pub fn log_failure(&self, failure: &Failure) {
        self.policy.log_failure(failure, &self.log);
    }

    /// Waits until the background reads the model's tables no more.
    pub fn finish_rendering(&mut self) {
        if let Some(background) = &mut self.background {
            background.wait();
        }
    }

    /// Waits until all frames are on disk.
    pub fn finish(&mut self) -> Outcome<()> {
        self.finish_rendering();
        self.writer.wait();
        self.collect();
        self.take_unreported()
    }

    pub fn report(&mut self) -> Outcome<icoray_frame_report> {
        self.collect();
        let none = || Failure::new(icoray_status::ICORAY_ERR_ORDER, "no frame has been rendered yet");
        let (stamp, report) = self.last.as_ref().ok_or_else(none)?;
        self.host.bytes_peak = memory::peak();
        Ok(icoray_frame_report::of(stamp, report, &self.host))
    }
}
