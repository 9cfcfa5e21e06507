//! What lies behind a handle: what the model has given so far.

use crate::borrow::{self, Versioned, argument, name};
use crate::boundary::{Failure, Outcome};
use crate::drawing::Drawing;
use crate::types::{icoray_array, icoray_config, icoray_frame_report, icoray_ndarray, icoray_status};
use icoray_core::output::Stamp;
use icoray_core::{Description, Field, Grid, GridTables, Held, Layers, Location, Ranks, Scene};
use std::collections::BTreeMap;
use std::ffi::c_char;
use std::ptr;
use std::sync::Arc;
use std::time::Instant;

/// A field as it was given: where its array is, and over which grid and layers.
struct Given {
    array: icoray_array,
    grid: String,
    layers: String,
}

// SAFETY: the array is read only inside calls on the context, in which the model keeps it alive and unchanged.
unsafe impl Send for Given {}

mod together;

/// A grid and, where it or its fields are spread over ranks, what this one has of them.
struct Spread {
    grid: Arc<Grid<'static>>,
    held: Option<Arc<Held>>,
}

/// An open icoray context.
pub struct Context {
    /// By name. The tables are borrowed from the model, which keeps them until close or the next grid_set.
    grids: BTreeMap<String, Spread>,
    layers: BTreeMap<String, Arc<Layers>>,
    fields: BTreeMap<String, Given>,
    /// What fields are called, by their names; also of those that are yet to come.
    descriptions: BTreeMap<String, Description>,
    scene: Choice,
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
    Scene(Arc<Scene>),
}

/// All that one frame is made of.
pub(crate) struct Subject<'a> {
    pub scene: Arc<Scene>,
    pub grid: Arc<Grid<'static>>,
    pub held: Option<Arc<Held>>,
    pub layers: Arc<Layers>,
    pub field: Field<'a>,
    pub description: Description,
}

impl Context {
    pub fn new(config: &icoray_config, output_dir: &str, ranks: &Ranks) -> Outcome<Self> {
        Ok(Context {
            grids: BTreeMap::new(),
            layers: BTreeMap::new(),
            fields: BTreeMap::new(),
            descriptions: BTreeMap::new(),
            scene: Choice::Open,
            drawing: Drawing::new(config, output_dir, ranks)?,
            ranks: Ranks::alone(),
            poison: None,
        })
    }

    pub fn refuse_if_poisoned(&self) -> Outcome<()> {
        let Some(poison) = &self.poison else { return Ok(()) };
        let message = format!("the context failed before and takes no more calls ({poison})");
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
        self.grids.insert(name.into(), Spread { grid: Arc::new(grid), held: None });
        Ok(())
    }

    pub fn set_layers(&mut self, name: &str, radius_m: &[f64], planet_radius_m: f64) -> Outcome<()> {
        let layers = Layers::new(radius_m.to_vec(), planet_radius_m)?;
        self.layers.insert(name.into(), Arc::new(layers));
        Ok(())
    }

    /// `of` names the struct that the model gave.
    pub fn set_field(&mut self, field: &str, array: &icoray_array, of: &str) -> Outcome<()> {
        let within = |f: Failure| Failure::new(f.status, format!("field {field:?}: {}", f.message));
        // SAFETY: the caller of icoray_field_set promises an array and two strings.
        let (columns, (grid, layers)) = unsafe {
            let columns = borrow::field(array, of).map_err(within)?.shape().columns;
            (columns, names(array.grid_name, array.layers_name).map_err(within)?)
        };
        if columns == 0 && !self.is_shared() {
            let none = Failure::new(icoray_status::ICORAY_ERR_FIELD, "0 columns, expected at least 1");
            return Err(within(none));
        }
        if field.is_empty() {
            return Err(argument("name: \"\", expected the name that scenes use".into()));
        }
        let (grid, layers) = (grid.to_string(), layers.to_string());
        // The caller's strings need not outlive the call.
        let array = icoray_array { grid_name: ptr::null(), layers_name: ptr::null(), ..*array };
        self.fields.insert(field.into(), Given { array, grid, layers });
        Ok(())
    }

    /// Says what a field is called, whether it was given yet or not.
    pub fn describe_field(&mut self, field: &str, description: Description) -> Outcome<()> {
        if field.is_empty() {
            return Err(argument("name: \"\", expected the name that scenes use".into()));
        }
        self.descriptions.insert(field.into(), description);
        Ok(())
    }

    /// Finds the layers and columns among an array's dimensions.
    pub fn set_ndarray(&mut self, field: &str, array: &icoray_ndarray) -> Outcome<()> {
        let within = |f: Failure| Failure::new(f.status, format!("field {field:?}: {}", f.message));
        let call = "icoray_field_set_ndarray";
        // SAFETY: the caller of icoray_field_set_ndarray promises two strings.
        let (grid, layers) = unsafe { names(array.grid_name, array.layers_name).map_err(within)? };
        let Spread { grid, held } =
            known(&self.grids, grid, "grid", call, "icoray_grid_set").map_err(within)?;
        let layers =
            known(&self.layers, layers, "set of layers", call, "icoray_layers_set").map_err(within)?;
        let location = borrow::location(array.location, "icoray_ndarray").map_err(within)?;
        let columns = match (held.as_deref(), location) {
            (Some(Held::Columns(columns)), _) => {
                columns.of_field_at(location).map_err(|e| within(e.into()))?
            }
            (_, Location::Center) => grid.cells(),
            (_, Location::Corner) => grid.triangles(),
        };
        let flat = borrow::flat(array, columns, layers.count()).map_err(within)?;
        self.set_field(field, &flat, icoray_ndarray::NAME)
    }

    pub fn set_scene(&mut self, text: &str) -> Outcome<()> {
        self.scene = Scene::parse_optional(text)?.map_or(Choice::Nothing, |s| Choice::Scene(Arc::new(s)));
        Ok(())
    }

    /// Whether a frame of this step would be drawn, from `field` where one is named.
    pub fn wants(&mut self, field: Option<&str>, step: i64) -> bool {
        // Frames that have failed by now may have switched the context off. Where there are several ranks, all hear of that in
        // the next call that they make together, and say the same until then.
        if !self.is_shared() {
            self.drawing.collect();
        }
        match &self.scene {
            Choice::Scene(scene) => {
                self.drawing.is_on() && scene.is_due(step) && field.is_none_or(|f| f == scene.field)
            }
            _ => false,
        }
    }

    /// Draws the scene, where this step is due, with the other ranks where there are any.
    pub fn execute(&mut self, stamp: Outcome<Stamp>) -> Outcome<()> {
        let start = Instant::now();
        let outcome = if self.is_shared() { self.execute_together(stamp) } else { self.draw(stamp) };
        self.drawing.spent(start.elapsed().as_secs_f64());
        outcome
    }

    fn draw(&mut self, stamp: Outcome<Stamp>) -> Outcome<()> {
        let stamp = stamp?;
        let Some(scene) = due(&self.scene, stamp.step)? else {
            return self.drawing.pass();
        };
        let Context { grids, layers, fields, descriptions, drawing, .. } = self;
        drawing.draw(stamp, || subject(scene, grids, layers, fields, descriptions))
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

/// The scene that is drawn of this step, if any.
fn due(scene: &Choice, step: i64) -> Outcome<Option<Arc<Scene>>> {
    match scene {
        Choice::Scene(scene) if scene.is_due(step) => Ok(Some(scene.clone())),
        Choice::Scene(_) | Choice::Nothing => Ok(None),
        Choice::Open => {
            let call = "icoray_scene_load or icoray_scene_text";
            Err(missing("icoray_execute", "scene", call))
        }
    }
}

/// Looks up what a scene is drawn from.
fn subject<'a>(
    scene: Arc<Scene>,
    grids: &BTreeMap<String, Spread>,
    layers: &BTreeMap<String, Arc<Layers>>,
    fields: &BTreeMap<String, Given>,
    descriptions: &BTreeMap<String, Description>,
) -> Outcome<Subject<'a>> {
    let call = "icoray_execute";
    if grids.is_empty() {
        return Err(missing(call, "grid", "icoray_grid_set"));
    }
    if layers.is_empty() {
        return Err(missing(call, "set of layers", "icoray_layers_set"));
    }
    let Some(given) = fields.get(&scene.field) else {
        let known: Vec<&str> = fields.keys().map(String::as_str).collect();
        let message = format!(
            "the scene's field {:?} was not given by icoray_field_set; given: {known:?}",
            scene.field
        );
        return Err(Failure::new(icoray_status::ICORAY_ERR_FIELD, message));
    };
    let within = |f: Failure| Failure::new(f.status, format!("field {:?}: {}", scene.field, f.message));
    let Spread { grid, held } = known(grids, &given.grid, "grid", call, "icoray_grid_set").map_err(within)?;
    let layers =
        known(layers, &given.layers, "set of layers", call, "icoray_layers_set").map_err(within)?.clone();
    // SAFETY: the model promises that its arrays live and do not change until icoray_execute returns.
    let field = unsafe { borrow::field(&given.array, icoray_array::NAME).map_err(within)? };
    let description = descriptions.get(&scene.field).cloned().unwrap_or_default();
    Ok(Subject { scene, grid: grid.clone(), held: held.clone(), layers, field, description })
}

fn missing(came: &str, what: &str, first: &str) -> Failure {
    let message = format!("{came} came before a {what} was given; call {first} first");
    Failure::new(icoray_status::ICORAY_ERR_ORDER, message)
}

/// What was given under `name`.
fn known<'m, T>(
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
