//! The command line.

use std::ffi::OsString;
use std::path::{Component, PathBuf};
use std::str::FromStr;

use crate::error::Error;

/// What `--help` prints.
pub const USAGE: &str = "\
Usage: cargo xtask <demo|gallery|test|install> [options]

demo  Builds the C library and the tracer model of examples/c, runs the model,
      which renders itself, and prints where the pictures are and what they
      cost. Then the same with the shallow-water model of examples/fortran on
      two ranks of MPI. If that cannot be built or run, it is left out with the
      reason, and the demo still succeeds.
  --out DIR      where the pictures go            [default: out/demo]
  --level N      refinement level of the grid     [default: 5]
  --layers N     vertical layers of the model     [default: 30]
  --days X       simulated days                   [default: 12]
  --scene FILE   what the pictures show           [default: examples/scenes/tracer.toml]
  --backend WHO  what renders: cpu, gpu, or auto (a GPU if there is one); with
                 auto or gpu the library is built with GPUs
  --no-install   install nothing; say what is missing instead
  --level, --layers, --days and --scene are for the tracer model.

gallery  Renders the example scenes of the files in ../shared/data and of the
      models of the demo into examples/gallery, and writes its page. Pictures
      whose file is missing are kept, and their scenes are listed.
  --profile NAME cargo's profile: release, dev    [default: release]
  --no-install   install nothing; say what is missing instead
  ICORAY_TEST_DATA=DIR   in the environment: where the files are

test  Checks formatting, lints, and the tests of everything but GPU and MPI;
      fails at the end if any of them failed. The last lines say how many tests
      were skipped, by cause, and: N passed, N failed, N skipped.
  --all          also GPU and MPI, valgrind, long counts (10,000,000 rays, 60,000
                 damaged grids, 10,000 frames), documentation, and programs in C,
                 C++ and Fortran that link the installed library
  --no-install   install nothing; say what is missing instead
  ICORAY_REQUIRE=LIST   in the environment: fail tests that would be skipped for
                 want of these, separated by commas: all, or some of long, gpu,
                 mpi, mpich, fortran, c++, make, binutils, sanitizers, valgrind,
                 counters, mount, glibc, memory, data
  ICORAY_TEST_DATA=DIR   in the environment: where the files of models are

install  Builds the C library for Linux and installs it: shared and static
      library, header, Fortran module's source, files for pkg-config and CMake.
      Nothing is replaced before all is built; running programs keep the files
      that they opened. The installed tree may be moved as a whole.
  --prefix DIR   where to install                 [default: /usr/local]
  --libdir DIR   the libraries' directory in it, such as lib64   [default: lib]
  --mpi          with icoray_open over several ranks, for the MPI of `mpicc`
                 or of the compiler that the environment variable MPICC names
  --no-gpu       without GPUs, for a smaller library
  --no-install   install no packages; say what is missing instead
  DESTDIR=DIR    in the environment: put everything below DIR, for packagers

All of them install missing Debian packages with apt-get (as root or by sudo)
and missing Rust components with rustup, and print which.";

/// What a scene's `backend` may be.
const BACKENDS: [&str; 3] = ["auto", "cpu", "gpu"];

/// Cargo's profiles that the gallery may be drawn with.
const PROFILES: [&str; 2] = ["release", "dev"];

/// One call of this program.
#[derive(Debug, PartialEq)]
pub enum Invocation {
    /// Print the usage.
    Help,
    /// Run the demo.
    Demo(DemoOptions),
    /// Draw the gallery.
    Gallery(GalleryOptions),
    /// Run the checks.
    Test(TestOptions),
    /// Install the C library.
    Install(InstallOptions),
}

/// Options of `demo`.
#[derive(Debug, PartialEq)]
pub struct DemoOptions {
    /// Where the pictures go; the workspace's `out/demo` where none is given.
    pub out: Option<PathBuf>,
    /// The scene to draw; the example's own where none is given.
    pub scene: Option<PathBuf>,
    /// What renders; without it, what the scenes say.
    pub backend: Option<&'static str>,
    /// The size of the simulation.
    pub size: Size,
    /// Whether missing packages may be installed.
    pub install: bool,
}

/// How large a simulation the tracer model runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Size {
    /// Refinement level of the geodesic grid.
    pub level: u32,
    /// Vertical layers.
    pub layers: u32,
    /// Simulated days.
    pub days: f64,
}

/// Options of `gallery`.
#[derive(Debug, PartialEq)]
pub struct GalleryOptions {
    /// Cargo's profile to build with.
    pub profile: &'static str,
    /// Whether missing packages may be installed.
    pub install: bool,
}

/// Options of `test`.
#[derive(Debug, PartialEq)]
pub struct TestOptions {
    /// Whether to run all that there is.
    pub all: bool,
    /// Whether missing packages may be installed.
    pub install: bool,
}

/// Options of `install`.
#[derive(Debug, PartialEq)]
pub struct InstallOptions {
    /// Where to install.
    pub prefix: PathBuf,
    /// Where the libraries go, below the prefix.
    pub libdir: PathBuf,
    /// Whether several ranks may draw together.
    pub mpi: bool,
    /// Whether GPUs may draw.
    pub gpu: bool,
    /// Whether missing packages may be installed.
    pub install: bool,
}

/// Parses the arguments after the program's name.
pub fn parse(arguments: impl IntoIterator<Item = OsString>) -> Result<Invocation, Error> {
    let mut arguments = Arguments { rest: arguments.into_iter().collect::<Vec<_>>().into_iter() };
    let Some(subcommand) = arguments.rest.next() else {
        return Err(Error::Usage("a subcommand is missing".into()));
    };
    match subcommand.to_str() {
        Some("demo") => parse_demo(arguments),
        Some("gallery") => parse_gallery(arguments),
        Some("test") => parse_test(arguments),
        Some("install") => parse_install(arguments),
        Some("help" | "--help" | "-h") => Ok(Invocation::Help),
        _ => Err(Error::Usage(format!("unknown subcommand {}", quoted(&subcommand)))),
    }
}

fn parse_demo(mut arguments: Arguments) -> Result<Invocation, Error> {
    let mut options = DemoOptions {
        out: None,
        scene: None,
        backend: None,
        size: Size { level: 5, layers: 30, days: 12.0 },
        install: true,
    };
    while let Some(option) = arguments.next_option()? {
        match option.name.as_str() {
            "--out" => options.out = Some(arguments.value(option)?.into()),
            "--scene" => options.scene = Some(arguments.value(option)?.into()),
            "--backend" => options.backend = Some(arguments.one_of(option, &BACKENDS)?),
            "--level" => options.size.level = arguments.number(option)?,
            "--layers" => options.size.layers = arguments.number(option)?,
            "--days" => options.size.days = arguments.number(option)?,
            "--no-install" => options.install = !option.given()?,
            "--help" | "-h" => return Ok(Invocation::Help),
            _ => return Err(option.unknown("demo")),
        }
    }
    let Size { layers, days, .. } = options.size;
    if layers == 0 {
        return Err(Error::Usage("--layers must be at least 1".into()));
    }
    if !(days.is_finite() && days > 0.0) {
        return Err(Error::Usage("--days must be a positive number".into()));
    }
    Ok(Invocation::Demo(options))
}

fn parse_gallery(mut arguments: Arguments) -> Result<Invocation, Error> {
    let mut options = GalleryOptions { profile: "release", install: true };
    while let Some(option) = arguments.next_option()? {
        match option.name.as_str() {
            "--profile" => options.profile = arguments.one_of(option, &PROFILES)?,
            "--no-install" => options.install = !option.given()?,
            "--help" | "-h" => return Ok(Invocation::Help),
            _ => return Err(option.unknown("gallery")),
        }
    }
    Ok(Invocation::Gallery(options))
}

fn parse_test(mut arguments: Arguments) -> Result<Invocation, Error> {
    let mut options = TestOptions { all: false, install: true };
    while let Some(option) = arguments.next_option()? {
        match option.name.as_str() {
            "--all" => options.all = option.given()?,
            "--no-install" => options.install = !option.given()?,
            "--help" | "-h" => return Ok(Invocation::Help),
            _ => return Err(option.unknown("test")),
        }
    }
    Ok(Invocation::Test(options))
}

fn parse_install(mut arguments: Arguments) -> Result<Invocation, Error> {
    // The usual prefix of `make install`.
    let mut options = InstallOptions {
        prefix: "/usr/local".into(),
        libdir: "lib".into(),
        mpi: false,
        gpu: true,
        install: true,
    };
    while let Some(option) = arguments.next_option()? {
        match option.name.as_str() {
            "--prefix" => options.prefix = arguments.value(option)?.into(),
            "--libdir" => options.libdir = arguments.value(option)?.into(),
            "--mpi" => options.mpi = option.given()?,
            "--no-gpu" => options.gpu = !option.given()?,
            "--no-install" => options.install = !option.given()?,
            "--help" | "-h" => return Ok(Invocation::Help),
            _ => return Err(option.unknown("install")),
        }
    }
    // What is installed finds its other parts from where it lies itself.
    if !options.libdir.components().all(|part| matches!(part, Component::Normal(_))) {
        let given = quoted(options.libdir.as_os_str());
        return Err(Error::Usage(format!("--libdir must be a path below the prefix, not {given}")));
    }
    Ok(Invocation::Install(options))
}

/// The arguments not yet looked at.
struct Arguments {
    rest: std::vec::IntoIter<OsString>,
}

/// One option, and its value where it was written as `--name=value`.
struct Opt {
    name: String,
    value: Option<OsString>,
}

impl Arguments {
    fn next_option(&mut self) -> Result<Option<Opt>, Error> {
        let Some(argument) = self.rest.next() else {
            return Ok(None);
        };
        // Only a value may be something other than Unicode, and only as an argument of its own.
        let Some(text) = argument.to_str() else {
            return Err(Error::Usage(format!("unknown argument {}", quoted(&argument))));
        };
        Ok(Some(match text.split_once('=') {
            Some((name, value)) if name.starts_with("--") => {
                Opt { name: name.into(), value: Some(value.into()) }
            }
            _ => Opt { name: text.into(), value: None },
        }))
    }

    fn value(&mut self, option: Opt) -> Result<OsString, Error> {
        match option.value.or_else(|| self.rest.next()) {
            Some(value) if !value.is_empty() => Ok(value),
            _ => Err(Error::Usage(format!("{} needs a value", option.name))),
        }
    }

    fn one_of(&mut self, option: Opt, known: &[&'static str]) -> Result<&'static str, Error> {
        let name = option.name.clone();
        let value = self.value(option)?;
        let found = known.iter().find(|word| value == **word).copied();
        found.ok_or_else(|| {
            Error::Usage(format!("{name} must be one of {}, not {}", known.join(", "), quoted(&value)))
        })
    }

    fn number<T: FromStr>(&mut self, option: Opt) -> Result<T, Error> {
        let name = option.name.clone();
        let value = self.value(option)?;
        let number = value.to_str().and_then(|text| text.parse().ok());
        number.ok_or_else(|| Error::Usage(format!("{name} cannot be {}", quoted(&value))))
    }
}

impl Opt {
    /// True, for an option whose presence is all it says.
    fn given(self) -> Result<bool, Error> {
        match self.value {
            None => Ok(true),
            Some(_) => Err(Error::Usage(format!("{} takes no value", self.name))),
        }
    }

    fn unknown(self, subcommand: &str) -> Error {
        Error::Usage(format!("{subcommand} has no option '{}'", self.name))
    }
}

fn quoted(text: &std::ffi::OsStr) -> String {
    format!("'{}'", text.display())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse_words(line: &str) -> Result<Invocation, Error> {
        parse(line.split_whitespace().map(OsString::from))
    }

    fn complaint(line: &str) -> String {
        match parse_words(line) {
            Err(Error::Usage(message)) => message,
            other => panic!("'{line}' gave {other:?}"),
        }
    }

    #[test]
    fn demo_has_defaults() {
        let expected = DemoOptions {
            out: None,
            scene: None,
            backend: None,
            size: Size { level: 5, layers: 30, days: 12.0 },
            install: true,
        };
        assert_eq!(parse_words("demo"), Ok(Invocation::Demo(expected)));
    }

    #[test]
    fn demo_takes_values_in_either_form() {
        let expected = DemoOptions {
            out: Some("pictures".into()),
            scene: Some("my.toml".into()),
            backend: Some("gpu"),
            size: Size { level: 3, layers: 8, days: 0.5 },
            install: false,
        };
        assert_eq!(
            parse_words(
                "demo --out pictures --scene=my.toml --backend gpu --level=3 --layers 8 --days .5 --no-install"
            ),
            Ok(Invocation::Demo(expected))
        );
    }

    #[test]
    fn test_takes_flags() {
        assert_eq!(parse_words("test"), Ok(Invocation::Test(TestOptions { all: false, install: true })));
        assert_eq!(
            parse_words("test --all --no-install"),
            Ok(Invocation::Test(TestOptions { all: true, install: false }))
        );
    }

    #[test]
    fn gallery_is_built_for_release_unless_told() {
        let expected = GalleryOptions { profile: "release", install: true };
        assert_eq!(parse_words("gallery"), Ok(Invocation::Gallery(expected)));
        let expected = GalleryOptions { profile: "dev", install: false };
        assert_eq!(parse_words("gallery --profile=dev --no-install"), Ok(Invocation::Gallery(expected)));
        assert_eq!(complaint("gallery --profile fast"), "--profile must be one of release, dev, not 'fast'");
    }

    #[test]
    fn install_goes_where_make_install_goes_unless_told() {
        let expected = InstallOptions {
            prefix: "/usr/local".into(),
            libdir: "lib".into(),
            mpi: false,
            gpu: true,
            install: true,
        };
        assert_eq!(parse_words("install"), Ok(Invocation::Install(expected)));
        let expected = InstallOptions {
            prefix: "here".into(),
            libdir: "lib/x".into(),
            mpi: true,
            gpu: false,
            install: false,
        };
        assert_eq!(
            parse_words("install --prefix here --libdir=lib/x --mpi --no-gpu --no-install"),
            Ok(Invocation::Install(expected))
        );
    }

    #[test]
    fn help_is_found_wherever_it_stands() {
        for line in ["--help", "-h", "help", "demo --help", "test --all -h", "install -h"] {
            assert_eq!(parse_words(line), Ok(Invocation::Help), "{line}");
        }
    }

    #[test]
    fn nonsense_is_refused_by_name() {
        assert_eq!(complaint(""), "a subcommand is missing");
        assert_eq!(complaint("dmeo"), "unknown subcommand 'dmeo'");
        assert_eq!(complaint("demo --all"), "demo has no option '--all'");
        assert_eq!(complaint("test here"), "test has no option 'here'");
        assert_eq!(complaint("demo --level"), "--level needs a value");
        assert_eq!(complaint("demo --out="), "--out needs a value");
        assert_eq!(complaint("demo --level five"), "--level cannot be 'five'");
        assert_eq!(complaint("demo --level -1"), "--level cannot be '-1'");
        assert_eq!(complaint("demo --layers 0"), "--layers must be at least 1");
        assert_eq!(complaint("demo --days nan"), "--days must be a positive number");
        assert_eq!(complaint("install /usr"), "install has no option '/usr'");
        for libdir in ["/usr/lib", "../lib"] {
            let expected = format!("--libdir must be a path below the prefix, not '{libdir}'");
            assert_eq!(complaint(&format!("install --libdir {libdir}")), expected);
        }
        assert_eq!(
            complaint("demo --backend vulkan"),
            "--backend must be one of auto, cpu, gpu, not 'vulkan'"
        );
        assert_eq!(complaint("test --all=yes"), "--all takes no value");
    }
}
