//! What the model has given so far, by name, and what a frame is drawn of.

use crate::borrow::{self, Versioned, argument, name};
use crate::boundary::{Failure, Outcome};
use crate::types::{icoray_array, icoray_ndarray, icoray_status};
use icoray_core::{Description, Field, Fields, Grid, Heights, Held, Layers, Location, Scene, Shot};
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

/// All that was given.
#[derive(Default)]
pub(super) struct Inputs {
    /// By name. The tables are borrowed from the model, which keeps them until close or the next grid_set.
    pub grids: BTreeMap<String, Spread>,
    pub layers: BTreeMap<String, Arc<Layers>>,
    pub fields: BTreeMap<String, Given>,
    /// Of cells and layers.
    pub heights: Option<Given>,
    /// What fields are called, by their names; also of those that are yet to come.
    pub descriptions: BTreeMap<String, Description>,
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

    fn field<'a>(&self) -> Outcome<Field<'a>> {
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
    /// The array that one of many dimensions is, over its grid and layers; `call` has given it.
    pub fn flat(&self, array: &icoray_ndarray, call: &str) -> Outcome<icoray_array> {
        // SAFETY: the caller of icoray_field_set_ndarray or icoray_heights_set_ndarray promises two strings.
        let (grid, layers) = unsafe { names(array.grid_name, array.layers_name)? };
        let Spread { grid, held } = known(&self.grids, grid, "grid", call, "icoray_grid_set")?;
        let layers = known(&self.layers, layers, "set of layers", call, "icoray_layers_set")?;
        let location = borrow::location(array.location, "icoray_ndarray")?;
        let columns = match (held.as_deref(), location) {
            (Some(Held::Columns(columns)), _) => columns.of_field_at(location)?,
            (_, Location::Center) => grid.cells(),
            (_, Location::Corner) => grid.triangles(),
        };
        borrow::flat(array, columns, layers.count())
    }

    /// Looks up the field of a condition.
    pub fn measured<'a>(&self, name: &str) -> Outcome<Measured<'a>> {
        let call = "icoray_execute";
        let given = self.fields.get(name).ok_or_else(|| self.not_given("when: field", name, ""))?;
        let within = |f: Failure| f.within(format_args!("field {name:?}"));
        let spread = known(&self.grids, &given.grid, "grid", call, "icoray_grid_set").map_err(within)?;
        let field = given.field().map_err(within)?;
        Ok(Measured { name: name.to_owned(), field, held: spread.held.clone() })
    }

    fn not_given(&self, what: &str, name: &str, needs: &str) -> Failure {
        let known: Vec<&str> = self.fields.keys().map(String::as_str).collect();
        let message = format!("{what} {name:?} was not given by icoray_field_set; {needs}given: {known:?}");
        Failure::new(icoray_status::ICORAY_ERR_FIELD, message)
    }

    /// Looks up what a picture is drawn from.
    pub fn subject<'a>(&self, shot: Shot) -> Outcome<Subject<'a>> {
        let (call, view, scene) = ("icoray_execute", shot.name, Arc::new(shot.scene));
        if self.grids.is_empty() {
            return Err(missing(call, "grid", "icoray_grid_set"));
        }
        if self.layers.is_empty() {
            return Err(missing(call, "set of layers", "icoray_layers_set"));
        }
        let needed = self.needed(&scene)?;
        let (called, first) = needed[0];
        let within = |f: Failure| f.within(format_args!("field {called:?}"));
        let spread = known(&self.grids, &first.grid, "grid", call, "icoray_grid_set").map_err(within)?;
        let layers = known(&self.layers, &first.layers, "set of layers", call, "icoray_layers_set");
        let layers = layers.map_err(within)?;
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
        let needs = if names.len() > 1 { format!("the scene needs {names:?}, ") } else { String::new() };
        let given = |name: &&'s str| {
            let found = self.fields.get(*name).map(|given| (*name, given));
            found.ok_or_else(|| self.not_given("the scene's field", name, &needs))
        };
        names.iter().map(given).collect()
    }

    /// Heights over the grid and layers of the scene's first field.
    fn heights_for<'a>(
        &self,
        Spread { grid, held }: &Spread,
        layers: &Layers,
        (called, first): (&str, &Given),
    ) -> Outcome<Field<'a>> {
        let Some(given) = &self.heights else {
            let message = "the scene has heights = \"native\", and none were given by icoray_heights_set";
            return Err(Failure::new(icoray_status::ICORAY_ERR_FIELD, message));
        };
        given.check_fits(first, called)?;
        let heights = given.field()?;
        let columns = match held.as_deref() {
            Some(Held::Columns(columns)) => columns.of_field_at(Location::Center)?,
            _ => grid.cells(),
        };
        let shape = heights.shape();
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

/// What was given under `name`.
pub(super) fn known<'m, T>(
    given: &'m BTreeMap<String, T>,
    name: &str,
    what: &str,
    came: &str,
    first: &str,
) -> Outcome<&'m T> {
    if let Some(found) = given.get(name) {
        return Ok(found);
    }
    if given.is_empty() {
        return Err(missing(came, what, first));
    }
    let names: Vec<&str> = given.keys().map(String::as_str).collect();
    let named = if name.is_empty() { "without a name".into() } else { format!("named {name:?}") };
    Err(argument(format!("no {what} {named} was given by {first}; given: {names:?}")))
}

/// # Safety
/// Both are NULL or strings that live for `'a`.
unsafe fn names<'a>(grid: *const c_char, layers: *const c_char) -> Outcome<(&'a str, &'a str)> {
    // SAFETY: passed on.
    unsafe { Ok((name(grid, "grid_name")?, name(layers, "layers_name")?)) }
}

#[cfg(test)]
mod tests;
