//! What is drawn.

use super::Options;
use crate::scenes::multi_scale::{self, Opacity};
use icoray::{Result, Scene};

/// A transfer function, or none.
#[derive(Debug, Clone, Copy)]
pub(super) struct Case {
    pub name: &'static str,
    opacity: Option<Opacity>,
    /// Whether frusta are integrated: else rays walk and interpolate, and lay aside what would be.
    pub integrates: bool,
}

impl Case {
    pub fn all() -> impl Iterator<Item = Case> {
        let transfer = |(name, opacity)| Case { name, opacity: Some(opacity), integrates: true };
        let walk = Case { name: "walk", opacity: None, integrates: false };
        multi_scale::TRANSFERS.into_iter().map(transfer).chain([walk])
    }
}

/// Whether a scene is lit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Light {
    /// Emission and absorption only.
    Unlit,
    /// By a headlight.
    Lit,
}

impl Light {
    pub(super) fn name(self) -> &'static str {
        match self {
            Light::Unlit => "unlit",
            Light::Lit => "lit",
        }
    }
}

impl std::fmt::Display for Light {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
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
        let rest = |method: &str| {
            format!("method = \"{method}\"\nprecision = \"{precision}\"\ntolerance = {tolerance:e}")
        };
        match self.case.opacity {
            Some(opacity) => {
                let light = if self.light == Light::Lit { "[light]\nkind = \"headlight\"" } else { "" };
                multi_scale::scene(options.pixels(), opacity, &rest(&options.method), light)
            }
            None => {
                let mut scene = multi_scale::scene(options.pixels(), |_| 0.5, &rest("exact"), "")?;
                // One span, that no value leaves.
                let knots = &mut scene.transfer.knots;
                *knots = vec![knots[0], knots[knots.len() - 1]];
                Ok(scene)
            }
        }
    }
}
