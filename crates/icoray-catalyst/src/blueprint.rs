//! Meshes and fields of a channel, in the conventions of Conduit's Mesh Blueprint, as far as geodesic grids need them.
//!
//! Reference: <https://llnl-conduit.readthedocs.io/en/latest/blueprint_mesh.html>, and ParaView Catalyst's channels.

use crate::conduit::{Array, Node, NumberType};
use crate::elements::Elements;
use crate::fields::FieldKind;
use glam::DVec3;
use icoray::{Error, Result};

/// Names of fields that mark elements or points which other ranks have too.
const GHOSTS: [&str; 2] = ["vtkGhostType", "ascent_ghosts"];

#[derive(Clone, Copy)]
pub struct Topology<'a> {
    mesh: Node<'a>,
    node: Node<'a>,
    name: &'a str,
}

/// The arrays of a topology.
pub struct Geometry<'a> {
    /// x, y and z of the points.
    pub points: [Array<'a>; 3],
    pub elements: Elements<'a>,
}

pub struct BlueprintField<'a> {
    pub name: String,
    pub topology: String,
    pub kind: FieldKind,
    pub values: Array<'a>,
}

/// The mesh of a channel; `None` where its node is empty, as it may be on a rank without elements.
pub fn mesh_of(channel: Node) -> Result<Option<Node>> {
    let kind = channel.text_at("type").unwrap_or_else(|| "mesh".into());
    if kind != "mesh" {
        return Err(Error::grid(format!("type {kind:?}, expected \"mesh\": one mesh of columns")));
    }
    let mesh = channel.at("data").ok_or_else(|| Error::grid("no node data"))?;
    match mesh.at("topologies") {
        Some(_) => Ok(Some(mesh)),
        None if mesh.is_empty() => Ok(None),
        None => Err(Error::grid(format!("data is {}, expected a mesh with topologies", mesh.described()))),
    }
}

/// The fields of a mesh: an array each, or one for each component, then named as `velocity.u`. Others are left out.
pub fn fields<'a>(mesh: Node<'a>) -> Vec<BlueprintField<'a>> {
    let mut found = Vec::new();
    for (name, node) in mesh.at("fields").into_iter().flat_map(Node::children) {
        let Some(topology) = node.text_at("topology") else { continue };
        let is_at_elements = match node.text_at("association").as_deref() {
            Some("element") => true,
            Some("vertex") => false,
            _ => continue,
        };
        let mut add = |name: String, values: Array<'a>| {
            let kind = FieldKind { is_at_elements, is_f64: values.kind() != NumberType::F32 };
            found.push(BlueprintField { name, topology: topology.clone(), kind, values });
        };
        let Some(values) = node.at("values") else { continue };
        if let Some(values) = values.array() {
            add(name, values);
            continue;
        }
        for (component, values) in values.children() {
            if let Some(values) = values.array() {
                add(format!("{name}.{component}"), values);
            }
        }
    }
    found
}

impl<'a> Topology<'a> {
    pub fn of(mesh: Node<'a>, name: &'a str) -> Result<Self> {
        let all = mesh.at("topologies").map(Node::children).unwrap_or_default();
        if let Some((_, node)) = all.iter().find(|(other, _)| other == name) {
            return Ok(Topology { mesh, node: *node, name });
        }
        let names: Vec<_> = all.into_iter().map(|(name, _)| name).collect();
        Err(Error::grid(format!("no topology {name:?}, found {}", names.join(", "))))
    }

    /// Its arrays. Fails for other meshes than those of known elements in Cartesian coordinates, and for marked ghosts.
    pub fn geometry(self) -> Result<Geometry<'a>> {
        self.refuse_ghosts()?;
        let name = self.name;
        let within = |e: Error| e.within(format_args!("topology {name}"));
        let kind = self.node.text_at("type").unwrap_or_default();
        if !["unstructured", "points"].contains(&kind.as_str()) {
            return Err(within(Error::grid(format!("type {kind:?}, expected \"unstructured\" or \"points\""))));
        }
        let points = self.points().map_err(within)?;
        let count = points[0].len();
        let elements = if kind == "points" { Ok(Elements::of_points(count)) } else { Elements::of(self.node, count) };
        Ok(Geometry { points, elements: elements.map_err(within)? })
    }

    fn points(self) -> Result<[Array<'a>; 3]> {
        let name = self.node.text_at("coordset").ok_or_else(|| Error::grid("no coordset"))?;
        let within = |e: Error| e.within(format_args!("coordset {name}"));
        let coordset = self.mesh.at("coordsets").and_then(|all| all.at(&name));
        let coordset = coordset.ok_or_else(|| within(Error::grid("it is missing")))?;
        let kind = coordset.text_at("type").unwrap_or_default();
        if kind != "explicit" {
            return Err(within(Error::grid(format!("type {kind:?}, expected \"explicit\""))));
        }
        let values = coordset.at("values").ok_or_else(|| within(Error::grid("no values")))?;
        let axis = |axis: &str| values.at(axis).and_then(Node::array);
        let [Some(x), Some(y), Some(z)] = ["x", "y", "z"].map(axis) else {
            return Err(within(Error::grid(format!("values are {}, expected arrays x, y and z", values.described()))));
        };
        if x.len() != y.len() || x.len() != z.len() {
            let what = format!("x has {} values, y {}, z {}, expected as many", x.len(), y.len(), z.len());
            return Err(within(Error::grid(what)));
        }
        Ok([x, y, z])
    }

    fn refuse_ghosts(self) -> Result<()> {
        for (name, node) in self.mesh.at("fields").into_iter().flat_map(Node::children) {
            let attribute = format!("state/metadata/vtk_fields/{name}/attribute_type");
            let is_marked = self.mesh.text_at(&attribute).is_some_and(|kind| kind == "Ghosts");
            let is_of_this = node.text_at("topology").is_none_or(|topology| topology == self.name);
            let values = node.at("values").and_then(Node::array);
            let Some(values) = values.filter(|_| is_of_this && (is_marked || GHOSTS.contains(&name.as_str()))) else {
                continue;
            };
            let ghosts = (0..values.len()).filter(|&i| values.real(i) != 0.0).count();
            if ghosts > 0 {
                return Err(Error::grid(format!(
                    "field {name} marks {ghosts} of {} elements or points as ghosts; expected each element on one rank only",
                    values.len()
                )));
            }
        }
        Ok(())
    }
}

impl Geometry<'_> {
    pub fn point(&self, i: u32) -> DVec3 {
        DVec3::from_array(self.points.map(|axis| axis.real(i as usize)))
    }
}
