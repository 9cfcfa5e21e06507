//! One host: from `catalyst_initialize` to `catalyst_finalize`.

use crate::blueprint::Topology;
use crate::channels::{Channel, NamedField, Place, Places, named_fields, places_of};
use crate::conduit::Node;
use crate::context::{Context, error};
use crate::fields::{CopiedField, set, set_empty};
use crate::grid::{HostGrid, HostMeshes, Setting};
use crate::peers::{Peers, teams_of_host};
use icoray::{Error, ErrorKind, OwnedReals, Result};
use std::collections::{BTreeMap, BTreeSet};

/// The function of C that sets a field.
const FIELD_SET: &str = "icoray_field_set";

/// The context of a host, its grids and its other ranks.
pub struct Adaptor {
    /// Dropped first, as it reads what follows.
    context: Context,
    grids: BTreeMap<String, Slot>,
    copies: Vec<OwnedReals>,
    peers: Peers,
    scene_fields: Vec<String>,
    /// The fields that the context has.
    given: BTreeSet<String>,
    planet_radius: Option<f64>,
    calls: i64,
    /// Whether ranks send each other step and time, as one of them had not both in its first call; `None` before that.
    shares_now: Option<bool>,
    /// Whether there may be a report that was not asked for, or that there was.
    may_have_report: bool,
    /// Bytes of fields that were copied for the last frame.
    bytes_copied: usize,
    /// Messages that were written, once each.
    reported: BTreeSet<String>,
}

/// A grid of the context, if the last update succeeded, and its tables.
#[derive(Default)]
struct Slot {
    grid: Option<HostGrid>,
    tables: HostMeshes,
}

impl Adaptor {
    /// Opens a context over the host's ranks and loads its scene. Collective; all fail where one does.
    pub fn new(params: Node) -> Result<Self> {
        let communicator = params.at("catalyst/mpi_comm").and_then(Node::integer);
        let (first, second) = match teams_of_host(communicator)? {
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
        context.load_scene(&scene).map_err(error)?;
        Ok(Adaptor {
            scene_fields: context.scene_fields().map_err(error)?,
            context,
            grids: BTreeMap::new(),
            copies: Vec::new(),
            peers,
            given: BTreeSet::new(),
            planet_radius: params.at("catalyst/icoray/planet_radius").and_then(Node::number),
            calls: 0,
            shares_now: None,
            may_have_report: false,
            bytes_copied: 0,
            reported: BTreeSet::new(),
        })
    }

    /// Draws what is due; a rank without a node has no channels. Collective; all fail where one does. Failures of
    /// fields and frames are in the log.
    pub fn execute(&mut self, params: Option<Node>) -> Result<()> {
        let channels = guarded(|| params.map(Channel::all).unwrap_or_default());
        let (step, time_s) = self.now(params, &channels)?;
        self.calls += 1;
        let mut wants = false;
        // What fails here is in the log.
        let _ = self.context.wants(None, step, time_s, &mut wants);
        if !wants {
            return Ok(());
        }
        let places = self.places(&channels)?;
        let failures = self.update_grids(&channels, &places)?;
        guarded(|| {
            self.set_heights(&places);
            self.set_fields(&channels, &places, &failures);
        });
        // The context logs what fails, and switches itself off after three failed frames in a row.
        // SAFETY: tables, arrays and copies are alive until the call returns.
        let _ = unsafe { self.context.execute(step, time_s, None) };
        self.may_have_report = true;
        self.copies.clear();
        Ok(())
    }

    /// Step and time: those of the host, or else the number of calls. Where they are in the mesh alone, which ranks
    /// without elements may not give, ranks send them to each other. Collective.
    fn now(&mut self, params: Option<Node>, channels: &[Channel]) -> Result<(i64, f64)> {
        let find = |names: [&str; 3]| names.into_iter().find_map(|name| params?.at(name));
        let of_mesh = |path| channels.iter().find_map(|channel| channel.mesh.as_ref().ok()?.as_ref()?.at(path));
        let step = find(["catalyst/state/timestep", "catalyst/state/cycle", "catalyst/timestep"]);
        let time = find(["catalyst/state/time", "catalyst/time", "catalyst/state/time_value"]);
        let (step, time) = (step.and_then(Node::integer), time.and_then(Node::number));
        let is_whole = step.is_some() && time.is_some();
        let step = step.or_else(|| of_mesh("state/cycle")?.integer());
        let mut known = vec![(step, time.or_else(|| of_mesh("state/time")?.number()))];
        if self.shares_now != Some(false) {
            let ranks = self.peers.share((is_whole, known[0]))?;
            let is_any_without = ranks.iter().any(|(is_whole, _)| !is_whole);
            self.shares_now.get_or_insert(is_any_without);
            known = ranks.into_iter().map(|(_, known)| known).collect();
        }
        let step = known.iter().find_map(|(step, _)| *step).unwrap_or(self.calls);
        Ok((step, known.iter().find_map(|(_, time)| *time).unwrap_or(step as f64)))
    }

    /// Where the scene's fields are on any rank. Collective.
    fn places(&mut self, channels: &[Channel]) -> Result<Places> {
        let mine: Vec<Vec<Place>> =
            self.scene_fields.iter().map(|field| guarded(|| places_of(field, channels))).collect();
        Ok(Places::new(&self.scene_fields, &self.peers.share(mine)?))
    }

    /// Updates the grids of the scene's fields; returns why those that failed did. Collective.
    fn update_grids(&mut self, channels: &[Channel], places: &Places) -> Result<BTreeMap<String, String>> {
        let mut failures = BTreeMap::new();
        for (name, place) in places.grids() {
            let channel = channels.iter().find(|channel| channel.name == place.channel);
            let geometry = match channel.map(|channel| &channel.mesh) {
                None | Some(Ok(None)) => Ok(None),
                Some(Err(error)) => Err(error.clone()),
                Some(Ok(Some(mesh))) => {
                    let geometry = || Topology::of(*mesh, &place.topology).and_then(Topology::geometry);
                    Error::of_panics(geometry).map(Some)
                }
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

    /// Sets the heights of the first grid that the scene has now: a context has those of one.
    fn set_heights(&self, places: &Places) {
        let heights =
            |(name, place): (String, &Place)| self.grids.get(&name)?.grid.as_ref()?.heights(place.kind.is_at_elements);
        let first = places.grids().into_iter().find_map(heights);
        // What fails here is in the log.
        // SAFETY: `grids` keeps the heights until the context has others or is closed.
        let _ = unsafe { self.context.set_heights(first.as_ref()) };
    }

    fn set_fields(&mut self, channels: &[Channel], places: &Places, failures: &BTreeMap<String, String>) {
        self.copies.clear();
        self.bytes_copied = 0;
        let (mut given, mut refused) = (BTreeSet::new(), BTreeSet::new());
        for NamedField { name, field, grid, is_in_scene } in named_fields(channels, places) {
            let Some(on) = self.grids.get(&grid).and_then(|slot| slot.grid.as_ref()) else { continue };
            match set(&self.context, &name, field, on, is_in_scene) {
                Ok(copy) => {
                    copy.into_iter().for_each(|copy| self.keep(&name, copy));
                    given.insert(name);
                }
                Err(error) if is_in_scene => {
                    self.context.refuse(FIELD_SET, &name, &error.to_string());
                    refused.insert(name);
                }
                // The scene does not name the field.
                Err(_) => {}
            }
        }
        let missing = self.scene_fields.iter().filter(|name| !given.contains(*name) && !refused.contains(*name));
        // Of this step or an earlier one.
        let has_grid = self.grids.values().any(|slot| slot.tables.are_set());
        let mut reasons = BTreeSet::new();
        for name in missing.cloned().collect::<Vec<_>>() {
            match self.set_without_values(&name, channels, places, failures) {
                Ok(()) => {
                    given.insert(name);
                }
                Err(why) if has_grid => self.context.refuse(FIELD_SET, &name, &why),
                // This is what a frame lacks first.
                Err(why) => {
                    if reasons.insert(why.clone()) {
                        self.context.refuse("icoray_grid_set", "", &why);
                    }
                }
            }
        }
        for name in self.given.difference(&given).filter(|name| !self.scene_fields.contains(name)) {
            self.context.refuse(FIELD_SET, name, "the host gives no values that can be read in place");
        }
        self.given = given;
    }

    /// Sets a field of the scene that this rank has no values of, where it has no elements; or says why it has none.
    fn set_without_values(
        &self,
        name: &str,
        channels: &[Channel],
        places: &Places,
        failures: &BTreeMap<String, String>,
    ) -> std::result::Result<(), String> {
        let place = places.of(name).ok_or_else(|| places.why_none(name, channels))?;
        let grid = place.grid();
        if let Some(failure) = failures.get(&grid) {
            return Err(failure.clone());
        }
        let on = self.grids.get(&grid).and_then(|slot| slot.grid.as_ref());
        let empty = on.filter(|on| on.elements.layout.elements == 0);
        let empty = empty.ok_or_else(|| "the host gives no such field on this rank".to_owned())?;
        set_empty(&self.context, name, &place.kind, empty).map_err(|e| e.to_string())
    }

    /// Keeps a copy of a field until the frame is drawn, and reports it once.
    fn keep(&mut self, name: &str, CopiedField { values, reason }: CopiedField) {
        self.bytes_copied += values.bytes();
        let message = format!("field {name}: its values {reason}, and are copied for each picture");
        if self.peers.rank() == 0 && self.reported.insert(message.clone()) {
            crate::say(&message);
        }
        self.copies.push(values);
    }

    /// Adds the report of the last frame.
    pub fn fill_results(&mut self, to: Node) {
        // A context without a report says so in the log.
        let report = if self.may_have_report { self.context.report().ok() } else { None };
        self.may_have_report = report.is_some();
        let Some(report) = report else { return };
        to.set_integer("icoray/step", report.step);
        to.set_integer("icoray/frames_written", report.frames_written as i64);
        to.set_integer("icoray/frames_failed", report.frames_failed as i64);
        to.set_integer("icoray/bytes_copied", report.bytes_copied as i64 + self.bytes_copied as i64);
        to.set_number("icoray/error_max", report.error_max);
        to.set_number("icoray/host_s", report.host_s);
        to.set_number("icoray/render_s", report.render_s);
    }
}

/// Does some of this rank's work between collective calls. A panic in it is reported and gives the default: the
/// other ranks wait for this one in the next call.
fn guarded<R: Default>(work: impl FnOnce() -> R) -> R {
    Error::of_panics(|| Ok(work())).unwrap_or_else(|error| {
        crate::say(&error.to_string());
        R::default()
    })
}

/// The path of the scene: the first of the host's scripts that ends in .toml, or that of the environment.
fn scene_of(params: Node) -> Option<String> {
    let scripts = params.at("catalyst/scripts").into_iter().flat_map(Node::children);
    let path = |(_, script): (String, Node)| script.text().or_else(|| script.text_at("filename"));
    let of_host = scripts.filter_map(path).find(|path| path.ends_with(".toml"));
    of_host.or_else(|| std::env::var("ICORAY_SCENE").ok().filter(|path| !path.is_empty()))
}
