//! libclang, with which bindgen reads MPI's header for Rust.
//!
//! Searches as bindgen's clang-sys does, and then uses the library as bindgen does: a small program loads it and parses
//! a header that needs clang's own headers. `libclang-cpp.so` is another library (its interface is C++), and libclang
//! without the headers of `libclang-common-*-dev` cannot read `stddef.h`.

use std::cmp::Reverse;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::error::Error;
use crate::files;
use crate::host::{Host, Probe};

/// Patterns of the directories that are searched last, below the root.
const DIRECTORIES: [&str; 7] = [
    "usr/local/llvm*/lib*",
    "usr/local/lib*/*/*",
    "usr/local/lib*/*",
    "usr/local/lib*",
    "usr/lib*/*/*",
    "usr/lib*/*",
    "usr/lib*",
];
/// Patterns of the library's name, in the order of preference.
const NAMES: [&str; 4] = ["libclang.so", "libclang-*.so", "libclang.so.*", "libclang-*.so.*"];

static USER: Probe = Probe { name: "libclang.c", text: include_str!("probes/libclang.c") };
/// Headers that come with clang, and one of the C library's, as MPI's header includes.
static HEADER: Probe =
    Probe { name: "probe.h", text: "#include <stddef.h>\n#include <stdint.h>\n#include <stdio.h>\n" };

/// A libclang that works.
#[derive(Debug, PartialEq)]
pub struct Libclang {
    /// Its file.
    pub file: PathBuf,
    /// Whether it is the one that bindgen chooses by itself; otherwise LIBCLANG_PATH has to name it.
    pub first: bool,
}

/// The first libclang that works, in bindgen's order; or else in one line why there is none.
pub fn find(host: &Host) -> Result<Libclang, String> {
    let candidates = candidates(host);
    if candidates.is_empty() {
        return Err(match host.variable("LIBCLANG_PATH") {
            Some(path) => format!("LIBCLANG_PATH is {}, where no libclang.so lies", path.display()),
            None => "no libclang.so was found".into(),
        });
    }
    let program = host.build("cc", &USER, ["-ldl"])?;
    let header = host.write(&HEADER)?;
    let arguments = clang_arguments(host);
    let mut causes = Vec::new();
    for (index, file) in candidates.iter().enumerate() {
        let words = [file.as_os_str(), header.as_os_str()];
        match host.run(&program, words.into_iter().chain(arguments.iter().map(OsString::as_os_str))) {
            Ok(_) => return Ok(Libclang { file: file.clone(), first: index == 0 }),
            Err(cause) => {
                let cause = cause.split_once(": ").map_or(cause.as_str(), |(_, cause)| cause);
                causes.push(format!("{} does not work: {cause}", file.display()));
            }
        }
    }
    Err(causes.swap_remove(0))
}

/// The environment variable by which cargo's builds find the libclang that works, where bindgen would choose another.
pub fn variable(host: &Host) -> Result<Option<(&'static str, PathBuf)>, Error> {
    let found = find(host).map_err(Error::Failed)?;
    Ok((!found.first).then_some(("LIBCLANG_PATH", found.file)))
}

/// The libraries that bindgen finds, those that it prefers first: by version, then by place.
fn candidates(host: &Host) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for file in installed(host) {
        // Several patterns may find the same file.
        if is_native(&file) && !found.contains(&file) {
            found.push(file);
        }
    }
    found.sort_by_key(|file| Reverse(version(&files::name(file))));
    found
}

/// The files of the right names in all directories, in the order of the directories.
fn installed(host: &Host) -> Vec<PathBuf> {
    if let Some(path) = host.variable("LIBCLANG_PATH") {
        let path = host.file(path);
        let parent = path.parent().map(in_directory).unwrap_or_default();
        return if parent.contains(&path) { vec![path] } else { in_directory(&path) };
    }
    let mut directories = Vec::new();
    if let Ok(prefix) = llvm_config(host, "--prefix") {
        directories.extend(["bin", "lib", "lib64"].map(|name| prefix.join(name)));
    }
    for name in ["LD_LIBRARY_PATH", "LIBRARY_PATH"] {
        let paths = host.variable(name).map(std::env::split_paths);
        directories.extend(paths.into_iter().flatten().map(|path| host.file(path)));
    }
    let usual = DIRECTORIES.iter().flat_map(|pattern| files::fitting(&host.file("/"), pattern));
    directories.extend(usual.filter(|path| path.is_dir()));
    directories.iter().flat_map(|directory| in_directory(directory)).collect()
}

/// libclangs in a directory, in the order of [`NAMES`].
fn in_directory(directory: &Path) -> Vec<PathBuf> {
    let found = NAMES.iter().flat_map(|pattern| files::fitting(directory, pattern));
    found.filter(|file| !files::name(file).contains("-cpp.")).collect()
}

/// A directory that `llvm-config` prints.
fn llvm_config(host: &Host, option: &str) -> Result<PathBuf, String> {
    let config = host.variable("LLVM_CONFIG_PATH").unwrap_or(OsStr::new("llvm-config"));
    host.run(Path::new(config), [option]).map(|path| host.file(path.trim()))
}

/// The version that clang-sys reads from a name.
fn version(name: &str) -> Vec<u32> {
    let text = name.strip_prefix("libclang.so.").or_else(|| {
        let end = name.len().checked_sub(3)?;
        name.strip_prefix("libclang-").and_then(|_| name.get("libclang-".len()..end))
    });
    text.map(|text| text.split('.').map(|part| part.parse().unwrap_or(0)).collect()).unwrap_or_default()
}

/// Whether the file is an ELF file for pointers of this program's size.
fn is_native(file: &Path) -> bool {
    let mut start = [0; 5];
    let read = fs::File::open(file).and_then(|mut file| file.read_exact(&mut start));
    let class = if cfg!(target_pointer_width = "64") { 2 } else { 1 };
    read.is_ok() && start[..4] == *b"\x7fELF" && start[4] == class
}

/// What bindgen passes to libclang: the directories in which a `clang` that is installed looks for headers.
fn clang_arguments(host: &Host) -> Vec<OsString> {
    let extra = host.variable("BINDGEN_EXTRA_CLANG_ARGS").unwrap_or_default().to_string_lossy();
    let mut arguments: Vec<OsString> = extra.split_whitespace().map(OsString::from).collect();
    let Some(clang) = clang(host) else {
        return arguments;
    };
    // The search list is printed to standard error.
    let script = "\"$0\" -E -x c - -v </dev/null 2>&1";
    let printed = host.run("/bin/sh", [OsStr::new("-c"), script.as_ref(), clang.as_os_str()]).unwrap_or_default();
    let list = printed.split_once("#include <...> search starts here:").map(|(_, list)| list);
    let list = list.and_then(|list| list.split_once("End of search list.")).map_or("", |(list, _)| list);
    for directory in list.lines().map(str::trim).filter(|line| !line.is_empty()) {
        arguments.extend(["-isystem".into(), directory.into()]);
    }
    arguments
}

/// The `clang` program, where clang-sys looks for it.
fn clang(host: &Host) -> Option<PathBuf> {
    if let Some(path) = host.variable("CLANG_PATH") {
        return host.program(path);
    }
    let directories = llvm_config(host, "--bindir").into_iter().chain(host.program_directories());
    let found =
        directories.flat_map(|directory| ["clang", "clang-[0-9]*"].map(|name| files::fitting(&directory, name)));
    found.flatten().find_map(|file| host.program(file))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::host::fake::Machine;

    static STUB: Probe = Probe { name: "stub.c", text: include_str!("probes/libclang_stub.c") };

    /// A machine with a C compiler.
    fn machine() -> Machine {
        let machine = Machine::bare();
        machine.own_program("cc");
        machine
    }

    /// Adds a libclang that works, or else reports an error.
    fn add_libclang(machine: &Machine, path: &str, error: Option<&str>) -> PathBuf {
        let mut options = vec!["-shared".to_owned(), "-fPIC".to_owned()];
        options.extend(error.map(|error| format!("-DMESSAGE=\"{error}\"")));
        let host = machine.host();
        let library = host.build("cc", &STUB, options).unwrap();
        let file = machine.add(path);
        fs::copy(library, &file).unwrap();
        file
    }

    /// Adds a library without libclang's functions.
    fn add_other(machine: &Machine, path: &str) {
        let other = Probe { name: "other.c", text: "int other;\n" };
        let host = machine.host();
        let library = host.build("cc", &other, ["-shared", "-fPIC"]).unwrap();
        fs::copy(library, machine.add(path)).unwrap();
    }

    #[test]
    fn the_cpp_library_is_not_libclang() {
        let machine = machine();
        assert_eq!(find(&machine.host()), Err("no libclang.so was found".into()));
        add_other(&machine, "/usr/lib/x86_64-linux-gnu/libclang-cpp.so.14");
        add_other(&machine, "/usr/lib/llvm-14/lib/libclang-cpp.so.14");
        assert_eq!(find(&machine.host()), Err("no libclang.so was found".into()));
    }

    #[test]
    fn a_library_without_its_headers_does_not_do() {
        let machine = machine();
        let error = "'stddef.h' file not found";
        let file = add_libclang(&machine, "/usr/lib/x86_64-linux-gnu/libclang-14.so.1", Some(error));
        assert_eq!(find(&machine.host()), Err(format!("{} does not work: {error}", file.display())));
    }

    #[test]
    fn a_complete_one_is_found_and_the_newest_is_bindgens_choice() {
        let machine = machine();
        let old = add_libclang(&machine, "/usr/lib/llvm-14/lib/libclang-14.so.1", None);
        add_other(&machine, "/usr/lib/x86_64-linux-gnu/libclang-cpp.so.14");
        assert_eq!(find(&machine.host()), Ok(Libclang { file: old.clone(), first: true }));
        // A newer one that is not complete is what bindgen would take by itself.
        add_libclang(&machine, "/usr/lib/llvm-16/lib/libclang-16.so.1", Some("'stddef.h' file not found"));
        assert_eq!(find(&machine.host()), Ok(Libclang { file: old, first: false }));
        let new = add_libclang(&machine, "/usr/lib/llvm-19/lib/libclang-19.so.1", None);
        assert_eq!(find(&machine.host()), Ok(Libclang { file: new, first: true }));
    }

    #[test]
    fn libclang_path_is_a_file_or_a_directory_and_the_only_place() {
        let mut machine = machine();
        add_libclang(&machine, "/usr/lib/llvm-14/lib/libclang.so.1", None);
        let mine = add_libclang(&machine, "/opt/clang/lib/libclang.so", None);
        let found = |machine: &mut Machine, path: &str| {
            let value = machine.root.join(path).into();
            machine.variables.insert("LIBCLANG_PATH".into(), value);
            find(&machine.host())
        };
        let expected = Ok(Libclang { file: mine, first: true });
        assert_eq!(found(&mut machine, "opt/clang/lib"), expected);
        assert_eq!(found(&mut machine, "opt/clang/lib/libclang.so"), expected);
        let nonsense = found(&mut machine, "opt/nonsense").unwrap_err();
        assert!(nonsense.starts_with("LIBCLANG_PATH is ") && nonsense.contains("opt/nonsense"), "{nonsense}");
    }

    #[test]
    fn llvm_config_and_library_paths_are_followed() {
        let mut machine = machine();
        let file = add_libclang(&machine, "/opt/llvm/lib/libclang.so", None);
        assert!(find(&machine.host()).is_err());
        machine.program("llvm-config", &format!("echo {}", machine.root.join("opt/llvm").display()));
        assert_eq!(find(&machine.host()), Ok(Libclang { file: file.clone(), first: true }));
        fs::remove_file(machine.root.join("usr/bin/llvm-config")).unwrap();
        machine.variables.insert("LD_LIBRARY_PATH".into(), machine.root.join("opt/llvm/lib").into());
        assert_eq!(find(&machine.host()), Ok(Libclang { file, first: true }));
    }

    #[test]
    fn libraries_for_other_machines_are_left_out() {
        let machine = machine();
        let file = machine.add("/usr/lib/llvm-14/lib/libclang.so");
        for start in [b"\x7fELF\x01".as_slice(), b"INPUT(x)", b""] {
            fs::write(&file, start).unwrap();
            assert_eq!(find(&machine.host()), Err("no libclang.so was found".into()));
        }
    }

    #[test]
    fn versions_are_those_of_clang_sys() {
        assert_eq!(version("libclang.so"), [0; 0]);
        assert_eq!(version("libclang.so.14.0"), [14, 0]);
        assert_eq!(version("libclang-14.so"), [14]);
        assert_eq!(version("libclang-14.so.1"), [14, 0]);
    }
}
