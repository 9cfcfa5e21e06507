//! What lies behind a handle.

use crate::boundary::{Failure, Outcome};
use crate::types::{icoray_array, icoray_frame_report, icoray_status};
use icoray_core::output::{Stamp, write_frame};
use icoray_core::{Certainty, Error, ErrorKind, Field, Frame, Grid, Layers, Lights, Renderer, Scene};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// An open icoray context.
pub struct Context {
    renderer: Renderer,
    output_dir: PathBuf,
    /// The tables are borrowed from the model, which keeps them until close or the next grid_set.
    grid: Option<Grid<'static>>,
    layers: Option<Layers>,
    fields: BTreeMap<String, icoray_array>,
    scene: Option<Scene>,
    report: Option<icoray_frame_report>,
    /// The last failure's message.
    pub(crate) message: String,
    /// Set when icoray itself failed: its state can no longer be trusted.
    pub(crate) poisoned: bool,
}

impl Context {
    pub fn new(threads: i32, output_dir: Option<&str>) -> Outcome<Self> {
        let threads = usize::try_from(threads).ok().filter(|n| *n <= 4096).ok_or_else(|| {
            Error::new(ErrorKind::Argument, format!("icoray_config.threads: {threads}, expected 0 to 4096"))
        })?;
        Ok(Context {
            renderer: Renderer::new(threads)?,
            output_dir: output_dir.unwrap_or(".").into(),
            grid: None,
            layers: None,
            fields: BTreeMap::new(),
            scene: None,
            report: None,
            message: String::new(),
            poisoned: false,
        })
    }

    /// Checks the tables; the grid before stays where they are wrong.
    pub fn set_grid(&mut self, tables: icoray_core::GridTables<'static>) -> Outcome<()> {
        self.grid = Some(self.renderer.run(|| Grid::new(tables))?);
        Ok(())
    }

    pub fn set_layers(&mut self, radius_m: &[f64], planet_radius_m: f64) -> Outcome<()> {
        self.layers = Some(Layers::new(radius_m.to_vec(), planet_radius_m)?);
        Ok(())
    }

    pub fn set_field(&mut self, name: &str, array: &icoray_array) {
        self.fields.insert(name.into(), *array);
    }

    pub fn set_scene(&mut self, text: &str) -> Outcome<()> {
        self.scene = Some(Scene::parse(text)?);
        Ok(())
    }

    /// Renders the scene and writes the picture. `borrow` makes a field of an array as it stands now.
    pub fn execute<'a>(
        &mut self,
        stamp: &Stamp,
        borrow: impl Fn(&icoray_array) -> Outcome<Field<'a>>,
    ) -> Outcome<()> {
        let missing = |what: &str, call: &str| {
            let message = format!("icoray_execute came before a {what} was given; call {call} first");
            Failure::new(icoray_status::ICORAY_ERR_ORDER, message)
        };
        let grid = self.grid.as_ref().ok_or_else(|| missing("grid", "icoray_grid_set"))?;
        let layers = self.layers.as_ref().ok_or_else(|| missing("set of layers", "icoray_layers_set"))?;
        let scene =
            self.scene.as_ref().ok_or_else(|| missing("scene", "icoray_scene_load or icoray_scene_text"))?;
        let array = self.fields.get(&scene.field).ok_or_else(|| {
            let known: Vec<&str> = self.fields.keys().map(String::as_str).collect();
            let message = format!(
                "the scene's field {:?} was not given by icoray_field_set; given: {known:?}",
                scene.field
            );
            Failure::new(icoray_status::ICORAY_ERR_FIELD, message)
        })?;
        // A date that is missing, or two files of one name, are known before the first ray.
        scene.output.names(stamp, &scene.field)?;
        let field = borrow(array)?;
        let mut frame = self.renderer.render(scene, grid, layers, &field)?;
        // Encoding is parallel too; outside of the pool it would start rayon's global one and leave it to the model.
        let written = self.renderer.run(|| write_frame(&self.output_dir, &scene.output, stamp, &mut frame));
        self.report = Some(report(&frame, stamp));
        written.map(|_| ()).map_err(Failure::from)
    }

    pub fn report(&self) -> Outcome<icoray_frame_report> {
        let none = || Failure::new(icoray_status::ICORAY_ERR_ORDER, "no frame has been rendered yet");
        self.report.ok_or_else(none)
    }
}

fn report(frame: &Frame, stamp: &Stamp) -> icoray_frame_report {
    let r = &frame.report;
    let [value_min, value_max] = r.value_range.unwrap_or([f64::NAN; 2]);
    icoray_frame_report {
        struct_size: size_of::<icoray_frame_report>(),
        step: stamp.step,
        time_s: stamp.time_s,
        prepare_s: r.prepare_s,
        render_s: r.render_s,
        write_s: r.write_s,
        rays: r.counts.rays,
        columns: r.counts.columns,
        frusta: r.counts.frusta,
        void_frusta: r.counts.void_frusta,
        value_min,
        value_max,
        missing_values: r.missing_values,
        derived_bytes: r.derived_bytes as u64,
        error_max: r.error.max,
        error_mean: r.error.mean,
        error_p999: r.error.p999,
        tolerance: r.quality.tolerance,
        pixel_step: r.quality.pixel_step as i32,
        lights: match r.quality.lights {
            Lights::Off => 0,
            Lights::Coarse => 1,
            Lights::Full => 2,
        },
        error_is_bound: (r.error.certainty == Certainty::Bound).into(),
    }
}
