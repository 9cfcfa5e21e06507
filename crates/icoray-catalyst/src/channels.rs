//! The channels of a call, and where the fields of the scene are in those of all ranks.

use crate::blueprint::{BlueprintField, fields, mesh_of};
use crate::conduit::Node;
use crate::fields::FieldKind;
use icoray::Result;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A channel of the host with the fields that it has now.
pub struct Channel<'a> {
    pub name: String,
    /// `None` where this rank has no part of it.
    pub mesh: Result<Option<Node<'a>>>,
    pub fields: Vec<BlueprintField<'a>>,
}

impl<'a> Channel<'a> {
    pub fn all(params: Node<'a>) -> Vec<Self> {
        let all = params.at("catalyst/channels").into_iter().flat_map(Node::children);
        let channel = |(name, node): (String, _)| {
            let mesh = mesh_of(node);
            let fields = mesh.as_ref().ok().and_then(|mesh| *mesh).map(fields).unwrap_or_default();
            Channel { name, mesh, fields }
        };
        all.map(channel).collect()
    }

    fn described(&self) -> String {
        if let Err(error) = &self.mesh {
            return format!("channel {}: {error}", self.name);
        }
        let names: Vec<_> = self.fields.iter().map(|field| field.name.as_str()).collect();
        format!("channel {} has {}", self.name, if names.is_empty() { "none".into() } else { names.join(", ") })
    }
}

/// Where a field is: its channel and topology, and what it is there.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Place {
    pub channel: String,
    pub topology: String,
    pub kind: FieldKind,
}

impl Place {
    /// The name of the grid.
    pub fn grid(&self) -> String {
        format!("{}/{}", self.channel, self.topology)
    }
}

/// The places of a field on this rank; its name may have its channel's before it.
pub fn places_of(name: &str, channels: &[Channel]) -> Vec<Place> {
    let mut places = Vec::new();
    for channel in channels {
        let qualified = name.strip_prefix(&channel.name).and_then(|rest| rest.strip_prefix('.'));
        for field in channel.fields.iter().filter(|field| field.name == name || Some(field.name.as_str()) == qualified)
        {
            places.push(Place { channel: channel.name.clone(), topology: field.topology.clone(), kind: field.kind });
        }
    }
    places
}

/// The places of the scene's fields on any rank, the same on all.
pub struct Places(BTreeMap<String, Vec<Place>>);

impl Places {
    /// Puts together what each rank has of each of these fields.
    pub fn new(scene_fields: &[String], ranks: &[Vec<Vec<Place>>]) -> Self {
        let places = |i: usize| {
            let mut places: Vec<Place> = ranks.iter().flat_map(|rank| &rank[i]).cloned().collect();
            places.sort_by_key(Place::grid);
            places.dedup_by_key(|place| place.grid());
            places
        };
        Places(scene_fields.iter().enumerate().map(|(i, field)| (field.clone(), places(i))).collect())
    }

    /// The only place of a field of the scene.
    pub fn of(&self, field: &str) -> Option<&Place> {
        match self.0.get(field).map(Vec::as_slice) {
            Some([place]) => Some(place),
            _ => None,
        }
    }

    /// The grids that the scene's fields are on, each with one of its places.
    pub fn grids(&self) -> BTreeMap<String, &Place> {
        self.0.keys().filter_map(|field| self.of(field)).map(|place| (place.grid(), place)).collect()
    }

    /// Why a field of the scene has no place, or more than one.
    pub fn why_none(&self, field: &str, channels: &[Channel]) -> String {
        if let Some(places) = self.0.get(field).filter(|places| places.len() > 1) {
            let mut names: Vec<_> = places.iter().map(|place| format!("{}.{field}", place.channel)).collect();
            names.dedup();
            return match &names[..] {
                [_] => format!("ranks have {field} on several topologies of channel {}", places[0].channel),
                _ => format!("several channels have {field}, name one of {}", names.join(", ")),
            };
        }
        let found: Vec<_> = channels.iter().map(Channel::described).collect();
        let found = if found.is_empty() { "the host gives no channels".into() } else { found.join("; ") };
        format!("the host gives no such field: {found}")
    }
}

/// A field of this rank by a name that scenes have for it.
pub struct NamedField<'c, 'a> {
    pub name: String,
    pub field: &'c BlueprintField<'a>,
    /// The name of its grid.
    pub grid: String,
    pub is_in_scene: bool,
}

/// The fields on grids of the scene: those that the scene names, and the others by all their names.
pub fn named_fields<'c, 'a>(channels: &'c [Channel<'a>], places: &Places) -> Vec<NamedField<'c, 'a>> {
    let grids = places.grids();
    let mut named = Vec::new();
    for channel in channels {
        for field in &channel.fields {
            let grid = format!("{}/{}", channel.name, field.topology);
            let is_only = || channels.iter().flat_map(|c| &c.fields).filter(|f| f.name == field.name).count() == 1;
            let qualified = format!("{}.{}", channel.name, field.name);
            for (name, is_a_name) in [(field.name.clone(), is_only()), (qualified, channels.len() > 1)] {
                let is_in_scene = places.of(&name).is_some_and(|place| place.grid() == grid);
                let is_other = is_a_name && !places.0.contains_key(&name) && grids.contains_key(&grid);
                if is_in_scene || is_other {
                    named.push(NamedField { name, field, grid: grid.clone(), is_in_scene });
                }
            }
        }
    }
    named
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(channel: &str, topology: &str) -> Place {
        let kind = FieldKind { is_at_elements: false, is_f64: true };
        Place { channel: channel.into(), topology: topology.into(), kind }
    }

    #[test]
    fn places_are_those_of_all_ranks() {
        let fields = ["t", "q", "u", "v"].map(String::from);
        let (a, b) = (place("a", "m"), place("b", "m"));
        let one = vec![vec![a.clone()], vec![a.clone()], vec![a.clone()], vec![]];
        let other = vec![vec![a.clone()], vec![b], vec![place("a", "n")], vec![]];
        let places = Places::new(&fields, &[one.clone(), other, one]);
        assert_eq!(places.of("t").map(Place::grid), Some("a/m".into()));
        assert_eq!(places.grids().keys().collect::<Vec<_>>(), ["a/m"]);
        assert!(["q", "u", "v", "w"].iter().all(|name| places.of(name).is_none()));
        assert_eq!(places.why_none("q", &[]), "several channels have q, name one of a.q, b.q");
        assert_eq!(places.why_none("u", &[]), "ranks have u on several topologies of channel a");
        assert_eq!(places.why_none("v", &[]), "the host gives no such field: the host gives no channels");
    }
}
