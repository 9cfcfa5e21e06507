//! Finds the derived fields that a scene needs, and the model's fields that these need.

use icoray_scene::{Derivation, How, Scene};

/// The derivations that a scene needs, each behind its inputs, with its origin: its inputs, resolved down to the
/// model's fields, which identify the derivation across scenes.
pub(super) fn needed_derivations(scene: &Scene) -> Vec<(&Derivation, String)> {
    let all = &scene.scenery.derived;
    numbers_of_needed(scene).into_iter().map(|at| (&all[at], origin(all, at))).collect()
}

/// The derivation of `name` among the first `count`: its inputs are among those before it.
fn find(all: &[Derivation], name: &str, count: usize) -> Option<usize> {
    all[..count].iter().position(|derivation| derivation.name == name)
}

/// Numbers of the derivations that a scene needs.
fn numbers_of_needed(scene: &Scene) -> Vec<usize> {
    let all = &scene.scenery.derived;
    let mut is_needed = vec![false; all.len()];
    let shown = scene.shown_fields().into_iter();
    shown.filter_map(|name| find(all, name, all.len())).for_each(|at| is_needed[at] = true);
    for at in (0..all.len()).rev().filter(|at| is_needed[*at]).collect::<Vec<_>>() {
        need_inputs(all, at, &mut is_needed);
    }
    (0..all.len()).filter(|at| is_needed[*at]).collect()
}

/// Number of arrays of the derived fields of a scene, those of first frames included.
pub(super) fn count_arrays(scene: &Scene) -> usize {
    let arrays = |at: usize| if matches!(scene.scenery.derived[at].how, How::FromFirst(_)) { 2 } else { 1 };
    numbers_of_needed(scene).into_iter().map(arrays).sum()
}

/// Marks the inputs of derivation `at`, recursively.
fn need_inputs(all: &[Derivation], at: usize, is_needed: &mut [bool]) {
    for name in all[at].how.fields() {
        if let Some(input) = find(all, name, at)
            && !is_needed[input]
        {
            is_needed[input] = true;
            need_inputs(all, input, is_needed);
        }
    }
}

/// The definitions of the inputs of derivation `at`.
fn origin(all: &[Derivation], at: usize) -> String {
    let of = |name: &str| match find(all, name, at) {
        Some(input) => format!("{:?} of [{}]", all[input].how, origin(all, input)),
        None => format!("{name:?}"),
    };
    all[at].how.fields().into_iter().map(of).collect::<Vec<_>>().join(", ")
}
