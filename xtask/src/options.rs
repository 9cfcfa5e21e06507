//! The command line.

use std::ffi::{OsStr, OsString};
use std::path::{Component, PathBuf};
use std::str::FromStr;

use lexopt::{Arg, Parser};

use crate::error::Error;

/// The text of `--help`.
pub const USAGE: &str = include_str!("usage.txt").trim_ascii_end();

/// Values of `--backend`.
const BACKENDS: [&str; 3] = ["auto", "cpu", "gpu"];

/// Values of `--profile`.
const PROFILES: [&str; 2] = ["release", "dev"];

/// One call of this program.
#[derive(Debug, PartialEq)]
pub struct Invocation {
    pub subcommand: Subcommand,
    /// Whether missing packages may be installed.
    pub install: bool,
}

/// A subcommand with its options.
#[derive(Debug, PartialEq)]
pub enum Subcommand {
    Help,
    Demo(DemoOptions),
    /// With cargo's profile to build with.
    Gallery {
        profile: &'static str,
    },
    /// With the long checks, or without.
    Test {
        all: bool,
    },
    Install(InstallOptions),
    Package,
}

/// Options of `demo`.
#[derive(Debug, Default, PartialEq)]
pub struct DemoOptions {
    /// Directory of the pictures; default: `out/demo` in the workspace.
    pub out: Option<PathBuf>,
    /// Scene of the tracer model; default: the example's.
    pub scene: Option<PathBuf>,
    /// Backend that replaces the one of the scenes.
    pub backend: Option<&'static str>,
    pub size: Size,
}

/// Size of a run of the tracer model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Size {
    /// Refinement level of the geodesic grid.
    pub level: u32,
    /// Number of vertical layers.
    pub layers: u32,
    /// Simulated days.
    pub days: f64,
}

impl Default for Size {
    fn default() -> Self {
        Self { level: 5, layers: 30, days: 12.0 }
    }
}

/// Options of `install`.
#[derive(Debug, PartialEq)]
pub struct InstallOptions {
    pub prefix: PathBuf,
    /// Directory of the libraries, relative to the prefix.
    pub libdir: PathBuf,
    /// Whether to build with MPI.
    pub mpi: bool,
    /// Whether to build with GPUs.
    pub gpu: bool,
    /// The prefix of ComIn, to build the plugin for ICON.
    pub comin: Option<PathBuf>,
    /// Whether to build the implementation of Catalyst.
    pub catalyst: bool,
}

impl Default for InstallOptions {
    fn default() -> Self {
        Self { prefix: "/usr/local".into(), libdir: "lib".into(), mpi: false, gpu: true, comin: None, catalyst: false }
    }
}

/// Parses the arguments that follow the program's name.
pub fn parse(arguments: impl IntoIterator<Item = OsString>) -> Result<Invocation, Error> {
    let mut arguments = arguments.into_iter();
    let Some(name) = arguments.next() else {
        return Err(Error::Usage("a subcommand is missing".into()));
    };
    let subcommand = match name.to_str() {
        Some("demo") => Subcommand::Demo(DemoOptions::default()),
        Some("gallery") => Subcommand::Gallery { profile: "release" },
        Some("test") => Subcommand::Test { all: false },
        Some("install") => Subcommand::Install(InstallOptions::default()),
        Some("package") => Subcommand::Package,
        Some("help" | "--help" | "-h") => Subcommand::Help,
        _ => return Err(Error::Usage(format!("unknown subcommand {}", quoted(&name)))),
    };
    parse_options(subcommand, Parser::from_args(arguments)).map_err(|error| {
        let no_option = |option: &OsStr| format!("{} has no option {}", name.display(), quoted(option));
        Error::Usage(match error {
            lexopt::Error::UnexpectedOption(option) => no_option(option.as_ref()),
            lexopt::Error::UnexpectedArgument(argument) => no_option(&argument),
            lexopt::Error::UnexpectedValue { option, .. } => format!("{option} takes no value"),
            lexopt::Error::MissingValue { option } => needs_value(&option.unwrap_or_default()),
            other => other.to_string(),
        })
    })
}

fn parse_options(mut subcommand: Subcommand, mut parser: Parser) -> Result<Invocation, lexopt::Error> {
    use Subcommand::{Demo, Gallery, Help, Install, Test};
    let mut install = true;
    while subcommand != Help
        && let Some(option) = next_option(&mut parser)?
    {
        let mut argument = Argument { option: &option, parser: &mut parser };
        match (&mut subcommand, option.as_str()) {
            (_, "--help" | "-h") => subcommand = Help,
            (_, "--no-install") => install = false,
            (Demo(options), "--out") => options.out = Some(argument.value()?.into()),
            (Demo(options), "--scene") => options.scene = Some(argument.value()?.into()),
            (Demo(options), "--backend") => options.backend = Some(argument.one_of(&BACKENDS)?),
            (Demo(options), "--level") => options.size.level = argument.number()?,
            (Demo(options), "--layers") => options.size.layers = argument.number()?,
            (Demo(options), "--days") => options.size.days = argument.number()?,
            (Gallery { profile }, "--profile") => *profile = argument.one_of(&PROFILES)?,
            (Test { all }, "--all") => *all = true,
            (Install(options), "--prefix") => options.prefix = argument.value()?.into(),
            (Install(options), "--libdir") => options.libdir = argument.value()?.into(),
            (Install(options), "--mpi") => options.mpi = true,
            (Install(options), "--no-gpu") => options.gpu = false,
            (Install(options), "--catalyst") => options.catalyst = true,
            (Install(options), "--comin") => options.comin = Some(argument.value()?.into()),
            _ => return Err(lexopt::Error::UnexpectedOption(option)),
        }
    }
    check(&subcommand)?;
    Ok(Invocation { subcommand, install })
}

/// The next option, with its hyphens.
fn next_option(parser: &mut Parser) -> Result<Option<String>, lexopt::Error> {
    Ok(match parser.next()? {
        Some(Arg::Long(name)) => Some(format!("--{name}")),
        Some(Arg::Short(name)) => Some(format!("-{name}")),
        Some(argument @ Arg::Value(_)) => return Err(argument.unexpected()),
        None => None,
    })
}

/// Checks the ranges of values.
fn check(subcommand: &Subcommand) -> Result<(), String> {
    match subcommand {
        Subcommand::Demo(DemoOptions { size, .. }) if size.layers == 0 => Err("--layers must be at least 1".into()),
        Subcommand::Demo(DemoOptions { size, .. }) if !(size.days.is_finite() && size.days > 0.0) => {
            Err("--days must be a positive number".into())
        }
        // Installed files refer to each other by relative paths.
        Subcommand::Install(InstallOptions { libdir, .. })
            if !libdir.components().all(|part| matches!(part, Component::Normal(_))) =>
        {
            Err(format!("--libdir must be a path below the prefix, not {}", quoted(libdir.as_os_str())))
        }
        _ => Ok(()),
    }
}

/// The argument of an option.
struct Argument<'a> {
    option: &'a str,
    parser: &'a mut Parser,
}

impl Argument<'_> {
    fn value(&mut self) -> Result<OsString, lexopt::Error> {
        let value = self.parser.value()?;
        if value.is_empty() { Err(needs_value(self.option).into()) } else { Ok(value) }
    }

    fn one_of(&mut self, known: &[&'static str]) -> Result<&'static str, lexopt::Error> {
        let value = self.value()?;
        let found = known.iter().find(|word| value == **word).copied();
        let (option, known) = (self.option, known.join(", "));
        Ok(found.ok_or_else(|| format!("{option} must be one of {known}, not {}", quoted(&value)))?)
    }

    fn number<T: FromStr>(&mut self) -> Result<T, lexopt::Error> {
        let value = self.value()?;
        let number = value.to_str().and_then(|text| text.parse().ok());
        Ok(number.ok_or_else(|| format!("{} cannot be {}", self.option, quoted(&value)))?)
    }
}

fn needs_value(option: &str) -> String {
    format!("{option} needs a value")
}

fn quoted(text: &OsStr) -> String {
    format!("'{}'", text.display())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse_words(line: &str) -> Result<Invocation, Error> {
        parse(line.split_whitespace().map(OsString::from))
    }

    #[test]
    fn options_have_defaults_and_take_values_in_either_form() {
        let demo = DemoOptions {
            out: Some("pictures".into()),
            scene: Some("my.toml".into()),
            backend: Some("gpu"),
            size: Size { level: 3, layers: 8, days: 0.5 },
        };
        let default =
            DemoOptions { out: None, scene: None, backend: None, size: Size { level: 5, layers: 30, days: 12.0 } };
        let usual = InstallOptions {
            prefix: "/usr/local".into(),
            libdir: "lib".into(),
            mpi: false,
            gpu: true,
            comin: None,
            catalyst: false,
        };
        let comin = Some("icon".into());
        let prefix = "here".into();
        let libdir = "lib/x".into();
        let other = InstallOptions { prefix, libdir, mpi: true, gpu: false, comin, catalyst: true };
        let demo_line = "demo --out pictures --scene=my.toml --backend gpu --level=3 --layers 8 --days .5 --no-install";
        let install_line = "install --prefix here --libdir=lib/x --mpi --no-gpu --comin icon --catalyst --no-install";
        for (line, subcommand, install) in [
            ("demo", Subcommand::Demo(default), true),
            (demo_line, Subcommand::Demo(demo), false),
            ("test", Subcommand::Test { all: false }, true),
            ("test --all --no-install", Subcommand::Test { all: true }, false),
            ("gallery", Subcommand::Gallery { profile: "release" }, true),
            ("gallery --profile=dev --no-install", Subcommand::Gallery { profile: "dev" }, false),
            ("install", Subcommand::Install(usual), true),
            ("package", Subcommand::Package, true),
            (install_line, Subcommand::Install(other), false),
        ] {
            assert_eq!(parse_words(line), Ok(Invocation { subcommand, install }), "{line}");
        }
    }

    #[test]
    fn help_is_found_wherever_it_stands() {
        for line in ["--help", "-h", "help", "demo --help", "test --all -h", "install -h"] {
            let help = Invocation { subcommand: Subcommand::Help, install: true };
            assert_eq!(parse_words(line), Ok(help), "{line}");
        }
    }

    #[test]
    fn wrong_arguments_are_named() {
        for (line, message) in [
            ("", "a subcommand is missing"),
            ("dmeo", "unknown subcommand 'dmeo'"),
            ("demo --all", "demo has no option '--all'"),
            ("test here", "test has no option 'here'"),
            ("demo --level", "--level needs a value"),
            ("demo --out=", "--out needs a value"),
            ("demo --level five", "--level cannot be 'five'"),
            ("demo --level -1", "--level cannot be '-1'"),
            ("demo --layers 0", "--layers must be at least 1"),
            ("demo --days nan", "--days must be a positive number"),
            ("demo --backend vulkan", "--backend must be one of auto, cpu, gpu, not 'vulkan'"),
            ("gallery --profile fast", "--profile must be one of release, dev, not 'fast'"),
            ("install /usr", "install has no option '/usr'"),
            ("install --libdir /usr/lib", "--libdir must be a path below the prefix, not '/usr/lib'"),
            ("install --libdir ../lib", "--libdir must be a path below the prefix, not '../lib'"),
            ("test --all=yes", "--all takes no value"),
        ] {
            assert_eq!(parse_words(line), Err(Error::Usage(message.into())), "{line}");
        }
    }
}
