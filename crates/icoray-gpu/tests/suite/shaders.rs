//! The shaders parse and validate, and agree with Rust in structs, constants and names.

use icoray_gpu::layout::{
    Around, Fragment, Params, Part, Passed, Piece, Pixel, Shading, ShellLayer, Span, Step,
};
use icoray_gpu::shader::{SOURCES, compose, compose_for};
use naga::{Module, TypeInner};
use std::mem::offset_of;
use std::path::{Path, PathBuf};

fn parse(name: &str) -> Module {
    let text = compose(name);
    naga::front::wgsl::parse_str(&text).unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string(&text)))
}

#[test]
fn every_shader_parses_and_validates() {
    for (name, _) in SOURCES {
        validate(name, &compose(name));
    }
}

fn validate(name: &str, text: &str) {
    let module =
        naga::front::wgsl::parse_str(text).unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string(text)));
    let mut validator = naga::valid::Validator::new(Default::default(), naga::valid::Capabilities::empty());
    validator.validate(&module).unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string(text)));
}

/// A page is a binding and a case, of values and of what lies beside them, and there are no others.
#[test]
fn a_shader_has_as_many_pages_as_are_asked_for() {
    for (shader, beside) in [("picture", "gradients"), ("parts", "gradients"), ("gradient", "rests")] {
        for pages in [1, 2, 7, 16] {
            let text = compose_for(shader, pages);
            validate(shader, &text);
            for page in 0..pages {
                for (group, name) in [(1, "field"), (3, beside)] {
                    let binding =
                        format!("@group({group}) @binding({page}) var<storage, read> {name}_{page}:");
                    assert!(text.contains(&binding), "{shader}, {pages} pages: {binding}");
                }
                let cases = text.matches(&format!("case {page}u: {{")).count();
                assert_eq!(cases, 2, "{shader}, {pages} pages: {page}");
            }
            assert!(
                !text.contains(&format!("field_{pages}")) && !text.contains("\n#each"),
                "{shader}, {pages}"
            );
        }
    }
}

/// Every file in `shaders/` is known to `SOURCES`.
#[test]
fn no_shader_is_forgotten() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shaders");
    let mut folders: Vec<PathBuf> = vec![root.clone()];
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(&root).unwrap().with_extension("");
                found.push(name.to_str().unwrap().to_owned());
            }
        }
    }
    let mut known: Vec<&str> = SOURCES.iter().map(|(name, _)| *name).collect();
    found.sort();
    known.sort_unstable();
    assert_eq!(found, known);
}

/// A struct's members with their offsets, and its size, as the shader has them.
fn layout(module: &Module, name: &str) -> (Vec<(String, usize)>, usize) {
    let found = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name));
    match &found.unwrap_or_else(|| panic!("no struct {name}")).1.inner {
        TypeInner::Struct { members, span } => {
            let member = |m: &naga::StructMember| (m.name.clone().unwrap(), m.offset as usize);
            (members.iter().map(member).collect(), *span as usize)
        }
        other => panic!("{name} is {other:?}"),
    }
}

macro_rules! same_layout {
    ($module:expr, $name:ident { $($field:ident),* $(,)? }) => {{
        let expected = vec![$((stringify!($field).to_owned(), offset_of!($name, $field))),*];
        assert_eq!(layout($module, stringify!($name)), (expected, size_of::<$name>()), stringify!($name));
    }};
}

#[test]
fn structs_lie_in_memory_as_rust_has_them() {
    let module = &parse("picture");
    same_layout!(
        module,
        Params {
            eye_hi,
            width,
            eye_lo,
            height,
            forward_hi,
            first_piece,
            forward_lo,
            pixel_step,
            right_hi,
            half_pixel_hi,
            right_lo,
            half_pixel_lo,
            up_hi,
            zero,
            up_lo,
            most_steps,
            knots,
            core,
            layers,
            index_base,
            triangles,
            rim_sides,
            spans,
            steps,
            column_stride,
            layer_stride,
            share,
            rest,
            brightest,
            start,
            page_columns,
            first_layer,
            last_layer,
        }
    );
    same_layout!(
        module,
        Span {
            low,
            high,
            anchor,
            extinction,
            color,
            extinction_slope,
            color_slope,
            steepest,
            is_clear,
            brightest
        }
    );
    same_layout!(module, Step { value, extinction });
    same_layout!(&parse("gradient"), Around { first, columns, row });
    same_layout!(module, ShellLayer { radius_hi, radius_lo, curvature, inverse });
    same_layout!(module, Piece { left, top, width, height, first, stride, hint });
    same_layout!(
        module,
        Shading {
            light_hi,
            ambient,
            light_lo,
            diffuse,
            specular,
            shininess,
            sharpness,
            blind,
            dull,
            is_headlight,
            most_cuts
        }
    );
    let parts = &parse("parts");
    same_layout!(parts, Part { middle, reach, lowest_hi, lowest_lo, most });
    same_layout!(
        parts,
        Fragment { ray, entry_hi, entry_lo, exit_hi, exit_lo, red, green, blue, absorbed, error, variance }
    );
    same_layout!(parts, Passed { columns, frusta, void_frusta, fragments });
    same_layout!(module, Pixel { red, green, blue, absorbed, error, variance, columns, frusta, void_frusta });
}

fn constant(module: &Module, name: &str) -> f64 {
    let found = module.constants.iter().find(|(_, c)| c.name.as_deref() == Some(name));
    match module.global_expressions[found.unwrap_or_else(|| panic!("no constant {name}")).1.init] {
        naga::Expression::Literal(naga::Literal::F32(x)) => f64::from(x),
        naga::Expression::Literal(naga::Literal::U32(x)) => f64::from(x),
        ref other => panic!("{name} is {other:?}"),
    }
}

#[test]
fn constants_are_those_of_rust() {
    let module = &parse("picture");
    for (name, value) in [
        ("ENDLESS", icoray::device::ENDLESS),
        ("ROUNDING", f32::EPSILON / 2.0),
        ("MISSED", Pixel::MISSED),
        ("LOST", Pixel::LOST),
    ] {
        assert_eq!(constant(module, name), f64::from(value), "{name}");
    }
    assert_eq!(constant(&parse("parts"), "LOST"), f64::from(Passed::LOST));
    let kernel = Path::new(env!("CARGO_MANIFEST_DIR")).join("../icoray/src/kernel");
    let source = |file: &str| std::fs::read_to_string(kernel.join(file)).unwrap();
    for (file, name, text) in [
        ("real.rs", "SURFACE", "const SURFACE: f64 = 1e12;"),
        ("piece.rs", "THIN", "const THIN: f64 = 0.5;"),
        ("piece.rs", "MOST_PANELS", "const MOST_PANELS: usize = 32;"),
        ("lit.rs", "MOST_CUTS", "const MOST_CUTS: u32 = 20;"),
    ] {
        let value = text.split_once("= ").unwrap().1.trim_end_matches(';').parse::<f64>().unwrap();
        assert!(source(file).contains(text), "{file} has {name} no longer so");
        assert_eq!(constant(module, name), f64::from(value as f32), "{name}");
    }
}

/// Functions of the kernel that its shaders have not, and why.
const LEFT_OUT: [(&str, &[&str]); 12] = [
    // The host makes the shell. WGSL passes no functions on, so `cross` stands in ray.wgsl beside what it visits.
    // Nor do shaders leap.
    (
        "column",
        &[
            "shell_new",
            "shell_layers",
            "chord_course",
            "mix",
            "visit_chord",
            "visit_frustum",
            "visit_leaps",
            "visit_core",
            "passage_new",
            "passage_crossed",
            "passage_pass",
            "passage_places",
            "passage_eps",
            "cross",
        ],
    ),
    ("doubt", &[]),
    // Recursion, for which `exact` has a loop; what lanes have apart.
    (
        "piece",
        &[
            "terms_of",
            "thin_piece_takes",
            "thin_piece_new",
            "thin_piece_is_near",
            "thin_piece_light",
            "thin_bound",
            "bend_series",
            "halves",
            "light_wide",
        ],
    ),
    ("lit", &["off"]),
    // A struct's constructor.
    ("plane", &["point_new"]),
    // Columns are crossed where they are met; `frustum` is not divided.
    (
        "ray",
        &[
            "budget_new",
            "budget_sees_behind",
            "trace_all",
            "ray",
            "pass",
            "meet",
            "ends_between",
            "odd",
            "vertex",
            "leaps",
            "column",
            "ground",
            "enter",
            "whole",
            "passed",
            "add",
        ],
    ),
    // For who puts them together.
    (
        "ray/fragment",
        &["fragment_light", "runs_new", "runs_pass", "runs_close", "runs_end", "runs_is_behind_core"],
    ),
    ("real", &["of", "wide", "absorbed_by_thin", "look_up", "compress", "log2", "exp2"]),
    // Fields are normalised when they are uploaded.
    (
        "sample",
        &[
            "wide",
            "near",
            "exact",
            "next_up",
            "next_down",
            "reading_new",
            "reading_normal",
            "reading_usual",
            "reading_rare",
            "samples_new",
            "samples_bases",
            "samples_element",
            "samples_layer_stride",
            "samples_at",
            "samples_normal",
            "samples_usual",
        ],
    ),
    // Part of their callers.
    ("segment", &["segment_is_void", "segment_is_constant", "segment_reach", "segment_within"]),
    // Fields of the struct; WGSL's own.
    ("shade", &["shading_dull", "ray_shading_range", "dot"]),
    // Fields of the struct; the host makes spans.
    (
        "transfer",
        &[
            "span_unknown",
            "span_numbers",
            "span_extinction_slope",
            "span_color_slope",
            "span_brightest",
            "span_steepest",
            "spans_new",
            "spans_all",
            "spans_range",
            "spans_steps",
            "spans_span",
            "spans_holding",
            "spans_find_all",
            "spans_media",
            "steps",
            "span",
        ],
    ),
];
/// In walk.wgsl these are part of their callers.
const WALK: &[&str] =
    &["contour_exit_side", "column_new", "place_clip", "walk_triangle", "walk_is_void", "walk_entry_place"];
/// Types whose methods bear no prefix in WGSL: there is one of each.
const PLAIN: [&str; 8] = ["Real", "f32", "f64", "Sample", "Caster", "Pass", "Ray", "Step"];

/// The functions of a Rust file as a shader would name them: `Segment::value` is `segment_value`.
fn rust_names(text: &str) -> Vec<String> {
    let word = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let (mut prefix, mut names) = (String::new(), Vec::<String>::new());
    for line in text.split("#[cfg(test)]").next().unwrap().lines() {
        let bare = line
            .trim_start_matches("pub")
            .trim_start_matches("(crate)")
            .trim_start_matches("(super)")
            .trim_start();
        if line == "}" {
            prefix.clear();
        } else if let Some(rest) = bare.strip_prefix("trait ").or_else(|| bare.strip_prefix("impl")) {
            let rest = rest.split_once(" for ").map_or(rest, |(_, rest)| rest);
            // Behind the parameters of `impl<..>`.
            let mut depth = 0;
            let start = rest.char_indices().find(|(_, c)| {
                depth += i32::from(*c == '<') - i32::from(*c == '>');
                depth == 0 && c.is_alphabetic()
            });
            let name = word(&rest[start.map_or(0, |(i, _)| i)..]);
            let snake =
                |c: char| if c.is_uppercase() { format!("_{}", c.to_lowercase()) } else { c.to_string() };
            let snake = name.chars().map(snake).collect::<String>();
            prefix = if PLAIN.contains(&name.as_str()) {
                String::new()
            } else {
                // Samples of any type are read as samples of one type are.
                format!("{}_", snake.trim_start_matches('_').trim_start_matches("any_"))
            };
        }
        let bare = line
            .trim_start()
            .trim_start_matches("pub")
            .trim_start_matches("(crate)")
            .trim_start_matches("(super)");
        if let Some(rest) = bare.trim_start().strip_prefix("fn ") {
            let name = format!("{prefix}{}", word(rest));
            // Of several that bear one name the last stands where the shader's is.
            names.retain(|known| *known != name);
            names.push(name);
        }
    }
    names
}

/// Each function of the kernel is in the shader of its file's name, in its place.
#[test]
fn kernels_have_the_same_functions() {
    let kernel = Path::new(env!("CARGO_MANIFEST_DIR")).join("../icoray/src/kernel");
    for (name, left_out) in LEFT_OUT.into_iter().chain([("walk", WALK)]) {
        let rust = rust_names(&std::fs::read_to_string(kernel.join(name).with_extension("rs")).unwrap());
        for function in left_out {
            assert!(rust.iter().any(|known| known == function), "{name}.rs has no {function} to leave out");
        }
        let shader = SOURCES.iter().find(|(known, _)| *known == format!("kernel/{name}")).unwrap().1;
        let mut ours = shader.lines().filter_map(|line| line.strip_prefix("fn ")?.split('(').next());
        for function in rust.iter().filter(|function| !left_out.contains(&function.as_str())) {
            assert!(
                ours.any(|known| known == function),
                "{name}.wgsl has no {function}, or not in its place"
            );
        }
    }
}
