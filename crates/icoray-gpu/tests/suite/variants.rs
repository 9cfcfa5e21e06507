//! The functions reachable from a shader's entry point under given override constants: a scene's shader has no code
//! that the scene does not need.

use icoray_gpu::shader::{Contents, compose};
use naga::back::pipeline_constants::process_overrides;
use naga::{Block, Expression, Function, Handle, Literal, Module, ShaderStage, Statement};
use std::collections::BTreeSet;

/// The names of functions that the picture's entry point reaches.
fn reached(constants: &[(&str, f64)]) -> BTreeSet<String> {
    let module = naga::front::wgsl::parse_str(&compose("picture", Contents::default(), 1)).unwrap();
    let mut validator = naga::valid::Validator::new(Default::default(), naga::valid::Capabilities::empty());
    let info = validator.validate(&module).unwrap();
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
