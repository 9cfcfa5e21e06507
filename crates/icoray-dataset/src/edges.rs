//! Fields at edges, as fields at the centres beside these: MPAS's cells, ICON's triangles.
//!
//! A scalar is the mean over the edges of a centre. A vector is in files as the component u along the normal n of each
//! edge, which points from the first centre beside it to the second: (U, V) at a centre, zonal and meridional, minimise
//! Σ (n · (U, V) − u)² over its edges. The great circle through both centres crosses the edge along n, so that n at a
//! centre is the direction of that circle there. Tables: MPAS mesh specification 1.0; ICON's grid files.

use crate::field::FieldInfo;
use crate::mesh::{Convention, Mesh};
use crate::source::{Dimension, Variable};
use crate::sources::{IN_ANOTHER_FILE, Sources};
use crate::values::ShapedValues;
use icoray::{Description, Error, ErrorKind, Location, Result};

/// A field at centres that is made of a variable at edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Part {
    /// The mean of the edges.
    Mean,
    /// The eastward component of a vector, from its components normal to edges.
    Zonal,
    /// The northward component.
    Meridional,
}

/// Names, or words of names such as `u_init`, of vectors' components normal to edges; others have "normal" in their name
/// or long name, or are fluxes.
const NORMAL: [&str; 3] = ["u", "ru", "vn"];
/// Names of components along edges, from which no vector follows; others have "tangential" in their long name.
const TANGENTIAL: [&str; 2] = ["v", "vt"];

impl Part {
    /// The fields that are made of a variable at edges; none of a component along them. Lengths are scalars, such as
    /// the thickness of layers with which MPAS-Ocean makes fluxes.
    pub(crate) fn all_of(name: &str, description: &Description) -> &'static [Self] {
        let long_name = description.long_name.as_deref().unwrap_or_default();
        let words = format!("{name} {long_name}").to_lowercase().replace("normali", "");
        let is_named = name.split('_').any(|word| NORMAL.contains(&word));
        match () {
            () if description.is_length() => &[Part::Mean],
            () if TANGENTIAL.contains(&name) || words.contains("tangential") => &[],
            () if is_named || words.contains("normal") || words.contains("flux") => &[Part::Zonal, Part::Meridional],
            () => &[Part::Mean],
        }
    }

    /// What is appended to a variable's name.
    pub(crate) fn ending(self) -> &'static str {
        match self {
            Part::Mean => "",
            Part::Zonal => "_zonal",
            Part::Meridional => "_meridional",
        }
    }

    /// A description of the field, for a note.
    pub(crate) fn in_words(self) -> &'static str {
        match self {
            Part::Mean => "the mean over the edges of each cell",
            Part::Zonal | Part::Meridional => "reconstructed from the components normal to the edges of each cell",
        }
    }
}

/// The variable at edges of which a field of this name is a component; `None` if it has no such name.
///
/// ```
/// assert_eq!(icoray_dataset::variable_at_edges("vn_zonal"), Some("vn"));
/// assert_eq!(icoray_dataset::variable_at_edges("theta"), None);
/// ```
pub fn variable_at_edges(field: &str) -> Option<&str> {
    [Part::Zonal, Part::Meridional].into_iter().find_map(|part| field.strip_suffix(part.ending()))
}

/// The location of centres beside edges, if a dimension is that of edges.
pub(crate) fn location_beside(mesh: &Mesh, dimension: &Dimension) -> Option<Location> {
    match mesh.convention() {
        Convention::Mpas => (dimension.name == "nEdges").then_some(Location::Center),
        Convention::Icon => (dimension.len == mesh.edges()).then_some(Location::Corner),
        Convention::Cf => None,
    }
}

/// Name of the table of the two centres beside each edge.
fn table_name(mesh: &Mesh) -> &'static str {
    if mesh.convention() == Convention::Mpas { "cellsOnEdge" } else { "adjacent_cell_of_edge" }
}

/// Whether a file has the table from which fields at centres are made.
pub(crate) fn are_in(sources: &Sources, mesh: &Mesh) -> bool {
    sources.find(table_name(mesh)).is_some()
}

/// The reason why a variable at edges is not a field itself; `made` are the names of fields that are made of it.
pub(crate) fn reason(sources: &Sources, mesh: &Mesh, variable: &Variable, made: &[&str]) -> Option<String> {
    variable.dimensions.iter().find_map(|dimension| location_beside(mesh, dimension))?;
    let table = table_name(mesh);
    let has_triangles = ["vertex_of_cell", "clon"].iter().any(|name| sources.find(name).is_some());
    if made.is_empty() && mesh.convention() == Convention::Icon && !has_triangles {
        return None;
    }
    Some(match made {
        [] if !are_in(sources, mesh) => format!(
            "variable {variable} is at edges, and variable {table}, which has the cells beside each, is missing: \
             {IN_ANOTHER_FILE}"
        ),
        [] => format!(
            "variable {variable} is at edges, expected there a scalar or a component normal to edges that changes \
             with time or has layers (`at` picks an entry of a further dimension)"
        ),
        made => format!("variable {variable} is at edges, its fields at cells are {}", made.join(" and ")),
    })
}

/// The edges of each centre.
#[derive(Debug)]
pub(crate) struct Edges {
    of_centers: Vec<Vec<Side>>,
    /// Number of edges.
    count: usize,
}

/// An edge of a centre.
#[derive(Debug)]
struct Side {
    edge: usize,
    /// Zonal and meridional component, at the centre, of the edge's normal; `None` at the rim, where it is not known.
    normal: Option<[f64; 2]>,
}

impl Edges {
    /// Reads the table for the fields that `info` and others are.
    pub(crate) fn read(sources: &Sources, mesh: &Mesh, info: &FieldInfo) -> Result<Self> {
        let (name, columns) = (table_name(mesh), info.columns);
        let found = sources.find(name);
        let (source, variable) =
            found.ok_or_else(|| sources.error(ErrorKind::Field, format_args!("variable {name} is missing")))?;
        let (count, strides) = match variable.after_time() {
            [edges, two] if two.len == 2 => (edges.len, [2, 1]),
            [two, edges] if two.len == 2 => (edges.len, [1, edges.len]),
            _ => {
                let context = format!("variable {variable}, expected the two cells beside each edge");
                return Err(source.error(ErrorKind::Grid, context));
            }
        };
        let table = source.all_integers(variable)?;
        let mut of_centers: Vec<Vec<Side>> = (0..columns).map(|_| Vec::new()).collect();
        for edge in 0..count {
            let beside = [0, 1].map(|k| table[edge * strides[0] + k * strides[1]]);
            // One past the last marks a missing cell, as do numbers below 1.
            if let Some(number) = beside.iter().find(|number| **number > columns as i32 + 1) {
                let context = format!("{name}: cell {number} beside edge {}, expected 1 to {columns}", edge + 1);
                return Err(source.error(ErrorKind::Grid, context));
            }
            let [first, second] =
                beside.map(|number| usize::try_from(number.saturating_sub(1)).ok().filter(|cell| *cell < columns));
            for (own, other, sign) in [(first, second, 1.0), (second, first, -1.0)] {
                let Some(own) = own else { continue };
                let toward = other.map(|other| mesh.direction_between(info.location, own, other));
                of_centers[own].push(Side { edge, normal: toward.map(|toward| toward.map(|part| sign * part)) });
            }
        }
        Ok(Edges { of_centers, count })
    }

    /// The values of a part at centres from those at edges; NaN where these do not determine it.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] if there are more or fewer edges than in the table.
    pub(crate) fn at_centers(&self, values: &ShapedValues, fill: f64, part: Part) -> Result<ShapedValues> {
        if values.shape.columns != self.count {
            let context =
                format!("{} edges, expected {} as in the table of the mesh", values.shape.columns, self.count);
            return Err(Error::new(ErrorKind::Field, context));
        }
        Ok(values.made(self.of_centers.len(), |column, layer| {
            let there = self.of_centers[column].iter().map(|side| (side.normal, values.value(side.edge, layer, fill)));
            let there = there.filter(|(_, value)| !value.is_nan());
            if part == Part::Mean {
                let (count, sum) = there.fold((0.0, 0.0), |(count, sum), (_, value)| (count + 1.0, sum + value));
                return sum / count;
            }
            // The normal equations of the least squares.
            let (mut of, mut with) = ([0.0; 3], [0.0; 2]);
            for ([east, north], value) in there.filter_map(|(normal, value)| Some((normal?, value))) {
                of = [of[0] + east * east, of[1] + east * north, of[2] + north * north];
                with = [with[0] + east * value, with[1] + north * value];
            }
            let determinant = of[0] * of[2] - of[1] * of[1];
            let numerator = match part {
                Part::Zonal => with[0] * of[2] - with[1] * of[1],
                _ => with[1] * of[0] - with[0] * of[1],
            };
            if determinant > LEAST_DETERMINANT { numerator / determinant } else { f64::NAN }
        }))
    }
}

/// Minimum determinant of the normal equations: the square of the sine of the angle between two normals that differ.
const LEAST_DETERMINANT: f64 = 1e-3;
