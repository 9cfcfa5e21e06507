//! `cargo xtask demo` on machines without some software: a lack of the second model never fails the demo.
//!
//! Cargo, the tracer, MPI and apt-get are shell scripts here; the C compiler is this machine's.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::process::Command;
use std::sync::{Mutex, MutexGuard, PoisonError};

use xshell::{Shell, TempDir};

/// A cargo that pretends to build. FAIL names a package that it fails to build.
const CARGO: &str = r#"
case "$*" in *"$FAIL"*) for i in 1 2 3 4 5 6 7 8 9; do echo "line $i" >&2; done; exit 101;; esac
mkdir -p "$PLACE/target/release"
printf '#!/bin/sh\n: >"$3"\n' >"$PLACE/target/release/contact_sheet"
chmod +x "$PLACE/target/release/contact_sheet"
"#;

/// A C compiler that makes a script for the tracer, and programs of other sources.
const CC: &str = r#"
case "$*" in *-licoray*) ;; *) exec cc "$@";; esac
cat >"$PLACE/target/release/tracer" <<'END'
#!/bin/sh
PATH=/usr/bin:/bin
echo "tracer $*" >>"$PLACE/log"
for out; do :; done
echo picture >"$out/tracer_000000.png"
printf 'step,total_s\n0,1.5\n' >"$out/report.csv"
echo "summary steps=1 frames=1 simulation_s=0.5 visualization_s=1.5"
END
chmod +x "$PLACE/target/release/tracer"
"#;

/// An apt-get that knows packages only after an update, and installs the programs of the second model.
const APT_GET: &str = r#"
case $1 in
    --version) ;;
    update) : >"$PLACE/updated";;
    install) [ -e "$PLACE/updated" ] || exit 100
        for name in gfortran make mpicc mpifort mpirun; do cp "$PLACE/later" "$PLACE/bin/$name"; done
        : >"$PLACE/libclang.so";;
esac
"#;

/// Stands for the compilers and the launcher of Open MPI, and for make, which builds nothing.
const OPEN_MPI: &str = "case $1 in --showme:version|--version) echo Open MPI;; esac";

/// Locked by the test that runs: a program that was just written is busy while another test starts a process.
static ALONE: Mutex<()> = Mutex::new(());

/// What a run of the demo did and printed.
struct Ran {
    succeeded: bool,
    printed: String,
    errors: String,
}

/// A machine in a temporary directory.
struct Machine {
    directory: TempDir,
    sh: Shell,
    _alone: MutexGuard<'static, ()>,
}

impl Machine {
    /// A machine with cargo, a C compiler and other programs of [`OPEN_MPI`].
    fn new(programs: &[&str]) -> Self {
        let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
        let sh = Shell::new().unwrap();
        let machine = Self { directory: sh.create_temp_dir().unwrap(), sh, _alone };
        let products = machine.sh.create_dir(machine.file("target/debug")).unwrap();
        machine.sh.copy_file(env!("CARGO_BIN_EXE_xtask"), products).unwrap();
        machine.add("bin/cargo", CARGO);
        machine.add("bin/cc", CC);
        programs.iter().for_each(|name| machine.add(&format!("bin/{name}"), OPEN_MPI));
        machine
    }

    /// A machine with the software that the second model needs.
    fn complete() -> Self {
        let machine = Self::new(&["gfortran", "mpicc", "mpifort", "mpirun", "make"]);
        machine.sh.write_file(machine.file("libclang.so"), "").unwrap();
        machine
    }

    fn file(&self, path: &str) -> PathBuf {
        self.directory.path().join(path)
    }

    fn add(&self, path: &str, script: &str) {
        let file = self.file(path);
        let start = "#!/bin/sh\nPATH=/usr/bin:/bin\necho \"${0##*/} $*\" >>\"$PLACE/log\"";
        self.sh.write_file(&file, format!("{start}\n{script}\n")).unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o755)).unwrap();
    }

    fn demo(&self, fail: &str, options: &[&str]) -> Ran {
        let mut demo = Command::new(self.file("target/debug/xtask"));
        demo.args(["demo", "--out", "pictures"]).args(options).current_dir(self.directory.path());
        demo.env("PATH", self.file("bin"));
        demo.env("PLACE", self.directory.path()).env("FAIL", fail);
        demo.env("CARGO", self.file("bin/cargo")).env("LIBCLANG_PATH", self.file("libclang.so"));
        demo.env_remove("MPICC").env_remove("LD_LIBRARY_PATH");
        let output = demo.output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        Ran { succeeded: output.status.success(), printed: text(&output.stdout), errors: text(&output.stderr) }
    }

    /// The programs that ran, in order.
    fn log(&self) -> String {
        self.sh.read_file(self.file("log")).unwrap()
    }
}

/// Fails unless the demo succeeded with the first model's pictures; returns the lines from the one that says what is
/// left out.
fn left_out(Ran { succeeded, printed, errors }: &Ran) -> Vec<&str> {
    assert!(*succeeded, "{printed}{errors}");
    assert!(
        printed.contains("first picture after ") && printed.contains(" s: pictures/tracer_000000.png\n"),
        "{printed}"
    );
    assert!(printed.contains("\npictures (1), the last one:\n") && printed.contains("contact_sheet.png"), "{printed}");
    printed.lines().skip_while(|line| !line.starts_with("left out: the shallow-water model on 2 ranks")).collect()
}

#[test]
fn a_c_compiler_is_enough() {
    let demo = Machine::new(&[]).demo("nothing", &["--no-install"]);
    let lines = left_out(&demo);
    let packages = "gfortran, make, libopenmpi-dev, openmpi-bin, libclang-dev; run `sudo apt-get install ";
    assert!(lines[0].contains(&format!("--no-install forbids installing: {packages}")), "{lines:#?}");
    assert!(lines.len() == 6 && lines[1..].iter().all(|line| line.starts_with("    ")), "{lines:#?}");
}

#[test]
fn missing_packages_are_installed_at_once() {
    let machine = Machine::new(&[]);
    machine.add("bin/apt-get", APT_GET);
    machine.add("later", OPEN_MPI);
    for (name, script) in [("id", "echo 0"), ("env", "exec env PATH=\"$PLACE/bin\" \"$@\"")] {
        machine.add(&format!("bin/{name}"), script);
    }
    let demo = machine.demo("nothing", &[]);
    // make builds nothing, so there is nothing to run.
    assert!(
        !left_out(&demo).is_empty() && demo.printed.contains("installing gfortran (Fortran compiler"),
        "{}",
        demo.printed
    );
    let log = machine.log();
    let calls: Vec<_> = log.lines().filter(|line| line.starts_with("apt-get ")).collect();
    let packages = " gfortran make libopenmpi-dev openmpi-bin libclang-dev";
    assert!(
        calls.last().is_some_and(|call| call.starts_with("apt-get install -y ") && call.ends_with(packages)),
        "{log}"
    );
    assert!(calls[calls.len() - 2].starts_with("apt-get update"), "{log}");
    assert!(log.contains("icoray-capi-mpi"), "{log}");
}

#[test]
fn the_first_model_runs_before_anything_of_the_second() {
    let machine = Machine::complete();
    let demo = machine.demo("icoray-capi-mpi", &["--no-install"]);
    let lines = left_out(&demo);
    assert!(lines[0].contains("MPI, because `") && lines[0].ends_with("ended with exit status: 101"), "{lines:#?}");
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
    assert!(after.contains("mpicc ") && after.contains("icoray-capi-mpi --no-default-features --features mpi,live"));
}

#[test]
fn a_failure_of_the_first_model_is_one() {
    let Ran { succeeded, printed, errors } = Machine::complete().demo("contact-sheet", &["--no-install"]);
    assert!(!succeeded && !printed.contains("left out"), "{printed}");
    assert!(errors.contains("ended with exit status: 101\nline 1\n"), "{errors}");
}
