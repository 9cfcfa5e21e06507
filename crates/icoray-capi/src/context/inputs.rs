//! What the model has given so far, by name, and what a frame is drawn of.

use super::refusals::{Input, Refusals, lacking};
use crate::borrow::{self, Versioned, argument, name};
use crate::boundary::{Failure, Outcome};
use crate::message::listed;
use crate::types::{icoray_array, icoray_ndarray, icoray_status};
use icoray_core::{
    ColumnCount, Description, Field, Fields, Grid, Heights, Held, Layers, Location, Scene, Shot,
};
use std::collections::BTreeMap;
use std::ffi::c_char;
use std::ptr;
use std::sync::Arc;

/// A field as it was given: where its array is, and over which grid and layers.
pub(super) struct Given {
    array: icoray_array,
    grid: String,
    layers: String,
}

// SAFETY: the array is read only inside calls on the context, in which the model keeps it alive and unchanged.
unsafe impl Send for Given {}

/// A grid and, where it or its fields are spread over ranks, what this one has of them.
pub(super) struct Spread {
    pub grid: Arc<Grid<'static>>,
    pub held: Option<Arc<Held>>,
}

impl Spread {
    /// The columns that a field at `location` has on this rank.
    fn columns_at(&self, location: Location) -> Outcome<ColumnCount> {
        let whole = ColumnCount::new(&self.grid, location);
        Ok(match self.held.as_deref() {
            Some(Held::Columns(held)) => ColumnCount { columns: held.of_field_at(location)?, ..whole },
            _ => whole,
        })
    }
}

/// All that was given.
#[derive(Default)]
pub(super) struct Inputs {
    /// By name. The tables are borrowed from the model, which keeps them until close or the next grid_set.
    pub grids: BTreeMap<String, Spread>,
    pub layers: BTreeMap<String, Arc<Layers>>,
    pub fields: BTreeMap<String, Given>,
    /// Name of the field that was set first.
    pub first: Option<String>,
    /// Of cells and layers.
    pub heights: Option<Given>,
    /// What fields are called, by their names; also of those that are yet to come.
    pub descriptions: BTreeMap<String, Description>,
    pub refusals: Refusals,
}

/// All that one frame is made of.
pub(crate) struct Subject<'a> {
    /// Name of its view; empty where it has none.
    pub view: String,
    pub scene: Arc<Scene>,
    pub grid: Arc<Grid<'static>>,
    pub held: Option<Arc<Held>>,
    pub layers: Arc<Layers>,
    /// Those that the scene needs, by name, with heights where it needs them.
    pub fields: Fields<'a>,
    /// Of the first field that is shown.
    pub description: Description,
    /// Of the others that have one.
    pub descriptions: Vec<(String, Description)>,
}

/// A field of which a condition asks, and what this rank has of it.
pub(super) struct Measured<'a> {
    pub name: String,
    pub field: Field<'a>,
    pub held: Option<Arc<Held>>,
}

impl Subject<'_> {
    /// Refuses fields that have other columns than the whole grid, where several ranks draw and none has a part.
    pub fn check_whole(&self) -> Outcome<()> {
        if self.held.is_some() {
            return Ok(());
        }
        if self.grid.cells() == 0 {
            let message = "0 cells, expected at least 1, or icoray_part_set where ranks have parts of a grid";
            return Err(Failure::new(icoray_status::ICORAY_ERR_GRID, message));
        }
        for (name, field) in self.fields.iter() {
            let (columns, expected) = (field.shape().columns, ColumnCount::new(&self.grid, field.location()));
            if columns != expected.columns {
                let parts = || {
                    "those of the whole grid; call icoray_part_set where ranks have some columns each"
                        .to_owned()
                };
                let why = expected.explain(columns).unwrap_or_else(parts);
                let message =
                    format!("field {name:?}: {columns} columns, expected {}, {why}", expected.columns);
                return Err(Failure::new(icoray_status::ICORAY_ERR_FIELD, message));
            }
        }
        Ok(())
    }

    /// What this rank has of the grid, which must be the same on all ranks, and its name in the sentence that says it is not.
    pub fn grid_fact(&self) -> (&'static str, String) {
        const NAME: &str = "has a grid";
        if self.held.is_some() {
            return (NAME, "in parts of icoray_part_set".into());
        }
        let (cells, corners, center) = (self.grid.cells(), self.grid.triangles(), self.grid.tables().center);
        let place = if cells == 0 { [f64::NAN; 2] } else { [center.lon_rad.get(0), center.lat_rad.get(0)] };
        let [lon, lat] = place.map(f64::to_degrees);
        let whole = format!("of {cells} cells and {corners} corners, the first at {lon:.3} E {lat:.3} N");
        (NAME, whole + ", without icoray_part_set")
    }
}

impl Given {
    /// Looks at all but the values; `of` names the struct that the model gave.
    pub fn new(array: &icoray_array, of: &str, is_shared: bool) -> Outcome<Self> {
        // SAFETY: the caller of icoray_field_set or icoray_heights_set promises an array and two strings.
        let (columns, (grid, layers)) = unsafe {
            let columns = borrow::field(array, of)?.shape().columns;
            (columns, names(array.grid_name, array.layers_name)?)
        };
        if columns == 0 && !is_shared {
            return Err(Failure::new(icoray_status::ICORAY_ERR_FIELD, "0 columns, expected at least 1"));
        }
        // The caller's strings need not outlive the call.
        let copy = icoray_array { grid_name: ptr::null(), layers_name: ptr::null(), ..*array };
        Ok(Given { array: copy, grid: grid.into(), layers: layers.into() })
    }

    pub fn field<'a>(&self) -> Outcome<Field<'a>> {
        // SAFETY: the model promises that its arrays live and do not change until icoray_execute returns.
        unsafe { borrow::field(&self.array, icoray_array::NAME) }
    }

    /// Refuses another grid and other layers than those of the scene's first field, `first`.
    fn check_fits(&self, first: &Given, called: &str) -> Outcome<()> {
        for (what, mine, firsts) in
            [("grid", &self.grid, &first.grid), ("layers", &self.layers, &first.layers)]
        {
            if mine != firsts {
                let message =
                    format!("{what} {mine:?}, expected {firsts:?} as of field {called:?} in the same scene");
                return Err(Failure::new(icoray_status::ICORAY_ERR_FIELD, message));
            }
        }
        Ok(())
    }
}

impl Inputs {
    /// The grid of a name, which `came` needs.
    pub fn grid(&self, name: &str, came: &str) -> Outcome<&Spread> {
        known(&self.grids, name, Input::Grid, came, &self.refusals)
    }

    fn layers(&self, name: &str, came: &str) -> Outcome<&Arc<Layers>> {
        known(&self.layers, name, Input::Layers, came, &self.refusals)
    }

    /// The array that one of many dimensions is, over its grid and layers; `call` has given it.
    pub fn flat(&self, array: &icoray_ndarray, call: &str) -> Outcome<icoray_array> {
        // SAFETY: the caller of icoray_field_set_ndarray or icoray_heights_set_ndarray promises two strings.
        let (grid, layers) = unsafe { names(array.grid_name, array.layers_name)? };
        let spread = self.grid(grid, call)?;
        let layers = self.layers(layers, call)?;
        let location = borrow::location(array.location, "icoray_ndarray")?;
        borrow::flat(array, &spread.columns_at(location)?, layers.count())
    }

    /// Looks up the field of a condition.
    pub fn measured<'a>(&self, name: &str) -> Outcome<Measured<'a>> {
        let call = "icoray_execute";
        let given = self.fields.get(name).ok_or_else(|| self.not_given("when: field", name, ""))?;
        let within = |f: Failure| f.within(format_args!("field {name:?}"));
        let spread = self.grid(&given.grid, call).map_err(within)?;
        let field = given.field().map_err(within)?;
        Ok(Measured { name: name.to_owned(), field, held: spread.held.clone() })
    }

    fn not_given(&self, what: &str, name: &str, needs: &str) -> Failure {
        let known = listed(self.fields.keys().map(String::as_str));
        let message = format!("{what} {name:?} was not given by icoray_field_set; {needs}given: {known}");
        let failure = Failure::new(icoray_status::ICORAY_ERR_FIELD, message);
        lacking(self.refusals.of(Input::Field, name), failure)
    }

    /// Looks up what a picture is drawn from.
    pub fn subject<'a>(&self, shot: Shot) -> Outcome<Subject<'a>> {
        let (call, view, scene) = ("icoray_execute", shot.name, Arc::new(shot.scene));
        for (input, is_empty) in
            [(Input::Grid, self.grids.is_empty()), (Input::Layers, self.layers.is_empty())]
        {
            if is_empty {
                let failure = missing(call, input.what(), input.call());
                return Err(lacking(self.refusals.of_any(input), failure));
            }
        }
        let needed = self.needed(&scene)?;
        let (called, first) = needed[0];
        let within = |f: Failure| f.within(format_args!("field {called:?}"));
        let spread = self.grid(&first.grid, call).map_err(within)?;
        let layers = self.layers(&first.layers, call).map_err(within)?;
        let field = |(name, given): &(&str, &Given)| {
            let field = given.check_fits(first, called).and_then(|()| given.field());
            Ok(((*name).to_owned(), field.map_err(|f| f.within(format_args!("field {name:?}")))?))
        };
        let mut fields = Fields::new(needed.iter().map(field).collect::<Outcome<Vec<_>>>()?);
        if scene.scenery.heights == Heights::Native {
            let heights = self.heights_for(spread, layers, (called, first));
            fields = fields.with_heights(heights.map_err(|f| f.within("heights"))?);
        }
        let described = |name: &str| self.descriptions.get(name).cloned();
        let description = described(&scene.field).unwrap_or_default();
        let others = scene.shown_fields().into_iter().skip(1);
        let descriptions = others.filter_map(|name| Some((name.to_owned(), described(name)?))).collect();
        let (grid, held, layers) = (spread.grid.clone(), spread.held.clone(), layers.clone());
        Ok(Subject { view, scene, grid, held, layers, fields, description, descriptions })
    }

    /// The fields that a scene is made of, at least one.
    fn needed<'s>(&'s self, scene: &'s Scene) -> Outcome<Vec<(&'s str, &'s Given)>> {
        let names = scene.model_fields();
        let needs = if names.len() > 1 {
            format!("the scene needs {}, ", listed(names.iter().copied()))
        } else {
            String::new()
        };
        let given = |name: &&'s str| {
            if name.is_empty() {
                return Err(missing("icoray_execute", "field", "icoray_field_set"));
            }
            let found = self.fields.get(*name).map(|given| (*name, given));
            found.ok_or_else(|| self.not_given("the scene's field", name, &needs))
        };
        names.iter().map(given).collect()
    }

    /// Heights over the grid and layers of the scene's first field.
    fn heights_for<'a>(
        &self,
        spread: &Spread,
        layers: &Layers,
        (called, first): (&str, &Given),
    ) -> Outcome<Field<'a>> {
        let Some(given) = &self.heights else {
            let message = "the scene has heights = \"native\", and none were given by icoray_heights_set";
            let failure = Failure::new(icoray_status::ICORAY_ERR_FIELD, message);
            return Err(lacking(self.refusals.of(Input::Heights, ""), failure));
        };
        given.check_fits(first, called)?;
        let heights = given.field()?;
        let expected = spread.columns_at(Location::Center)?;
        let (shape, columns) = (heights.shape(), expected.columns);
        if (shape.columns, shape.layers) == (columns, layers.count()) {
            return Ok(heights);
        }
        let message = format!(
            "{} columns of {} layers, expected {columns} of {}, as many as icoray_layers has",
            shape.columns,
            shape.layers,
            layers.count()
        );
        Err(Failure::new(icoray_status::ICORAY_ERR_LAYERS, message))
    }
}

pub(super) fn missing(came: &str, what: &str, first: &str) -> Failure {
    let message = format!("{came} was called before a {what} was set; call {first} first");
    Failure::new(icoray_status::ICORAY_ERR_ORDER, message)
}

/// What was given under `name`, which `came` needs.
fn known<'m, T>(
    given: &'m BTreeMap<String, T>,
    name: &str,
    input: Input,
    came: &str,
    refusals: &Refusals,
) -> Outcome<&'m T> {
    if let Some(found) = given.get(name) {
        return Ok(found);
    }
    let (what, first) = (input.what(), input.call());
    let failure = if given.is_empty() {
        missing(came, what, first)
    } else {
        let names = listed(given.keys().map(String::as_str));
        let named = if name.is_empty() { "without a name".into() } else { format!("named {name:?}") };
        argument(format!("no {what} {named} was given by {first}; given: {names}"))
    };
    Err(lacking(refusals.of(input, name), failure))
}

/// # Safety
/// Both are NULL or strings that live for `'a`.
unsafe fn names<'a>(grid: *const c_char, layers: *const c_char) -> Outcome<(&'a str, &'a str)> {
    // SAFETY: passed on.
    unsafe { Ok((name(grid, "grid_name")?, name(layers, "layers_name")?)) }
}

#[cfg(test)]
mod tests;
