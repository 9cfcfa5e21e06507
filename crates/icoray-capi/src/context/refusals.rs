//! What a model has given and icoray has refused, so that a later call that lacks it can say why.

use crate::boundary::{Failure, Outcome};
use std::collections::BTreeMap;

/// What a model gives, each under a name; the heights have none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Input {
    Grid,
    Layers,
    Field,
    Heights,
}

impl Input {
    /// What a call gives; `None` for calls that give nothing of this kind.
    pub fn of_call(call: &str) -> Option<Self> {
        let all = [Input::Grid, Input::Layers, Input::Field, Input::Heights];
        all.into_iter().find(|input| input.call() == call)
    }

    /// The call that gives it.
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

/// The last refusal of each input that was not given since.
#[derive(Default)]
pub(super) struct Refusals(BTreeMap<(Input, String), String>);

impl Refusals {
    /// Keeps why an input was refused, or forgets it where it was taken.
    pub fn keep<T>(&mut self, input: Input, name: &str, outcome: Outcome<T>) -> Outcome<T> {
        match &outcome {
            Ok(_) => self.0.remove(&(input, name.to_owned())),
            Err(failure) => self.0.insert((input, name.to_owned()), failure.message.clone()),
        };
        outcome
    }

    /// Says that the input was refused and why, if it was.
    pub fn of(&self, input: Input, name: &str) -> Option<String> {
        let why = self.0.get(&(input, name.to_owned()))?;
        let named = if name.is_empty() { String::new() } else { format!(" {name:?}") };
        let was = if input == Input::Heights { "were" } else { "was" };
        Some(format!("{}{named} {was} refused by {}: {why}", input.what(), input.call()))
    }

    /// The same of any input of a kind.
    pub fn of_any(&self, input: Input) -> Option<String> {
        let (_, name) = self.0.keys().find(|(refused, _)| *refused == input)?;
        self.of(input, name)
    }
}

/// The failure of an input that is missing: that it was refused, or else `otherwise`.
pub(super) fn lacking(refused: Option<String>, otherwise: Failure) -> Failure {
    match refused {
        Some(why) => Failure::new(otherwise.status, why),
        None => otherwise,
    }
}
