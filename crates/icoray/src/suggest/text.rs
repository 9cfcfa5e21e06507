//! The text of the suggested scene.

use super::aim::{Aim, Region};
use super::look::{Kind, Look};
use super::numbers::to_step;
use super::sample::Sample;
use super::{FILLED, FOV_DEG, Options};
use icoray_grid::numbers::text as number;
use icoray_grid::{Layers, printable};
use icoray_scene::{Adapter, Backend, Level, LightSource, Scale};
use std::fmt::Write;

/// Radii of planets that have Earth's coasts, metres, and the radius of meshes that are still to be scaled to it.
const EARTH_M: std::ops::Range<f64> = 6.3e6..6.45e6;
const UNSCALED_M: f64 = 1.0;
/// Width and height of the picture.
const SIZE: (u32, u32) = (900, 720);

/// Contents of the text.
pub(super) struct Suggested<'s> {
    pub name: &'s str,
    pub sample: &'s Sample,
    pub layers: &'s Layers,
    pub exaggeration: f64,
    pub look: Look,
    pub aim: Aim,
    pub region: Option<Region>,
    pub options: &'s Options,
}

impl Suggested<'_> {
    pub fn text(&self) -> String {
        let mut text = String::new();
        // TOML comments have no control characters.
        let comment = |line: &str| format!("# {}\n", printable(&line.replace(['\n', '\r'], " ")));
        self.options.head.iter().for_each(|line| text += &comment(line));
        let shown = if self.options.isosurface.is_some() { "one value" } else { self.look.kind.describe() };
        text += &comment(&format!("{}: {shown}", self.name));
        text.push('\n');
        self.root(&mut text);
        self.camera(&mut text);
        self.derived(&mut text);
        self.shown(&mut text);
        self.cut(&mut text);
        self.light(&mut text);
        self.ground(&mut text);
        self.labels(&mut text);
        text
    }

    fn root(&self, text: &mut String) {
        let Options { tolerance, samples, backend, device, .. } = self.options;
        let mut line = |key: &str, value: &str, what: &str| put(text, key, value, what);
        line("field", &quoted(&self.shown_name()), "a variable of the model, or derived below");
        line("exaggeration", &number(self.exaggeration), "factor on heights; 1 is true to scale");
        let background = self.options.background.as_deref().unwrap_or("#0a0d11");
        line("background", &quoted(background), "or \"transparent\"");
        line("core", "\"#242424\"", "the opaque planet below the lowest layer; or \"transparent\"");
        if let Some(tolerance) = tolerance {
            line("tolerance", &number(*tolerance), "largest error of a channel");
        }
        if let Some(samples) = samples {
            line("samples", &samples.to_string(), "most rays per pixel");
        }
        if let Some(backend) = backend {
            let word = match backend {
                Backend::Auto => "auto",
                Backend::Cpu => "cpu",
                Backend::Gpu => "gpu",
            };
            line("backend", &quoted(word), "who draws: \"auto\", \"cpu\" or \"gpu\"");
        }
        match device {
            Some(Adapter::Number(device)) => line("device", &device.to_string(), "which GPU"),
            Some(Adapter::Name(name)) => line("device", &quoted(name), "which GPU"),
            None => (),
        }
        let (width, height) = self.size();
        *text += &format!("\n[image]\nwidth = {width}\nheight = {height}\n");
    }

    fn camera(&self, text: &mut String) {
        let Options { lon_deg, lat_deg, distance, .. } = self.options;
        let outer = self.layers.radius_m().iter().copied().fold(0.0, f64::max) / self.layers.planet_radius_m();
        let radius = 1.0 + self.exaggeration * (outer - 1.0).max(0.0);
        let (width, height) = self.size();
        let (place, farthest, why) = match &self.region {
            Some(region) => {
                let distance = region.distance(self.sample, radius, f64::from(width) / f64::from(height));
                ([region.lon_deg, region.lat_deg], distance, "the middle of the mesh")
            }
            None => {
                let aspect = (f64::from(width) / f64::from(height)).min(1.0);
                let distance = to_step(radius / (FILLED * aspect * 0.5 * FOV_DEG.to_radians()).sin(), 0.01);
                let why = if self.aim.is_of_field { "where most of the field is seen" } else { "degrees east" };
                ([self.aim.lon_deg, self.aim.lat_deg], distance, why)
            }
        };
        *text += "\n[camera]\n";
        put(text, "lon", &number(lon_deg.unwrap_or(place[0])), why);
        put(text, "lat", &number(lat_deg.unwrap_or(place[1])), "degrees north");
        put(text, "distance", &number(distance.unwrap_or(farthest)), "from the planet's centre, planet radii");
        put(text, "fov", &number(FOV_DEG), "full vertical angle, degrees");
    }

    fn size(&self) -> (u32, u32) {
        self.options.size.unwrap_or(SIZE)
    }

    /// The name of the field that is shown.
    fn shown_name(&self) -> String {
        if self.look.is_of_anomaly { format!("{}_anomaly", self.name) } else { self.name.to_owned() }
    }

    fn derived(&self, text: &mut String) {
        if !self.look.is_of_anomaly {
            return;
        }
        *text += "\n[[derive]]\n";
        put(text, "name", &quoted(&self.shown_name()), "");
        put(text, "anomaly", &quoted(self.name), "as each layer has about one value");
        put(text, "from", "\"zonal mean\"", "");
        put(text, "band", "180", "degrees of latitude: the mean of the whole layer");
    }

    fn cut(&self, text: &mut String) {
        if !self.look.is_cut {
            return;
        }
        let lon = self.options.lon_deg.unwrap_or(self.region.map_or(self.aim.lon_deg, |region| region.lon_deg));
        *text += "\n[[clip]]                   # a sector, so that the inside is seen\n";
        put(text, "lon", &format!("[{}, {}]", number(lon), number(lon + 90.0)), "");
        put(text, "lat", "[0, 90]", "");
    }

    /// The volume, or the surface.
    fn shown(&self, text: &mut String) {
        let Look { map, scale, range: [low, high], opacity, unit_length, .. } = &self.look;
        let range = format!("[{}, {}]", number(*low), number(*high));
        let is_log = *scale == Scale::Log;
        if let Some(level) = self.options.surface {
            let scale = if is_log { ", scale = \"log\"" } else { "" };
            let transfer = format!("{{ map = {}, range = {range}{scale} }}", quoted(map));
            *text += "\n[[surfaces]]\n";
            let (key, value) = level_keys(level);
            put(text, key, &value, "from 0, the innermost; or \"top\", \"bottom\"; or height_m");
            put(text, "field", &quoted(self.name), "");
            put(text, "transfer", &transfer, "colours; fixed, so that times can be compared");
            return;
        }
        if let Some(value) = self.options.isosurface {
            *text += "\n[[isosurfaces]]\n";
            put(text, "value", &number(value), "or values = [...] with colors = [...]");
            put(text, "color", "\"#f0a030\"", "or color_by, a field with a transfer");
            return;
        }
        let stops = opacity.iter().map(|(value, opacity)| format!("[{}, {}]", number(*value), number(*opacity)));
        let stops = stops.collect::<Vec<_>>().join(", ");
        *text += "\n[transfer]\n";
        put(text, "map", &quoted(map), "colour map; with _r behind it the other way round");
        put(text, "range", &range, "its ends; fixed, so that times can be compared");
        if is_log {
            put(text, "scale", "\"log\"", "or \"linear\"");
        }
        *text += "# [value, opacity after unit_length], linear between\n";
        put(text, "opacity", &format!("[{stops}]"), "");
        put(text, "unit_length", &number(*unit_length), "planet radii, after exaggeration");
    }

    fn light(&self, text: &mut String) {
        *text += "\n[light]\n";
        let Options { surface, isosurface, light, .. } = self.options;
        // Colours to be read from the bar are not shaded.
        let is_read = surface.is_some() || self.look.kind == Kind::Layered && isosurface.is_none();
        match light.unwrap_or((!is_read).then_some(LightSource::Headlight)) {
            None => {
                put(text, "kind", "\"none\"", "colours are those of the bar; or \"headlight\", \"sun\"");
                return;
            }
            Some(LightSource::Headlight) => {
                put(text, "kind", "\"headlight\"", "from the eye; or \"sun\" with lon and lat, or \"none\"");
            }
            Some(LightSource::Sun { lon_deg, lat_deg }) => {
                put(text, "kind", "\"sun\"", "from above a place; or \"headlight\" or \"none\"");
                put(text, "lon", &number(lon_deg), "degrees east");
                put(text, "lat", &number(lat_deg), "degrees north");
            }
        }
        put(text, "ambient", "0.6", "");
        put(text, "diffuse", "0.4", "");
        put(text, "specular", "0.1", "strength of the highlight");
    }

    fn ground(&self, text: &mut String) {
        let radius_m = self.layers.planet_radius_m();
        let is_earth = EARTH_M.contains(&radius_m) || radius_m == UNSCALED_M;
        let ground = ("on", quoted("ground"));
        // The ground shows under a volume, and around the data of a mesh with holes.
        let levels = match self.options.surface.map(level_keys) {
            Some(("layer", layer)) => vec![("on", layer)],
            Some(height) => vec![height],
            None => Vec::new(),
        };
        let is_ground_seen = levels.is_empty() || self.sample.has_holes;
        if is_earth && is_ground_seen {
            *text += "\n[ground]                   # the core is painted with land and sea; leave this out for other planets\n";
            *text += "land = \"#2e2e2e\"\nocean = \"#1c1c1c\"\n";
        }
        for (key, on) in levels.into_iter().chain(is_ground_seen.then_some(ground)) {
            let color = if on == quoted("ground") { "\"white\"" } else { "\"black\"" };
            let mut lines = |pattern: &str, what: &str, width: &str, opacity: &str| {
                *text += "\n[[lines]]\n";
                put(text, "pattern", &quoted(pattern), what);
                put(text, key, &on, "");
                put(text, "color", color, "");
                put(text, "width", width, "pixels");
                put(text, "opacity", opacity, "");
            };
            if is_earth {
                lines("coast", "Natural Earth", "1.2", "0.6");
            }
            if is_earth && self.options.has_borders {
                lines("borders", "between countries, of Natural Earth", "0.8", "0.5");
            }
            lines("graticule", "meridians and parallels", "0.7", "0.25");
            put(text, "spacing", &number(self.spacing_deg()), "degrees");
        }
    }

    /// Degrees between lines of the graticule: small enough for some lines to cross a region.
    fn spacing_deg(&self) -> f64 {
        let across = self.region.map_or(f64::INFINITY, |region| region.across.to_degrees());
        let fits = |spacing: &f64| *spacing <= 0.4 * across;
        [30.0, 15.0, 10.0, 5.0, 2.0, 1.0, 0.5, 0.2].into_iter().find(fits).unwrap_or(0.1)
    }

    fn labels(&self, text: &mut String) {
        if !self.options.is_unlabelled {
            *text += "\n[labels]                   # in PNG files; without this section there are none\n";
            let time = if self.options.is_timeless { "" } else { "\\n{time}" };
            put(text, "title", &format!("\"{{name}} ({{units}}){time}\""), "");
            if self.look.is_of_anomaly {
                put(text, "name", &quoted(&format!("{}, less the mean of each layer", self.name)), "");
            }
        }
        *text += "\n[output]\n";
        let what = "date, if there is one, and step; also {step:06}, $Y-$M-$D_$h";
        put(text, "file", "\"{field}_{when}.png\"", what);
    }
}

/// A key with its value and a comment.
fn put(text: &mut String, key: &str, value: &str, what: &str) {
    let line = format!("{key} = {value}");
    let written = match what {
        "" => writeln!(text, "{line}"),
        _ => writeln!(text, "{line:<26} # {what}"),
    };
    written.expect("a String takes all text");
}

/// A TOML string.
fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// The key and the value with which a scene names a level.
fn level_keys(level: Level) -> (&'static str, String) {
    match level {
        Level::Ground => ("layer", quoted("bottom")),
        Level::Top => ("layer", quoted("top")),
        Level::Layer(number) => ("layer", number.to_string()),
        Level::Height(height_m) => ("height_m", number(height_m)),
    }
}
