//! Several ranks under mpirun: C and Fortran programs against the library that was built with MPI.

use icoray_test_support::{Need, has_tool};
use icoray_tests::native::{
    checked, command, fortran, library, linked, mpi_library, new_directory, root, succeeded, text, with_small_disk,
};
use icoray_tests::pictures::{column, difference, files};
use icoray_tests::ranks::{FIRST, MPICH, Mpi};
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// A program of `tests/c` with an MPI, and the directory of its pictures.
struct Run<'a> {
    mpi: &'a Mpi,
    name: &'static str,
    program: PathBuf,
    directory: TempDir,
}

impl<'a> Run<'a> {
    fn new(mpi: &'a Mpi, name: &'static str) -> Self {
        Run::against((mpi.library)(), mpi, name)
    }

    fn against(library: PathBuf, mpi: &'a Mpi, name: &'static str) -> Self {
        Run { mpi, name, program: mpi.compile(library, name), directory: TempDir::new().unwrap() }
    }

    fn at(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    /// Runs it in one process without MPI, with pictures in `one`.
    fn alone(&self, least: u32) -> Vec<String> {
        let mut run = command(&self.program, self.directory.path());
        checked(run.arg(self.at("one")).arg("serial"), self.name, least)
    }

    /// The command that runs it on `ranks`, each node with `node` of them (all if empty), with pictures in `to`.
    fn on(&self, ranks: usize, node: &str, to: &str) -> Command {
        std::fs::create_dir_all(self.at(to)).unwrap();
        let mut run = self.mpi.on_ranks(ranks, &self.program, self.directory.path());
        if !node.is_empty() {
            run.env("ICORAY_NODE_RANKS", node);
        }
        run.arg(self.at(to));
        run
    }

    /// Runs that command with more arguments.
    fn checks(&self, ranks: usize, node: &str, to: &str, more: &[&str], least: u32) -> Vec<String> {
        checked(self.on(ranks, node, to).args(more), self.name, least)
    }
}

const KINDS: [&str; 4] = ["contiguous", "random", "single_cell", "no_cell"];

/// Tests with the MPI that is found first; skipped where there is none.
macro_rules! first {
    ($($(#[$doc:meta])* $name:ident: $run:expr;)*) => {$(
        $(#[$doc])*
        #[test]
        fn $name() {
            if FIRST.is_there() {
                $run;
            }
        }
    )*};
}

first! {
    pictures_of_several_ranks_are_those_of_one_to_the_byte: pictures(&FIRST, &[1, 2, 3, 4, 8]);
    pictures_of_a_grid_in_parts_are_those_of_the_whole:
        parts(&FIRST, &[(1, ""), (2, ""), (3, ""), (4, ""), (8, ""), (3, "1"), (4, "2"), (5, "2")]);
    pictures_of_columns_over_whole_tables_are_those_of_the_whole_to_the_byte:
        columns(&FIRST, &[(2, ""), (3, ""), (4, ""), (8, ""), (4, "2"), (8, "3"), (3, "1")]);
    pictures_in_the_background_are_those_of_the_call_to_the_byte:
        background(&FIRST, &[(1, ""), (2, ""), (4, ""), (4, "2")]);
    columns_are_put_together_where_a_node_has_no_memory_to_share: without_shared_memory(&FIRST, "mpi_columns", "one");
    parts_are_put_together_where_a_node_has_no_memory_to_share: without_shared_memory(&FIRST, "mpi_parts", "one/whole");
    what_fails_on_one_rank_fails_on_all: refusals(&FIRST, &[2, 3, 4]);
    /// A model that draws where `icoray_wants` says so comes to its end, whichever call fails on whichever rank.
    no_failure_of_one_rank_leaves_others_waiting: failures(&FIRST, &[2, 4]);
    a_part_that_is_wrong_on_one_rank_is_refused_on_all: wrong_parts(&FIRST, &[2, 3, 4]);
    views_of_a_grid_in_parts_are_decided_alike_on_all: views();
    a_full_disk_at_rank_0_is_an_error_on_all: full_disk();
    before_mpi_and_after_it_there_are_answers: ends();
    /// As MPI says in a library with it, and as the launcher says in one without.
    a_context_of_one_process_among_ranks_is_pointed_out: alone_among_ranks();
}

fn pictures(mpi: &Mpi, sizes: &[usize]) {
    let run = Run::new(mpi, "mpi_pictures");
    let alone = run.alone(150);
    let one = files(&run.at("one"));
    assert_eq!(one.len(), 6 * 3 + 2 * 3, "{:?}", one.keys());
    for &ranks in sizes {
        let to = run.at(&ranks.to_string());
        let notes = run.checks(ranks, "", &ranks.to_string(), &[], 150);
        // Where time is short all leave out as many pixels as may be, unless the machine was too fast for that.
        let is_coarsest = |note: &String| !note.contains("short: ") || note.contains("one of 32 ");
        let is_same = alone.iter().chain(&notes).all(is_coarsest);
        let is_left_out = |name: &str| name.starts_with("short") && !is_same;
        let [reported, received] = ["ranks", "bytes_received"].map(|name| column(&to.join("report.csv"), name));
        assert!(reported.len() >= 6 && reported.iter().all(|count| *count == ranks.to_string()), "{reported:?}");
        assert_eq!(received.iter().any(|bytes| bytes != "0"), ranks > 1);
        let several = files(&to);
        assert_eq!(several.keys().collect::<Vec<_>>(), one.keys().collect::<Vec<_>>());
        for (name, bytes) in &one {
            assert!(is_left_out(name) || several[name] == *bytes, "{name} of {ranks} ranks is another picture");
        }
    }
}

/// On so many ranks, each with how many of them make a node; none is said where all do: then pictures are the same to
/// the byte, unless the scene asks for fragments. Halos have no values.
fn parts(mpi: &Mpi, runs: &[(usize, &str)]) {
    let run = Run::new(mpi, "mpi_parts");
    run.alone(50);
    let whole = files(&run.at("one/whole"));
    assert_eq!(whole.len(), 9, "{:?}", whole.keys());
    assert!(whole == files(&run.at("one/part")), "one process draws another picture of a part that has all");
    for &(ranks, node) in runs {
        let name = format!("{ranks}_{node}");
        let kinds = if ranks == 1 { 1 } else { 4 };
        run.checks(ranks, node, &name, &[], 50 * kinds);
        let to = run.at(&name);
        let mut worst = [0.0f64; 2];
        for kind in KINDS.into_iter().take(kinds as usize) {
            for name in whole.keys() {
                let [max, _] = difference(&to.join(kind).join(name), &run.at("one/whole").join(name));
                let (limit, of) = if name.starts_with("f64") { (1e-6, 0) } else { (1e-5, 1) };
                let is_same = node.is_empty() && name != "f32_inside.exr";
                assert!(max <= if is_same { 0.0 } else { limit }, "{ranks} ranks, {node}, {kind}, {name}: {max:e}");
                worst[of] = worst[of].max(max);
            }
        }
        println!("{ranks} ranks, {node} on a node, largest differences: f64 {:.1e}, f32 {:.1e}", worst[0], worst[1]);
    }
    // Other pictures do differ.
    let names: Vec<&String> = whole.keys().collect();
    let [one, other] = [0, 2].map(|i| run.at("one/whole").join(names[i]));
    assert!(difference(&one, &other)[0] > 0.01);
}

/// On so many ranks, each with how many of them make a node; none is said where all do.
fn columns(mpi: &Mpi, runs: &[(usize, &str)]) {
    let run = Run::new(mpi, "mpi_columns");
    run.alone(15);
    let one = files(&run.at("one"));
    assert_eq!(one.len(), 10, "{:?}", one.keys());
    let same = |to: &Path| assert!(files(to) == one, "{} has other pictures", to.display());
    for &(ranks, node) in runs {
        let name = format!("{ranks}_{node}");
        run.checks(ranks, node, &name, &[], 100);
        KINDS.iter().for_each(|kind| same(&run.at(&name).join(kind)));
    }
}

/// On so many ranks, each with how many of them make a node; none is said where all do.
fn background(mpi: &Mpi, runs: &[(usize, &str)]) {
    for &(ranks, node) in runs {
        let run = Run::new(mpi, "mpi_async");
        run.checks(ranks, node, "", &[], 100);
        // Messages are on their way when these end, of which UCX under MPICH warns.
        checked(run.on(ranks, node, "").arg("apart").env("UCX_LOG_LEVEL", "error"), "mpi_async", 20);
        for kind in ["whole", "columns", "parts"] {
            let [called, beside] = ["sync", "async"].map(|way| files(&run.at(&format!("{kind}_{way}"))));
            assert_eq!(called.len(), 5, "{:?}", called.keys());
            assert!(called == beside, "{kind} on {ranks} ranks, nodes of {node:?}: other pictures");
        }
    }
}

/// In a mount namespace with another `/dev/shm`, where this user may make one. Open MPI itself is to do without, too;
/// MPICH makes its window elsewhere than where room is looked for then, so that only its pages show it.
fn without_shared_memory(mpi: &Mpi, program: &'static str, alone: &str) {
    let run = Run::new(mpi, program);
    let mut inner = run.on(3, "", "small");
    let Some(mut outer) = with_small_disk(inner.arg("small"), "64m", "/dev/shm") else { return };
    run.alone(15);
    checked(outer.env("OMPI_MCA_btl", "self,tcp"), run.name, 20);
    let [small, mut one] = ["small/contiguous", alone].map(|to| files(&run.at(to)));
    // Fragments differ in last digits.
    one.retain(|name, _| program != "mpi_parts" || name != "f32_inside.exr");
    assert!(one.iter().all(|(name, bytes)| small[name] == *bytes), "the pictures differ");
}

fn views() {
    let run = Run::new(&FIRST, "mpi_views");
    for ranks in [2, 3] {
        let to = run.at(&ranks.to_string());
        run.checks(ranks, "", &ranks.to_string(), &[], 50);
        for kind in ["contiguous", "random"] {
            let names: Vec<String> = files(&to.join(kind)).into_keys().collect();
            let expected = "fine_20.png good_20.png high_1.png low_4.png mean_3.png sides.cdb \
                            two.ffconcat two_0.png two_2.png two_4.png";
            assert_eq!(names.join(" "), expected, "{ranks} ranks, {kind}");
            let table = std::fs::read_to_string(to.join(kind).join("sides.cdb/data.csv")).unwrap();
            assert_eq!(table.lines().count(), 3, "{table}");
            let list = std::fs::read_to_string(to.join(kind).join("two.ffconcat")).unwrap();
            assert_eq!(list.matches("file ").count(), 3, "{list}");
        }
    }
}

fn refusals(mpi: &Mpi, sizes: &[usize]) {
    let run = Run::new(mpi, "mpi_refusals");
    for &ranks in sizes {
        run.checks(ranks, "", &ranks.to_string(), &[], 250);
        let to = run.at(&ranks.to_string());
        assert!(to.join("half_0/frame_1.png").is_file() && to.join("half_1/frame_2.png").is_file());
    }
}

fn failures(mpi: &Mpi, sizes: &[usize]) {
    const CALLS: &str = "none open grid_set layers_set field_set part_set scene_load scene_text describe wants \
                         wants_field execute wait close";
    let run = Run::new(mpi, "mpi_failures");
    for &ranks in sizes {
        for call in CALLS.split(' ') {
            run.checks(ranks, "", &format!("{ranks}_{call}"), &[call], 10);
        }
    }
}

fn wrong_parts(mpi: &Mpi, sizes: &[usize]) {
    let run = Run::new(mpi, "mpi_parts_refusals");
    for &ranks in sizes {
        run.checks(ranks, "", &ranks.to_string(), &[], 350);
    }
}

fn full_disk() {
    let run = Run::new(&FIRST, "mpi_parts_refusals");
    new_directory(run.directory.path(), "disk");
    let mut inner = FIRST.on_ranks(2, &run.program, run.directory.path());
    let Some(mut outer) = with_small_disk(inner.args(["disk", "full"]), "200k", "disk") else { return };
    checked(&mut outer, "mpi_parts_refusals", 25);
}

/// On few ranks: its ranks do not leave the processor while they wait, and would take most of the time of all tests.
#[test]
fn mpich_does_the_same() {
    if MPICH.is_there() {
        pictures(&MPICH, &[2, 3]);
        refusals(&MPICH, &[2]);
        parts(&MPICH, &[(2, ""), (3, "1")]);
        wrong_parts(&MPICH, &[2]);
        failures(&MPICH, &[2]);
        columns(&MPICH, &[(3, ""), (4, "2")]);
        background(&MPICH, &[(2, ""), (4, "2")]);
        without_shared_memory(&MPICH, "mpi_columns", "one");
        without_shared_memory(&MPICH, "mpi_parts", "one/whole");
    }
}

/// The host's MPI is the one whose functions both call, as it comes first; handles of the other would end the process.
#[test]
fn a_host_of_another_mpi_is_refused() {
    if !FIRST.is_there() || !MPICH.is_there() || !FIRST.is_open_mpi() {
        return;
    }
    for (host, other) in [(&FIRST, &MPICH), (&MPICH, &FIRST)] {
        let run = Run::against((other.library)(), host, "mpi_other");
        for ranks in [1, 2] {
            run.checks(ranks, "", &ranks.to_string(), &[], 5);
        }
    }
}

fn ends() {
    let run = Run::new(&FIRST, "mpi_ends");
    for ranks in [1, 2] {
        run.checks(ranks, "", &ranks.to_string(), &[], 15);
        assert!(run.at(&ranks.to_string()).join("frame_0.png").is_file());
    }
    Run::against(library(), &FIRST, "mpi_ends").checks(1, "", "", &["without"], 3);
}

fn alone_among_ranks() {
    for library in [mpi_library(), library()] {
        let run = Run::against(library, &FIRST, "mpi_serial");
        for ranks in [1, 2] {
            run.checks(ranks, "", "", &[], 6);
        }
    }
}

/// With `mpi_f08` and with the integers of `mpi`: the world's ranks, and a part of them.
#[test]
fn fortran_hands_its_communicators_over() {
    let Some(directory) = FIRST.directory().filter(|_| has_tool(Need::Fortran, "mpifort")) else { return };
    let program = directory.path().join("mpi_model");
    let mut compile = fortran("mpifort", directory.path(), &[]);
    compile.arg(root().join("tests/fortran/mpi_model.f90"));
    succeeded(compile.args(linked(mpi_library())).arg("-o").arg(&program));
    for ranks in [1, 2, 3] {
        let to = directory.path().join(ranks.to_string());
        let output = succeeded(FIRST.on_ranks(ranks, &program, directory.path()).arg(&to));
        assert_eq!(text(&output.stdout), format!("mpi_model: all well on {ranks}\n"), "{}", text(&output.stderr));
        for name in ["world/f_1.png", "integer/f_1.png", "part/f_1.png"] {
            assert!(to.join(name).is_file(), "{name}");
        }
        let picture = |name: &str| std::fs::read(to.join(name)).unwrap();
        assert!(picture("world/f_1.png") == picture("part/f_1.png"));
        assert!(picture("world/f_1.png") == picture("integer/f_1.png"));
        assert!(picture("world/f_1.png") == picture("columns/f_1.png"));
        for name in ["first/f_1.png", "last/f_1.png"] {
            // One step of eight bits.
            assert!(difference(&to.join(name), &to.join("world/f_1.png"))[0] < 1.1 / 255.0, "{name} of {ranks} ranks");
        }
    }
}
