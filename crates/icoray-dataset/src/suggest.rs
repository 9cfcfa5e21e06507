//! Suggests scenes for a field of a dataset.

use crate::dataset::Dataset;
use crate::field::FieldInfo;
use crate::layering::LayerSelection;
use icoray::{Error, ErrorKind, Grid, Level, Renderer, Result, suggest};

impl Dataset {
    /// The text of a scene file that shows a field, with a look that fits its values at a time, as [`suggest::scene`]
    /// chooses it. A 2D field is shown as a surface, without exaggeration unless `options` has one.
    ///
    /// # Errors
    /// As [`Dataset::read_layers`], [`Dataset::layer_heights`], [`LayerSelection::of`] and [`suggest::scene`];
    /// [`ErrorKind::Argument`] if another surface than layer 0, or an isosurface, of a 2D field is requested.
    pub fn suggest_scene(
        &self,
        grid: &Grid,
        renderer: &Renderer,
        info: &FieldInfo,
        time: usize,
        layers_wanted: &LayerSelection,
        options: suggest::Options,
    ) -> Result<String> {
        let range = layers_wanted.of(info)?;
        let read = self.read_layers(&info.name, time, range.clone())?;
        let is_flat = options.surface.is_some_and(|level| !matches!(level, Level::Height(_)));
        let heights = self.heights_of(&info.name, is_flat)?;
        let layers = heights.layers_over(info, range)?;
        let options = match info.is_2d() {
            true => as_surface(info, options)?,
            // A shell for unknown heights is thin.
            false if heights.are_of_shell() => {
                suggest::Options { exaggeration: options.exaggeration.or(Some(1.0)), ..options }
            }
            false => options,
        };
        let is_timeless = self.seconds().is_none() && self.times().get(time).is_none_or(Option::is_none);
        let options = suggest::Options { is_timeless, is_length: info.is_length(), ..options };
        let field = read.field()?;
        renderer.run(|| suggest::scene(&info.name, grid, &layers, &field, &options))
    }

    /// The text of a scene, completed by [`suggest::completed`] with the suggestion for its field at a time; unchanged
    /// if there is nothing to complete.
    ///
    /// # Errors
    /// As [`Dataset::suggest_scene`], [`Dataset::field_info`] and [`Dataset::first_field`].
    pub fn completed_scene(
        &self,
        grid: &Grid,
        renderer: &Renderer,
        wanted: &suggest::Completion,
        time: usize,
        layers_wanted: &LayerSelection,
    ) -> Result<String> {
        let completed = suggest::completed(wanted, &mut |name, options| {
            let info = if name.is_empty() { self.first_field()? } else { self.field_info(name)? };
            self.suggest_scene(grid, renderer, info, time, layers_wanted, options).map(Some)
        });
        Ok(completed?.unwrap_or_else(|| wanted.text.to_owned()))
    }
}

/// Options for a 2D field.
fn as_surface(info: &FieldInfo, options: suggest::Options) -> Result<suggest::Options> {
    if let Some(Level::Layer(layer @ 1..)) = options.surface {
        let context = format!("surface {layer}: {} is a 2D field, expected 0", info.name);
        return Err(Error::new(ErrorKind::Argument, context));
    }
    if let Some(value) = options.isosurface {
        let context = format!("isosurface {value}: {} is a 2D field, expected one with layers", info.name);
        return Err(Error::new(ErrorKind::Argument, context));
    }
    Ok(options.for_2d())
}
