//! The variables of a file, those of NetCDF-4's groups by their paths.

use icoray_dataset::{Dimension, Kind, Variable};
use netcdf::types::{FloatType, NcVariableType};
use netcdf::{AttributeValue, Group};
use std::collections::HashMap;

/// The names in a [`Variable`] of the dimensions that a group and those around it declare.
type Names = HashMap<String, String>;

/// All variables: those of the root first, then those of each group as `group/name`.
///
/// A dimension of a group has the group's path before its name where it has a coordinate there, and where one of that
/// name is another: it is in a group around, or its length differs.
pub(crate) fn variables(file: &netcdf::File) -> Vec<Variable> {
    let mut found = Vec::new();
    match file.root() {
        Some(root) => collect(&root, "", &Names::new(), &mut found),
        None => found.extend(file.variables().map(|variable| describe(&variable, "", &Names::new()))),
    }
    found
}

/// The attribute of a group itself, else that of the first group inside which has one of this name.
pub(crate) fn attribute(group: &Group<'_>, name: &str) -> Option<netcdf::Result<AttributeValue>> {
    let own = group.attribute(name).map(|attribute| attribute.value());
    own.or_else(|| group.groups().find_map(|inner| attribute(&inner, name)))
}

/// Appends the variables of a group and of those in it; `path` ends with `/`, and is empty of the root.
fn collect(group: &Group<'_>, path: &str, around: &Names, found: &mut Vec<Variable>) {
    let mut names = around.clone();
    for dimension in group.dimensions() {
        let (name, len) = (dimension.name(), dimension.len());
        let mut dimensions = found.iter().flat_map(|variable| &variable.dimensions);
        let is_other = around.contains_key(&name) || dimensions.any(|known| known.name == name && known.len != len);
        let is_of_group = is_other || group.variable(&name).is_some();
        let shown = if is_of_group { format!("{path}{name}") } else { name.clone() };
        names.insert(name, shown);
    }
    found.extend(group.variables().map(|variable| describe(&variable, path, &names)));
    for inner in group.groups() {
        collect(&inner, &format!("{path}{}/", inner.name()), &names, found);
    }
}

fn describe(variable: &netcdf::Variable<'_>, path: &str, names: &Names) -> Variable {
    let kind = match variable.vartype() {
        NcVariableType::Float(FloatType::F32) => Kind::F32,
        NcVariableType::Float(FloatType::F64) => Kind::F64,
        NcVariableType::Int(_) => Kind::Integer,
        NcVariableType::Char => Kind::Text,
        _ => Kind::Other,
    };
    let dimension = |dimension: &netcdf::Dimension<'_>| {
        let name = dimension.name();
        Dimension::new(names.get(&name).cloned().unwrap_or(name), dimension.len())
    };
    let dimensions = variable.dimensions().iter().map(dimension).collect();
    Variable { name: format!("{path}{}", variable.name()), kind, dimensions }
}
