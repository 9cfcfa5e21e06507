//! The text of the suggested scene.

use super::aim::Aim;
use super::look::{Kind, Look};
use super::numbers::to_step;
use super::{FILLED, FOV_DEG, Options};
use icoray_grid::Layers;
use icoray_grid::numbers::text as number;
use icoray_scene::{Adapter, Backend, Level};
use std::fmt::Write;

/// Radii of planets that have Earth's coasts, metres.
const EARTH_M: std::ops::Range<f64> = 6.3e6..6.45e6;
/// Width and height of the picture.
const SIZE: (u32, u32) = (960, 720);

/// Contents of the text.
pub(super) struct Suggested<'s> {
    pub name: &'s str,
    pub layers: &'s Layers,
    pub exaggeration: f64,
    pub look: Look,
    pub aim: Aim,
    pub options: &'s Options,
}

impl Suggested<'_> {
    pub fn text(&self) -> String {
        let mut text = String::new();
        for line in &self.options.head {
            text += &format!("# {}\n", line.replace(['\n', '\r'], " "));
        }
        text += &format!("# {}: {}\n\n", self.name.replace(['\n', '\r'], " "), self.look.kind.describe());
        for part in [self.root(), self.camera(), self.shown(), self.light(), self.ground(), self.labels()] {
            text += &part;
        }
        text
    }

    fn root(&self) -> String {
        let Options { tolerance, samples, backend, device, size, .. } = self.options;
        let mut text = String::new();
        let mut line = |key: &str, value: &str, what: &str| put(&mut text, key, value, what);
        line("field", &quoted(self.name), "a variable of the model");
        line("exaggeration", &number(self.exaggeration), "factor on heights; 1 is true to scale");
        line("background", "\"#0b0f16\"", "or \"transparent\"");
        line("core", "\"#36424e\"", "the opaque planet below the lowest layer; or \"transparent\"");
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
        let (width, height) = size.unwrap_or(SIZE);
        text += &format!("\n[image]\nwidth = {width}\nheight = {height}\n");
        text
    }

    fn camera(&self) -> String {
        let Options { lon_deg, lat_deg, distance, .. } = self.options;
        let outer = self.layers.radius_m().iter().copied().fold(0.0, f64::max) / self.layers.planet_radius_m();
        let radius = 1.0 + self.exaggeration * (outer - 1.0).max(0.0);
        let farthest = radius / (FILLED * 0.5 * FOV_DEG.to_radians()).sin();
        let why = match self.aim.is_of_field {
            true => "the side on which the field differs most from its zonal mean",
            false => "degrees east",
        };
        let mut text = "\n[camera]\n".to_owned();
        put(&mut text, "lon", &number(lon_deg.unwrap_or(self.aim.lon_deg)), why);
        put(&mut text, "lat", &number(lat_deg.unwrap_or(self.aim.lat_deg)), "degrees north");
        let distance = number(distance.unwrap_or(to_step(farthest, 0.01)));
        put(&mut text, "distance", &distance, "from the planet's centre, planet radii");
        put(&mut text, "fov", &number(FOV_DEG), "full vertical angle, degrees");
        text
    }

    /// The volume, or the surface.
    fn shown(&self) -> String {
        let Look { map, range: [low, high], opacity, unit_length, .. } = &self.look;
        let range = format!("[{}, {}]", number(*low), number(*high));
        if let Some(level) = self.options.surface {
            let transfer = format!("{{ map = {}, range = {range} }}", quoted(map));
            let mut text = "\n[[surfaces]]\n".to_owned();
            let (key, value) = level_keys(level);
            put(&mut text, key, &value, "from 0, the innermost; or \"top\", \"bottom\"; or height_m");
            put(&mut text, "field", &quoted(self.name), "");
            put(&mut text, "transfer", &transfer, "colours; fixed, so that times can be compared");
            return text;
        }
        let stops = opacity.iter().map(|(value, opacity)| format!("[{}, {}]", number(*value), number(*opacity)));
        let stops = stops.collect::<Vec<_>>().join(", ");
        let mut text = "\n[transfer]\n".to_owned();
        put(&mut text, "map", &quoted(map), "colour map; with _r behind it the other way round");
        put(&mut text, "range", &range, "its ends; fixed, so that times can be compared");
        text += "# [value, opacity after unit_length], linear between\n";
        put(&mut text, "opacity", &format!("[{stops}]"), "");
        put(&mut text, "unit_length", &number(*unit_length), "planet radii, after exaggeration");
        text
    }

    fn light(&self) -> String {
        let mut text = "\n[light]\n".to_owned();
        // Colours that are to be read from the bar are not shaded.
        if self.options.surface.is_some() || self.look.kind == Kind::Whole {
            put(&mut text, "kind", "\"none\"", "colours are those of the bar; or \"headlight\", \"sun\"");
            return text;
        }
        put(&mut text, "kind", "\"headlight\"", "from the eye; or \"sun\" with lon and lat, or \"none\"");
        put(&mut text, "ambient", "0.45", "");
        put(&mut text, "diffuse", "0.55", "");
        put(&mut text, "specular", "0.15", "strength of the highlight");
        text
    }

    fn ground(&self) -> String {
        let is_earth = EARTH_M.contains(&self.layers.planet_radius_m());
        // Nothing of the ground is seen through what is dense throughout.
        let (key, on) = match self.options.surface {
            Some(level) => match level_keys(level) {
                ("layer", layer) => ("on", layer),
                height => height,
            },
            None if self.look.kind == Kind::Whole => ("on", quoted("top")),
            None => ("on", quoted("ground")),
        };
        let is_on_ground = on == quoted("ground");
        let mut text = String::new();
        if is_earth && is_on_ground {
            text += "\n[ground]                   # the core is painted with land and sea; leave this out for other planets\n";
            text += "land = \"#4d5548\"\nocean = \"#26384e\"\n";
        }
        let mut lines = |pattern: &str, what: &str, width: &str, opacity: &str| {
            text += "\n[[lines]]\n";
            put(&mut text, "pattern", &quoted(pattern), what);
            put(&mut text, key, &on, "");
            put(&mut text, "color", if is_on_ground { "\"white\"" } else { "\"black\"" }, "");
            put(&mut text, "width", width, "pixels");
            put(&mut text, "opacity", opacity, "");
        };
        if is_earth {
            lines("coast", "Natural Earth 1:110m", "1.2", "0.6");
        }
        lines("graticule", "meridians and parallels, each 30 degrees", "0.7", "0.25");
        text
    }

    fn labels(&self) -> String {
        let mut text = "\n[labels]                   # in PNG files; without this section there are none\n".to_owned();
        put(&mut text, "title", "\"{field}\\n{time}\"", "");
        text += "\n[output]\n";
        put(&mut text, "file", "\"{field}_{step:06}.png\"", "also $Y-$M-$D_$h for the date");
        text
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

/// How a scene names a level.
fn level_keys(level: Level) -> (&'static str, String) {
    match level {
        Level::Ground => ("layer", quoted("bottom")),
        Level::Top => ("layer", quoted("top")),
        Level::Layer(number) => ("layer", number.to_string()),
        Level::Height(height_m) => ("height_m", number(height_m)),
    }
}
