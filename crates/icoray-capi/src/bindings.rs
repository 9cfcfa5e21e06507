//! Calls on a context for bindings of other languages in Rust, over Rust's types: each does what the exported function
//! of this name does, fails as that, and asks the same of the caller. Messages of failures have at most 400 bytes, as
//! those of icoray_last_error.
#![expect(clippy::missing_errors_doc, reason = "they fail as the exported functions do")]

use crate::borrow::{ArrayInput, argument};
use crate::boundary::Failure;
use crate::context::{Context, SceneSource};
use crate::frames::{stamp, wanted};
use crate::handle::CallKind::{AfterFrames, Answer, Collective, Local};
use crate::handle::icoray_ctx;
use crate::types::{icoray_array, icoray_frame_report, icoray_ndarray};
use icoray_core::Grid;
use std::sync::Arc;

pub use crate::context::PartInput;

impl icoray_ctx {
    /// As icoray_grid_set, for a grid that the caller has checked and goes on using: nothing is checked or derived
    /// again. The tables live until the context is closed or has another grid of the same name.
    pub fn set_grid(&self, name: &str, grid: Arc<Grid<'static>>) -> Result<(), Failure> {
        self.call(AfterFrames("icoray_grid_set"), |context| context.set_checked_grid(name, grid))
    }

    /// As icoray_part_set. Collective: a rank without a part takes part too, and all ranks fail.
    pub fn set_part(&self, part: Option<PartInput>) -> Result<(), Failure> {
        self.call(Collective, |context| context.set_part(|| part.ok_or_else(|| Failure::null("icoray_part"))))
    }

    /// As icoray_layers_set.
    pub fn set_layers(&self, name: &str, radius_m: &[f64], planet_radius_m: f64) -> Result<(), Failure> {
        self.call(Local, |context| context.set_layers(name, Ok(radius_m), planet_radius_m))
    }

    /// As icoray_field_set.
    ///
    /// # Safety
    /// As there.
    pub unsafe fn set_field(&self, name: &str, array: &icoray_array) -> Result<(), Failure> {
        self.call(Local, |context| context.set_field(name, ArrayInput::new(array, context.is_shared())))
    }

    /// As icoray_field_set_ndarray.
    ///
    /// # Safety
    /// As there.
    pub unsafe fn set_field_ndarray(&self, name: &str, array: &icoray_ndarray) -> Result<(), Failure> {
        self.call(Local, |context| {
            let array = context.ndarray_input("icoray_field_set_ndarray", array);
            context.set_field(name, array)
        })
    }

    /// As icoray_heights_set.
    ///
    /// # Safety
    /// As there.
    pub unsafe fn set_heights(&self, heights: Option<&icoray_array>) -> Result<(), Failure> {
        self.call(Local, |context| {
            let input = |array| ArrayInput::new(array, context.is_shared());
            context.set_heights(heights.map(input).transpose())
        })
    }

    /// As icoray_heights_set_ndarray.
    ///
    /// # Safety
    /// As there.
    pub unsafe fn set_heights_ndarray(&self, heights: &icoray_ndarray) -> Result<(), Failure> {
        self.call(Local, |context| {
            let array = context.ndarray_input("icoray_heights_set_ndarray", heights);
            context.set_heights(array.map(Some))
        })
    }

    /// As icoray_refuse with ICORAY_ERR_ARGUMENT.
    pub fn refuse(&self, call: &str, name: &str, message: &str) {
        // The failure is the one that is given here.
        let _ = self.call(Local, |context| context.refuse(call, name, argument(message.to_owned())));
    }

    /// As icoray_field_describe.
    pub fn describe_field(&self, name: &str, long_name: &str, units: &str) -> Result<(), Failure> {
        self.call(Local, |context| context.describe_field(name, long_name, units))
    }

    /// As icoray_scene_load. Collective.
    pub fn load_scene(&self, path: &str) -> Result<(), Failure> {
        self.call(Collective, |context| context.set_scene("icoray_scene_load", || Ok(SceneSource::File(path))))
    }

    /// As icoray_scene_text. Collective.
    pub fn set_scene_text(&self, text: &str) -> Result<(), Failure> {
        self.call(Collective, |context| context.set_scene("icoray_scene_text", || Ok(SceneSource::Text(text))))
    }

    /// All names of icoray_scene_field.
    pub fn scene_fields(&self) -> Result<Vec<String>, Failure> {
        self.call(Local, |context| context.scene_fields())
    }

    /// Whether pictures of the scene may read the heights of layers; false without a scene.
    pub fn may_need_heights(&self) -> bool {
        self.call(Local, |context| Ok(context.may_need_heights())).unwrap_or(false)
    }

    /// Sets `wants` to the answer of icoray_wants or, with the name of a field, of icoray_wants_field. With a time that
    /// is not finite the call fails, and the answer is that for the step alone.
    pub fn wants(&self, field: Option<&str>, step: i64, time_s: f64, wants: &mut bool) -> Result<(), Failure> {
        self.call(Answer, |context| wanted(context, field, step, time_s, wants))
    }

    /// Collective.
    ///
    /// # Safety
    /// The tables and arrays that were set are alive and unchanged until the call returns.
    pub unsafe fn execute(&self, step: i64, time_s: f64, date: Option<&str>) -> Result<(), Failure> {
        self.call(Collective, |context| context.execute(stamp(step, time_s, date)))
    }

    /// Collective.
    pub fn wait(&self) -> Result<(), Failure> {
        self.call(Collective, Context::wait)
    }

    /// The report of the last frame.
    pub fn report(&self) -> Result<icoray_frame_report, Failure> {
        self.call(Local, |context| context.drawing.report())
    }
}
