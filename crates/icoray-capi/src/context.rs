//! What lies behind a handle: what the model has given so far.

use crate::borrow::{Versioned, argument};
use crate::boundary::{Failure, Outcome};
use crate::drawing::Drawing;
use crate::types::{
    ICORAY_CORNER, icoray_array, icoray_config, icoray_frame_report, icoray_ndarray, icoray_status,
};
use icoray_core::output::Stamp;
use icoray_core::{Description, Grid, GridTables, Layers, Ranks, Script, View};
use std::sync::Arc;

mod execute;
mod inputs;
mod levels;
mod refusals;
mod scene;
mod together;

pub(crate) use inputs::Subject;
use inputs::{Given, Inputs, Spread, missing};
use levels::TimeLevels;
use refusals::Input;
pub(crate) use scene::SceneSource;

/// An open icoray context.
pub struct Context {
    inputs: Inputs,
    scene: Choice,
    /// The step that icoray_execute had before.
    before: Option<Stamp>,
    /// What was seen of fields at the steps before.
    levels: TimeLevels,
    drawing: Drawing,
    /// Those who draw together, or this process alone.
    ranks: Ranks,
    /// Why icoray itself failed, if it did: its state can no longer be trusted.
    poison: Option<String>,
    /// With several ranks: whether all of them have agreed that icoray itself failed on one of them.
    is_over: bool,
}

/// What to draw.
enum Choice {
    /// No scene was given yet.
    Open,
    /// An empty one was.
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
            scene: Choice::Open,
            before: None,
            levels: TimeLevels::default(),
            drawing,
            ranks: Ranks::alone(),
            poison: None,
            is_over: false,
        })
    }

    /// Refuses a broken context in calls whose answer must be the same on all ranks: a failure of this rank alone does not
    /// count before all have heard of it.
    pub fn refuse_if_over(&self) -> Outcome<()> {
        if self.is_shared() && !self.is_over { Ok(()) } else { self.refuse_if_poisoned() }
    }

    pub fn refuse_if_poisoned(&self) -> Outcome<()> {
        let Some(poison) = &self.poison else { return Ok(()) };
        let message = format!("the context failed earlier and accepts no more calls ({poison})");
        Err(Failure::new(icoray_status::ICORAY_ERR_INTERNAL, message))
    }

    /// Tells the log what is not wrong but hardly meant.
    pub fn warn(&self, message: &str) {
        self.drawing.warn(message);
    }

    /// A call failed.
    pub fn failed(&mut self, failure: &Failure) {
        self.drawing.log_failure(failure);
        self.keep(failure);
    }

    /// A call failed on all ranks, with one failure: one of them logs it.
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

    /// Checks the tables, while no frame reads those before; the grid before stays where they are wrong, and its part goes with it.
    pub fn set_grid(&mut self, name: &str, tables: Outcome<GridTables<'static>>) -> Outcome<()> {
        let outcome = tables.and_then(|tables| self.take_grid(name, tables));
        self.inputs.refusals.keep(Input::Grid, name, outcome)
    }

    fn take_grid(&mut self, name: &str, tables: GridTables<'static>) -> Outcome<()> {
        if tables.cells() == 0 && !self.is_shared() {
            return Err(Failure::new(icoray_status::ICORAY_ERR_GRID, "0 cells, expected at least 1"));
        }
        let grid = self.drawing.renderer().run(|| Grid::new(tables))?;
        self.inputs.grids.insert(name.into(), Spread { grid: Arc::new(grid), held: None });
        Ok(())
    }

    pub fn set_layers(&mut self, name: &str, radius_m: Outcome<&[f64]>, planet_radius_m: f64) -> Outcome<()> {
        let layers = radius_m.and_then(|radius_m| Ok(Layers::new(radius_m.to_vec(), planet_radius_m)?));
        let layers = self.inputs.refusals.keep(Input::Layers, name, layers)?;
        self.inputs.layers.insert(name.into(), Arc::new(layers));
        Ok(())
    }

    pub fn set_field(&mut self, field: &str, array: Outcome<&icoray_array>) -> Outcome<()> {
        let is_shared = self.is_shared();
        let given = array.and_then(|array| Given::new(array, icoray_array::NAME, is_shared));
        self.take_field(field, given)
    }

    /// Finds the layers and columns among an array's dimensions.
    pub fn set_ndarray(&mut self, field: &str, array: Outcome<&icoray_ndarray>) -> Outcome<()> {
        let is_shared = self.is_shared();
        let flat = array.and_then(|array| self.inputs.flat(array, "icoray_field_set_ndarray"));
        let given = flat.and_then(|flat| Given::new(&flat, icoray_ndarray::NAME, is_shared));
        self.take_field(field, given)
    }

    fn take_field(&mut self, field: &str, given: Outcome<Given>) -> Outcome<()> {
        let kept = self.inputs.refusals.keep(Input::Field, field, given);
        let given = kept.map_err(|f| f.within(format_args!("field {field:?}")))?;
        if field.is_empty() {
            return Err(argument("name: \"\", expected the name that scenes use".into()));
        }
        self.inputs.first.get_or_insert_with(|| field.into());
        self.inputs.fields.insert(field.into(), given);
        self.levels.given(field);
        Ok(())
    }

    /// Heights of cells and layers; none takes back those before.
    pub fn set_heights(&mut self, array: Outcome<Option<&icoray_array>>) -> Outcome<()> {
        let is_shared = self.is_shared();
        let of = icoray_array::NAME;
        let given = array.and_then(|array| {
            let given = array.map(|array| {
                at_centers(array.location, of)?;
                Given::new(array, of, is_shared)
            });
            given.transpose()
        });
        self.take_heights(given)
    }

    /// The same of an array of many dimensions.
    pub fn set_heights_ndarray(&mut self, array: Outcome<Option<&icoray_ndarray>>) -> Outcome<()> {
        let is_shared = self.is_shared();
        let of = icoray_ndarray::NAME;
        let given = array.and_then(|array| {
            let given = array.map(|array| {
                at_centers(array.location, of)?;
                Given::new(&self.inputs.flat(array, "icoray_heights_set_ndarray")?, of, is_shared)
            });
            given.transpose()
        });
        self.take_heights(given)
    }

    fn take_heights(&mut self, given: Outcome<Option<Given>>) -> Outcome<()> {
        let kept = self.inputs.refusals.keep(Input::Heights, "", given);
        self.inputs.heights = kept.map_err(|f| f.within("heights"))?;
        Ok(())
    }

    /// A binding has refused what the model gave to `call` under `name`.
    pub fn refuse(&mut self, call: &str, name: &str, failure: Failure) -> Outcome<()> {
        let Some(input) = Input::of_call(call) else { return Err(failure) };
        self.inputs.refusals.keep(input, name, Err(failure)).map_err(|f| match input {
            Input::Field => f.within(format_args!("field {name:?}")),
            Input::Heights => f.within("heights"),
            Input::Grid | Input::Layers => f,
        })
    }

    /// Says what a field is called, whether it was given yet or not.
    pub fn describe_field(&mut self, field: &str, description: Description) -> Outcome<()> {
        if field.is_empty() {
            return Err(argument("name: \"\", expected the name that scenes use".into()));
        }
        self.inputs.descriptions.insert(field.into(), description);
        Ok(())
    }

    /// Whether a picture of this step may be drawn, by a view that reads `field` where one is named. What the answer is made of
    /// changes only in calls that all ranks make together: the script, the step before, and whether frames are drawn.
    pub fn wants(&mut self, field: Option<&str>, now: &Stamp) -> bool {
        // Frames that have failed by now may have switched the context off. Where there are several ranks, all hear of that in
        // the next call that they make together, and say the same until then.
        if !self.is_shared() {
            self.drawing.collect();
        }
        let Choice::Script(script) = &self.scene else { return false };
        let mut scheduled = script.scheduled(now, self.before.as_ref());
        let first = self.inputs.first.as_deref();
        self.drawing.is_on() && scheduled.any(|view| field.is_none_or(|field| reads(view, field, first)))
    }

    /// Waits until all frames are on disk.
    pub fn wait(&mut self) -> Outcome<()> {
        if self.is_shared() { self.wait_together() } else { self.drawing.finish() }
    }

    /// Waits, for the last time, and says nothing where the context has said before that it is broken.
    pub fn finish(&mut self) -> Outcome<()> {
        if self.is_shared() {
            return self.finish_together();
        }
        let outcome = self.drawing.finish();
        if self.poison.is_some() { Ok(()) } else { outcome }
    }

    /// Moves messages of frames that ranks render in the background. Every call does: frames come to an end so.
    pub fn pump(&mut self) {
        self.drawing.pump();
    }

    pub fn report(&mut self) -> Outcome<icoray_frame_report> {
        self.drawing.report()
    }
}

/// Refuses corners, where there are no heights.
fn at_centers(location: i32, of: &str) -> Outcome<()> {
    if location == ICORAY_CORNER {
        return Err(argument(format!("{of}.location: ICORAY_CORNER (1), expected ICORAY_CENTER (0)")));
    }
    Ok(())
}

/// Whether a view draws a field or has a condition on it. A field that the view does not name is the `first` that was set, and
/// may be any as long as none was.
fn reads(view: &View, field: &str, first: Option<&str>) -> bool {
    let is_condition = view.conditions().iter().any(|condition| condition.field() == field);
    let is_meant =
        |name: &String| name == field || name.is_empty() && first.is_none_or(|first| first == field);
    is_condition || view.model_fields().iter().any(is_meant)
}
