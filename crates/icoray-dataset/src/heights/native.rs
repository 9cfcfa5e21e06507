//! Native heights: those of each column's layers.

use super::thickness::{self, Columns};
use super::{HeightColumns, ICON_COLUMNS, LayerHeights, expect, is_over_mpas_levels, looked_for, of_axis, sigma};
use crate::field::{FieldInfo, OwnedField};
use crate::mesh::{Mesh, MeshLayout};
use crate::sea::Floor;
use crate::source::SourceVariable;
use crate::sources::{IN_ANOTHER_FILE, Sources};
use icoray::{ComputedField, Error, ErrorKind, Field, Grid, Layers, Location, Result, Shape};
use std::ops::Range;

/// Heights of each column's layers, read: metres above the sphere, negative below it, at the cells.
///
/// MPAS-Atmosphere's are `zgrid` as stored. MPAS-Ocean's are sums of its thicknesses, from the sea floor
/// (`bottomDepth`) if the files have it, else down from the sea surface (`ssh`, or the sphere): layers below the sea
/// floor and above an ice shelf have no thickness, and a column without water has no heights. ICON's, over triangles,
/// are averaged to cells as its fields are.
#[derive(Debug)]
pub struct NativeHeights(Stored);

#[derive(Debug)]
enum Stored {
    AsRead(Box<OwnedField>),
    Averaged(ComputedField),
    AddedUp(Columns),
}

/// Properties of native heights, before they are read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NativeInfo {
    /// Description of their source: "zgrid of each column".
    pub description: String,
    /// Whether they change with time.
    pub time_dependent: bool,
    /// Bytes of the variable that is read for one time.
    pub bytes: usize,
}

/// The variable from which native heights are read.
#[derive(Clone, Copy)]
struct HeightVariable<'a> {
    found: SourceVariable<'a>,
    kind: HeightKind,
}

/// The values of a variable from which native heights are read.
#[derive(Clone, Copy, PartialEq, Eq)]
enum HeightKind {
    Heights,
    /// Thicknesses of layers, to be added up.
    Thicknesses,
    /// Fractions of the depth.
    Sigma,
}

impl<'a> HeightVariable<'a> {
    /// The variable for a field; `None` if all columns share the heights of layers, or no file has native ones.
    fn of(sources: &'a Sources, mesh: &Mesh, info: &FieldInfo) -> Result<Option<Self>> {
        if info.is_2d() || sources.options.heights_m.is_some() {
            return Ok(None);
        }
        let of_kind = |kind: HeightKind| move |found| HeightVariable { found, kind };
        if let Some(found) = sigma::of(sources, mesh, info) {
            return Ok(Some(HeightVariable { found, kind: HeightKind::Sigma }));
        }
        if !is_over_mpas_levels(mesh, info) {
            let is_shared = of_axis(sources, mesh, info)?.is_some();
            let columns = if is_shared { None } else { HeightColumns::find(&ICON_COLUMNS, sources, mesh, info)? };
            return Ok(columns.map(|columns| columns.found).map(of_kind(HeightKind::Heights)));
        }
        if let Some(found) = sources.find("zgrid") {
            expect(found, &["nCells", "nVertLevelsP1"])?;
            return Ok(Some(HeightVariable { found, kind: HeightKind::Heights }));
        }
        Ok(thickness::of_now(sources).map(of_kind(HeightKind::Thicknesses)))
    }

    fn time_dependent(self, sources: &Sources) -> bool {
        sources.changes(self.found)
            || match self.kind {
                HeightKind::Heights => false,
                HeightKind::Thicknesses => thickness::start_changes(sources),
                HeightKind::Sigma => thickness::changes(sources, &sigma::SURFACE),
            }
    }

    fn description(self, sources: &Sources, mesh: &Mesh) -> String {
        let name = self.found.name();
        let at_times = if self.time_dependent(sources) { ", those of each time" } else { "" };
        match mesh.layout() {
            _ if self.kind == HeightKind::Sigma => format!("{name} of each column, between its depth and sea surface"),
            _ if self.kind == HeightKind::Thicknesses => {
                format!("{name} of each column added up {}{at_times}", thickness::start(sources))
            }
            MeshLayout::Mpas | MeshLayout::Polygons => format!("{name} of each column{at_times}"),
            MeshLayout::Triangles => format!("{name} of each triangle, averaged to cells{at_times}"),
        }
    }
}

impl NativeInfo {
    /// Those of a field; `None` if all its columns share the heights of layers, or no file has native ones.
    pub(crate) fn find(sources: &Sources, mesh: &Mesh, info: &FieldInfo) -> Result<Option<Self>> {
        let Some(heights) = HeightVariable::of(sources, mesh, info)? else { return Ok(None) };
        let variable = heights.found.variable;
        let of_one_time = variable.dimensions.iter().filter(|dimension| !dimension.is_time);
        let values = of_one_time.fold(1usize, |values, dimension| values.saturating_mul(dimension.len));
        Ok(Some(NativeInfo {
            description: heights.description(sources, mesh),
            time_dependent: heights.time_dependent(sources),
            bytes: values.saturating_mul(variable.kind.bytes()),
        }))
    }
}

/// The error that a field has no native heights.
pub(crate) fn missing(sources: &Sources, mesh: &Mesh, info: &FieldInfo) -> Error {
    let why = if info.is_2d() {
        "it is a 2D field, which lies on the sphere".to_owned()
    } else {
        format!("no variable has those of each column; looked for {}; {IN_ANOTHER_FILE}", looked_for(mesh, info))
    };
    sources.error(ErrorKind::Layers, format_args!("{} has no native heights: {why}", info.name))
}

impl NativeHeights {
    /// Reads record `time`, or the first record of files without the fields.
    pub(crate) fn read(
        sources: &Sources,
        mesh: &Mesh,
        grid: &Grid,
        info: &FieldInfo,
        floor: Option<&Floor>,
        time: usize,
    ) -> Result<Option<Self>> {
        let Some(heights) = HeightVariable::of(sources, mesh, info)? else { return Ok(None) };
        let found = heights.found;
        let stored = match heights.kind {
            HeightKind::Thicknesses => Stored::AddedUp(Columns::read(sources, found, floor, time)?),
            HeightKind::Sigma => Stored::AddedUp(sigma::of_columns(sources, found, time)?),
            HeightKind::Heights => {
                let info = FieldInfo::of(found, mesh, &sources.options)?;
                let expected = "heights over layers and cells, at times or not";
                let info = info.ok_or_else(|| found.unexpected(ErrorKind::Layers, expected))?;
                let time = if info.time_dependent { sources.record(found, time)? } else { 0 };
                let mut read = OwnedField::read(found, &info, time, 0..info.layers, &sources.options)?;
                match info.location {
                    Location::Center => Stored::AsRead(Box::new(read)),
                    Location::Corner => {
                        read.spread(mesh.corner_rows());
                        Stored::Averaged(ComputedField::average(grid, &read.field()?)?)
                    }
                }
            }
        };
        Ok(Some(NativeHeights(stored)))
    }

    /// All heights, borrowed: one column per cell, layers in the file's order.
    ///
    /// # Errors
    /// As [`Field::new`].
    pub fn all(&self) -> Result<Field<'_>> {
        match &self.0 {
            Stored::AsRead(read) => read.field(),
            Stored::Averaged(average) => Ok(average.field()),
            Stored::AddedUp(columns) => Field::new(columns.heights.as_reals(), columns.shape, Location::Center, None),
        }
    }

    /// The heights that go with [`LayerHeights::layers_over`] of the same field and `layers`: for
    /// [`Fields::with_heights`](icoray::Fields::with_heights).
    ///
    /// # Errors
    /// [`ErrorKind::Field`] if the heights have another number of layers than the field's or one more.
    pub fn over(&self, info: &FieldInfo, layers: Range<usize>) -> Result<Field<'_>> {
        let all = self.all()?;
        let layers_with_heights = layers_with_heights(all.shape().layers, info, layers)?;
        let first = layers_with_heights.start as isize * all.shape().layer_stride;
        let offset = (all.shape().offset as isize + first) as usize;
        let shape = Shape { offset, layers: layers_with_heights.len(), ..*all.shape() };
        Field::new(all.samples(), shape, all.location(), all.fill())
    }
}

impl LayerHeights {
    /// The radii between which, or on which, some of a field's layers lie, counted from 0: those of
    /// [`LayerHeights::layers`] that these layers need.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] if the heights have another number of layers than the field's or one more, or
    /// [`ErrorKind::Layers`] if fewer than 2 remain.
    pub fn layers_over(&self, info: &FieldInfo, layers: Range<usize>) -> Result<Layers> {
        let layers_with_heights = layers_with_heights(self.layers.count(), info, layers)?;
        Layers::new(self.layers.radius_m()[layers_with_heights].to_vec(), self.layers.planet_radius_m())
    }
}

/// The layers with heights, of `count`, that `layers` of a field need.
fn layers_with_heights(count: usize, info: &FieldInfo, layers: Range<usize>) -> Result<Range<usize>> {
    if info.is_2d() {
        return Ok(0..count);
    }
    let bad = |what: String| Err(Error::new(ErrorKind::Field, format!("{}: {what}", info.name)));
    let more = match count.checked_sub(info.layers) {
        Some(more @ 0..=1) => more,
        _ => {
            return bad(format!("{count} layers have heights, expected {} or {}", info.layers, info.layers + 1));
        }
    };
    if layers.is_empty() || layers.end > info.layers {
        return bad(format!("layers {layers:?}, expected some of 0..{}", info.layers));
    }
    Ok(layers.start..layers.end + more)
}
