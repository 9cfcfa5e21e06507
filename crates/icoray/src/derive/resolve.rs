//! Finds the derived fields that a scene needs, and the model's fields that these need.

use icoray_grid::{Error, ErrorKind, Result};
use icoray_scene::{Derivation, How, Scene};
use std::fmt;

/// The derivations that a scene needs, each behind its inputs.
#[derive(Debug)]
pub(super) struct NeededDerivations<'s> {
    pub derivations: Vec<NeededDerivation<'s>>,
}

/// One derivation.
#[derive(Debug)]
pub(super) struct NeededDerivation<'s> {
    pub derivation: &'s Derivation,
    /// Its inputs, resolved down to the model's fields: identifies the derivation across scenes.
    pub origin: String,
}

/// The derivation of `name` among the first `count`: its inputs are among those before it.
fn find(all: &[Derivation], name: &str, count: usize) -> Option<usize> {
    all[..count].iter().position(|derivation| derivation.name == name)
}

impl<'s> NeededDerivations<'s> {
    pub fn of(scene: &'s Scene) -> Result<Self> {
        let all = &scene.scenery.derived;
        let needed = numbers_of_needed(scene).into_iter();
        let derivations = needed.map(|at| NeededDerivation { derivation: &all[at], origin: origin(all, at) }).collect();
        let needed = NeededDerivations { derivations };
        match needed.twice() {
            None => Ok(needed),
            Some(name) => {
                let context = format!("{name:?} is derived twice, expected fields of different names");
                Err(Error::new(ErrorKind::Scene, context))
            }
        }
    }

    fn twice(&self) -> Option<&'s str> {
        let names: Vec<&str> = self.derivations.iter().map(|one| one.derivation.name.as_str()).collect();
        names.iter().enumerate().find(|(i, name)| names[..*i].contains(name)).map(|(_, name)| *name)
    }
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

impl fmt::Display for NeededDerivations<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let definition = |one: &NeededDerivation| format!("{:?} = {:?}", one.derivation.name, one.derivation.how);
        f.write_str(&self.derivations.iter().map(definition).collect::<Vec<_>>().join(", "))
    }
}
