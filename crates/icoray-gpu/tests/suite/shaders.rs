//! The shaders parse and validate, and agree with Rust in structs and constants. That their functions agree is tested
//! by numbers (`functions.rs`, `light.rs`) and by pictures.

use icoray::device::mirror;
use icoray_gpu::layout::{
    Around, Clip, Fragment, Isosurface, Material, Params, Part, Passed, Piece, Pixel, SceneField, Scenery, Shading,
    ShellLayer, Span, Step, SurfaceLayer, VolumeMap,
};
use icoray_gpu::shader::{Contents, SOURCES, compose, compose_for};
use naga::{Module, TypeInner};
use std::mem::offset_of;
use std::path::{Path, PathBuf};

/// The contents of scenes that are not plain.
const SCENES: [Contents; 2] = [Contents { scenery: true, volumes: 0 }, Contents { scenery: true, volumes: 3 }];

fn parse(name: &str) -> Module {
    parse_text(name, &compose(name))
}

fn parse_text(name: &str, text: &str) -> Module {
    naga::front::wgsl::parse_str(text).unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string(text)))
}

#[test]
fn every_shader_parses_and_validates() {
    for (name, _) in SOURCES {
        let contents = match name {
            "kernel/general/several" | "kernel/general/blend" | "kernel/general/maps" => SCENES[1],
            name if name.starts_with("kernel/general") => SCENES[0],
            _ => Contents::default(),
        };
        validate(name, &compose_for(name, contents, 1));
    }
}

/// Code that a scene does not need is not in its shader.
#[test]
fn shaders_have_what_their_scenes_have() {
    let named = |contents, function: &str| compose_for("picture", contents, 1).contains(&format!("fn {function}("));
    for (function, expected) in
        [("trace", [true; 3]), ("clips_behind", [false, true, true]), ("map_cut", [false, false, true])]
    {
        let found = [Contents::default(), SCENES[0], SCENES[1]].map(|contents| named(contents, function));
        assert_eq!(found, expected, "{function}");
    }
}

fn validate(name: &str, text: &str) {
    let module = parse_text(name, text);
    let mut validator = naga::valid::Validator::new(Default::default(), naga::valid::Capabilities::empty());
    validator.validate(&module).unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string(text)));
}

/// Each page has a binding and a case for values, and the same for gradients or residuals.
#[test]
fn a_shader_has_as_many_pages_as_are_asked_for() {
    for (shader, contents, beside) in [
        ("picture", Contents::default(), "gradients"),
        ("picture", SCENES[0], "gradients"),
        ("picture", SCENES[1], "gradients"),
        ("parts", Contents::default(), "gradients"),
        ("gradient", Contents::default(), "rests"),
    ] {
        for pages in [1, 2, 7, 16] {
            let text = compose_for(shader, contents, pages);
            validate(shader, &text);
            for page in 0..pages {
                for (group, name) in [(1, "field"), (3, beside)] {
                    let binding = format!("@group({group}) @binding({page}) var<storage, read> {name}_{page}:");
                    assert!(text.contains(&binding), "{shader}, {pages} pages: {binding}");
                }
                let cases = text.matches(&format!("case {page}u: {{")).count();
                assert_eq!(cases, 2, "{shader}, {pages} pages: {page}");
            }
            assert!(!text.contains(&format!("field_{pages}")) && !text.contains("\n#each"), "{shader}, {pages}");
        }
    }
}

/// Every shader in `shaders/` is known to `SOURCES`.
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
            } else if path.extension().is_some_and(|ending| ending == "wgsl") {
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

/// The members of a shader's struct with their offsets, and its size.
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

// The members are separated by blanks, which rustfmt does not spread over one line each.
macro_rules! same_layout {
    ($module:expr, $name:ident: $($field:ident)*) => {{
        let expected = vec![$((stringify!($field).to_owned(), offset_of!($name, $field))),*];
        assert_eq!(layout($module, stringify!($name)), (expected, size_of::<$name>()), stringify!($name));
    }};
}

#[test]
fn structs_have_the_same_layout_in_rust_and_wgsl() {
    let [picture, parts, gradient] = ["picture", "parts", "gradient"].map(parse);
    let scene = parse_text("scene", &compose_for("picture", SCENES[1], 1));
    same_layout!(&picture, Params: eye_hi width eye_lo height forward_hi first_piece forward_lo pixel_step right_hi
        half_pixel_hi right_lo half_pixel_lo up_hi zero up_lo max_steps knots core layers index_base triangles rim_sides
        spans steps column_stride layer_stride color_tolerance min_transmittance brightest start page_columns first_layer last_layer);
    same_layout!(&picture, Span: low high anchor extinction color extinction_slope color_slope steepest is_clear
        brightest);
    same_layout!(&picture, Step: value extinction slope);
    same_layout!(&picture, ShellLayer: radius_hi radius_lo curvature inverse);
    same_layout!(&picture, Piece: left top width height first stride hint);
    same_layout!(&picture, Shading: light_hi ambient light_lo diffuse specular shininess sharpness
        is_headlight max_cuts);
    same_layout!(&picture, Pixel: red green blue alpha error variance columns frusta void_frusta order nearness);
    same_layout!(&scene, Clip: towards_hi distance_hi towards_lo distance_lo west east inner outer south north
        first_layer last_layer kind cuts_inside);
    same_layout!(&scene, SurfaceLayer: layer first_material material_count padding radius padding_b);
    same_layout!(&scene, Material: color opacity kind first_value first_span span_count field scale shift
        padding);
    same_layout!(&scene, SceneField: first_value first_gradient padding);
    same_layout!(&scene, Isosurface: color opacity value field kind color_field first_span span_count scale shift);
    same_layout!(&scene, VolumeMap: field first_span span_count first_step step_count);
    same_layout!(&scene, Scenery: clips surface_layers materials isosurfaces fields maps clip_count surface_layer_count
        isosurface_count seen_above volume_count sphere_count);
    same_layout!(&gradient, Around: first columns row);
    same_layout!(&parts, Part: middle reach lowest_hi lowest_lo max_fragments);
    same_layout!(&parts, Fragment: ray entry_hi entry_lo exit_hi exit_lo red green blue alpha error variance);
    same_layout!(&parts, Passed: columns frusta void_frusta fragments);
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
        ("SURFACE", mirror::SURFACE),
        ("THIN", mirror::THIN),
        ("MAX_PANELS", mirror::MAX_PANELS as f32),
        ("MAX_CUTS", mirror::MAX_CUTS as f32),
        ("HALVINGS_AT_START", mirror::HALVINGS[0] as f32),
        ("HALVINGS_ALONG", mirror::HALVINGS[1] as f32),
    ] {
        assert_eq!(constant(module, name), f64::from(value), "{name}");
    }
    assert_eq!(constant(&parse("parts"), "LOST"), f64::from(Passed::LOST));
    let scene = &parse_text("scene", &compose_for("picture", SCENES[1], 1));
    for (name, value) in [
        ("HAS_HALF_SPACE", Clip::HAS_HALF_SPACE),
        ("HAS_SHELL", Clip::HAS_SHELL),
        ("HAS_LATITUDES", Clip::HAS_LATITUDES),
        ("HAS_LONGITUDES", Clip::HAS_LONGITUDES),
        ("IS_WIDE", Clip::IS_WIDE),
        ("OWN_FIELD", Isosurface::OWN_FIELD),
        ("MATERIAL_PLAIN", Material::PLAIN),
        ("MATERIAL_FIELD", Material::FIELD),
        ("MATERIAL_CELLS", Material::CELLS),
        ("MATERIAL_BETWEEN", Material::BETWEEN),
        ("AT_RADIUS", SurfaceLayer::AT_RADIUS),
    ] {
        assert_eq!(constant(scene, name), f64::from(value), "{name}");
    }
}
