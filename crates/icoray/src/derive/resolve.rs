//! Finds the derived fields that a scene needs, and the model's fields that these need.

use icoray_scene::{Derivation, Scene};

/// The derivations that a scene needs, each behind its inputs, with its origin: its inputs, resolved down to the
/// model's fields, which identify the derivation across scenes.
pub(super) fn needed_derivations(scene: &Scene) -> Vec<(&Derivation, String)> {
    let all = &scene.scenery.derived;
    let mut is_needed = vec![false; all.len()];
    let shown = scene.shown_fields().into_iter();
    shown.filter_map(|name| find(all, name, all.len())).for_each(|at| is_needed[at] = true);
    // Inputs come before what is derived from them.
    for at in (0..all.len()).rev() {
        if is_needed[at] {
            all[at].how.fields().iter().filter_map(|name| find(all, name, at)).for_each(|at| is_needed[at] = true);
        }
    }
    (0..all.len()).filter(|at| is_needed[*at]).map(|at| (&all[at], origin(all, at))).collect()
}

/// The derivation of `name` among the first `count`: its inputs are among those before it.
fn find(all: &[Derivation], name: &str, count: usize) -> Option<usize> {
    all[..count].iter().position(|derivation| derivation.name == name)
}

/// The definitions of the inputs of derivation `at`.
fn origin(all: &[Derivation], at: usize) -> String {
    let of = |name: &str| match find(all, name, at) {
        Some(input) => format!("{:?} of [{}]", all[input].how, origin(all, input)),
        None => format!("{name:?}"),
    };
    all[at].how.fields().into_iter().map(of).collect::<Vec<_>>().join(", ")
}
