//! One host: from `catalyst_initialize` to `catalyst_finalize`.

use crate::blueprint::{BlueprintField, Topology, fields, mesh_of};
use crate::conduit::Node;
use crate::context::Context;
use crate::fields::{Copy, FieldKind, set, set_empty};
use crate::grid::{HostGrid, Setting, Tables};
use crate::peers::Peers;
use crate::team;
use icoray::{Error, ErrorKind, Result};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// What is drawn, and with whom.
pub struct Adaptor {
    /// Dropped first, as it reads what follows.
    context: Context,
    grids: BTreeMap<String, Slot>,
    copies: Vec<Copy>,
    peers: Peers,
    /// The fields that the scene file names.
    scene_fields: Vec<String>,
    /// The fields that the context has.
    given: BTreeSet<String>,
    planet_radius: Option<f64>,
    calls: i64,
    /// Bytes of fields that were copied for the last frame.
    bytes_copied: usize,
    told: BTreeSet<String>,
}

/// A grid of the context, if the last update succeeded, and its tables.
#[derive(Default)]
struct Slot {
    grid: Option<HostGrid>,
    tables: Tables,
}

/// Where a field is: its channel and topology, and what it is there.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Place {
    channel: String,
    topology: String,
    kind: FieldKind,
}

impl Place {
    /// The name of the grid.
    fn grid(&self) -> String {
        format!("{}/{}", self.channel, self.topology)
    }
}

/// A channel of the host with the fields that it has now.
struct Channel<'a> {
    name: String,
    mesh: Result<Node<'a>>,
    fields: Vec<BlueprintField<'a>>,
}

impl Adaptor {
    /// Opens a context over the host's ranks and loads its scene. Collective.
    ///
    /// # Errors
    /// The failure of any rank, the same on all.
    pub fn new(params: Node) -> Result<Self> {
        let communicator = params.at("catalyst/mpi_comm").and_then(Node::integer);
        let (first, second) = match team::of_host(communicator)? {
            Some([first, second]) => (Some(first), Some(second)),
            None => (None, None),
        };
        let mut peers = Peers::new(first);
        let context = Context::open(second)?;
        let scenes = peers.share(scene_of(params))?;
        let Some(scene) = scenes.into_iter().next().flatten() else {
            let message = "catalyst/scripts has no path that ends in .toml, and the environment variable ICORAY_SCENE is \
                           not set: nothing is drawn";
            return Err(Error::new(ErrorKind::Scene, message));
        };
        context.load_scene(&scene)?;
        Ok(Adaptor {
            scene_fields: context.scene_fields(),
            context,
            grids: BTreeMap::new(),
            copies: Vec::new(),
            peers,
            given: BTreeSet::new(),
            planet_radius: params.at("catalyst/icoray/planet_radius").and_then(Node::number),
            calls: 0,
            bytes_copied: 0,
            told: BTreeSet::new(),
        })
    }

    /// Draws what is due. Collective.
    ///
    /// # Errors
    /// The failure of any rank, the same on all. Those of fields and frames are in the log.
    pub fn execute(&mut self, params: Node) -> Result<()> {
        let channels = channels(params);
        let (step, time_s) = self.now(params, &channels);
        self.calls += 1;
        if !self.context.wants(step, time_s) {
            return Ok(());
        }
        let places = self.places(&channels)?;
        let failures = self.update_grids(&channels, &places)?;
        self.set_heights();
        self.set_fields(&channels, &places, &failures);
        // The context logs what fails, and switches itself off after three failed frames in a row.
        let _ = self.context.execute(step, time_s);
        self.copies.clear();
        Ok(())
    }

    /// Step and time: those of the host, or else the number of calls.
    fn now(&self, params: Node, channels: &[Channel]) -> (i64, f64) {
        let of_mesh = |path: &str| channels.iter().find_map(|channel| channel.mesh.as_ref().ok()?.at(path));
        let find = |names: [&str; 3], of_meshes: &str| {
            names.into_iter().find_map(|name| params.at(name)).or_else(|| of_mesh(of_meshes))
        };
        let step = find(["catalyst/state/timestep", "catalyst/state/cycle", "catalyst/timestep"], "state/cycle");
        let time = find(["catalyst/state/time", "catalyst/time", "catalyst/state/time_value"], "state/time");
        let step = step.and_then(Node::integer).unwrap_or(self.calls);
        (step, time.and_then(Node::number).unwrap_or(step as f64))
    }

    /// Where the scene's fields are on any rank; several places of a field are none. Collective.
    fn places(&mut self, channels: &[Channel]) -> Result<BTreeMap<String, Place>> {
        let mine: Vec<Vec<Place>> = self.scene_fields.iter().map(|field| places_of(field, channels)).collect();
        let all = self.peers.share(mine)?;
        let mut places = BTreeMap::new();
        for (i, field) in self.scene_fields.iter().enumerate() {
            let mut known: Vec<&Place> = all.iter().flat_map(|rank| &rank[i]).collect();
            known.dedup_by_key(|place| place.grid());
            if let [place] = known[..] {
                places.insert(field.clone(), place.clone());
            }
        }
        Ok(places)
    }

    /// Updates the grids of the scene's fields; returns why those that failed did. Collective.
    fn update_grids(
        &mut self,
        channels: &[Channel],
        places: &BTreeMap<String, Place>,
    ) -> Result<BTreeMap<String, String>> {
        let mut failures = BTreeMap::new();
        let needed: BTreeMap<String, &Place> = places.values().map(|place| (place.grid(), place)).collect();
        for (name, place) in needed {
            let channel = channels.iter().find(|channel| channel.name == place.channel);
            let geometry = match channel.map(|channel| &channel.mesh) {
                None => Ok(None),
                Some(Err(error)) => Err(error.clone()),
                Some(Ok(mesh)) => Topology::of(*mesh, &place.topology).and_then(Topology::geometry).map(Some),
            };
            let geometry = geometry.map_err(|e| e.within(format_args!("channel {}", place.channel)));
            let slot = self.grids.entry(name.clone()).or_default();
            let (context, peers, planet_radius) = (&self.context, &mut self.peers, self.planet_radius);
            let mut setting = Setting { name: &name, planet_radius, context, peers };
            match HostGrid::update(slot.grid.take(), geometry, &mut slot.tables, &mut setting) {
                Ok(grid) => slot.grid = Some(grid),
                Err(error) if error.kind() == ErrorKind::Mpi => return Err(error),
                Err(error) => {
                    failures.insert(name, error.to_string());
                }
            }
        }
        Ok(failures)
    }

    /// Sets the heights of the first grid: a context has those of one.
    fn set_heights(&self) {
        let first = self.grids.iter().find_map(|(name, slot)| slot.grid.as_ref()?.heights(name));
        // What fails here is in the log.
        let _ = self.context.set_heights(first.as_ref());
    }

    fn set_fields(
        &mut self,
        channels: &[Channel],
        places: &BTreeMap<String, Place>,
        failures: &BTreeMap<String, String>,
    ) {
        self.copies.clear();
        self.bytes_copied = 0;
        let mut given = BTreeSet::new();
        for (name, field, grid) in named_fields(channels) {
            let Some(on) = self.grids.get(&grid).and_then(|slot| slot.grid.as_ref()) else { continue };
            let is_in_scene = self.scene_fields.contains(&name);
            match set(&self.context, &name, field, (on, &grid), is_in_scene) {
                Ok(copy) => {
                    given.insert(name.clone());
                    self.keep(&name, copy);
                }
                Err(error) if is_in_scene => self.context.refuse_field(&name, &error.to_string()),
                Err(_) => self.context.refuse_field(&name, "its values cannot be read in place"),
            }
        }
        for name in self.scene_fields.clone() {
            let place = places.get(&name);
            let why = match place {
                _ if given.contains(&name) => continue,
                None => self.why_missing(&name, channels),
                Some(place) => match failures.get(&place.grid()) {
                    Some(failure) => failure.clone(),
                    None => {
                        let grid = place.grid();
                        let on = self.grids.get(&grid).and_then(|slot| slot.grid.as_ref());
                        let empty = on.filter(|on| on.elements.elements == 0);
                        let set = empty.map(|on| set_empty(&self.context, &name, &place.kind, (on, &grid)));
                        match set {
                            Some(Ok(())) => {
                                given.insert(name);
                                continue;
                            }
                            Some(Err(error)) => error.to_string(),
                            None => "the host gives no such field on this rank".into(),
                        }
                    }
                },
            };
            self.context.refuse_field(&name, &why);
        }
        for name in self.given.difference(&given).filter(|name| !self.scene_fields.contains(name)) {
            self.context.refuse_field(name, "the host gives it no more");
        }
        self.given = given;
    }

    /// Keeps a copy of a field until the frame is drawn, and says so once.
    fn keep(&mut self, name: &str, copy: Option<(Copy, &str)>) {
        let Some((copy, why)) = copy else { return };
        self.bytes_copied += copy.bytes();
        let message = format!("field {name}: its values {why}, and are copied for each picture");
        if self.peers.rank() == 0 && self.told.insert(message.clone()) {
            crate::say(&message);
        }
        self.copies.push(copy);
    }

    fn why_missing(&self, name: &str, channels: &[Channel]) -> String {
        let places = places_of(name, channels);
        if places.len() > 1 {
            let names: Vec<_> = places.iter().map(|place| format!("{}.{name}", place.channel)).collect();
            return format!("several channels have it, name one of {}", names.join(", "));
        }
        let of_channel = |channel: &Channel| match &channel.mesh {
            Ok(_) => {
                let names: Vec<_> = channel.fields.iter().map(|field| field.name.as_str()).collect();
                format!(
                    "channel {} has {}",
                    channel.name,
                    if names.is_empty() { "none".into() } else { names.join(", ") }
                )
            }
            Err(error) => format!("channel {}: {error}", channel.name),
        };
        let found: Vec<_> = channels.iter().map(of_channel).collect();
        let found = if found.is_empty() { "the host gives no channels".into() } else { found.join("; ") };
        format!("the host gives no such field: {found}")
    }

    /// Fills in what is known of the last frame.
    pub fn fill_results(&self, to: Node) {
        let Some(report) = self.context.report() else { return };
        to.set_integer("icoray/step", report.step);
        to.set_integer("icoray/frames_written", report.frames_written as i64);
        to.set_integer("icoray/frames_failed", report.frames_failed as i64);
        to.set_integer("icoray/bytes_copied", report.bytes_copied as i64 + self.bytes_copied as i64);
        to.set_number("icoray/error_max", report.error_max);
        to.set_number("icoray/host_s", report.host_s);
        to.set_number("icoray/render_s", report.render_s);
    }
}

/// The path of the scene: the first of the host's scripts that ends in .toml, or that of the environment.
fn scene_of(params: Node) -> Option<String> {
    let scripts = params.at("catalyst/scripts").into_iter().flat_map(Node::children);
    let path = |(_, script): (String, Node)| script.text().or_else(|| script.text_at("filename"));
    let of_host = scripts.filter_map(path).find(|path| path.ends_with(".toml"));
    of_host.or_else(|| std::env::var("ICORAY_SCENE").ok().filter(|path| !path.is_empty()))
}

fn channels(params: Node) -> Vec<Channel> {
    let all = params.at("catalyst/channels").into_iter().flat_map(Node::children);
    let channel = |(name, node): (String, _)| {
        let mesh = mesh_of(node);
        let fields = mesh.as_ref().map_or_else(|_| Vec::new(), |mesh| fields(*mesh));
        Channel { name, mesh, fields }
    };
    all.map(channel).collect()
}

/// The places of a field of the scene, which may have its channel's name before it.
fn places_of(name: &str, channels: &[Channel]) -> Vec<Place> {
    let mut places = Vec::new();
    for channel in channels {
        let qualified = name.strip_prefix(&channel.name).and_then(|rest| rest.strip_prefix('.'));
        for field in channel.fields.iter().filter(|field| field.name == name || Some(field.name.as_str()) == qualified)
        {
            places.push(Place {
                channel: channel.name.clone(),
                topology: field.topology.clone(),
                kind: FieldKind::of(field),
            });
        }
    }
    places
}

/// All fields, with the names that scenes may have for them and the names of their grids.
fn named_fields<'a, 'c>(channels: &'c [Channel<'a>]) -> Vec<(String, &'c BlueprintField<'a>, String)> {
    let mut named = Vec::new();
    for channel in channels {
        for field in &channel.fields {
            let grid = format!("{}/{}", channel.name, field.topology);
            if channels.len() > 1 {
                named.push((format!("{}.{}", channel.name, field.name), field, grid.clone()));
            }
            if channels.iter().flat_map(|other| &other.fields).filter(|other| other.name == field.name).count() == 1 {
                named.push((field.name.clone(), field, grid));
            }
        }
    }
    named
}
