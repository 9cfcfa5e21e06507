//! The heights of each column, for scenes that show them.

use super::subject::Subjects;
use icoray::{Error, ErrorKind, Field, Grid, Renderer, Result, Scene};
use icoray_netcdf::{ModelFile, NativeHeights};
use std::collections::HashMap;
use std::time::Instant;

/// Heights that were read: once per time, or once where they do not change. None where no picture has asked for them.
#[derive(Default)]
pub struct OwnHeights {
    /// By what they are in words, with the time of those that are of one.
    read: HashMap<String, (Option<usize>, NativeHeights)>,
}

impl OwnHeights {
    /// Reads those that `scenes` need at a time and are not here; gives the seconds that it took.
    pub fn get_ready(
        &mut self,
        (file, grid, renderer): (&ModelFile, &Grid, &Renderer),
        subjects: &Subjects,
        scenes: impl Iterator<Item = Scene>,
        time: usize,
    ) -> Result<f64> {
        let start = Instant::now();
        self.read.retain(|_, (of, _)| of.is_none_or(|of| of == time));
        for scene in scenes {
            let Some(info) = subjects.native(&scene)? else { continue };
            if self.read.contains_key(&info.description) {
                continue;
            }
            let name = &subjects.layering(&scene)?.bearer().name;
            let read = renderer.run(|| file.native_heights(grid, name, time))?;
            if let Some(read) = read {
                let of = info.time_dependent.then_some(time);
                self.read.insert(info.description.clone(), (of, read));
            }
        }
        Ok(start.elapsed().as_secs_f64())
    }

    /// Those of a scene, borrowed; `None` where it shows mean heights.
    pub fn of(&self, subjects: &Subjects, scene: &Scene) -> Result<Option<Field<'_>>> {
        let Some(info) = subjects.native(scene)? else { return Ok(None) };
        let Some((_, read)) = self.read.get(&info.description) else {
            let context = format!("{} was not read", info.description);
            return Err(Error::new(ErrorKind::Internal, context));
        };
        let layering = subjects.layering(scene)?;
        let bearer = layering.bearer();
        read.over(bearer, layering.range(bearer)?).map(Some)
    }
}
