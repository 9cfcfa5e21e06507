//! The scenes of each grid.

use super::options::{Light, Options, Terrain};
use crate::scenes::multi_scale::{self, Opacity};
use icoray::{Error, ErrorKind, Result, Scene};

/// A transfer function, or none.
#[derive(Debug, Clone, Copy)]
pub(super) struct Case {
    pub name: &'static str,
    opacity: Option<Opacity>,
    /// Whether frusta are integrated; else rays only traverse and interpolate.
    pub integrates: bool,
}

impl Case {
    pub fn all() -> impl Iterator<Item = Case> {
        let transfer = |(name, opacity)| Case { name, opacity: Some(opacity), integrates: true };
        let walk = Case { name: "walk", opacity: None, integrates: false };
        multi_scale::TRANSFERS.into_iter().map(transfer).chain([walk])
    }
}

/// A scene of each grid.
#[derive(Debug, Clone, Copy)]
pub(super) struct Setting {
    pub case: Case,
    pub light: Light,
    pub tolerance: f64,
}

impl Setting {
    pub fn scene(&self, options: &Options) -> Result<Scene> {
        let (tolerance, precision) = (self.tolerance, &options.precision);
        let rest =
            |method: &str| format!("method = \"{method}\"\nprecision = \"{precision}\"\ntolerance = {tolerance:e}");
        let mut scene = match self.case.opacity {
            Some(opacity) => {
                let light = if self.light == Light::Lit { multi_scale::HEADLIGHT } else { "" };
                multi_scale::scene(options.pixels(), opacity, &rest(&options.method), light)?
            }
            None => {
                let mut scene = multi_scale::scene(options.pixels(), |_| 0.5, &rest("exact"), "")?;
                // One span, which contains all values.
                let knots = &mut scene.volumes[0].transfer.knots;
                *knots = vec![knots[0], knots[knots.len() - 1]];
                scene
            }
        };
        if options.heights == Terrain::Native {
            scene.scenery.heights = icoray::Heights::Native;
        }
        Ok(scene)
    }
}

impl Options {
    fn cases(&self) -> Result<Vec<Case>> {
        let find = |name: &String| {
            Case::all().find(|case| case.name == name).ok_or_else(|| {
                let there: Vec<_> = Case::all().map(|case| case.name).collect();
                let context = format!("there is no transfer function {name}; expected of {}", there.join(", "));
                Error::new(ErrorKind::Argument, context)
            })
        };
        self.transfers.iter().map(find).collect()
    }

    /// The settings of each grid. The traversal alone has one, as it depends on neither light nor tolerance.
    pub(super) fn settings(&self) -> Result<Vec<Setting>> {
        let cases = self.cases()?;
        let mut settings = Vec::new();
        for &light in &self.lights {
            for &tolerance in &self.tolerance {
                let of = |&case: &Case| Setting { case, light, tolerance };
                settings.extend(cases.iter().filter(|case| case.integrates).map(of));
            }
        }
        let walk = cases.iter().find(|case| !case.integrates);
        settings.extend(walk.map(|&case| Setting { case, light: Light::Unlit, tolerance: 1e-3 }));
        Ok(settings)
    }
}
