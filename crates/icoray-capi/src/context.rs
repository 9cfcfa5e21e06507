//! The context behind a handle: inputs, scene, frames in progress, ranks.

use crate::borrow::{ArrayInput, argument};
use crate::boundary::{Failure, Outcome};
use crate::drawing::Drawing;
use crate::types::{icoray_config, icoray_ndarray, icoray_status};
use icoray_core::output::Stamp;
use icoray_core::{Description, Grid, GridTables, Layers, LonLat, OwnedTables, Ranks, Script, View};
use std::collections::BTreeSet;
use std::sync::{Arc, Weak};

mod collective;
mod execute;
mod inputs;
mod levels;
#[cfg(feature = "live")]
mod live;
#[cfg(not(feature = "live"))]
#[path = "context/no_live.rs"]
mod live;
mod refusals;
mod scene;
#[cfg(test)]
mod test_array;

pub use collective::PartInput;
use inputs::{GridInput, Inputs, missing};
use levels::TimeLevels;
use live::Viewers;
use refusals::Input;
pub(crate) use scene::SceneSource;

/// An open icoray context.
pub struct Context {
    inputs: Inputs,
    scene: SceneChoice,
    scene_text: String,
    /// Names of its views whose look is still to be suggested.
    open_views: BTreeSet<String>,
    viewers: Viewers,
    /// The stamp of the previous icoray_execute.
    before: Option<Stamp>,
    /// Detects fields whose array holds an old time level.
    levels: TimeLevels,
    /// Grids of pictures so far, whose holes were logged.
    drawn_grids: Vec<Weak<()>>,
    pub(crate) drawing: Drawing,
    /// The ranks that render together, or this process alone.
    ranks: Ranks,
    /// Message of the internal error after which the state of the context is not trusted.
    poison: Option<String>,
    /// With several ranks: whether all have agreed that one of them had an internal error.
    is_over: bool,
}

enum SceneChoice {
    /// Not set yet.
    Open,
    /// A scene without keys: nothing is rendered.
    Nothing,
    Script(Arc<Script>),
}

impl Context {
    /// `threads` is the number of threads where the config has none.
    pub fn new(config: &icoray_config, output_dir: &str, ranks: &Ranks, threads: usize) -> Outcome<Self> {
        let drawing = Drawing::new(config, output_dir, ranks, threads)?;
        if ranks.is_root() {
            drawing.check_directory()?;
        }
        Ok(Context {
            inputs: Inputs::default(),
            scene: SceneChoice::Open,
            scene_text: String::new(),
            open_views: BTreeSet::new(),
            viewers: Viewers::default(),
            before: None,
            levels: TimeLevels::default(),
            drawn_grids: Vec::new(),
            drawing,
            ranks: Ranks::alone(),
            poison: None,
            is_over: false,
        })
    }

    /// Fails on a poisoned context in calls whose answer must be equal on all ranks: an error of this rank counts only
    /// after all ranks have agreed on it.
    pub fn refuse_if_over(&self) -> Outcome<()> {
        if self.is_shared() && !self.is_over { Ok(()) } else { self.refuse_if_poisoned() }
    }

    pub fn refuse_if_poisoned(&self) -> Outcome<()> {
        let Some(poison) = &self.poison else { return Ok(()) };
        let message = format!("the context failed earlier and accepts no more calls ({poison})");
        Err(Failure::new(icoray_status::ICORAY_ERR_INTERNAL, message))
    }

    /// Logs the failure of a call, and poisons the context after an internal error.
    pub fn failed(&mut self, failure: &Failure) {
        self.drawing.log_failure(failure);
        self.keep(failure);
    }

    /// As [`Self::failed`] for a failure that all ranks have: rank 0 logs it.
    pub fn failed_for_all(&mut self, failure: &Failure) {
        if self.ranks.is_root() {
            self.drawing.log_failure(failure);
        }
        self.keep(failure);
    }

    fn keep(&mut self, failure: &Failure) {
        if failure.status == icoray_status::ICORAY_ERR_INTERNAL {
            self.poison = Some(failure.message.clone());
        }
    }

    /// Checks and sets the tables while no frame reads the previous ones. The previous grid stays if they are wrong; a
    /// new one has no part.
    pub fn set_grid(&mut self, name: &str, tables: Outcome<GridTables<'static>>) -> Outcome<()> {
        let outcome = tables.and_then(|tables| {
            self.refuse_without_cells(tables.cells())?;
            let grid = Arc::new(self.drawing.renderer().run(|| Grid::new(tables))?);
            Ok(GridInput { grid, decomposition: None, tables: None })
        });
        self.take_grid(name, outcome)
    }

    /// As [`Self::set_grid`], of points, which are read during the call only.
    pub fn set_points(&mut self, name: &str, center: Outcome<LonLat>) -> Outcome<()> {
        let outcome = center.and_then(|center| {
            self.refuse_without_cells(center.lon_rad.len())?;
            let renderer = self.drawing.renderer();
            let tables = Arc::new(renderer.run(|| OwnedTables::of_points(center))?);
            // SAFETY: the tables do not move in their Arc, which lives beside the grid and is dropped after it.
            let borrowed: &'static OwnedTables = unsafe { &*Arc::as_ptr(&tables) };
            let grid = Arc::new(renderer.run(|| Grid::new(borrowed.tables()))?);
            Ok(GridInput { grid, decomposition: None, tables: Some(tables) })
        });
        self.take_grid(name, outcome)
    }

    /// As [`Self::set_grid`], for a grid that was checked before.
    pub fn set_checked_grid(&mut self, name: &str, grid: Arc<Grid<'static>>) -> Outcome<()> {
        let outcome =
            self.refuse_without_cells(grid.cells()).map(|()| GridInput { grid, decomposition: None, tables: None });
        self.take_grid(name, outcome)
    }

    fn refuse_without_cells(&self, cells: usize) -> Outcome<()> {
        if cells == 0 && !self.is_shared() {
            return Err(Failure::new(icoray_status::ICORAY_ERR_GRID, "0 cells, expected at least 1"));
        }
        Ok(())
    }

    fn take_grid(&mut self, name: &str, outcome: Outcome<GridInput>) -> Outcome<()> {
        let grid = self.inputs.refusals.keep(Input::Grid, name, outcome)?;
        self.inputs.grids.insert(name.into(), grid);
        Ok(())
    }

    pub fn set_layers(&mut self, name: &str, radius_m: Outcome<&[f64]>, planet_radius_m: f64) -> Outcome<()> {
        let layers = radius_m.and_then(|radius_m| Ok(Layers::new(radius_m.to_vec(), planet_radius_m)?));
        let layers = self.inputs.refusals.keep(Input::Layers, name, layers)?;
        self.inputs.layers.insert(name.into(), Arc::new(layers));
        Ok(())
    }

    /// As [`ArrayInput::new`], for the dimensions of an array that the C function `call` sets.
    pub fn ndarray_input(&self, call: &str, array: &icoray_ndarray) -> Outcome<ArrayInput> {
        ArrayInput::of_dimensions(array, self.inputs.shape_of(call, array)?, self.is_shared())
    }

    pub fn set_field(&mut self, field: &str, array: Outcome<ArrayInput>) -> Outcome<()> {
        let kept = self.inputs.refusals.keep(Input::Field, field, array);
        let given = kept.map_err(|f| f.within(format_args!("field {field:?}")))?;
        refuse_no_name(field)?;
        self.inputs.first.get_or_insert_with(|| field.into());
        self.inputs.fields.insert(field.into(), given);
        self.levels.given(field);
        Ok(())
    }

    /// Sets the heights of layers over cells or corners; `None` removes them.
    pub fn set_heights(&mut self, array: Outcome<Option<ArrayInput>>) -> Outcome<()> {
        let kept = self.inputs.refusals.keep(Input::Heights, "", array);
        self.inputs.heights = kept.map_err(|f| f.within("heights"))?;
        Ok(())
    }

    /// Records that a language binding refused the input `name` of the C function `call`.
    pub fn refuse(&mut self, call: &str, name: &str, failure: Failure) -> Outcome<()> {
        let Some(input) = Input::of_call(call) else { return Err(failure) };
        if input == Input::Field {
            // The array before is not what the model wants to show now, and may not live any more.
            self.inputs.fields.remove(name);
        }
        self.inputs.refusals.keep(input, name, Err(failure)).map_err(|f| match input {
            Input::Field => f.within(format_args!("field {name:?}")),
            Input::Heights => f.within("heights"),
            Input::Grid | Input::Layers => f,
        })
    }

    /// Sets long name and units of a field, which may be set later; blank ones are none.
    pub fn describe_field(&mut self, field: &str, long_name: &str, units: &str) -> Outcome<()> {
        refuse_no_name(field)?;
        let text = |text: &str| Some(text.trim().to_owned()).filter(|text| !text.is_empty());
        let description = Description { long_name: text(long_name), units: text(units) };
        self.inputs.descriptions.insert(field.into(), description);
        Ok(())
    }

    /// Whether a view that reads `field` (any view if `None`) may be rendered at this step. The answer depends on the
    /// script, the previous step and whether the context is on, which change in collective calls only. A process alone
    /// counts in the fields of a scene that viewers have set since.
    pub fn wants(&mut self, field: Option<&str>, now: &Stamp) -> bool {
        // Frames that have failed by now may have switched the context off. Where there are several ranks, all hear of
        // that in the next call that they make together, and say the same until then.
        if !self.is_shared() {
            self.drawing.collect();
        }
        if field.is_some() {
            self.hear_viewers_early();
        }
        let SceneChoice::Script(script) = &self.scene else { return false };
        let (before, first) = (self.before.as_ref(), self.inputs.first.as_deref());
        let is_read = |script: &Script| {
            script.scheduled(now, before).any(|view| field.is_none_or(|field| reads(view, field, first)))
        };
        // Both scenes: ranks may yet refuse that of viewers.
        let wants = self.drawing.is_on() && (is_read(script) || self.viewers.next().is_some_and(is_read));
        if let (Some(field), Some(_)) = (field, script.live()) {
            self.viewers.answered(field, wants);
        }
        wants
    }

    /// Waits until all frames are on disk.
    pub fn wait(&mut self) -> Outcome<()> {
        if self.is_shared() { self.wait_collective() } else { self.drawing.finish() }
    }

    /// Waits before close; returns no error if a call has already reported that the context is poisoned.
    pub fn finish(&mut self) -> Outcome<()> {
        if self.is_shared() {
            return self.finish_collective();
        }
        let outcome = self.drawing.finish();
        if self.poison.is_some() { Ok(()) } else { outcome }
    }
}

fn refuse_no_name(field: &str) -> Outcome<()> {
    if field.is_empty() {
        return Err(argument("name: \"\", expected the name that scenes use".into()));
    }
    Ok(())
}

/// Whether a view renders a field or has a condition on it. A view without a field name reads the `first` field that
/// was set, or any while none is set.
fn reads(view: &View, field: &str, first: Option<&str>) -> bool {
    let is_condition = view.conditions().iter().any(|condition| condition.field() == field);
    let is_meant = |name: &String| name == field || name.is_empty() && first.is_none_or(|first| first == field);
    is_condition || view.model_fields().iter().any(is_meant)
}
