//! `cargo xtask demo` on machines without some software: a lack of the second model never fails the demo.
//!
//! Cargo, the tracer and MPI are shell scripts here; the C compiler is this machine's.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::Mutex;

use xshell::{Shell, TempDir, cmd};

/// A cargo that pretends to build. FAIL names a package that it fails to build.
const CARGO: &str = r#"
echo "cargo $*" >>"$PLACE/log"
case "$*" in *"$FAIL"*) for i in 1 2 3 4 5 6 7 8 9; do echo "line $i" >&2; done; exit 101;; esac
mkdir -p "$PLACE/target/release"
printf '#!/bin/sh\n: >"$3"\n' >"$PLACE/target/release/contact_sheet"
chmod +x "$PLACE/target/release/contact_sheet"
"#;

/// A C compiler that makes a script for the tracer, and programs of other sources.
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

/// Locked while programs are written and started: a program that was just written is busy while another test starts a
/// process.
static STARTING: Mutex<()> = Mutex::new(());

/// A machine in a temporary directory.
struct Machine {
    directory: TempDir,
    sh: Shell,
}

impl Machine {
    /// A machine with cargo and a C compiler only.
    fn bare() -> Self {
        let _starting = STARTING.lock();
        let sh = Shell::new().unwrap();
        let machine = Self { directory: sh.create_temp_dir().unwrap(), sh };
        let programs = machine.sh.create_dir(machine.file("target/debug")).unwrap();
        machine.sh.copy_file(env!("CARGO_BIN_EXE_xtask"), programs).unwrap();
        machine.add("cargo", CARGO);
        machine.add("cc", CC);
        machine
    }

    /// The same with the software that the second model needs.
    fn complete() -> Self {
        let machine = Self::bare();
        let _starting = STARTING.lock();
        for compiler in ["gfortran", "mpicc", "mpifort"] {
            machine.add(compiler, COMPILER);
        }
        machine.add("mpirun", MPIRUN);
        machine.add("make", "echo \"make $*\" >>\"$PLACE/log\"");
        let (library, stub) = (machine.file("libclang.so"), "src/probes/libclang_stub.c");
        machine.sh.change_dir(env!("CARGO_MANIFEST_DIR"));
        cmd!(machine.sh, "cc -shared -fPIC -o {library} {stub}").quiet().run().unwrap();
        machine
    }

    fn file(&self, path: &str) -> PathBuf {
        self.directory.path().join(path)
    }

    fn add(&self, name: &str, script: &str) {
        let file = self.file("bin").join(name);
        self.sh.write_file(&file, format!("#!/bin/sh\nPATH=/usr/bin:/bin\n{script}")).unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o755)).unwrap();
    }

    /// Runs the demo; returns whether it succeeded, its standard output and its standard error.
    fn demo(&self, fail: &str) -> (bool, String, String) {
        let mut demo = Command::new(self.file("target/debug/xtask"));
        demo.args(["demo", "--no-install", "--out", "pictures"]).current_dir(self.directory.path());
        demo.env("PATH", self.file("bin")).env("PLACE", self.directory.path()).env("FAIL", fail);
        demo.env("CARGO", self.file("bin/cargo")).env("LIBCLANG_PATH", self.file("libclang.so"));
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
        self.sh.read_file(self.file("log")).unwrap()
    }
}

/// The lines from the one that says what is left out.
fn left_out(printed: &str) -> Vec<&str> {
    printed.lines().skip_while(|line| !line.starts_with("left out: ")).collect()
}

/// Fails unless the output names the first model's pictures.
fn assert_first_model(printed: &str) {
    assert!(printed.contains("first picture after "), "{printed}");
    assert!(printed.contains(" s: pictures/tracer_000000.png\n"), "{printed}");
    assert!(printed.contains("\npictures (1):\n") && printed.contains("contact_sheet.png"), "{printed}");
}

#[test]
fn a_c_compiler_is_enough() {
    let machine = Machine::bare();
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
    let machine = Machine::complete();
    let (succeeded, printed, errors) = machine.demo("icoray-capi-mpi");
    assert!(succeeded, "{printed}{errors}");
    assert_first_model(&printed);
    let lines = left_out(&printed);
    assert!(lines[0].contains("MPI, because `") && lines[0].ends_with("ended with exit status: 101"), "{printed}");
    assert_eq!(lines[1..], ["    line 5", "    line 6", "    line 7", "    line 8", "    line 9"]);
    let log = machine.log();
    let (before, after) = log.split_once("tracer ").unwrap();
    let all: Vec<_> = before.lines().filter(|line| !line.starts_with("cc ")).collect();
    assert_eq!(
        all,
        [
            "cargo build --profile release --package icoray-capi --package contact-sheet --no-default-features --features icoray-capi/live"
        ]
    );
    assert!(
        after.contains("compiler -show") && after.contains("icoray-capi-mpi --no-default-features --features mpi,live")
    );
}

#[test]
fn what_fails_later_is_left_out_too() {
    let machine = Machine::complete();
    // make builds nothing, so there is nothing to run.
    let (succeeded, printed, errors) = machine.demo("nothing");
    assert!(succeeded, "{printed}{errors}");
    assert_first_model(&printed);
    assert!(left_out(&printed)[0].contains("shallow-water model on 2 ranks"), "{printed}");
}

#[test]
fn a_failure_of_the_first_model_is_one() {
    let machine = Machine::complete();
    let (succeeded, printed, errors) = machine.demo("contact-sheet");
    assert!(!succeeded && left_out(&printed).is_empty(), "{printed}");
    assert!(errors.contains("ended with exit status: 101\nline 1\n"), "{errors}");
}
