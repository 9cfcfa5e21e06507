//! Grids, layers, fields and heights that the model has set, by name, and the lookup of a frame's inputs.

use super::refusals::{Input, Refusals, refused_or};
use crate::borrow::{self, ArrayInput, Versioned, argument};
use crate::boundary::{Failure, Outcome};
use crate::message::listed;
use crate::types::{icoray_ndarray, icoray_status};
use icoray_core::output::Stamp;
use icoray_core::{
    ColumnCount, Decomposition, Description, Field, Fields, FrameInputs, FrameSetup, Grid, Heights, Layers, Location,
    OwnedTables, Scene, Script, Shape, Shot,
};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A grid, with this rank's part of it where columns or cells are distributed over ranks.
#[derive(Clone)]
pub(crate) struct GridInput {
    pub grid: Arc<Grid<'static>>,
    pub decomposition: Option<Arc<Decomposition>>,
    /// The tables that the grid borrows, where the context made them of points; dropped after it.
    #[expect(dead_code, reason = "it owns what the grid borrows")]
    pub tables: Option<Arc<OwnedTables>>,
}

impl GridInput {
    /// Whether ranks draw the joined parts of their node, and this one's grid has its tables only.
    pub fn has_joined_part(&self) -> bool {
        matches!(self.decomposition.as_deref(), Some(Decomposition::Columns(columns)) if columns.has_parts())
    }

    /// Number of columns of a field at `location` on this rank.
    fn columns_at(&self, location: Location) -> ColumnCount {
        let whole = ColumnCount::new(&self.grid, location);
        match self.decomposition.as_deref() {
            Some(Decomposition::Columns(decomposition)) => {
                ColumnCount { columns: decomposition.of_field_at(location), ..whole }
            }
            _ => whole,
        }
    }
}

/// All inputs of a context.
#[derive(Default)]
pub(crate) struct Inputs {
    /// By name. The tables are borrowed from the model, which keeps them until close or the next grid_set.
    pub grids: BTreeMap<String, GridInput>,
    pub layers: BTreeMap<String, Arc<Layers>>,
    pub fields: BTreeMap<String, ArrayInput>,
    /// Name of the field that was set first.
    pub first: Option<String>,
    /// Heights of layers over cells or corners.
    pub heights: Option<ArrayInput>,
    /// Long names and units by field name; fields may be described before they are set.
    pub descriptions: BTreeMap<String, Description>,
    pub refusals: Refusals,
}

/// A field that a condition evaluates, with this rank's part of the grid.
pub(crate) struct ConditionField<'a> {
    pub name: String,
    pub field: Field<'a>,
    pub decomposition: Option<Arc<Decomposition>>,
}

impl Inputs {
    /// The grid `name`, required by the C function `call`.
    pub fn grid(&self, name: &str, call: &str) -> Outcome<&GridInput> {
        known(&self.grids, name, Input::Grid, call, &self.refusals)
    }

    fn layers(&self, name: &str, call: &str) -> Outcome<&Arc<Layers>> {
        known(&self.layers, name, Input::Layers, call, &self.refusals)
    }

    /// The columns and layers of an array, which are found among its dimensions; `call` is the C function that sets it.
    pub fn shape_of(&self, call: &str, array: &icoray_ndarray) -> Outcome<Shape> {
        // SAFETY: the caller of icoray_field_set_ndarray or icoray_heights_set_ndarray promises two strings.
        let [grid, layers] = unsafe { borrow::names(array.grid_name, array.layers_name)? };
        let grid_input = self.grid(grid, call)?;
        let layers = self.layers(layers, call)?;
        let location = borrow::location(array.location, icoray_ndarray::NAME)?;
        borrow::shape_of(array, &grid_input.columns_at(location), layers.count())
    }

    /// A script with the name of the field that was set first, where it names none, and with 2D fields as surfaces.
    pub fn named(&self, script: &Arc<Script>) -> Arc<Script> {
        let first = self.first.as_ref().filter(|_| script.lacks_field());
        if first.is_none() && !self.fields.values().any(ArrayInput::is_2d) {
            return script.clone();
        }
        let mut named = Script::clone(script);
        first.into_iter().for_each(|first| named.name_first_field(first));
        named.show_as_surfaces(|name| self.fields.get(name).is_some_and(ArrayInput::is_2d));
        Arc::new(named)
    }

    /// Looks up the field of a condition.
    pub fn condition_field<'a>(&self, name: &str) -> Outcome<ConditionField<'a>> {
        let call = "icoray_execute";
        let given = self.fields.get(name).ok_or_else(|| self.not_given("when: field", name, ""))?;
        let within = |f: Failure| f.within(format_args!("field {name:?}"));
        let grid_input = self.grid(&given.grid, call).map_err(within)?;
        let field = given.field(None).map_err(within)?;
        let (columns, expected) = (field.shape().columns, grid_input.columns_at(field.location()));
        if columns != expected.columns {
            return Err(within(expected.error(columns, "per cell or corner of the grid").into()));
        }
        Ok(ConditionField { name: name.to_owned(), field, decomposition: grid_input.decomposition.clone() })
    }

    /// Number of layers of a field; 0 of a 2D field and of one whose array is not readable.
    #[cfg(feature = "live")]
    pub fn layers_of(&self, name: &str) -> usize {
        let field = self.fields.get(name).and_then(|given| given.field(None).ok());
        field.map(|field| field.shape().layers).filter(|layers| *layers > 1).unwrap_or(0)
    }

    fn not_given(&self, what: &str, name: &str, needs: &str) -> Failure {
        let known = listed(self.fields.keys().map(String::as_str));
        let message = format!("{what} {name:?} was not given by icoray_field_set; {needs}given: {known}");
        let failure = Failure::new(icoray_status::ICORAY_ERR_FIELD, message);
        refused_or(self.refusals.of(Input::Field, name), failure)
    }

    /// The fields of a scene that have one value per column.
    pub fn fields_2d<'s>(&self, scene: &'s Scene) -> Vec<&'s str> {
        let is_2d = |name: &&str| self.fields.get(*name).is_some_and(ArrayInput::is_2d);
        scene.model_fields().into_iter().filter(is_2d).collect()
    }

    /// Looks up the inputs of a picture.
    pub fn frame_inputs<'a>(&self, shot: Shot, stamp: &Stamp) -> Outcome<FrameInputs<'a>> {
        let (call, view, scene) = ("icoray_execute", shot.name, Arc::new(shot.scene));
        for (input, is_empty) in [(Input::Grid, self.grids.is_empty()), (Input::Layers, self.layers.is_empty())] {
            if is_empty {
                let failure = missing(call, input.what(), input.call());
                return Err(refused_or(self.refusals.of_any(input), failure));
            }
        }
        let names = scene.model_fields();
        let needs = match names.len() {
            1 => String::new(),
            _ => format!("the scene needs {}, ", listed(names.iter().copied())),
        };
        let given = |name: &&str| match self.fields.get(*name) {
            _ if name.is_empty() => Err(missing(call, "field", "icoray_field_set")),
            Some(given) => Ok(given),
            None => Err(self.not_given("the scene's field", name, &needs)),
        };
        let arrays = names.iter().map(given).collect::<Outcome<Vec<_>>>()?;
        let (called, first) = (names[0], arrays[0]);
        let within = |f: Failure| f.within(format_args!("field {called:?}"));
        let grid_input = self.grid(&first.grid, call).map_err(within)?;
        let layers = self.layers(&first.layers, call).map_err(within)?;
        let field = |(name, given): (&&str, &&ArrayInput)| {
            let field = check_fits(given, first, called).and_then(|()| given.field(Some(layers)));
            Ok(((*name).to_owned(), field.map_err(|f| f.within(format_args!("field {name:?}")))?))
        };
        let mut fields = Fields::new(names.iter().zip(&arrays).map(field).collect::<Outcome<Vec<_>>>()?);
        if scene.scenery.heights == Heights::Native {
            let heights = self.heights_for(grid_input, layers, called, first);
            fields = fields.with_heights(heights.map_err(|f| f.within("heights"))?);
        }
        let described = |name: &str| Some((name.to_owned(), self.descriptions.get(name)?.clone()));
        let setup = FrameSetup {
            view,
            descriptions: scene.shown_fields().into_iter().filter_map(described).collect(),
            scene,
            grid: grid_input.grid.clone(),
            decomposition: grid_input.decomposition.clone(),
            layers: layers.clone(),
            stamp: stamp.clone(),
            notes: Vec::new(),
        };
        Ok(FrameInputs { setup, fields })
    }

    /// Heights over the grid and layers of the scene's first field.
    fn heights_for<'a>(
        &self,
        grid_input: &GridInput,
        layers: &Layers,
        called: &str,
        first: &ArrayInput,
    ) -> Outcome<Field<'a>> {
        let Some(given) = &self.heights else {
            let message = "the scene has heights = \"native\", and none were given by icoray_heights_set";
            let failure = Failure::new(icoray_status::ICORAY_ERR_FIELD, message);
            return Err(refused_or(self.refusals.of(Input::Heights, ""), failure));
        };
        check_fits(given, first, called)?;
        let heights = given.field(None)?;
        let expected = grid_input.columns_at(heights.location());
        let (shape, columns) = (heights.shape(), expected.columns);
        if (shape.columns, shape.layers) == (columns, layers.count()) {
            return Ok(heights);
        }
        let why = expected.explain(shape.columns).map_or_else(String::new, |why| format!(" ({why})"));
        let message = format!(
            "{} columns of {} layers, expected {columns} of {}, as many as icoray_layers has{why}",
            shape.columns,
            shape.layers,
            layers.count()
        );
        Err(Failure::new(icoray_status::ICORAY_ERR_LAYERS, message))
    }
}

/// Checks that grid and layers of an array are those of the scene's first field, `first`.
fn check_fits(given: &ArrayInput, first: &ArrayInput, called: &str) -> Outcome<()> {
    for (what, its, firsts) in [("grid", &given.grid, &first.grid), ("layers", &given.layers, &first.layers)] {
        if its != firsts {
            let message = format!("{what} {its:?}, expected {firsts:?} as of field {called:?} in the same scene");
            return Err(Failure::new(icoray_status::ICORAY_ERR_FIELD, message));
        }
    }
    Ok(())
}

pub(crate) fn missing(call: &str, what: &str, first: &str) -> Failure {
    let message = format!("{call} was called before a {what} was set; call {first} first");
    Failure::new(icoray_status::ICORAY_ERR_ORDER, message)
}

/// The input `name` that the C function `call` requires.
fn known<'m, T>(
    given: &'m BTreeMap<String, T>,
    name: &str,
    input: Input,
    call: &str,
    refusals: &Refusals,
) -> Outcome<&'m T> {
    if let Some(found) = given.get(name) {
        return Ok(found);
    }
    let (what, first) = (input.what(), input.call());
    let failure = if given.is_empty() {
        missing(call, what, first)
    } else {
        let names = listed(given.keys().map(String::as_str));
        let named = if name.is_empty() { "without a name".into() } else { format!("named {name:?}") };
        argument(format!("no {what} {named} was given by {first}; given: {names}"))
    };
    Err(refused_or(refusals.of(input, name), failure))
}

/// Checks that the fields have as many columns as the whole grid, where several ranks render and no parts were set.
pub(crate) fn check_whole(FrameInputs { setup, fields }: &FrameInputs) -> Outcome<()> {
    if setup.decomposition.is_some() {
        return Ok(());
    }
    if setup.grid.cells() == 0 {
        let message = "0 cells, expected at least 1, or icoray_part_set where ranks have parts of a grid";
        return Err(Failure::new(icoray_status::ICORAY_ERR_GRID, message));
    }
    for (name, field) in fields.iter() {
        let (columns, expected) = (field.shape().columns, ColumnCount::new(&setup.grid, field.location()));
        if columns != expected.columns {
            let parts =
                || "those of the whole grid; call icoray_part_set where ranks have some columns each".to_owned();
            let why = expected.explain(columns).unwrap_or_else(parts);
            let message = format!("field {name:?}: {columns} columns, expected {}, {why}", expected.columns);
            return Err(Failure::new(icoray_status::ICORAY_ERR_FIELD, message));
        }
    }
    Ok(())
}

/// This rank's grid as a fact that must be equal on all ranks: the verb of the error message, and the description.
pub(crate) fn grid_fact(FrameSetup { grid, decomposition, .. }: &FrameSetup) -> (&'static str, String) {
    const NAME: &str = "has a grid";
    if decomposition.is_some() {
        return (NAME, "in parts of icoray_part_set".into());
    }
    let (cells, corners, center) = (grid.cells(), grid.triangles(), grid.tables().center);
    let place = if cells == 0 { [f64::NAN; 2] } else { [center.lon_rad.get(0), center.lat_rad.get(0)] };
    let [lon, lat] = place.map(f64::to_degrees);
    let whole = format!("of {cells} cells and {corners} corners, the first at {lon:.3} E {lat:.3} N");
    (NAME, whole + ", without icoray_part_set")
}

#[cfg(test)]
mod tests;
