//! Heights of each column's layers, for pictures that show them.

use super::thickness::{self, Columns};
use super::{ICON_COLUMNS, LayerHeights, axis, columns_of, expect, icon_columns};
use crate::field::{FieldInfo, OwnedField};
use crate::floor::Floor;
use crate::mesh::{Convention, Mesh};
use crate::source::{Kind, Source, Variable};
use crate::sources::Sources;
use crate::times::is_time;
use icoray::{CenterField, Error, ErrorKind, Field, Grid, Layers, Location, Result, Shape};
use std::ops::Range;

/// Heights of each column's layers, read: metres above the sphere, negative below it, at the cells.
///
/// MPAS-Atmosphere's are `zgrid` as it is stored. MPAS-Ocean's are its thicknesses added up, from the sea floor
/// (`bottomDepth`) where the files tell, else down from the sea surface (`ssh`, or the sphere): layers below the sea floor and
/// above an ice shelf have no thickness, and a column without water has no heights. ICON's, over triangles, are averaged to
/// cells as its fields are.
#[derive(Debug)]
pub struct NativeHeights {
    description: String,
    stored: Stored,
}

#[derive(Debug)]
enum Stored {
    AsRead(OwnedField),
    Averaged(CenterField),
    AddedUp(Columns),
}

/// What is known of the heights of each column before they are read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NativeInfo {
    /// What they are made of, in words: "zgrid of each column".
    pub description: String,
    /// Whether each time has its own.
    pub time_dependent: bool,
    /// Bytes of the variable that is read for one time.
    pub bytes: usize,
}

/// Where a file has them.
#[derive(Clone, Copy)]
enum Found<'a> {
    Heights(&'a Source, &'a Variable),
    Thicknesses(&'a Source, &'a Variable),
}

impl<'a> Found<'a> {
    /// Of a field's layers; `None` where all columns share the layers' heights, or no file tells.
    fn of(sources: &'a Sources, mesh: &Mesh, info: &FieldInfo) -> Result<Option<Self>> {
        if info.is_2d() {
            return Ok(None);
        }
        if mesh.convention() != Convention::Mpas {
            for source in sources.all() {
                let Some(variable) = source.variable(&info.layer_dimension) else { continue };
                if axis::heights(source, variable, info.layers)?.is_some() {
                    return Ok(None);
                }
            }
            return Ok(icon_columns(sources, mesh, info).map(|(source, v)| Found::Heights(source, v)));
        }
        if let Some((source, variable)) = sources.find("zgrid") {
            expect(source, variable, &["nCells", "nVertLevelsP1"])?;
            return Ok(Some(Found::Heights(source, variable)));
        }
        Ok(thickness::of_now(sources).map(|(source, variable)| Found::Thicknesses(source, variable)))
    }

    /// Of a field's layers.
    ///
    /// # Errors
    /// [`ErrorKind::Layers`] where there are none, with what was looked for.
    fn expected(sources: &'a Sources, mesh: &Mesh, info: &FieldInfo) -> Result<Self> {
        Self::of(sources, mesh, info)?.ok_or_else(|| {
            let (name, layers) = (&info.name, info.layers);
            if info.is_2d() {
                let context = format!("{name} has no native heights: it is a 2D field, which lies on the sphere");
                return sources.error(ErrorKind::Layers, context);
            }
            let looked_for = match mesh.convention() {
                Convention::Mpas => format!(
                    "zgrid(nCells, nVertLevelsP1), and {}(nCells, nVertLevels), at times or not",
                    thickness::NAMES_NOW.join(", ")
                ),
                Convention::Icon | Convention::Cf => format!(
                    "{} over {layers} or {} layers and {} cells, where no coordinate {dimension}({dimension}) gives heights \
                     or pressures that all columns share",
                    ICON_COLUMNS.join(", "),
                    layers + 1,
                    columns_of(mesh),
                    dimension = info.layer_dimension
                ),
            };
            let context = format!(
                "{name} has no native heights: no file has those of each column; looked for {looked_for}"
            );
            sources.error(ErrorKind::Layers, context)
        })
    }

    fn time_dependent(self, sources: &Sources) -> bool {
        match self {
            Found::Heights(source, variable) => changes(sources, source, variable),
            Found::Thicknesses(source, variable) => {
                changes(sources, source, variable) || thickness::start_changes(sources)
            }
        }
    }

    fn info(self, sources: &Sources, mesh: &Mesh) -> NativeInfo {
        let (Found::Heights(_, variable) | Found::Thicknesses(_, variable)) = self;
        let of_one_time = variable.dimensions.iter().filter(|dimension| !is_time(&dimension.name));
        let values = of_one_time.fold(1usize, |values, dimension| values.saturating_mul(dimension.len));
        let bytes = if variable.kind == Kind::F32 { 4 } else { 8 };
        NativeInfo {
            description: self.description(sources, mesh),
            time_dependent: self.time_dependent(sources),
            bytes: values.saturating_mul(bytes),
        }
    }

    fn description(self, sources: &Sources, mesh: &Mesh) -> String {
        let (Found::Heights(_, variable) | Found::Thicknesses(_, variable)) = self;
        let name = &variable.name;
        let at_times = if self.time_dependent(sources) { ", those of each time" } else { "" };
        match (self, mesh.convention()) {
            (Found::Heights(..), Convention::Mpas | Convention::Cf) => {
                format!("{name} of each column{at_times}")
            }
            (Found::Heights(..), Convention::Icon) => {
                format!("{name} of each triangle, averaged to cells{at_times}")
            }
            (Found::Thicknesses(..), _) => {
                format!("{name} of each column added up {}{at_times}", thickness::start(sources))
            }
        }
    }
}

/// What is found of them for a field, in words.
pub(crate) fn describe(sources: &Sources, mesh: &Mesh, info: &FieldInfo) -> Result<Option<String>> {
    Ok(Found::of(sources, mesh, info)?.map(|found| found.description(sources, mesh)))
}

/// What is known of them before they are read.
///
/// # Errors
/// As [`Found::expected`].
pub(crate) fn info(sources: &Sources, mesh: &Mesh, info: &FieldInfo) -> Result<NativeInfo> {
    Ok(Found::expected(sources, mesh, info)?.info(sources, mesh))
}

impl NativeHeights {
    /// Reads those of record `time`, or of a file's first where it has not the fields.
    pub(crate) fn read(
        sources: &Sources,
        (mesh, grid): (&Mesh, &Grid),
        info: &FieldInfo,
        floor: Option<&Floor>,
        time: usize,
    ) -> Result<Option<Self>> {
        let Some(found) = Found::of(sources, mesh, info)? else { return Ok(None) };
        let stored = match found {
            Found::Thicknesses(source, variable) => {
                Stored::AddedUp(Columns::read(sources, (source, variable), floor, time)?)
            }
            Found::Heights(source, variable) => {
                let info = FieldInfo::of(source, variable, mesh)?.ok_or_else(|| {
                    let context = format!(
                        "variable {variable}, expected heights over layers and cells, at times or not"
                    );
                    source.error(ErrorKind::Layers, context)
                })?;
                let time = if info.time_dependent { record(sources, source, variable, time)? } else { 0 };
                let read = OwnedField::read(source, &info, time, 0..info.layers, None)?;
                match info.location {
                    Location::Center => Stored::AsRead(read),
                    Location::Corner => Stored::Averaged(CenterField::average(grid, &read.field()?)?),
                }
            }
        };
        Ok(Some(NativeHeights { description: found.description(sources, mesh), stored }))
    }

    /// What they are made of, in words: "zgrid of each column".
    pub fn description(&self) -> &str {
        &self.description
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        match &self.stored {
            Stored::AsRead(read) => read.bytes(),
            Stored::Averaged(average) => average.bytes(),
            Stored::AddedUp(columns) => columns.heights.bytes(),
        }
    }

    /// All heights, borrowed: one column per cell, layers in the file's order.
    ///
    /// # Errors
    /// As [`Field::new`].
    pub fn all(&self) -> Result<Field<'_>> {
        match &self.stored {
            Stored::AsRead(read) => read.field(),
            Stored::Averaged(average) => Ok(average.field()),
            Stored::AddedUp(columns) => {
                Field::new(columns.heights.as_reals(), columns.shape, Location::Center, None)
            }
        }
    }

    /// The heights that go with [`LayerHeights::layers_over`] of the same field and `layers`: for
    /// [`Fields::with_heights`](icoray::Fields::with_heights).
    ///
    /// # Errors
    /// [`ErrorKind::Field`] where the heights are of another number of layers than the field's or one more.
    pub fn over(&self, info: &FieldInfo, layers: Range<usize>) -> Result<Field<'_>> {
        let all = self.all()?;
        let reached = reached(all.shape().layers, info, layers)?;
        let first = reached.start as isize * all.shape().layer_stride;
        let offset = (all.shape().offset as isize + first) as usize;
        let shape = Shape { offset, layers: reached.len(), ..*all.shape() };
        Field::new(all.samples(), shape, all.location(), all.fill())
    }
}

impl LayerHeights {
    /// The radii between which, or on which, some of a field's layers lie, counted from 0: those of [`LayerHeights::layers`] that
    /// these need.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] where the heights are of another number of layers than the field's or one more, or
    /// [`ErrorKind::Layers`] where fewer than 2 are left.
    pub fn layers_over(&self, info: &FieldInfo, layers: Range<usize>) -> Result<Layers> {
        let reached = reached(self.layers.count(), info, layers)?;
        Layers::new(self.layers.radius_m()[reached].to_vec(), self.layers.planet_radius_m())
    }
}

/// Of `count` layers that have heights, those that `layers` of a field need.
fn reached(count: usize, info: &FieldInfo, layers: Range<usize>) -> Result<Range<usize>> {
    if info.is_2d() {
        return Ok(0..count);
    }
    let bad = |what: String| Err(Error::new(ErrorKind::Field, format!("{}: {what}", info.name)));
    let more = match count.checked_sub(info.layers) {
        Some(more @ 0..=1) => more,
        _ => {
            return bad(format!(
                "{count} layers have heights, expected {} or {}",
                info.layers,
                info.layers + 1
            ));
        }
    };
    if layers.is_empty() || layers.end > info.layers {
        return bad(format!("layers {layers:?}, expected some of 0..{}", info.layers));
    }
    Ok(layers.start..layers.end + more)
}

/// Whether a variable has one record for each of the fields' times.
pub(super) fn changes(sources: &Sources, source: &Source, variable: &Variable) -> bool {
    std::ptr::eq(source, sources.fields()) && variable.dimensions.first().is_some_and(|d| is_time(&d.name))
}

/// Which record of a variable is that of a field's `time`.
pub(super) fn record(sources: &Sources, source: &Source, variable: &Variable, time: usize) -> Result<usize> {
    let records = variable.dimensions.first().map_or(0, |dimension| dimension.len);
    let record = if std::ptr::eq(source, sources.fields()) { time } else { 0 };
    if record < records {
        return Ok(record);
    }
    let context = format!("variable {variable} has no record {record}");
    Err(source.error(ErrorKind::Layers, context))
}
