//! Declares the structs of the shaders' buffers in Rust as they are declared in WGSL, with the padding that is implied
//! there, and constants of shaders: `layout.rs` includes them.

use icoray_shaders::SOURCES;
use std::collections::BTreeMap;
use std::env;
use std::fmt::Write;
use std::path::PathBuf;

/// The structs of buffers, each after those in it.
const STRUCTS: [&str; 18] = [
    "Params",
    "Span",
    "Step",
    "ShellLayer",
    "Shading",
    "Clip",
    "SurfaceLayer",
    "Material",
    "SceneField",
    "Isosurface",
    "VolumeMap",
    "Scenery",
    "Around",
    "Piece",
    "Pixel",
    "Part",
    "Fragment",
    "Passed",
];

/// The shaders whose constants the host needs; a module each.
const CONSTANTS: [&str; 6] = ["scenery", "parts", "picture", "gradient", "kernel/lit", "kernel/ray/fragment"];

/// Bytes of a type and of its alignment. Of arrays the bytes of an element: of offsets only the remainder by the
/// largest alignment, 16, is of use, and elements of arrays have multiples of it.
type Size = [usize; 2];

fn main() {
    let mut sizes = BTreeMap::new();
    let (mut code, mut layouts) = (String::new(), String::new());
    for name in STRUCTS {
        let (size, members) = declare(name, &sizes, &mut code);
        sizes.insert(name.to_owned(), size);
        let member = |member: &String| format!("({member:?}, std::mem::offset_of!({name}, {member}))");
        let members = members.iter().map(member).collect::<Vec<_>>().join(", ");
        layouts += &format!("({name:?}, size_of::<{name}>(), &[{members}]),\n");
    }
    code += &format!("/// Those of all structs.\npub const LAYOUTS: &[Layout] = &[{layouts}];\n");
    for (file, text) in SOURCES.iter().filter(|(file, _)| CONSTANTS.contains(file)) {
        let module = file.rsplit('/').next().expect("a path has a name");
        code += &format!("/// Constants of `shaders/{file}.wgsl`.\npub mod {module} {{\n");
        for line in text.lines().filter(|line| line.starts_with("const ")) {
            // Rust has no suffix `u`.
            let (name, value) = line.split_once('=').expect("a constant has a value");
            code += &format!("    pub {name}={};\n", value.trim_end_matches(['u', ';']).replace("u ", " "));
        }
        code += "}\n";
    }
    let path = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it")).join("layout.rs");
    std::fs::write(&path, code).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
}

/// Declares a struct; returns its size and the names of its members.
fn declare(name: &str, sizes: &BTreeMap<String, Size>, code: &mut String) -> (Size, Vec<String>) {
    let declared = SOURCES.iter().find_map(|(file, text)| {
        let (_, rest) = text.split_once(&format!("struct {name} {{\n"))?;
        Some((file, rest.split_once("\n}")?.0))
    });
    let (file, text) = declared.unwrap_or_else(|| panic!("no shader declares {name}"));
    let mut add = |line: String| writeln!(code, "{line}").expect("strings take all");
    add(format!("/// See `shaders/{file}.wgsl`."));
    add("#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]\n#[repr(C)]".to_owned());
    add(format!("pub struct {name} {{"));
    let (mut end, mut reserved, mut largest, mut members) = (0_usize, 0, 4, Vec::new());
    for line in text.lines().map(str::trim).filter(|line| !line.starts_with("//")) {
        let (bytes, member) = match line.strip_prefix("@size(").and_then(|rest| rest.split_once(") ")) {
            Some((bytes, member)) => (bytes.parse::<usize>().ok(), member),
            None => (None, line),
        };
        let (member, wgsl) = member.trim_end_matches(',').split_once(": ").expect("a member has a type");
        let (rust, [size, align]) = translated(wgsl, sizes);
        let is_next = end == reserved && end.is_multiple_of(align);
        assert!(is_next, "{name}.{member} is not behind the member before: declare the padding");
        add(format!("    pub {member}: {rust},"));
        members.push(member.to_owned());
        reserved = end + bytes.unwrap_or(size);
        (end, largest) = (end + size, largest.max(align));
    }
    let whole = reserved.next_multiple_of(largest);
    if whole > end {
        add(format!("    pub padding: [u32; {}],", (whole - end) / 4));
    }
    add("}\n".to_owned());
    ([whole, largest], members)
}

/// A type in Rust, with its size.
fn translated(wgsl: &str, sizes: &BTreeMap<String, Size>) -> (String, Size) {
    if let Some((element, count)) =
        wgsl.strip_prefix("array<").and_then(|rest| rest.trim_end_matches('>').split_once(", "))
    {
        let size = sizes[element];
        assert!(size[0].is_multiple_of(16), "elements {element} of an array have {} bytes", size[0]);
        return (format!("[{element}; {count}]"), size);
    }
    let (rust, size) = match wgsl {
        "f32" | "u32" | "i32" => (wgsl, [4, 4]),
        "vec2f" => ("[f32; 2]", [8, 8]),
        "vec2u" => ("[u32; 2]", [8, 8]),
        "vec3f" => ("[f32; 3]", [12, 16]),
        "vec4f" => ("[f32; 4]", [16, 16]),
        other => panic!("no type in Rust for {other}"),
    };
    (rust.to_owned(), size)
}
