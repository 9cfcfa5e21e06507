//! Changes and questions of the page's viewers, for which the last time is read again.

use super::Watch;
use super::session::Session;
use crate::failure::CommandResult;
use crate::render::{Job, Pictures};
use icoray::{Error, ErrorKind, Frame, Grid, Result, Script};
use icoray_dataset::{Drawing, FieldInfo, Mesh, SceneFields, Series};
use icoray_live::Question;
use std::io::Write;
use std::sync::Arc;

impl Watch<'_> {
    /// Whether viewers have set or asked something for which the last time is read again.
    pub fn hears_viewers(&mut self) -> bool {
        let Some(page) = &mut self.page else { return false };
        let outlines = self.folder.files().filter_map(|file| file.outline.as_ref());
        page.hear(outlines.flat_map(|outline| outline.fields().map(str::to_owned)).collect())
    }

    /// Opens the files of the last time again.
    pub fn for_viewers(&mut self, known: Option<&Arc<Mesh>>) -> Option<Session> {
        let page = self.page.as_ref()?;
        let last = page.last.clone()?;
        let opened = if last.is_valid() {
            self.reopened(last, known, &page.requested_fields())
        } else {
            Err(Error::new(ErrorKind::Io, format!("{}: its files have changed", last.id)))
        };
        opened.map_err(|error| self.refuse_viewers(&error)).ok()
    }

    fn refuse_viewers(&mut self, error: &Error) {
        if let Some(page) = &mut self.page {
            page.refuse(error.context());
            page.take_questions().into_iter().for_each(|question| question.refuse(error.clone()));
        }
    }

    /// Draws the picture that viewers look at, shows it and answers them. Failures go to viewers alone.
    pub fn draw_for_viewers(&mut self, session: &Session, grid: &Grid, out: &mut impl Write) -> CommandResult {
        let Some(page) = &mut self.page else { return Ok(()) };
        let (change, mut questions) = (page.change.clone(), page.take_questions());
        // The picture that is shown does where the scene is the same.
        let shown = page.view.shown().filter(|_| change.is_none());
        let view = page.view.view();
        let script = match &change {
            Some(change) => Script::parse(&change.text).map(|mut set| {
                set.name_by_date();
                set
            }),
            None => Ok(self.script.clone()),
        };
        let drawn = script.and_then(|script| {
            let frame = self.redrawn(&script, session, grid, &view, shown, &mut questions)?;
            Ok((script, frame))
        });
        let Some(page) = &mut self.page else { return Ok(()) };
        let unanswered = match drawn {
            Ok((script, frame)) => {
                self.needed = script.model_fields();
                self.script = script;
                let accepted = page.accept();
                if let Some(frame) = frame {
                    page.show(frame);
                }
                if let Some(change) = accepted {
                    let kept = change.keep(&self.args.output);
                    let failed = kept.err().map_or_else(String::new, |error| format!("; {}", error.context()));
                    let text = format!("live      a viewer has set {}{failed}", change.keys().join(", "));
                    self.progress.suspend(|| writeln!(out, "{text}"))?;
                }
                Error::new(ErrorKind::Argument, "the view is not drawn at this time")
            }
            Err(error) => {
                page.refuse(error.context());
                error
            }
        };
        questions.into_iter().for_each(|question| question.refuse(unanswered.clone()));
        Ok(())
    }

    /// Reads the time of a session and answers questions about it; draws the picture of a view unless it is `shown`.
    fn redrawn(
        &self,
        script: &Script,
        session: &Session,
        grid: &Grid,
        view: &str,
        shown: Option<Arc<Frame>>,
        questions: &mut Vec<Question>,
    ) -> Result<Option<Frame>> {
        let (file, time) = (&session.file, session.moments[0].sources[0].record);
        let mut script = script.clone();
        script.show_as_surfaces(|name| file.field_info(name).is_ok_and(FieldInfo::is_2d));
        let series = Series::of(file, &script, vec![time], true);
        let layers = &self.args.layer_option.layers;
        let scene_fields = self.renderer.run(|| SceneFields::new(file, &script, layers))?;
        let drawing = Drawing { scene_fields: &scene_fields, grid, renderer: self.renderer };
        let job = Job { drawing, target: self.target, open_s: 0.0, is_verbose: false };
        let mut pictures = Pictures::new(&series, job, self.progress);
        let due = pictures.read(time)?;
        let Some(shot) = pictures.shot(&due, view) else { return Ok(None) };
        let drawn = if shown.is_some() { None } else { pictures.frame(&due, &shot)? };
        if let Some(frame) = shown.as_deref().or(drawn.as_ref()) {
            for question in questions.drain(..) {
                pictures.answer(question, &due, &shot, frame);
            }
        }
        Ok(drawn)
    }
}
