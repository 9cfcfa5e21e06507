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
mod together;

pub(crate) use inputs::Subject;
use inputs::{Given, Inputs, Spread, known, missing};

/// An open icoray context.
pub struct Context {
    inputs: Inputs,
    scene: Choice,
    /// The step that icoray_execute had before.
    before: Option<Stamp>,
    drawing: Drawing,
    /// Those who draw together, or this process alone.
    ranks: Ranks,
    /// Why icoray itself failed, if it did: its state can no longer be trusted.
    poison: Option<String>,
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
    pub fn new(config: &icoray_config, output_dir: &str, ranks: &Ranks) -> Outcome<Self> {
        Ok(Context {
            inputs: Inputs::default(),
            scene: Choice::Open,
            before: None,
            drawing: Drawing::new(config, output_dir, ranks)?,
            ranks: Ranks::alone(),
            poison: None,
        })
    }

    pub fn refuse_if_poisoned(&self) -> Outcome<()> {
        let Some(poison) = &self.poison else { return Ok(()) };
        let message = format!("the context failed earlier and accepts no more calls ({poison})");
        Err(Failure::new(icoray_status::ICORAY_ERR_INTERNAL, message))
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

    /// Checks the tables; the grid before stays where they are wrong, and its part goes with it.
    pub fn set_grid(&mut self, name: &str, tables: GridTables<'static>) -> Outcome<()> {
        if tables.cells() == 0 && !self.is_shared() {
            return Err(Failure::new(icoray_status::ICORAY_ERR_GRID, "0 cells, expected at least 1"));
        }
        // After this call the model may free the tables of the grid before.
        self.drawing.finish_rendering();
        let grid = self.drawing.renderer().run(|| Grid::new(tables))?;
        self.inputs.grids.insert(name.into(), Spread { grid: Arc::new(grid), held: None });
        Ok(())
    }

    pub fn set_layers(&mut self, name: &str, radius_m: &[f64], planet_radius_m: f64) -> Outcome<()> {
        let layers = Layers::new(radius_m.to_vec(), planet_radius_m)?;
        self.inputs.layers.insert(name.into(), Arc::new(layers));
        Ok(())
    }

    /// `of` names the struct that the model gave.
    pub fn set_field(&mut self, field: &str, array: &icoray_array, of: &str) -> Outcome<()> {
        let is_shared = self.is_shared();
        let given =
            Given::new(array, of, is_shared).map_err(|f| f.within(format_args!("field {field:?}")))?;
        if field.is_empty() {
            return Err(argument("name: \"\", expected the name that scenes use".into()));
        }
        self.inputs.fields.insert(field.into(), given);
        Ok(())
    }

    /// Heights of cells and layers; none takes back those before.
    pub fn set_heights(&mut self, array: Option<&icoray_array>, of: &str) -> Outcome<()> {
        let is_shared = self.is_shared();
        let given = array.map(|array| {
            at_centers(array.location, of)?;
            Given::new(array, of, is_shared)
        });
        self.inputs.heights = given.transpose().map_err(|f| f.within("heights"))?;
        Ok(())
    }

    /// Says what a field is called, whether it was given yet or not.
    pub fn describe_field(&mut self, field: &str, description: Description) -> Outcome<()> {
        if field.is_empty() {
            return Err(argument("name: \"\", expected the name that scenes use".into()));
        }
        self.inputs.descriptions.insert(field.into(), description);
        Ok(())
    }

    /// Finds the layers and columns among an array's dimensions.
    pub fn set_ndarray(&mut self, field: &str, array: &icoray_ndarray) -> Outcome<()> {
        let flat = self.inputs.flat(array, "icoray_field_set_ndarray");
        let flat = flat.map_err(|f| f.within(format_args!("field {field:?}")))?;
        self.set_field(field, &flat, icoray_ndarray::NAME)
    }

    /// The same of heights.
    pub fn set_heights_ndarray(&mut self, array: Option<&icoray_ndarray>) -> Outcome<()> {
        let flat = array.map(|array| {
            at_centers(array.location, icoray_ndarray::NAME)?;
            self.inputs.flat(array, "icoray_heights_set_ndarray")
        });
        let flat = flat.transpose().map_err(|f| f.within("heights"))?;
        self.set_heights(flat.as_ref(), icoray_ndarray::NAME)
    }

    pub fn set_scene(&mut self, text: &str) -> Outcome<()> {
        self.scene = Script::parse_optional(text)?.map_or(Choice::Nothing, |s| Choice::Script(Arc::new(s)));
        Ok(())
    }

    /// Whether a picture of this step may be drawn, by a view that reads `field` where one is named.
    pub fn wants(&mut self, field: Option<&str>, now: &Stamp) -> bool {
        // Frames that have failed by now may have switched the context off. Where there are several ranks, all hear of that in
        // the next call that they make together, and say the same until then.
        if !self.is_shared() {
            self.drawing.collect();
        }
        let Choice::Script(script) = &self.scene else { return false };
        let mut scheduled = script.scheduled(now, self.before.as_ref());
        self.drawing.is_on() && scheduled.any(|view| field.is_none_or(|field| reads(view, field)))
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

/// Whether a view draws a field or has a condition on it.
fn reads(view: &View, field: &str) -> bool {
    let is_condition = view.conditions().iter().any(|condition| condition.field() == field);
    is_condition || view.model_fields().iter().any(|name| name == field)
}
