//! The scene, which is the same on all ranks: the file or text of rank 0.

use super::{Context, SceneChoice, missing};
use crate::boundary::{Failure, Outcome, caught};
use crate::message::listed;
use crate::ranks::Agreed;
use crate::types::icoray_status;
use icoray_core::output::Stamp;
use icoray_core::suggest::{self, Completion, Options, Suggestion};
use icoray_core::{Error, ErrorKind, Script, Shot, View};
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Where a scene comes from.
#[derive(Debug, Clone, Copy)]
pub(crate) enum SceneSource<'a> {
    /// The path of a file.
    File(&'a str),
    Text(&'a str),
}

impl SceneSource<'_> {
    fn read(self) -> Outcome<String> {
        match self {
            SceneSource::Text(text) => Ok(text.to_owned()),
            SceneSource::File(path) => std::fs::read_to_string(path).map_err(|e| {
                let message = format!("{path}: cannot read the scene: {e}");
                Failure::new(icoray_status::ICORAY_ERR_IO, message)
            }),
        }
    }

    /// A failure of the text, with the file's path if there is one.
    fn failure(self, failure: Failure) -> Failure {
        match self {
            SceneSource::Text(_) => failure,
            SceneSource::File(path) => failure.within(path),
        }
    }
}

impl Context {
    /// Sets the scene of rank 0. Collective: of other ranks only the validity of the arguments counts; the previous
    /// scene stays on all ranks if one fails.
    pub fn set_scene<'a>(
        &mut self,
        call: &'static str,
        given: impl FnOnce() -> Outcome<SceneSource<'a>>,
    ) -> Outcome<()> {
        let is_root = self.ranks.is_root();
        let mine = caught(|| {
            self.refuse_if_poisoned()?;
            let source = given()?;
            Ok((source, if is_root { source.read()? } else { String::new() }))
        });
        let text = mine.as_ref().map_or_else(|_| String::new(), |(_, text)| text.clone());
        let Agreed { outcome, root_message: text } = self.agree_with(mine, call, Vec::new(), &text);
        let (source, _) = outcome?;
        let mine = caught(|| self.parsed(&text).map_err(|failure| source.failure(failure)));
        let scene = self.agree(mine, call)?;
        if matches!(&scene, SceneChoice::Script(script) if script.is_async()) {
            self.drawing.render_in_background(&mut self.ranks)?;
        }
        self.scene = scene;
        self.keep_text(text);
        self.show_new_scene();
        self.warn_of_unknown_fields();
        Ok(())
    }

    /// Keeps the text of the scene that is drawn from now on.
    pub(super) fn keep_text(&mut self, text: String) {
        self.open_views = suggest::open_views(&text);
        self.scene_text = text;
    }

    /// A view that is due, with the look that is suggested for the values of its field if it names a field alone. The
    /// scene has that look from then on, unless it is provisional; while all values are missing the view stays as it is.
    /// Collective.
    pub(super) fn completed<'v>(&mut self, view: &'v View, stamp: &Stamp) -> Outcome<Cow<'v, View>> {
        if !self.open_views.contains(view.name()) {
            return Ok(Cow::Borrowed(view));
        }
        let text = self.scene_text.clone();
        let wanted = Completion { text: &text, view: Some(view.name()), ..Completion::default() };
        let Some(suggestion) = self.suggested(&wanted, stamp)? else { return Ok(Cow::Borrowed(view)) };
        let SceneChoice::Script(scene) = self.parsed(&suggestion.text)? else {
            return Ok(Cow::Borrowed(view));
        };
        let named = self.inputs.named(&scene);
        if !suggestion.is_provisional {
            self.scene = SceneChoice::Script(scene);
            self.keep_text(suggestion.text);
            self.show_scene();
        }
        let completed = named.views().iter().find(|completed| completed.name() == view.name());
        Ok(Cow::Owned(completed.unwrap_or(view).clone()))
    }

    /// The text of a scene with what is suggested for the values of its field at this step; `None` where all are
    /// missing. Collective.
    pub(super) fn suggested(&mut self, wanted: &Completion, stamp: &Stamp) -> Outcome<Option<Suggestion>> {
        let (mut is_provisional, mut failed) = (false, None);
        let text = suggest::completed(wanted, &mut |name, options| {
            let found = self.suggested_for(wanted.view.unwrap_or(""), name, options, stamp);
            let (suggestion, failure) = found.map_or_else(|failure| (None, Some(failure)), |found| (found, None));
            failed = failure;
            is_provisional = suggestion.as_ref().is_some_and(|suggestion| suggestion.is_provisional);
            Ok(suggestion.map(|suggestion| suggestion.text))
        });
        failed.map_or(Ok(()), Err)?;
        Ok(text?.map(|text| Suggestion { text, is_provisional }))
    }

    /// The scene that is suggested for a field (`""`: the first one) in a view. Collective.
    fn suggested_for(
        &mut self,
        view: &str,
        field: &str,
        options: Options,
        stamp: &Stamp,
    ) -> Outcome<Option<Suggestion>> {
        let mut script = Script::parse("every = 1")?;
        if !field.is_empty() {
            script.name_first_field(field);
        }
        let script = self.inputs.named(&Arc::new(script));
        let scene = script.views()[0].shots(stamp).next().map(|shot| shot.scene);
        let scene = scene.ok_or_else(|| Error::new(ErrorKind::Internal, "a view without a picture"))?;
        let given = self.picture_inputs(Shot { name: view.to_owned(), scene }, stamp, false)?;
        let no_field = || Error::new(ErrorKind::Internal, "a picture without a field");
        let field = given.fields.iter().next().ok_or_else(no_field)?;
        let options = if self.inputs.fields_2d(&given.setup.scene).is_empty() { options } else { options.for_2d() };
        let description = given.setup.descriptions.get(given.setup.scene.field());
        let is_length = description.is_some_and(|its| its.is_length() && !its.is_precipitation(None));
        let options = Options { is_length, ..options };
        let (renderer, data) = (self.drawing.renderer(), given.setup.distributed_grid());
        let found = renderer.suggest_decomposed(&mut self.ranks, data, field, &options);
        found.map_err(|error| Failure::from(error).of_picture(view, stamp.step))
    }

    /// Logs a warning, at rank 0, for fields of the scene that are none of those that the model has named by now.
    fn warn_of_unknown_fields(&self) {
        let SceneChoice::Script(script) = &self.scene else { return };
        let named = self.inputs.fields.keys().chain(self.inputs.descriptions.keys());
        let known: BTreeSet<&str> = named.map(String::as_str).collect();
        let mut read = script.model_fields();
        read.retain(|name| !name.is_empty() && !known.contains(name.as_str()));
        if self.ranks.is_root() && !known.is_empty() && !read.is_empty() {
            let (read, known) = (listed(read.iter().map(String::as_str)), listed(known.into_iter()));
            let message =
                format!("the scene reads {read}, which the model has not set or described so far; it has {known}");
            self.drawing.warn(&message);
        }
    }

    /// The names of the model's fields that pictures and conditions of the scene read at any step.
    pub fn scene_fields(&self) -> Outcome<Vec<String>> {
        match &self.scene {
            SceneChoice::Open => Err(missing("icoray_scene_field", "scene", "icoray_scene_load")),
            SceneChoice::Nothing => Ok(Vec::new()),
            SceneChoice::Script(script) => {
                // A scene may leave the field to the model.
                Ok(script.model_fields().into_iter().filter(|name| !name.is_empty()).collect())
            }
        }
    }

    /// Whether pictures of the scene may read the heights of layers.
    pub fn may_need_heights(&self) -> bool {
        matches!(&self.scene, SceneChoice::Script(script) if script.may_need_heights())
    }

    /// Parses the text of a scene. Rank 0, which writes the pictures, checks that it can.
    fn parsed(&self, text: &str) -> Outcome<SceneChoice> {
        let Some(mut script) = Script::parse_optional(text)? else {
            return Ok(SceneChoice::Nothing);
        };
        script.name_by_date();
        if self.ranks.is_root() {
            self.drawing.check_folders(&script)?;
        }
        Ok(SceneChoice::Script(Arc::new(script)))
    }
}

#[cfg(test)]
mod tests;
