//! The fields of a file: over columns and layers, or 2D ones over columns only.

use crate::edges::{EdgesInFiles, Part};
use crate::mesh::{Mesh, MeshLayout, is_coordinate};
use crate::source::{Dimension, Kind, SourceVariable};
use crate::sources::DatasetOptions;
use crate::stored::{Decoder, Packing};
use crate::values::{AssumedMark, ShapedValues};
use icoray::{Description, Error, ErrorKind, Field, Location, Reals, Result, Shape};
use std::ops::Range;

/// Layers of the shell of a 2D field, which has equal values on them.
const SHELL_LAYERS: usize = 2;

/// Positions and numbers of the mesh in files of MPAS, ICON and ESMF, which are no fields; with blanks between.
const OF_MESH: &str = "\
    nEdgesOnCell indexToCellID indexToVertexID boundaryCell boundaryVertex obtuseTriangle cell_index vertex_index \
    parent_cell_index parent_vertex_index cell_domain_id phys_cell_id child_cell_id refin_c_ctrl refin_v_ctrl \
    parent_cell_type \
    lonCell latCell xCell yCell zCell lonVertex latVertex xVertex yVertex zVertex clon clat vlon vlat lon lat \
    lon_cell_centre lat_cell_centre longitude_vertices latitude_vertices nodes \
    numElementConn";

/// Dimensions of tables, which are no layers: points, edges and neighbours of a triangle or a point in ICON's files,
/// ends of an interval, and those of tables of MPAS, FESOM, FVCOM, ESMF and SCRIP; with blanks between.
const OF_TABLES: &str = "\
    nv ne nc no nvertex vertices bnds nb2 n2 n3 n4 \
    maxEdges maxEdges2 vertexDegree TWO THREE R3 FIFTEEN StrLen \
    three four maxnode maxelem \
    coordDim maxNodePElement grid_corners";

/// A variable that can be read as a field.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FieldInfo {
    /// The variable's name; that of a vector at edges, followed by `_zonal` and `_meridional`.
    pub name: String,
    /// At cells (MPAS's `nCells`, ICON's `vertex`) or at corners (MPAS's `nVertices`, ICON's `cell`, which are
    /// triangles). Values at edges become values at MPAS's cells and at ICON's triangles.
    pub location: Location,
    /// Number of columns: the mesh's cells or corners.
    pub columns: usize,
    /// Number of layers; 1 for a 2D field ([`FieldInfo::is_2d`]).
    pub layers: usize,
    /// Precision of the values in the file, [`Kind::F32`] or [`Kind::F64`]; for integers, in memory.
    pub precision: Kind,
    /// Whether there is one array per time record; otherwise one array is used at all times.
    pub time_dependent: bool,
    /// The attributes `long_name` and `units`.
    pub description: Description,
    /// Name of the dimension of layers; empty for a 2D field.
    pub layer_dimension: String,
    /// Their positions among the variable's dimensions.
    pub(crate) axes: Axes,
    /// The variable.
    pub(crate) variable: String,
    /// The part of a variable at edges.
    pub(crate) part: Option<Part>,
    /// Whether the values are amounts or rates of precipitation.
    pub(crate) is_precipitation: bool,
}

impl FieldInfo {
    /// Describes a variable; `None` when it is not a field on the mesh.
    pub(crate) fn of(found: SourceVariable, mesh: &Mesh, options: &DatasetOptions) -> Result<Option<Self>> {
        let Some(axes) = Axes::of(&found.variable.dimensions, &options.at, |d| location(mesh, d)) else {
            return Ok(None);
        };
        let columns = found.variable.dimensions[axes.column].len;
        Self::described(found, axes, columns)
    }

    /// Describes the fields at centres that are made of a variable at edges; of one that does not change with time only
    /// if it has layers, as others are tables of the mesh.
    pub(crate) fn at_edges(
        found: SourceVariable,
        mesh: &Mesh,
        edges: &EdgesInFiles,
        options: &DatasetOptions,
    ) -> Result<Vec<Self>> {
        let Some(axes) = Axes::of(&found.variable.dimensions, &options.at, |d| edges.location_beside(d)) else {
            return Ok(Vec::new());
        };
        let columns = if axes.location == Location::Center { mesh.cells() } else { mesh.corners_in_file() };
        let info = Self::described(found, axes, columns)?;
        let Some(info) = info.filter(|info| info.time_dependent || !info.is_2d()) else { return Ok(Vec::new()) };
        let parts = Part::all_of(found.own_name(), &info.description).iter().map(|part| {
            let mut field = FieldInfo { part: Some(*part), ..info.clone() };
            let ending = part.ending();
            field.name += ending;
            if *part != Part::Mean {
                let long_name = field.description.long_name.as_ref().unwrap_or(&info.name);
                field.description.long_name = Some(format!("{long_name}, {} component", &ending[1..]));
            }
            field
        });
        Ok(parts.filter(|info| found.source.variable(&info.name).is_none() || info.part == Some(Part::Mean)).collect())
    }

    /// Describes a variable with values in `columns`; `None` when it is not a field.
    fn described(found: SourceVariable, axes: Axes, columns: usize) -> Result<Option<Self>> {
        let variable = found.variable;
        let is_axis = matches!(&variable.dimensions[..], [only] if only.name == variable.name);
        if is_axis || OF_MESH.split(' ').any(|name| name == found.own_name()) || is_coordinate(found) {
            return Ok(None);
        }
        let layer = axes.layer.map(|layer| &variable.dimensions[layer]);
        let precision = match variable.kind {
            kind if kind.is_real() => kind,
            Kind::Integer if is_field(found, &axes)? => Kind::F64,
            _ => return Ok(None),
        };
        let description = Description { long_name: found.text("long_name")?, units: found.text("units")? };
        let is_precipitation = description.is_precipitation(found.text("standard_name")?.as_deref());
        Ok(Some(FieldInfo {
            name: variable.name.clone(),
            location: axes.location,
            columns,
            layers: layer.map_or(1, |layer| layer.len),
            precision,
            time_dependent: axes.time.is_some(),
            description,
            layer_dimension: layer.map_or_else(String::new, |layer| layer.name.clone()),
            axes,
            variable: variable.name.clone(),
            part: None,
            is_precipitation,
        }))
    }

    /// Whether the values are made of those at edges.
    pub fn is_from_edges(&self) -> bool {
        self.part.is_some()
    }

    /// Whether the values are heights, depths or other lengths, not amounts of precipitation, which span decades.
    pub(crate) fn is_length(&self) -> bool {
        self.description.is_length() && !self.is_precipitation
    }

    /// Whether the field has one value in each column, such as surface pressure and sea surface height. Such a field is
    /// shown as a surface, and read with the same value on all requested layers.
    pub fn is_2d(&self) -> bool {
        self.layers == 1
    }

    /// The layers that [`Dataset::read_field`](crate::Dataset::read_field) reads: all; for a 2D field the 2 of a thin
    /// shell.
    pub fn all_layers(&self) -> Range<usize> {
        if self.is_2d() { 0..SHELL_LAYERS } else { 0..self.layers }
    }

    /// The picked entries of dimensions, and a layer.
    pub(crate) fn entries(&self, layer: usize) -> impl Iterator<Item = Entry<'_>> {
        let picked = self.axes.picked.iter().map(|(dimension, number)| {
            let Dimension { name, len, .. } = dimension;
            Entry { dimension: name, len: *len, number: *number }
        });
        picked.chain([Entry { dimension: &self.layer_dimension, len: self.layers, number: layer }])
    }

    /// Whether layers are a faster dimension than columns, as in MPAS's files; columns are the faster one in ICON's.
    pub(crate) fn is_level_fastest(&self) -> bool {
        self.axes.layer.is_none_or(|layer| layer > self.axes.column)
    }

    /// The layout of an array with `layers` layers. All layers of a 2D field are the same values.
    fn shape(&self, columns: usize, layers: usize) -> Shape {
        if self.is_2d() {
            Shape { layer_stride: 0, ..Shape::cell_fastest(columns, layers) }
        } else if self.is_level_fastest() {
            Shape::level_fastest(columns, layers)
        } else {
            Shape::cell_fastest(columns, layers)
        }
    }
}

/// The dimensions of a field among those of its variable. Others have one entry, or one entry that is read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Axes {
    column: usize,
    /// The location of the columns.
    location: Location,
    layer: Option<usize>,
    time: Option<usize>,
    /// The entry that is read along each of the other dimensions.
    start: Vec<usize>,
    /// The dimensions of which one entry was picked, and that entry.
    picked: Vec<(Dimension, usize)>,
}

/// An entry along a dimension.
pub(crate) struct Entry<'a> {
    pub dimension: &'a str,
    /// Length of the dimension.
    pub len: usize,
    pub number: usize,
}

impl Axes {
    /// The axes; `location` is that of columns along a dimension. `None` if the dimensions are not columns of the mesh,
    /// with or without layers and times, and others with an entry in `at`.
    fn of(
        dimensions: &[Dimension],
        at: &[(String, usize)],
        location: impl Fn(&Dimension) -> Option<Location>,
    ) -> Option<Self> {
        let mut columns = None;
        let mut axes = Axes {
            column: 0,
            location: Location::Center,
            layer: None,
            time: None,
            start: vec![0; dimensions.len()],
            picked: Vec::new(),
        };
        for (i, dimension) in dimensions.iter().enumerate() {
            let is_table = OF_TABLES.split(' ').any(|name| name == dimension.name);
            let can_be_layer = axes.layer.is_none() && dimension.len > 0 && !dimension.is_time && !is_table;
            match (at.iter().find(|(name, _)| *name == dimension.name), location(dimension)) {
                (Some((_, entry)), _) => {
                    axes.start[i] = *entry;
                    axes.picked.push((dimension.clone(), *entry));
                }
                _ if dimension.is_time && axes.time.is_none() => axes.time = Some(i),
                (_, Some(location)) if columns.is_none() && dimension.len > 0 => {
                    axes.column = i;
                    columns = Some(location);
                }
                (_, None) if dimension.len == 1 => {}
                (_, None) if can_be_layer => axes.layer = Some(i),
                _ => return None,
            }
        }
        columns.map(|location| Axes { location, ..axes })
    }

    /// Start and count of `columns` and `layers` of record `time` along each dimension.
    pub(crate) fn block(&self, time: usize, columns: Range<usize>, layers: Range<usize>) -> (Vec<usize>, Vec<usize>) {
        let (mut start, mut count) = (self.start.clone(), vec![1; self.start.len()]);
        for (axis, range) in [(Some(self.column), columns), (self.layer, layers)] {
            if let Some(axis) = axis {
                start[axis] = range.start;
                count[axis] = range.len();
            }
        }
        if let Some(record) = self.time {
            start[record] = time;
        }
        (start, count)
    }
}

/// Whether integers over columns are values of a field, not a table of the mesh, which looks like layers that never
/// change.
fn is_field(found: SourceVariable, axes: &Axes) -> Result<bool> {
    Ok(Packing::of(found)?.is_some()
        || (axes.time.is_some() || axes.layer.is_none()) && found.text("cf_role")?.is_none())
}

/// Location of a dimension on the mesh: by name for MPAS's own dimensions (`nCells`), by length for others, which have
/// various names in ICON's files and are `ncol` in those of CAM.
fn location(mesh: &Mesh, dimension: &Dimension) -> Option<Location> {
    let name = dimension.name.as_bytes();
    let is_mpas = mesh.layout() == MeshLayout::Mpas && matches!(name, [b'n', b'A'..=b'Z', ..]);
    match dimension.name.as_str() {
        "nCells" if is_mpas => Some(Location::Center),
        "nVertices" if is_mpas => Some(Location::Corner),
        _ if is_mpas => None,
        _ if dimension.len == mesh.corners_in_file() => Some(Location::Corner),
        _ if dimension.len == mesh.cells() => Some(Location::Center),
        _ => None,
    }
}

/// One time record of a field: its values in the source's order and precision.
#[derive(Debug, Clone)]
pub struct OwnedField {
    info: FieldInfo,
    pub(crate) values: ShapedValues,
    pub(crate) fill: f64,
    /// Values that became NaN as they look like marks, without an attribute that specifies them.
    pub(crate) assumed_marks: Vec<AssumedMark>,
}

impl OwnedField {
    /// Reads `layers` of record `time` of the variable that `info` describes; for a 2D field its values, for as many
    /// layers.
    pub(crate) fn read(
        found: SourceVariable,
        info: &FieldInfo,
        time: usize,
        layers: Range<usize>,
        options: &DatasetOptions,
    ) -> Result<Self> {
        let columns = found.variable.dimensions[info.axes.column].len;
        let (start, count) = info.axes.block(time, 0..columns, layers.clone());
        let shape = info.shape(columns, layers.len());
        let values = found.source.values(found.variable, &start, &count)?;
        let mut values = ShapedValues::new(values, shape, [Some(info.axes.column), info.axes.layer]);
        let decoder = Decoder::of(found, &options.missing)?;
        let assumed_marks = decoder.take_assumed_marks(&mut values);
        let fill = decoder.decode(&mut values);
        Ok(OwnedField { info: FieldInfo { layers: shape.layers, ..info.clone() }, values, fill, assumed_marks })
    }

    /// Distributes the values of the file's corners to the mesh's, whose rows in the file are `rows`; without `rows`
    /// the values are unchanged.
    pub(crate) fn spread(&mut self, rows: Option<&[u32]>) {
        if let Some(rows) = rows {
            self.values = self.values.of_columns(rows);
            self.info.columns = rows.len();
        }
    }

    /// The values minus those of another field.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] if that has other columns or layers.
    pub(crate) fn less(self, other: &OwnedField) -> Result<Self> {
        let shape = |field: &OwnedField| (field.info.location, field.values.shape.columns, field.values.shape.layers);
        if shape(&self) != shape(other) {
            let context = format!(
                "{}: {:?} less {:?}, expected the same place, columns and layers",
                self.info.name,
                shape(&self),
                shape(other)
            );
            return Err(Error::new(ErrorKind::Field, context));
        }
        let values = self.values.less(self.fill, &other.values, other.fill);
        Ok(OwnedField { values, fill: f64::NAN, ..self })
    }

    /// The field, borrowed.
    ///
    /// # Errors
    /// As [`Field::new`], with the field's name before the message.
    pub fn field(&self) -> Result<Field<'_>> {
        Field::new(self.values(), self.values.shape, self.info.location, Some(self.fill))
            .map_err(|e: Error| e.within(&self.info.name))
    }

    /// The array that contains the values, and possibly others; [`OwnedField::field`] has their layout.
    pub fn values(&self) -> Reals<'_> {
        self.values.as_reals()
    }

    /// The value that marks a missing sample: the attribute `_FillValue`, or else the NetCDF library's default for
    /// unwritten values. Values equal to `missing_value`, those outside `valid_range`, `valid_min` and `valid_max`,
    /// those below the sea floor or on land, and missing ones among packed values are NaN.
    pub fn fill(&self) -> f64 {
        self.fill
    }

    /// Bytes that were read or copied: 0 for values in memory that are borrowed.
    pub fn bytes(&self) -> usize {
        self.values.owned_bytes()
    }
}
