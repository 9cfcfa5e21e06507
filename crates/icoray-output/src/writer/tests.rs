//! Order, a full queue, and failures of a disk.

use super::*;
use crate::frame::tests::frame;
use icoray_scene::name::NameTemplate;
use icoray_test_support::{Need, skip_because};
use std::fs;
use std::process::Command;
use std::sync::mpsc::{Receiver, Sender, channel};

fn output() -> Output {
    NameTemplate::new("{field}_{step}.png").unwrap().into()
}

fn stamp(step: i64) -> Stamp {
    Stamp { step, ..Stamp::default() }
}

fn submit(writer: &Writer, step: i64) -> Submitted {
    writer.submit(frame(), output(), stamp(step))
}

/// Steps of the outcomes, and whether each went well.
fn took(writer: &Writer) -> Vec<(i64, bool)> {
    writer.take_outcomes().kept.iter().map(|w| (w.stamp.step, w.result.is_ok())).collect()
}

/// A writer that writes nothing: it sends the step of each frame when it begins with it, and finishes when permitted.
struct Gated {
    writer: Arc<Writer>,
    begun: Receiver<i64>,
    gate: Sender<()>,
}

impl Gated {
    fn new(queue: usize, when_full: WhenFull) -> Self {
        let ((report, begun), (gate, passed)) = (channel(), channel());
        let options = WriterOptions { queue, when_full, ..WriterOptions::new("/nowhere") };
        let writer = Writer::with(options, move |entry| {
            report.send(entry.stamp.step).unwrap();
            passed.recv().unwrap();
            Ok(PathBuf::from(format!("{} waited {}", entry.stamp.step, entry.frame.report.timing.waited_s > 0.0)))
        });
        Gated { writer: Arc::new(writer.unwrap()), begun, gate }
    }

    fn finish(&self, frames: usize) {
        (0..frames).for_each(|_| self.gate.send(()).unwrap());
        self.writer.wait();
    }
}

#[test]
fn a_full_queue_makes_the_caller_wait() {
    let Gated { writer, begun, gate } = &Gated::new(2, WhenFull::Block);
    assert_eq!(submit(writer, 1).waited_s, 0.0);
    assert_eq!(begun.recv(), Ok(1));
    assert_eq!(submit(writer, 2).waited_s, 0.0);
    assert_eq!(submit(writer, 3), Submitted::default());
    let (fourth, back) = (Arc::clone(writer), channel());
    let caller = std::thread::spawn(move || back.0.send(submit(&fourth, 4)).unwrap());
    while writer.shared.lock().blocked == 0 {
        assert!(back.1.try_recv().is_err(), "it came back although the queue is full");
        std::thread::yield_now();
    }
    assert_eq!(writer.waiting.len(), 2);
    gate.send(()).unwrap();
    let submitted = back.1.recv().unwrap();
    assert!(submitted.waited_s > 0.0 && submitted.dropped.is_none(), "{submitted:?}");
    caller.join().unwrap();
    (0..3).for_each(|_| gate.send(()).unwrap());
    writer.wait();
    let outcomes = writer.take_outcomes().kept;
    let said: Vec<_> = outcomes.iter().map(|w| w.result.clone().unwrap()).collect();
    let expected = ["1 waited false", "2 waited false", "3 waited false", "4 waited true"];
    assert_eq!(said, expected.map(PathBuf::from));
}

#[test]
fn or_drops_the_oldest_that_waits() {
    let gated = Gated::new(2, WhenFull::DropOldest);
    let writer = &gated.writer;
    submit(writer, 1);
    assert_eq!(gated.begun.recv(), Ok(1));
    let dropped: Vec<_> = (2..=5).map(|step| submit(writer, step).dropped.map(|s| s.step)).collect();
    assert_eq!(dropped, [None, None, Some(2), Some(3)]);
    let is_taken = |step| match writer.check(&output(), &stamp(step), "q") {
        Err(e) if e.kind() == ErrorKind::Exists => true,
        Err(e) => panic!("{e}"),
        Ok(names) => {
            assert_eq!(names.file, format!("q_{step}.png"));
            false
        }
    };
    // 1 is being written, 2 and 3 never will be, 4 and 5 wait.
    assert_eq!([1, 2, 3, 4, 5].map(is_taken), [true, false, false, true, true]);
    gated.finish(3);
    assert_eq!(took(writer), [(1, true), (4, true), (5, true)]);
    assert_eq!(took(writer), [], "outcomes are reported once");
    assert!(!is_taken(1));
}

#[test]
fn a_panic_of_an_encoder_is_an_outcome() {
    let writer = Writer::with(WriterOptions::new("x"), |entry| match entry.stamp.step {
        2 => panic!("bad luck"),
        _ => Ok(std::thread::current().name().unwrap().into()),
    });
    let writer = writer.unwrap();
    (1..=3).for_each(|step| drop(submit(&writer, step)));
    writer.wait();
    let outcomes = writer.take_outcomes().kept;
    assert_eq!(outcomes[1].result.as_ref().unwrap_err().to_string(), "internal error: bad luck");
    for well in [0, 2] {
        assert_eq!(outcomes[well].result.as_ref().unwrap(), Path::new("icoray-writer"));
    }
}

#[test]
fn dropping_the_writer_writes_queued_frames() {
    let folder = tempfile::tempdir().unwrap();
    let writer = Writer::new(WriterOptions { queue: 9, ..WriterOptions::new(folder.path()) }).unwrap();
    (1..=9).for_each(|step| drop(submit(&writer, step)));
    drop(writer);
    for step in 1..=9 {
        assert_eq!(image::open(folder.path().join(format!("q_{step}.png"))).unwrap().width(), 3);
    }
    let report = fs::read_to_string(folder.path().join("report.csv")).unwrap();
    let steps: Vec<_> = report.lines().skip(1).map(|l| l.split(',').next().unwrap()).collect();
    assert_eq!(steps, ["1", "2", "3", "4", "5", "6", "7", "8", "9"]);
}

#[test]
fn one_frames_failure_does_not_stop_the_next() {
    let folder = tempfile::tempdir().unwrap();
    let writer = Writer::new(WriterOptions::new(folder.path().join("new"))).unwrap();
    let template = |text| Output::from(NameTemplate::new(text).unwrap());
    submit(&writer, 1);
    writer.wait();
    fs::create_dir(folder.path().join("new/directory.png")).unwrap();
    let cases = [
        ("q_1.png", ErrorKind::Exists, "q_1.png: is there already"),
        ("directory.png", ErrorKind::Io, "a directory has its name"),
        ("q_1.png/x.png", ErrorKind::Io, "q_1.png: cannot make the directory"),
        ("$Y.png", ErrorKind::Argument, "date is absent"),
    ];
    for (name, ..) in cases {
        writer.submit(frame(), template(name), stamp(2));
    }
    submit(&writer, 3);
    writer.wait();
    let outcomes = writer.take_outcomes();
    assert_eq!((outcomes.done(), outcomes.failed()), (2, 4));
    for (error, (_, kind, part)) in outcomes.errors().zip(cases) {
        assert_eq!(error.kind(), kind, "{error}");
        assert!(error.to_string().contains(part), "{error}");
    }
    assert_eq!(outcomes.kept.last().unwrap().result.as_ref().unwrap(), &folder.path().join("new/q_3.png"));
}

#[test]
fn unwritable_names_are_reported_before_the_first_ray() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let new = |existing| Writer::new(WriterOptions { existing, ..WriterOptions::new(folder.path()) }).unwrap();
    let (keeper, replacer) = (new(Existing::NeverModify), new(Existing::Overwrite));
    let output = Output { error: Some(NameTemplate::new("map_{step}.png").unwrap()), ..output() };
    fs::write(at("map_1.png"), "").unwrap();
    fs::create_dir(at("map_2.png")).unwrap();
    let kind = |writer: &Writer, step| writer.check(&output, &stamp(step), "q").err().map(|e| e.kind());
    assert_eq!([1, 2, 3].map(|step| kind(&keeper, step)), [Some(ErrorKind::Exists), Some(ErrorKind::Io), None]);
    assert_eq!([1, 2, 3].map(|step| kind(&replacer, step)), [None, Some(ErrorKind::Io), None]);
    fs::write(at("report.csv"), "step,time_s\n1,2\n").unwrap();
    assert_eq!(kind(&replacer, 3), None, "the report was looked at");
    let error = new(Existing::Overwrite).check(&output, &stamp(3), "q").unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Exists);
    assert!(error.to_string().contains("report.csv: its first line is not"), "{error}");
}

#[test]
fn a_writer_keeps_to_where_it_was_made() {
    let writer = Writer::new(WriterOptions::new("")).unwrap();
    assert_eq!(writer.options().directory, std::env::current_dir().unwrap().join(""));
    let error = Writer::new(WriterOptions { queue: 0, ..WriterOptions::new("") }).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Argument);
}

/// Set to a folder in a process of its own, which one of the tests below started.
const CHILD: &str = "ICORAY_TEST_WRITER";

/// This test binary as another process that runs one test of this file, with `before` put before the command.
fn child(before: &[&str], test: &str, folder: &Path) -> std::process::Output {
    let exe = std::env::current_exe().unwrap();
    let name = format!("writer::tests::{test}");
    let mut words: Vec<_> = before.iter().map(|word| std::ffi::OsStr::new(*word)).collect();
    words.push(exe.as_os_str());
    let mut command = Command::new(words[0]);
    command.args(&words[1..]).args(["--exact", &name, "--nocapture", "--test-threads=1"]);
    command.env(CHILD, folder).output().unwrap()
}

/// A file system of 64 KiB, in a mount namespace of a child's own that ends with it. For root, or where users may make
/// namespaces.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_fails_its_frame_and_leaves_nothing() {
    if let Some(folder) = std::env::var_os(CHILD) {
        return fill(Path::new(&folder));
    }
    let folder = tempfile::tempdir().unwrap();
    let mount = "mount -t tmpfs -o size=64k tmpfs \"$ICORAY_TEST_WRITER\" || exit 77; exec \"$0\" \"$@\"";
    let before = ["unshare", "--map-root-user", "--mount", "sh", "-c", mount];
    let output = child(&before, "a_full_disk_fails_its_frame_and_leaves_nothing", folder.path());
    let said = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    match output.status.code() {
        Some(0) => assert!(said.contains("1 passed"), "{said}"),
        // The exit code of the test harness when a test fails.
        Some(101) => panic!("{said}"),
        _ => skip_because(Need::Mount, said),
    }
}

#[cfg(target_os = "linux")]
fn fill(folder: &Path) {
    let writer = Writer::new(WriterOptions::new(folder)).unwrap();
    // Digits of a square root: no two pixels alike, so that nothing is gained by compressing.
    let noise = (0..300 * 300).map(|i| f64::sqrt(f64::from(i) + 2.0).fract() as f32);
    let pixels: Vec<[f32; 4]> = noise.map(|v| [v, v * v, v * v * v, 1.0]).collect();
    let error = pixels.iter().map(|p| 10f32.powf(-1.0 - 7.0 * p[0])).collect();
    let large = Frame { width: 300, height: 300, pixels, error, ..frame() };
    let [picture, both] = ["large.png", "small_{step}.png"].map(|t| NameTemplate::new(t).unwrap());
    submit(&writer, 1);
    writer.submit(large.clone(), picture.clone().into(), stamp(2));
    submit(&writer, 3);
    // The picture itself is small, the map of its errors is not.
    let thin = Frame { pixels: vec![[0.0; 4]; large.pixels.len()], ..large };
    writer.submit(thin, Output { error: Some(picture), ..both.into() }, stamp(4));
    submit(&writer, 5);
    writer.wait();
    let outcomes = writer.take_outcomes();
    let went: Vec<_> = outcomes.kept.iter().map(|w| w.result.is_ok()).collect();
    assert_eq!(went, [true, false, true, false, true]);
    let errors: Vec<_> = outcomes.errors().map(ToString::to_string).collect();
    for error in &errors {
        assert!(error.contains("large.png: cannot write the picture: ") && error.contains("No space"), "{error}");
    }
    assert!(errors[1].ends_with("small_4.png is written)"), "{errors:?}");
    let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["q_1.png", "q_3.png", "q_5.png", "report.csv", "small_4.png"]);
}

/// Rayon's global pool would stay in the model for ever. In a process of its own, since other tests start it.
#[cfg(target_os = "linux")]
#[test]
fn encoding_starts_no_threads() {
    if let Some(folder) = std::env::var_os(CHILD) {
        let threads = || fs::read_dir("/proc/self/task").unwrap().count();
        let before = threads();
        let writer = Writer::new(WriterOptions::new(folder)).unwrap();
        for file in ["{step}.png", "{step}.exr"] {
            let error = Some(NameTemplate::new("map_{step}.png").unwrap());
            let output = Output { error, ..NameTemplate::new(file).unwrap().into() };
            let (pixels, error) = (vec![[0.5; 4]; 512 * 512], vec![1e-3; 512 * 512]);
            let step = i64::from(file.ends_with("exr"));
            writer.submit(Frame { width: 512, height: 512, pixels, error, ..frame() }, output, stamp(step));
        }
        writer.wait();
        assert_eq!(took(&writer), [(0, true), (1, true)]);
        assert_eq!(threads(), before + 1);
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let output = child(&[], "encoding_starts_no_threads", folder.path());
    let said = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && said.contains("1 passed"), "{said}");
}
