//! Each fault gives a message, and the host continues.

use super::drawn as pictures_of;
use super::hosts::{Host, ended_well, prepared};
use icoray_tests::native::{succeeded, text};
use icoray_tests::ranks::FIRST;

/// What goes wrong is a line of the host's standard error, and the host ends well.
#[test]
fn no_failure_ends_the_host() {
    let Some(directory) = FIRST.directory() else { return };
    let directory = directory.path();
    let host = Host::of_kind(directory, "", true);
    let cases = [
        ("no scene", "scene.toml", "catalyst/scripts has no path that ends in .toml", 0),
        ("", "nowhere.toml", "nowhere.toml: cannot read the scene", 0),
        ("type", "scene.toml", "channel grid: ", 0),
        ("shape", "scene.toml", "elements of shape \"tet\", expected \"polyhedral\" (prisms) or one of \"wedge\"", 0),
        ("ghosts", "scene.toml", "field vtkGhostType marks ", 0),
        ("rank", "scene.toml", "rank 2: ", 0),
        // The other view is drawn at steps 0 to 3, this one at step 0.
        ("field", "scene.toml", "the host gives no such field on this rank", 5),
        ("length", "scene.toml", "field \"q\" was refused by icoray_field_set: bad field: 7 values, expected one", 4),
        // At steps 1 to 3, which other ranks wait to draw with this one.
        ("null", "scene.toml", "catalyst_execute: NULL, expected a node", 2),
    ];
    for (fault, scene, said, drawn) in cases {
        let run = prepared(directory, &format!("fault {fault} {scene}"), "flat");
        let log = host.run(3, &run, &[scene, "wedges", "flat", "4", "column", fault]);
        assert!(log.contains("icoray: warning: ") && log.contains(said), "{fault}: {log}");
        assert!(log.lines().all(|line| line.len() < 480), "{log}");
        // No picture is said to lack what a host of Catalyst has never heard of.
        assert!(!log.contains("was called before"), "{log}");
        assert_eq!(pictures_of(&run).len(), drawn, "{fault}: {log}");
    }
    // Another Conduit than is known.
    let other = Host::of_kind(directory, "OTHER_CONDUIT", true);
    let run = prepared(directory, "other", "flat");
    let output = succeeded(&mut other.command(2, &run, &["scene.toml", "wedges", "flat", "2", "column"]));
    let (stdout, stderr) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(stdout.matches("the host ended well").count(), 2, "{stdout}");
    assert!(stderr.contains("icoray: warning: the process has no functions of Conduit"), "{stderr}");
    assert!(!stdout.contains("returned") && pictures_of(&run).is_empty(), "{stdout}");
    let run = prepared(directory, "in the way", "flat");
    std::fs::write(run.join("pictures"), "").unwrap();
    let log = host.run(2, &run, &["scene.toml", "wedges", "flat", "1", "column"]);
    assert!(log.contains("icoray: warning: ") && log.contains("pictures"), "{log}");
}

/// Files for `catalyst_replay`: where they cannot be made, the double ends the process, as the real one does.
#[test]
fn files_of_calls_that_cannot_be_made_do_not_end_the_host() {
    let Some(directory) = FIRST.directory() else { return };
    let directory = directory.path();
    for (is_on_ranks, ranks) in [(true, 2), (false, 1)] {
        let host = Host::of_kind(directory, "", is_on_ranks);
        for (name, files, warnings) in [("dump", 3 * ranks, 0), ("scene.toml", 0, ranks)] {
            let run = prepared(directory, &format!("{name} on {ranks}"), "flat");
            let mut command = host.command(ranks, &run, &["scene.toml", "wedges", "flat", "2", "column"]);
            command.env("CATALYST_DATA_DUMP_DIRECTORY", run.join(name));
            let log = ended_well(ranks, &mut command);
            assert_eq!(log.matches("no files for catalyst_replay are written: ").count(), warnings, "{log}");
            assert_eq!(std::fs::read_dir(run.join(name)).map_or(0, Iterator::count), files, "{log}");
            assert_eq!(pictures_of(&run).len(), 3, "{log}");
        }
    }
}
