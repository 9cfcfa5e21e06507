//! Options that change a scene: its camera, size, quality and device.

use crate::gpu;
use icoray::{Adapter, Backend, Error, ErrorKind, LightSource, Lighting, Lines, Result, Scene, Script};

/// Options that replace keys of a scene.
#[derive(clap::Args)]
pub struct Overrides {
    /// Longitude below the camera, degrees; also instead of the scene's. The camera then looks at the planet's centre
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = lon)]
    pub lon: Option<f64>,
    /// Latitude below the camera, degrees; as --lon
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = lat)]
    pub lat: Option<f64>,
    /// Distance of the camera from the planet's centre, planet radii; as --lon
    #[arg(long, value_name = "RADII", allow_hyphen_values = true, value_parser = factor)]
    pub distance: Option<f64>,
    /// Factor on heights; also instead of the scene's
    #[arg(long, value_name = "X", allow_hyphen_values = true, value_parser = factor)]
    pub exaggeration: Option<f64>,
    /// CSS colour behind everything, or "transparent"; also instead of the scene's
    #[arg(long, value_name = "COLOR", value_parser = background)]
    pub background: Option<String>,
    /// "headlight", "none", or longitude and latitude below a sun, such as 90,20; also instead of the scene's
    #[arg(long, value_name = "KIND", allow_hyphen_values = true, value_parser = light)]
    pub light: Option<Light>,
    /// Draw the borders between countries, if the planet is the Earth; also on the ground of a scene
    #[arg(long)]
    pub borders: bool,
    /// Draw no title and no colour bar
    #[arg(long)]
    pub no_labels: bool,
    /// Processor that draws, instead of the scene's backend
    #[arg(long, value_name = "BACKEND", value_parser = gpu::backend())]
    pub backend: Option<Backend>,
    /// One of several GPUs, instead of the scene's device: its number in `icoray devices`, or a part of its name
    #[arg(long, value_name = "N|NAME")]
    pub device: Option<Adapter>,
    /// Picture size in pixels, instead of the scene's
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<(u32, u32)>,
    /// Largest error allowed in a channel of a pixel, 0 to 1, instead of the scene's
    #[arg(long, value_name = "E", allow_hyphen_values = true, value_parser = tolerance)]
    pub tolerance: Option<f64>,
    /// Most rays per pixel, 1 to 64, whose mean it shows, instead of the scene's
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(Scene::MAX_SAMPLES)))]
    pub samples: Option<u32>,
}

/// The source of light; none without one.
#[derive(Clone, Copy)]
pub struct Light(pub Option<LightSource>);

type Parsed<T> = std::result::Result<T, String>;

fn within(text: &str, min: f64, max: f64) -> Parsed<f64> {
    let number = text.parse().ok().filter(|number| (min..=max).contains(number));
    number.ok_or_else(|| format!("expected a number from {min} to {max}"))
}

fn lon(text: &str) -> Parsed<f64> {
    within(text, -360.0, 360.0)
}

fn lat(text: &str) -> Parsed<f64> {
    within(text, -90.0, 90.0)
}

/// The scene of these keys alone, and a field.
fn scene_of(keys: &str) -> Result<Scene> {
    Scene::parse(&format!("field = \"any\"\n{keys}"))
}

fn background(text: &str) -> Parsed<String> {
    let expected = |_| "expected an opaque CSS colour such as #ff8800 or black, or \"transparent\"".to_owned();
    scene_of(&format!("background = {text:?}")).map(|_| text.to_owned()).map_err(expected)
}

fn light(text: &str) -> Parsed<Light> {
    let place = text.split_once(',').and_then(|(at_lon, at_lat)| Some((lon(at_lon).ok()?, lat(at_lat).ok()?)));
    match (text, place) {
        ("none", _) => Ok(Light(None)),
        ("headlight", _) => Ok(Light(Some(LightSource::Headlight))),
        (_, Some((lon_deg, lat_deg))) => Ok(Light(Some(LightSource::Sun { lon_deg, lat_deg }))),
        _ => Err("expected headlight, none, or longitude and latitude below a sun, such as 90,20".to_owned()),
    }
}

fn factor(text: &str) -> Parsed<f64> {
    within(text, 1e-6, 1e6)
}

fn size(text: &str) -> Parsed<(u32, u32)> {
    let side = |t: &str| t.parse().ok().filter(|s| (1..=16384).contains(s));
    let sides = text.split_once('x');
    sides
        .and_then(|(w, h)| Some((side(w)?, side(h)?)))
        .ok_or_else(|| "expected WxH with sides of 1 to 16384 pixels, such as 640x480".to_owned())
}

fn tolerance(text: &str) -> Parsed<f64> {
    let (low, high) = (Scene::TOLERANCE.start(), Scene::TOLERANCE.end());
    let tolerance = text.parse().ok().filter(|t| Scene::TOLERANCE.contains(t));
    tolerance.ok_or_else(|| format!("expected a number from {low:e} to {high}"))
}

impl Overrides {
    /// Fails if an option is given, for a scene that only its text determines.
    pub fn expect_none(&self) -> Result<()> {
        let given = [
            ("--lon", self.lon.is_some()),
            ("--lat", self.lat.is_some()),
            ("--distance", self.distance.is_some()),
            ("--exaggeration", self.exaggeration.is_some()),
            ("--background", self.background.is_some()),
            ("--light", self.light.is_some()),
            ("--borders", self.borders),
            ("--no-labels", self.no_labels),
            ("--size", self.size.is_some()),
            ("--tolerance", self.tolerance.is_some()),
            ("--samples", self.samples.is_some()),
            ("--backend", self.backend.is_some()),
            ("--device", self.device.is_some()),
        ];
        match given.into_iter().find(|(_, is_given)| *is_given) {
            Some((option, _)) => {
                let context = format!("{option}: expected no such option beside --scene; it is set on the page");
                Err(Error::new(ErrorKind::Argument, context))
            }
            None => Ok(()),
        }
    }

    pub fn apply(&self, script: &mut Script) -> Result<()> {
        let camera = script.set_camera(self.lon, self.lat, self.distance);
        camera.map_err(|e| e.within("--lon, --lat, --distance"))?;
        if let Some(exaggeration) = self.exaggeration {
            script.set_exaggeration(exaggeration).map_err(|e| e.within("--exaggeration"))?;
        }
        for scene in script.scenes_mut() {
            if let Some((width, height)) = self.size {
                (scene.width, scene.height) = (width, height);
            }
            if let Some(tolerance) = self.tolerance {
                scene.tolerance = tolerance;
            }
            if let Some(background) = &self.background {
                scene.background = scene_of(&format!("background = {background:?}"))?.background;
            }
            if let Some(Light(source)) = self.light {
                let usual = scene.lighting.or(scene_of("[light]")?.lighting);
                scene.lighting = source.and_then(|source| Some(Lighting { source, ..usual? }));
            }
            if self.borders {
                if scene.core.is_none() {
                    let context = "--borders: borders lie on the ground, and the scene's core is \"transparent\"; expected \
                                   another core, or [[lines]] with pattern = \"borders\" and on = \"top\" in the scene";
                    return Err(Error::new(ErrorKind::Scene, context));
                }
                let borders = scene_of("[[lines]]\npattern = \"borders\"\nwidth = 0.8\nopacity = 0.5")?;
                let is_missing = |lines: &Lines| !scene.scenery.lines.iter().any(|own| own.pattern == lines.pattern);
                let borders: Vec<_> = borders.scenery.lines.into_iter().filter(is_missing).collect();
                scene.scenery.lines.extend(borders);
            }
            if self.no_labels {
                scene.labels = None;
            }
            scene.samples = self.samples.unwrap_or(scene.samples);
            scene.backend = self.backend.unwrap_or(scene.backend);
            scene.device = self.device.clone().or(scene.device.take());
        }
        Ok(())
    }
}
