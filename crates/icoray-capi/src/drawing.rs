//! Frames on their way: drawn in the call or by a thread, written by another, and what became of them.

use crate::borrow::argument;
use crate::boundary::{Failure, Outcome};
use crate::context::Subject;
use crate::host::without_signals;
use crate::log::{Level, Log};
use crate::memory;
use crate::policy::Policy;
use crate::types::{
    ICORAY_ALONE, ICORAY_BLOCK, ICORAY_CPU, ICORAY_DROP_OLDEST, ICORAY_FRAGMENTS, ICORAY_GPU,
    ICORAY_GPU_AND_CPU, ICORAY_NEVER_MODIFY, ICORAY_OVERWRITE, ICORAY_TILES, icoray_config,
    icoray_frame_report, icoray_status,
};
use icoray_core::output::{Existing, Stamp, WhenFull, Writer, WriterOptions};
use icoray_core::{
    Backend, Background, Certainty, Error, Frame, FrameReport, Job, Lights, Ranks, Renderer, Scene, Scheme,
};
use std::sync::Arc;
use std::time::Instant;

mod devices;
mod together;

use devices::Devices;

/// Frames that wait for the writer, where the config names no number.
const QUEUE: usize = 2;

/// The threads of a context, and the frames that they have.
pub(crate) struct Drawing {
    renderer: Arc<Renderer>,
    writer: Arc<Writer>,
    /// Draws while the model goes on, where the config says so.
    background: Option<Background>,
    policy: Policy,
    /// With several ranks: what they last agreed on.
    is_on_for_all: Option<bool>,
    log: Log,
    devices: Devices,
    /// The first failure that no call has told of.
    untold: Option<Failure>,
    last: Option<(Stamp, FrameReport)>,
    /// The frame that the background draws, and what handing it over cost the model.
    handed_over: Option<(i64, f64)>,
    totals: Totals,
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

impl Drawing {
    pub fn new(config: &icoray_config, output_dir: &str, ranks: &Ranks) -> Outcome<Self> {
        let threads = usize::try_from(config.threads).ok().filter(|n| *n <= 4096).ok_or_else(|| {
            argument(format!("icoray_config.threads: {}, expected 0 to 4096", config.threads))
        })?;
        let options = writer_options(config, output_dir)?;
        let policy = Policy::new(config, ranks.is_root())?;
        if config.async_render != 0 && !ranks.is_alone() {
            let message = "icoray_config.async_render with several ranks: not supported yet, set it to 0";
            return Err(Failure::new(icoray_status::ICORAY_ERR_UNSUPPORTED, message));
        }
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
            let draws = (config.async_render != 0).then(|| Background::new(renderer.clone(), writer.clone()));
            Ok((renderer, writer, draws.transpose()?))
        })?;
        let (untold, last, handed_over, totals) = (None, None, None, Totals::default());
        let is_on_for_all = (!ranks.is_alone()).then_some(true);
        Ok(Drawing {
            renderer,
            writer,
            background,
            policy,
            is_on_for_all,
            log,
            devices: Devices::default(),
            untold,
            last,
            handed_over,
            totals,
        })
    }

    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// Counts the model's time.
    pub fn spent(&mut self, seconds: f64) {
        self.totals.host_s += seconds;
    }

    /// Whether frames are still drawn.
    pub fn is_on(&self) -> bool {
        self.is_on_for_all.unwrap_or(self.policy.is_on())
    }

    /// A step without a frame: tells only of frames before.
    pub fn pass(&mut self) -> Outcome<()> {
        self.collect();
        self.policy.refuse_if_off()?;
        self.tell()
    }

    /// Draws a frame of what `subject` finds, and queues it to be written.
    pub fn draw<'a>(&mut self, stamp: Stamp, subject: impl FnOnce() -> Outcome<Subject<'a>>) -> Outcome<()> {
        let start = Instant::now();
        self.collect();
        self.policy.refuse_if_off()?;
        let step = stamp.step;
        let drawn = subject().and_then(|subject| self.begin(stamp, subject));
        let host_s = start.elapsed().as_secs_f64();
        match drawn {
            Ok(()) if self.background.is_some() => self.handed_over = Some((step, host_s)),
            Ok(()) => self.totals.last_host_s = host_s,
            Err(failure) => {
                let failure = failure.at_step(step);
                // Nothing was drawn, as the user asked for.
                if failure.status != icoray_status::ICORAY_ERR_EXISTS {
                    self.fail(&failure);
                }
                return Err(failure);
            }
        }
        self.tell()
    }

    fn begin(&mut self, stamp: Stamp, subject: Subject) -> Outcome<()> {
        // What one process holds is the whole grid and fields.
        let Subject { scene, grid, held: _, layers, fields, description, descriptions } = subject;
        self.devices.is_asked = scene.backend == Backend::Gpu;
        if let Some(background) = &mut self.background {
            background.submit(Job { scene, grid, layers, stamp, description, descriptions }, fields)?;
            // The frame before was waited for; its cost is to be taken before this one's takes its place.
            self.collect();
            return Ok(());
        }
        // Names that are wrong or taken are known before the first ray.
        self.writer.check(&scene.output, &stamp, &scene.field)?;
        let frame = self.renderer.render(&scene, &grid, &layers, fields)?;
        self.hand_on(Frame { description, descriptions, ..frame }, &scene, stamp);
        Ok(())
    }

    /// A frame that is drawn goes to the writer.
    fn hand_on(&mut self, frame: Frame, scene: &Scene, stamp: Stamp) {
        let mut report = frame.report.clone();
        self.devices.tell(&stamp, &report, &self.log);
        self.describe(&stamp, &report);
        let submitted = self.writer.submit(frame, scene.output.clone(), stamp.clone());
        report.waited_s = submitted.waited_s;
        self.drop_frame(submitted.dropped.as_ref());
        self.last = Some((stamp, report));
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
            for drawn in drawn.kept {
                self.drop_frame(drawn.dropped.as_ref());
                match drawn.result {
                    Ok(report) => {
                        self.devices.tell(&drawn.stamp, &report, &self.log);
                        self.describe(&drawn.stamp, &report);
                        self.last = Some((drawn.stamp, report));
                    }
                    Err(error) => self.fail_late(&drawn.stamp, error),
                }
            }
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
    fn tell(&mut self) -> Outcome<()> {
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
        Ok(crossing(stamp, report, &self.totals))
    }
}

fn writer_options(config: &icoray_config, output_dir: &str) -> Outcome<WriterOptions> {
    let existing = match config.existing {
        ICORAY_NEVER_MODIFY => Existing::NeverModify,
        ICORAY_OVERWRITE => Existing::Overwrite,
        other => {
            return Err(argument(format!(
                "icoray_config.existing: {other}, expected ICORAY_NEVER_MODIFY (0) or ICORAY_OVERWRITE (1)"
            )));
        }
    };
    let when_full = match config.when_full {
        ICORAY_BLOCK => WhenFull::Block,
        ICORAY_DROP_OLDEST => WhenFull::DropOldest,
        other => {
            return Err(argument(format!(
                "icoray_config.when_full: {other}, expected ICORAY_BLOCK (0) or ICORAY_DROP_OLDEST (1)"
            )));
        }
    };
    let queue = match config.writer_queue {
        0 => QUEUE,
        n @ 1..=1024 => n as usize,
        other => {
            return Err(argument(format!("icoray_config.writer_queue: {other}, expected 0 to 1024")));
        }
    };
    Ok(WriterOptions { existing, when_full, queue, ..WriterOptions::new(output_dir) })
}

/// The report as it crosses the boundary.
fn crossing(stamp: &Stamp, r: &FrameReport, totals: &Totals) -> icoray_frame_report {
    let [value_min, value_max] = r.value_range.unwrap_or([f64::NAN; 2]);
    icoray_frame_report {
        struct_size: size_of::<icoray_frame_report>(),
        step: stamp.step,
        time_s: stamp.time_s,
        host_s: totals.last_host_s,
        waited_s: r.waited_s,
        copy_s: r.copy_s,
        prepare_s: r.prepare_s,
        render_s: r.render_s,
        write_s: totals.last_write_s,
        rays: r.counts.rays,
        columns: r.counts.columns,
        frusta: r.counts.frusta,
        void_frusta: r.counts.void_frusta,
        value_min,
        value_max,
        missing_values: r.missing_values,
        bytes_copied: r.bytes_copied,
        bytes_derived: r.derived_bytes as u64,
        bytes_peak: memory::peak(),
        error_max: r.error.max,
        error_mean: r.error.mean,
        error_p999: r.error.p999,
        tolerance: r.quality.tolerance,
        error_is_bound: (r.error.certainty == Certainty::Bound).into(),
        pixel_step: r.quality.pixel_step as i32,
        lights: match r.quality.lights {
            Lights::Off => 0,
            Lights::Coarse => 1,
            Lights::Full => 2,
        },
        threads: r.threads as i32,
        ranks: r.ranks as i32,
        tiles: r.tiles as i32,
        gather_s: r.gather_s,
        balance: r.balance,
        bytes_received: r.bytes_received,
        scheme: match r.sharing.map(|sharing| sharing.scheme) {
            None => ICORAY_ALONE,
            Some(Scheme::Fragments) => ICORAY_FRAGMENTS,
            Some(Scheme::Auto | Scheme::Tiles) => ICORAY_TILES,
        },
        fragments: r.counts.fragments,
        fragment_bytes: r.counts.fragment_bytes,
        compose_s: r.compose_s,
        drawn_on: match (&r.device, &r.left_to_cpu) {
            (None, _) => ICORAY_CPU,
            (Some(_), None) => ICORAY_GPU,
            (Some(_), Some(_)) => ICORAY_GPU_AND_CPU,
        },
        upload_s: r.upload_s,
        device_s: r.device_s.unwrap_or(f64::NAN),
        bytes_uploaded: r.bytes_uploaded,
        frames_written: totals.written,
        frames_failed: totals.failed,
        frames_dropped: totals.dropped,
        host_total_s: totals.host_s,
        write_total_s: totals.write_s,
    }
}
