//! `cargo xtask demo` on machines that lack things: what the second model lacks never fails the demo.
//!
//! Cargo, the tracer and MPI are shell scripts here; the C compiler of the probes is this machine's.

use std::env;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{self, Command, Stdio};
use std::sync::Mutex;

/// A cargo that "builds" what it is asked for. FAIL names a package that it cannot build.
const CARGO: &str = r#"
echo "cargo $*" >>"$PLACE/log"
case "$*" in *"$FAIL"*) for i in 1 2 3 4 5 6 7 8 9; do echo "line $i" >&2; done; exit 101;; esac
mkdir -p "$PLACE/target/release"
printf '#!/bin/sh\n: >"$3"\n' >"$PLACE/target/release/contact_sheet"
chmod +x "$PLACE/target/release/contact_sheet"
"#;

/// A C compiler that makes a script of the tracer, and programs of all else.
const CC: &str = r#"
echo "cc $*" >>"$PLACE/log"
case "$*" in *-licoray*) ;; *) exec cc "$@";; esac
cat >"$PLACE/target/release/tracer" <<'END'
#!/bin/sh
PATH=/usr/bin:/bin
echo "tracer $*" >>"$PLACE/log"
for out; do :; done
echo picture >"$out/tracer_000000.png"
echo "step,total_s" >"$out/report.csv"
echo "0,1.5" >>"$out/report.csv"
echo "summary steps=1 frames=1 simulation_s=0.5 visualization_s=1.5"
END
chmod +x "$PLACE/target/release/tracer"
"#;

/// An MPI compiler, and GNU's Fortran compiler: their programs are scripts.
const COMPILER: &str = r#"
echo "compiler $*" >>"$PLACE/log"
case $1 in -show) echo cc -lmpi; exit;; --version) echo GNU Fortran; exit;; esac
printf '#!/bin/sh\n[ "$1" ] || echo size ${RANKS:-1}\n[ -z "$1" ] || echo An MPI\n' >"$2"
chmod +x "$2"
"#;

const MPIRUN: &str = r#"
for program; do :; done
export RANKS=2; "$program"; "$program"
"#;

/// Held while programs are written and started: one that a test has just written is busy while another test starts a process.
static STARTING: Mutex<()> = Mutex::new(());

/// A machine in a directory of its own.
struct Machine {
    place: PathBuf,
}

impl Machine {
    /// A machine with cargo and a C compiler, and nothing else.
    fn bare(name: &str) -> Self {
        let _starting = STARTING.lock();
        let place = env::temp_dir().join(format!("icoray-demo-{name}-{}", process::id()));
        let _ = fs::remove_dir_all(&place);
        fs::create_dir_all(place.join("target/debug")).unwrap();
        fs::create_dir_all(place.join("bin")).unwrap();
        fs::copy(env!("CARGO_BIN_EXE_xtask"), place.join("target/debug/xtask")).unwrap();
        let machine = Self { place };
        machine.add("cargo", CARGO);
        machine.add("cc", CC);
        machine
    }

    /// The same with what the second model needs.
    fn complete(name: &str) -> Self {
        let machine = Self::bare(name);
        let _starting = STARTING.lock();
        for compiler in ["gfortran", "mpicc", "mpifort"] {
            machine.add(compiler, COMPILER);
        }
        machine.add("mpirun", MPIRUN);
        machine.add("make", "echo \"make $*\" >>\"$PLACE/log\"");
        let stub = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/probes/libclang_stub.c");
        let mut cc = Command::new("cc");
        cc.args(["-shared", "-fPIC", "-o"]).arg(machine.place.join("libclang.so")).arg(stub);
        assert!(cc.status().unwrap().success());
        machine
    }

    fn add(&self, name: &str, script: &str) {
        let file = self.place.join("bin").join(name);
        fs::write(&file, format!("#!/bin/sh\nPATH=/usr/bin:/bin\n{script}")).unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o755)).unwrap();
    }

    /// Runs the demo; returns whether it succeeded, and what it printed to standard output and error.
    fn demo(&self, fail: &str) -> (bool, String, String) {
        let mut demo = Command::new(self.place.join("target/debug/xtask"));
        demo.args(["demo", "--no-install", "--out", "pictures"]).current_dir(&self.place);
        demo.env("PATH", self.place.join("bin")).env("PLACE", &self.place).env("FAIL", fail);
        demo.env("CARGO", self.place.join("bin/cargo")).env("LIBCLANG_PATH", self.place.join("libclang.so"));
        demo.env_remove("MPICC").env_remove("LD_LIBRARY_PATH");
        demo.stdout(Stdio::piped()).stderr(Stdio::piped());
        let child = {
            let _starting = STARTING.lock();
            demo.spawn().unwrap()
        };
        let output = child.wait_with_output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (output.status.success(), text(&output.stdout), text(&output.stderr))
    }

    /// The programs that ran, in order.
    fn log(&self) -> String {
        fs::read_to_string(self.place.join("log")).unwrap()
    }
}

impl Drop for Machine {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.place);
    }
}

/// The lines from the one that tells what is left out.
fn left_out(printed: &str) -> Vec<&str> {
    printed.lines().skip_while(|line| !line.starts_with("left out: ")).collect()
}

/// Fails unless the first model's pictures are told.
fn assert_first_model(printed: &str) {
    assert!(printed.contains("first picture after "), "{printed}");
    assert!(printed.contains(" s: pictures/tracer_000000.png\n"), "{printed}");
    assert!(printed.contains("\npictures (1):\n") && printed.contains("contact_sheet.png"), "{printed}");
}

#[test]
fn a_c_compiler_is_enough() {
    let machine = Machine::bare("bare");
    let (succeeded, printed, errors) = machine.demo("nothing");
    assert!(succeeded, "{printed}{errors}");
    assert_first_model(&printed);
    let lines = left_out(&printed);
    let start = "left out: the shallow-water model on 2 ranks of MPI, because gfortran, make, libopenmpi-dev and libclang-dev are \
                 missing, and --no-install forbids installing: ";
    assert!(lines[0].starts_with(start), "{printed}");
    assert!(lines.len() == 6 && lines[1..].iter().all(|line| line.starts_with("    ")), "{lines:#?}");
}

#[test]
fn the_first_model_runs_before_anything_of_the_second() {
    let machine = Machine::complete("order");
    let (succeeded, printed, errors) = machine.demo("icoray-capi-mpi");
    assert!(succeeded, "{printed}{errors}");
    assert_first_model(&printed);
    let lines = left_out(&printed);
    assert!(
        lines[0].contains("MPI, because `") && lines[0].ends_with("ended with exit status: 101"),
        "{printed}"
    );
    assert_eq!(lines[1..], ["    line 5", "    line 6", "    line 7", "    line 8", "    line 9"]);
    let log = machine.log();
    let (before, after) = log.split_once("tracer ").unwrap();
    let all: Vec<_> = before.lines().filter(|line| !line.starts_with("cc ")).collect();
    assert_eq!(
        all,
        ["cargo build --profile release --package icoray-capi --package contact-sheet --no-default-features"]
    );
    assert!(
        after.contains("compiler -show")
            && after.contains("icoray-capi-mpi --no-default-features --features mpi")
    );
}

#[test]
fn what_fails_later_is_left_out_too() {
    let machine = Machine::complete("later");
    // make builds nothing, so there is nothing to run.
    let (succeeded, printed, errors) = machine.demo("nothing");
    assert!(succeeded, "{printed}{errors}");
    assert_first_model(&printed);
    assert!(left_out(&printed)[0].contains("shallow-water model on 2 ranks"), "{printed}");
}

#[test]
fn a_failure_of_the_first_model_is_one() {
    let machine = Machine::complete("first");
    let (succeeded, printed, errors) = machine.demo("contact-sheet");
    assert!(!succeeded && left_out(&printed).is_empty(), "{printed}");
    assert!(errors.contains("ended with exit status: 101\nline 1\n"), "{errors}");
}
