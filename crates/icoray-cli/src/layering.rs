//! Which layers of a file's fields a scene is drawn of.

use crate::input::Wanted;
use icoray::{Error, ErrorKind, Layers, Result, Scene};
use icoray_netcdf::{FieldInfo, LayerHeights, ModelFile};
use std::ops::Range;

/// The layers of a scene: those of its first field that has any, to which others that lie on interfaces or between them are
/// moved. A 2D field has the same values on all of them; a scene of 2D fields alone has the layers of a thin shell.
#[derive(Clone, Copy)]
pub struct Layering<'a> {
    wanted: &'a Wanted,
    /// The model's field whose layers are counted: the first one with layers, or the first of which that is made.
    lead: &'a FieldInfo,
    /// The field whose layers have the heights: one on interfaces where the first lies between them.
    bearer: &'a FieldInfo,
}

impl<'a> Layering<'a> {
    /// That of a scene.
    ///
    /// # Errors
    /// As [`ModelFile::field_info`].
    pub fn of(file: &'a ModelFile, scene: &Scene, wanted: &'a Wanted) -> Result<Self> {
        let infos: Vec<&FieldInfo> =
            scene.model_fields().into_iter().map(|name| file.field_info(name)).collect::<Result<_>>()?;
        let lead = infos.iter().find(|info| !info.is_2d()).or(infos.first()).copied();
        let lead = lead.map_or_else(|| file.field_info(&scene.field), Ok)?;
        let bearer = infos.into_iter().find(|info| info.layers == lead.layers + 1).unwrap_or(lead);
        Ok(Layering { wanted, lead, bearer })
    }

    /// The names by which layerings differ.
    pub fn key(&self) -> [&'a str; 2] {
        [&self.lead.name, &self.bearer.name]
    }

    /// The field whose layers have the heights.
    pub fn bearer(&self) -> &'a FieldInfo {
        self.bearer
    }

    /// Whether a field has to be moved to the layers of the first.
    pub fn moves(&self, info: &FieldInfo) -> bool {
        info.layers != self.lead.layers && !info.is_2d()
    }

    /// A field's layers that are read and drawn: of one on interfaces all that are around those of the first field, of one between
    /// interfaces all that are between those of the first, of a 2D field as many as of the first.
    ///
    /// # Errors
    /// As [`Wanted::of`]; [`ErrorKind::Argument`] where fewer than 2 are left, or the field's layers are not the first one's.
    pub fn range(&self, info: &FieldInfo) -> Result<Range<usize>> {
        if self.wanted.is_all() {
            return Ok(if info.is_2d() { self.lead.all_layers() } else { info.all_layers() });
        }
        let Range { start, end } = self.wanted.of(self.lead)?;
        let bad = |what: String| {
            let lead = &self.lead.name;
            let context = format!("--layers: {start}..{end} are layers of {lead}; {}{what}", info.name);
            Err(Error::new(ErrorKind::Argument, context))
        };
        match (info.layers, self.lead.layers) {
            (own, first) if own == first || info.is_2d() => Ok(start..end),
            (own, first) if own == first + 1 => Ok(start..end + 1),
            (own, first) if own + 1 == first && start + 3 <= end => Ok(start..end - 1),
            (own, first) if own + 1 == first => bad(" has 1 between them, expected at least 2".into()),
            (own, first) => bad(format!(" has {own} of its own, expected {first}, one more or one fewer")),
        }
    }

    /// The radii on which the first field lies, or between which it does.
    ///
    /// # Errors
    /// As [`Layering::range`] and [`LayerHeights::layers_over`].
    pub fn layers(&self, heights: &LayerHeights) -> Result<Layers> {
        heights.layers_over(self.bearer, self.range(self.bearer)?)
    }
}
