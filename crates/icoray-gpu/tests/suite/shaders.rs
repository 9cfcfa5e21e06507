//! The shaders parse and validate, and agree with Rust in structs and constants. That their functions agree is tested
//! by numbers (`functions.rs`, `light.rs`) and by pictures.

use icoray_gpu::layout::LAYOUTS;
use icoray_gpu::shader::{Contents, SOURCES, compose};
use icoray_grid::real::Real;
use icoray_kernel::lit::{HALVINGS_ALONG, HALVINGS_AT_START, Lit};
use icoray_kernel::piece;
use naga::back::pipeline_constants::process_overrides;
use naga::valid::{ModuleInfo, Validator};
use naga::{Block, Expression, Function, Handle, Literal, Module, ShaderStage, Statement, TypeInner};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The contents of scenes of more than one volume and a core.
const SCENES: [Contents; 3] = [
    Contents { scenery: true, volumes: 0, painted: false, native: false },
    Contents { scenery: true, volumes: 3, painted: false, native: false },
    Contents { scenery: true, volumes: 3, painted: true, native: true },
];

fn parse(name: &str) -> Module {
    parse_text(name, &compose(name, Contents::default(), 1))
}

fn parse_text(name: &str, text: &str) -> Module {
    naga::front::wgsl::parse_str(text).unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string(text)))
}

#[test]
fn every_shader_parses_and_validates() {
    for (name, _) in SOURCES {
        let contents = match name {
            "kernel/general/native" => Contents { native: true, ..SCENES[0] },
            "kernel/general/several" | "kernel/general/blend" | "kernel/general/maps" => SCENES[1],
            name if name.starts_with("kernel/general") => SCENES[0],
            _ => Contents::default(),
        };
        validate(name, &compose(name, contents, 1));
    }
}

/// Code that a scene does not need is not in its shader.
#[test]
fn shaders_have_the_code_of_their_scenes() {
    let named = |contents, function: &str| compose("picture", contents, 1).contains(&format!("fn {function}("));
    for (function, expected) in
        [("trace", [true; 3]), ("clips_behind", [false, true, true]), ("map_cut", [false, false, true])]
    {
        let found = [Contents::default(), SCENES[0], SCENES[1]].map(|contents| named(contents, function));
        assert_eq!(found, expected, "{function}");
    }
}

fn validate(name: &str, text: &str) -> (Module, ModuleInfo) {
    let module = parse_text(name, text);
    let mut validator = Validator::new(Default::default(), naga::valid::Capabilities::empty());
    let info = validator.validate(&module).unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string(text)));
    (module, info)
}

/// Each page has a binding and a case for values, and the same for gradients or residuals.
#[test]
fn a_shader_has_the_requested_number_of_pages() {
    for (shader, contents, beside) in [
        ("picture", Contents::default(), "gradients"),
        ("picture", SCENES[0], "gradients"),
        ("picture", SCENES[1], "gradients"),
        ("parts", Contents::default(), "gradients"),
        ("parts", SCENES[0], "gradients"),
        ("parts", SCENES[2], "gradients"),
        ("parts", Contents { painted: true, ..Contents::default() }, "gradients"),
        ("gradient", Contents::default(), "rests"),
    ] {
        for pages in [1, 2, 7, 16] {
            let text = compose(shader, contents, pages);
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
    let paths = glob::glob(root.join("**/*.wgsl").to_str().unwrap()).unwrap().map(Result::unwrap);
    let name = |path: PathBuf| path.strip_prefix(&root).unwrap().with_extension("").to_str().unwrap().to_owned();
    let mut found: Vec<String> = paths.map(name).collect();
    let mut known: Vec<&str> = SOURCES.iter().map(|(name, _)| *name).collect();
    found.sort();
    known.sort_unstable();
    assert_eq!(found, known);
}

/// Bytes of a shader's struct, and its members with their offsets.
fn layout<'m>(module: &'m Module, name: &str) -> Option<(usize, Vec<(&'m str, usize)>)> {
    let (_, found) = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name))?;
    let TypeInner::Struct { members, span } = &found.inner else { panic!("{name} is {:?}", found.inner) };
    let member = |m: &'m naga::StructMember| (m.name.as_deref().unwrap(), m.offset as usize);
    Some((*span as usize, members.iter().map(member).collect()))
}

#[test]
fn structs_have_the_same_layout_in_rust_and_wgsl() {
    let scene = parse_text("scene", &compose("picture", SCENES[1], 1));
    let modules = [parse("picture"), parse("parts"), parse("gradient"), scene];
    assert_eq!(LAYOUTS.len(), 18);
    for (name, size, members) in LAYOUTS {
        let found = modules.iter().find_map(|module| layout(module, name));
        assert_eq!(found, Some((*size, members.to_vec())), "{name}");
    }
}

fn constant(module: &Module, name: &str) -> f64 {
    let found = module.constants.iter().find(|(_, c)| c.name.as_deref() == Some(name));
    match module.global_expressions[found.unwrap_or_else(|| panic!("no constant {name}")).1.init] {
        Expression::Literal(Literal::F32(x)) => f64::from(x),
        Expression::Literal(Literal::U32(x)) => f64::from(x),
        ref other => panic!("{name} is {other:?}"),
    }
}

#[test]
fn constants_are_those_of_rust() {
    let module = &parse("picture");
    for (name, value) in [
        ("ENDLESS", icoray::device::ENDLESS),
        ("ROUNDING", f32::EPSILON / 2.0),
        ("MISSED", icoray::device::Traced::MISSED),
        ("SURFACE", f32::SURFACE as f32),
        ("THIN", piece::THIN as f32),
        ("MAX_PANELS", piece::MAX_PANELS as f32),
        ("MAX_CUTS", Lit::<f32, 4>::MAX_CUTS as f32),
        ("HALVINGS_AT_START", HALVINGS_AT_START as f32),
        ("HALVINGS_ALONG", HALVINGS_ALONG as f32),
    ] {
        assert_eq!(constant(module, name), f64::from(value), "{name}");
    }
}

/// The names of functions that the picture's entry point reaches with these override constants.
fn reached(constants: &[(&str, f64)]) -> BTreeSet<String> {
    let text = compose("picture", Contents::default(), 1);
    let (module, info) = validate("picture", &text);
    let constants = constants.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    let entry = Some((ShaderStage::Compute, "picture"));
    let (module, _) = process_overrides(&module, &info, entry, &constants).unwrap();
    let mut reach = Reach { module: &module, seen: BTreeSet::new() };
    reach.body(&module.entry_points[0].function, &module.entry_points[0].function.body);
    reach.seen
}

struct Reach<'m> {
    module: &'m Module,
    seen: BTreeSet<String>,
}

impl Reach<'_> {
    fn call(&mut self, function: Handle<Function>) {
        let function = &self.module.functions[function];
        if self.seen.insert(function.name.clone().unwrap()) {
            self.body(function, &function.body);
        }
    }

    /// Visits a block, and returns whether it always returns from the function.
    fn body(&mut self, function: &Function, block: &Block) -> bool {
        for statement in block {
            let returns = match statement {
                Statement::Call { function: called, .. } => {
                    self.call(*called);
                    false
                }
                Statement::Block(block) => self.body(function, block),
                Statement::If { condition, accept, reject } => match self.known(function, *condition) {
                    Some(true) => self.body(function, accept),
                    Some(false) => self.body(function, reject),
                    None => self.body(function, accept) & self.body(function, reject),
                },
                Statement::Loop { body, continuing, .. } => {
                    self.body(function, body);
                    self.body(function, continuing);
                    false
                }
                Statement::Switch { cases, .. } => {
                    cases.iter().for_each(|case| _ = self.body(function, &case.body));
                    false
                }
                Statement::Return { .. } => true,
                _ => false,
            };
            if returns {
                return true;
            }
        }
        false
    }

    fn known(&self, function: &Function, condition: Handle<Expression>) -> Option<bool> {
        match function.expressions[condition] {
            Expression::Literal(Literal::Bool(is)) => Some(is),
            Expression::Constant(constant) => {
                match self.module.global_expressions[self.module.constants[constant].init] {
                    Expression::Literal(Literal::Bool(is)) => Some(is),
                    _ => None,
                }
            }
            _ => None,
        }
    }
}

fn constants(is: [bool; 5]) -> [(&'static str, f64); 5] {
    let names = ["IS_EXACT", "HAS_VOID", "HAS_STEPS", "IS_LIT", "FEW_KNOTS"];
    std::array::from_fn(|i| (names[i], f64::from(u8::from(is[i]))))
}

#[test]
fn simple_scenes_have_no_code_of_other_features() {
    // Unlit, no holes, no steps, four knots.
    let plain = reached(&constants([true, false, false, false, true]));
    println!("{plain:?}");
    for needed in ["trace", "frustum", "spans_find", "spans_follow", "knots_below", "integrate", "exact", "core"] {
        assert!(plain.contains(needed), "{needed}");
    }
    // Scenes that need a function have it, so that a renamed function fails the test.
    for (name, is) in [
        ("spans_search", [true, false, false, false, false]),
        ("spans_walk", [true, false, false, false, false]),
        ("near_steps", [true, false, true, false, true]),
        ("linear", [false, false, false, false, true]),
        ("lit_light", [true, false, false, true, true]),
        ("ray_shading_mean", [true, false, false, true, true]),
        ("gradients_get", [true, false, false, true, true]),
    ] {
        assert!(!plain.contains(name), "{name} is in the shader of one volume and a core");
        assert!(reached(&constants(is)).contains(name), "{name} is in no shader");
    }
}
