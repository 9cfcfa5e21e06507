//! The scenes of each grid.

use super::options::{Light, Options};
use crate::scenes::multi_scale::{self, Opacity};
use crate::scenes::select;
use icoray::{Result, Scene};

/// A transfer function, or none.
#[derive(Debug, Clone, Copy)]
pub(super) struct Case {
    pub name: &'static str,
    opacity: Opacity,
    /// Whether frusta are integrated; else rays only traverse and interpolate.
    pub integrates: bool,
}

impl Case {
    pub fn all() -> impl Iterator<Item = Case> {
        let transfer = |(name, opacity)| Case { name, opacity, integrates: true };
        let walk = Case { name: "walk", opacity: |_| 0.5, integrates: false };
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
    /// Transfer function, light and tolerance.
    pub fn name(&self) -> String {
        format!("{} {} {:e}", self.case.name, self.light, self.tolerance)
    }

    pub fn scene(&self, options: &Options) -> Result<Scene> {
        let Options { method, precision, heights, .. } = options;
        let method = if self.case.integrates { method } else { "exact" };
        let rest = format!(
            "method = \"{method}\"\nprecision = \"{precision}\"\nheights = \"{heights}\"\ntolerance = {:e}",
            self.tolerance
        );
        let rest = if options.hollow { format!("core = \"transparent\"\n{rest}") } else { rest };
        let light = if self.light == Light::Lit { multi_scale::HEADLIGHT } else { "" };
        let mut scene = multi_scale::scene(options.pixels(), self.case.opacity, &rest, light)?;
        if !self.case.integrates {
            // One span, which contains all values.
            let knots = &mut scene.volumes[0].transfer.knots;
            *knots = vec![knots[0], knots[knots.len() - 1]];
        }
        Ok(scene)
    }
}

impl Options {
    /// The settings of each grid. The traversal alone has one, as it depends on neither light nor tolerance.
    pub(super) fn settings(&self) -> Result<Vec<Setting>> {
        let cases = select(Case::all().collect(), &self.transfers, |case| case.name)?;
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
