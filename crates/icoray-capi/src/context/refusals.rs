//! Inputs that were refused, so that a later call that lacks one can state the reason.

use crate::boundary::{Failure, Outcome};
use std::collections::BTreeMap;

/// Kinds of inputs. Each input has a name, heights an empty one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Input {
    Grid,
    Layers,
    Field,
    Heights,
}

impl Input {
    /// The input that a C function sets.
    pub fn of_call(call: &str) -> Option<Self> {
        let all = [Input::Grid, Input::Layers, Input::Field, Input::Heights];
        let call = if call == "icoray_points_set" { Input::Grid.call() } else { call };
        all.into_iter().find(|input| input.call() == call)
    }

    /// The C function that sets it.
    pub fn call(self) -> &'static str {
        match self {
            Input::Grid => "icoray_grid_set",
            Input::Layers => "icoray_layers_set",
            Input::Field => "icoray_field_set",
            Input::Heights => "icoray_heights_set",
        }
    }

    pub fn what(self) -> &'static str {
        match self {
            Input::Grid => "grid",
            Input::Layers => "set of layers",
            Input::Field => "field",
            Input::Heights => "heights",
        }
    }
}

/// The last refusal of each input that was not set since.
#[derive(Default)]
pub(crate) struct Refusals(BTreeMap<(Input, String), String>);

impl Refusals {
    /// Records why an input was refused, or removes the record if it was accepted.
    pub fn keep<T>(&mut self, input: Input, name: &str, outcome: Outcome<T>) -> Outcome<T> {
        match &outcome {
            Ok(_) => self.0.remove(&(input, name.to_owned())),
            Err(failure) => self.0.insert((input, name.to_owned()), failure.message.clone()),
        };
        outcome
    }

    /// The sentence that the input was refused, with the reason.
    pub fn of(&self, input: Input, name: &str) -> Option<String> {
        let why = self.0.get(&(input, name.to_owned()))?;
        let named = if name.is_empty() { String::new() } else { format!(" {name:?}") };
        let was = if input == Input::Heights { "were" } else { "was" };
        Some(format!("{}{named} {was} refused by {}: {why}", input.what(), input.call()))
    }

    /// As [`Self::of`], for any input of a kind.
    pub fn of_any(&self, input: Input) -> Option<String> {
        let (_, name) = self.0.keys().find(|(refused, _)| *refused == input)?;
        self.of(input, name)
    }
}

/// The failure of a missing input: its refusal, or else `otherwise`.
pub(crate) fn refused_or(refused: Option<String>, otherwise: Failure) -> Failure {
    match refused {
        Some(why) => Failure::new(otherwise.status, why),
        None => otherwise,
    }
}
