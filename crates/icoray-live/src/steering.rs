//! Limits the scenes that viewers may set if a program writes the pictures that they watch: they change the contents of
//! pictures, not their destination, times, sizes or cost.

use crate::document;
use crate::session::{NamedScene, SceneReader};
use icoray::{Error, ErrorKind, Scene, Script, View, did_you_mean};
use serde_json::Value as Json;
use std::collections::BTreeSet;
use std::iter;
use std::sync::{Arc, Mutex, PoisonError};

/// The keys that viewers may change, by sections. All others are the model's, including those that are added to the
/// schema later. A name stands for all values that the key contains.
const STEERED: &[(&str, &[&str])] = &[
    ("", &["field", "exaggeration", "background", "core"]),
    ("camera", &["lon", "lat", "distance", "altitude", "eye", "target", "up", "fov", "orbit", "path"]),
    ("transfer", &TRANSFER),
    ("opacity", &["field", "values", "unit_length"]),
    ("volumes", &["field", "opacity"]),
    ("volumes.transfer", &TRANSFER),
    ("surfaces", &["layer", "height_m", "color", "field", "shading", "opacity"]),
    ("surfaces.transfer", &TRANSFER),
    ("isosurfaces", &["field", "value", "values", "color", "colors", "color_by", "opacity"]),
    ("isosurfaces.transfer", &TRANSFER),
    ("lines", &["pattern", "on", "height_m", "color", "width", "opacity", "spacing", "region"]),
    ("ground", &["land", "ocean"]),
    ("clip", &["cut", "lon", "lat", "layers", "height_m", "half_space"]),
    ("light", &["kind", "lon", "lat", "ambient", "diffuse", "specular", "shininess"]),
    ("labels", &["on", "title", "name", "units", "place", "size", "color", "bar", "scale", "error"]),
];
const TRANSFER: [&str; 10] =
    ["unit_length", "knots", "map", "reverse", "range", "scale", "threshold", "center", "opacity", "opacity_in"];

/// Maximum number of volumes, surfaces, isosurfaces, lines and clips of each kind in a viewer's scene, if the model's
/// has no more.
const MAX_ENTRIES: usize = 8;
/// Maximum number of bytes by which a viewer's text may exceed the model's, which parses it too.
const MAX_EXTRA_BYTES: usize = 1 << 16;

/// The model's data for steering. They may change while the page is open.
#[derive(Debug, Clone, Default)]
pub struct Steered {
    /// The text of its own scene.
    pub text: String,
    /// The names of its fields.
    pub fields: BTreeSet<String>,
}

/// State that a program and its page's reader of scenes share.
pub type SharedSteered = Arc<Mutex<Steered>>;

/// Parses scenes that replace the model's, with its fields only; `first` is the field of scenes that name none. Refuses
/// a scene that differs from the model's in more than the keys that viewers may change.
pub fn steering_reader(first: Option<String>, steered: SharedSteered) -> Box<SceneReader> {
    Box::new(move |text| {
        // A copy: the model waits for this lock, and the rest takes time.
        let steered = steered.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let refused = |what: String| Err(Error::new(ErrorKind::Scene, what));
        let max_bytes = steered.text.len() + MAX_EXTRA_BYTES;
        if text.len() > max_bytes {
            return refused(format!("a scene of {} bytes, expected at most {max_bytes} of a viewer", text.len()));
        }
        let (own, given) = (document::values(&steered.text, None), document::values(text, None));
        // Parsing a scene reads its files.
        if files(&given).any(|file| files(&own).all(|known| known != file)) {
            return refused("lines.file is the model's, which a viewer cannot change".into());
        }
        let mut script = Script::parse(text)?;
        if let Some(path) = not_steered("", &own, &given) {
            return refused(format!("{path} is the model's, which a viewer cannot change"));
        }
        if let Some(what) = too_many(&Script::parse(&steered.text)?, &script) {
            return refused(what);
        }
        script.name_by_date();
        if let (true, Some(first)) = (script.lacks_field(), &first) {
            script.name_first_field(first);
        }
        if let Some(missing) = script.model_fields().into_iter().find(|name| !steered.fields.contains(name)) {
            let known: Vec<&str> = steered.fields.iter().map(String::as_str).collect();
            let hint = did_you_mean(&missing, known.iter().copied());
            return refused(format!("field {missing:?}{hint}, expected one of {}", known.join(", ")));
        }
        let scene = |view: &View| {
            let scene = view.scenes().next();
            let scene = scene.ok_or_else(|| Error::new(ErrorKind::Scene, "the view draws no picture"))?;
            Ok(NamedScene { name: view.name().to_owned(), scene })
        };
        script.views().iter().map(scene).collect()
    })
}

/// The files of outlines in a scene and its views.
fn files(scene: &Json) -> impl Iterator<Item = &Json> {
    let parts = iter::once(scene).chain(scene["views"].as_array().into_iter().flatten());
    let lines = parts.flat_map(|part| part["lines"].as_array().into_iter().flatten());
    lines.map(|lines| &lines["file"]).filter(|file| !file.is_null())
}

/// Whether viewers may change the key at a path, with all values that it contains.
fn is_steered(path: &str) -> bool {
    let (section, key) = path.rsplit_once('.').unwrap_or(("", path));
    STEERED.iter().any(|(name, keys)| *name == section && keys.contains(&key))
}

/// Whether viewers may change the key at a path, or one that contains it.
pub(crate) fn may_steer(path: &str) -> bool {
    is_steered(path) || path.rsplit_once('.').is_some_and(|(above, _)| may_steer(above))
}

/// The path of the first difference that viewers may not make.
fn not_steered(path: &str, own: &Json, given: &Json) -> Option<String> {
    if own == given || is_steered(path) {
        return None;
    }
    match [own, given].map(|value| (value.as_object(), value.as_array())) {
        // If only one of the texts has a table, or entries of a list of tables, they differ in each of their keys.
        [(own_keys, None), (keys, None)]
            if (own_keys.is_some() || own.is_null()) && (keys.is_some() || given.is_null()) =>
        {
            let names: BTreeSet<&String> = own_keys.into_iter().chain(keys).flat_map(|keys| keys.keys()).collect();
            if names.is_empty() && !is_section(path) {
                return Some(path.to_owned());
            }
            // The keys of a view are those at the top.
            let within = |name: &str| match path {
                "" | "views" => name.to_owned(),
                path => format!("{path}.{name}"),
            };
            names.into_iter().find_map(|name| not_steered(&within(name), &own[name], &given[name]))
        }
        [(None, own_list), (None, list)] if path == "views" || is_section(path) => {
            let count = own_list.map_or(0, Vec::len).max(list.map_or(0, Vec::len));
            (0..count).find_map(|i| not_steered(path, &own[i], &given[i]))
        }
        _ => Some(path.to_owned()),
    }
}

/// Whether viewers may change keys of the table or of the list of tables at a path.
fn is_section(path: &str) -> bool {
    STEERED.iter().any(|(name, _)| *name == path)
}

/// The kind of which a script has more than [`MAX_ENTRIES`] and than the model's own.
fn too_many(own: &Script, given: &Script) -> Option<String> {
    let counts = |scene: &Scene| {
        let scenery = &scene.scenery;
        [
            ("volumes", scene.volumes.len()),
            ("surfaces", scenery.surfaces.len()),
            ("isosurfaces", scenery.isosurfaces.len()),
            ("lines", scenery.lines.len()),
            ("clip", scenery.clips.len()),
        ]
    };
    let of_first = |view: &View| view.scenes().next().as_ref().map(counts);
    given.views().iter().zip(own.views()).find_map(|(given, own)| {
        let own = of_first(own);
        of_first(given)?.into_iter().enumerate().find_map(|(i, (name, count))| {
            let max = own.map_or(0, |own| own[i].1).max(MAX_ENTRIES);
            (count > max).then(|| format!("{count} {name}, expected at most {max} of a viewer"))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use icoray::keys::{self, Key};

    const TEXT: &str = "field = 'q'\n[live]\n[image]\nwidth = 64\n[output]\nfile = 'a_{step}.png'\n[camera]\nlon = 3\n\
                        lat = 4\ndistance = 3\n";

    fn reader(text: &str) -> Box<SceneReader> {
        let fields = ["q", "w"].map(str::to_owned).into();
        steering_reader(Some("q".to_owned()), Arc::new(Mutex::new(Steered { text: text.to_owned(), fields })))
    }

    #[test]
    fn viewers_change_the_contents_of_pictures() {
        let read = reader(TEXT);
        let surface = "[[surfaces]]\nlayer = 0\nfield = 'w'\ntransfer = { map = 'viridis', range = [0, 1] }\n";
        let values = "[[isosurfaces]]\nvalues = [1, 2, 3]\n";
        for good in [
            TEXT.replace("'q'", "'w'"),
            TEXT.replace("field = 'q'", ""),
            TEXT.replace("lon = 3", "lon = 40"),
            TEXT.replace("[camera]\nlon = 3\nlat = 4\ndistance = 3\n", "[light]\n"),
            format!("{TEXT}[transfer]\nmap = 'magma'\nrange = {{ percentile = [2, 98] }}\n{surface}{values}"),
            // As TOML has it otherwise.
            TEXT.replace("[image]\nwidth = 64\n", "").replace("[live]", "image.width = 64\n[live]"),
        ] {
            assert_eq!(read(&good).map(|views| views.len()).map_err(|e| e.to_string()), Ok(1), "{good}");
        }
    }

    #[test]
    fn all_else_is_the_models() {
        let read = reader(TEXT);
        let many = |section: &str| format!("{TEXT}{}", section.repeat(MAX_ENTRIES + 1));
        for (bad, wanted) in [
            (TEXT.replace("a_{step}", "../b_{step}"), "output.file is the model's"),
            (TEXT.replace("[camera]", "cinema = '/any/where/x.cdb'\n[camera]"), "output.cinema is the model's"),
            (TEXT.replace("[camera]", "concat = 'x.ffconcat'\n[camera]"), "output.concat is the model's"),
            (format!("{TEXT}[[lines]]\nfile = '/no/such/file'\n"), "lines.file is the model's"),
            (
                format!("{TEXT}[[views]]\nname = 'a'\n[[views.lines]]\nfile = '/no/such/file'\n"),
                "lines.file is the model's",
            ),
            (TEXT.replace("64", "6400"), "image.width is the model's"),
            (TEXT.replace("[live]", "[live]\nport = 99"), "live.port is the model's"),
            (TEXT.replace("[live]", ""), "live is the model's"),
            (format!("every = 1000000000\n{TEXT}"), "every is the model's"),
            (format!("at_steps = [9]\n{TEXT}"), "at_steps is the model's"),
            (format!("when = 'max(q) > 1e30'\n{TEXT}"), "when is the model's"),
            (format!("samples = 64\n{TEXT}"), "samples is the model's"),
            (format!("sweep.lon = [0, 10]\n{}", TEXT.replace("a_{step}", "{lon}")), "is the model's"),
            (format!("{TEXT}[[views]]\nname = 'a'\n"), "name is the model's"),
            (format!("{TEXT}[[derive]]\nname = 'a'\nmagnitude = ['q', 'w']\n"), "derive is the model's"),
            (TEXT.replace("'q'", "'z'"), "field \"z\", expected one of q, w"),
            (many("[[isosurfaces]]\nfield = 'q'\nvalue = 1\ncolor = 'red'\n"), "9 isosurfaces, expected at most 8"),
            (
                format!("{TEXT}[[isosurfaces]]\nfield = 'q'\nvalues = [1, 2, 3, 4, 5, 6, 7, 8, 9]\ncolor = 'red'\n"),
                "9 isosurfaces, expected at most 8",
            ),
            (many("[[clip]]\nlat = [0, 1]\n"), "9 clip, expected at most 8"),
            (format!("{TEXT}# {}\n", "x".repeat(MAX_EXTRA_BYTES)), "expected at most 65643 of a viewer"),
            ("field = ".to_owned(), "line 1"),
        ] {
            let error = read(&bad).unwrap_err().to_string();
            assert!(error.contains(wanted), "{bad}: {error}");
        }
    }

    #[test]
    fn views_keep_their_names_and_schedules() {
        let text = "field = 'q'\n[[views]]\nname = 'a'\n[[views]]\nname = 'b'\nevery = 4\n[views.camera]\nlon = 1\n\
                    lat = 2\ndistance = 3\n[[views.isosurfaces]]\nvalue = 2\n";
        let read = reader(text);
        for good in [text.replace("lon = 1", "lon = 7"), text.replace("value = 2", "value = 5")] {
            assert_eq!(read(&good).map(|views| views.len()).map_err(|e| e.to_string()), Ok(2), "{good}");
        }
        for (bad, wanted) in [
            (text.replace("'a'", "'c'"), "name is the model's"),
            (text.replace("every = 4", "every = 5"), "every is the model's"),
            (text.replace("every = 4", "every = 4\noutput.cinema = 'x.cdb'"), "output.cinema is the model's"),
            (text.replace("[[views]]\nname = 'a'\n", ""), "is the model's"),
            ("field = 'q'\n".to_owned(), "is the model's"),
        ] {
            let error = read(&bad).unwrap_err().to_string();
            assert!(error.contains(wanted), "{bad}: {error}");
        }
    }

    /// Each name is a key, and the keys inside of those that viewers may change as a whole are listed here: a key that
    /// is added to one of them must be added here too.
    #[test]
    fn the_list_names_keys_of_the_schema() {
        fn collect_inner(path: &str, key: &Key, all: &mut Vec<String>) {
            for inner in key.keys() {
                let path = format!("{path}.{}", inner.name);
                collect_inner(&path, inner, all);
                all.push(path);
            }
        }
        let mut all = Vec::new();
        for (section, names) in STEERED.iter().filter(|(section, _)| !section.ends_with(".transfer")) {
            for name in *names {
                let path = if section.is_empty() { (*name).to_owned() } else { format!("{section}.{name}") };
                collect_inner(&path, keys::find(&path).unwrap_or_else(|| panic!("{path} is no key")), &mut all);
            }
        }
        all.sort();
        let known = "camera.orbit.degrees_per_step camera.orbit.seconds camera.orbit.steps camera.orbit.turn \
                     camera.path.altitude camera.path.distance camera.path.fov camera.path.lat camera.path.lon \
                     camera.path.step camera.path.time clip.half_space.distance clip.half_space.towards \
                     lines.region.lat lines.region.lon transfer.knots.color transfer.knots.extinction \
                     transfer.knots.opacity transfer.knots.value transfer.range.hysteresis transfer.range.percentile \
                     transfer.range.union volumes.opacity.field volumes.opacity.unit_length volumes.opacity.values";
        assert_eq!(all.join(" "), known);
    }
}
