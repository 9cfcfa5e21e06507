//! Values of fields that a scene names: those that the kernels' arithmetic represents.

use crate::scene::Scene;
use icoray_grid::{Error, ErrorKind, Result, numbers};
use std::ops::RangeInclusive;

/// Magnitudes that values other than 0 may have.
#[derive(Debug)]
pub(super) struct Magnitudes {
    pub range: RangeInclusive<f64>,
    /// Valid values in words.
    pub text: &'static str,
}

/// Those of the transfer function of a volume without surfaces: differences and their inverses are normal numbers.
pub(super) const ALONE: Magnitudes =
    Magnitudes { range: 1e-290..=1e290, text: "0 or a magnitude from 1e-290 to 1e290" };
/// Those of all other scenes: squares, and squares of differences in the last digit, are normal numbers.
pub(super) const SQUARED: Magnitudes =
    Magnitudes { range: 1e-130..=1e100, text: "0 or a magnitude from 1e-130 to 1e100" };

impl Magnitudes {
    /// Whether kernels can find the places where a field takes this value.
    pub fn contain(&self, value: f64) -> bool {
        value == 0.0 || self.range.contains(&value.abs())
    }
}

impl Scene {
    /// Checks the values of all transfer functions, whose range may come from a field, and of isosurfaces.
    ///
    /// # Errors
    /// [`ErrorKind::Scene`] where kernels cannot represent one.
    pub fn check_values(&self) -> Result<()> {
        let magnitudes = if self.has_volume_alone() { ALONE } else { SQUARED };
        let refuse = |value: f64, field: &str, what: &str| {
            let message = format!("{what} {} of {field:?}, expected {}", numbers::text(value), magnitudes.text);
            Err(Error::new(ErrorKind::Scene, message))
        };
        let opacities = self.volumes.iter().filter_map(|volume| volume.opacity.as_ref());
        let opacities = opacities.map(|by| (by.field.as_str(), &by.transfer));
        let colors = self.paintings().into_iter().map(|painting| (painting.field, painting.transfer));
        for (field, transfer) in colors.chain(opacities) {
            if let Some(knot) = transfer.knots.iter().find(|knot| !magnitudes.contain(knot.value)) {
                return refuse(knot.value, field, "the transfer function's value");
            }
        }
        let outside = self.scenery.isosurfaces.iter().find(|surface| !magnitudes.contain(surface.value));
        outside.map_or(Ok(()), |surface| refuse(surface.value, &surface.field, "the isosurface's value"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(transfer: &str, more: &str) -> Result<Scene> {
        Scene::parse(&format!(
            "field = \"f\"\n[camera]\nlon = 0\nlat = 0\ndistance = 3\n[transfer]\n{transfer}\n{more}"
        ))
    }

    fn knots(values: [&str; 2]) -> String {
        let knot = |value: &str| format!("{{ value = {value}, color = \"red\", opacity = 0.5 }}");
        format!("knots = [{}]", values.map(knot).join(", "))
    }

    fn isosurface(value: &str) -> String {
        format!("[[isosurfaces]]\nfield = \"f\"\nvalue = {value}\ncolor = \"red\"")
    }

    #[test]
    fn values_that_the_kernels_represent_are_accepted() {
        for ends in [["-1e100", "1e100"], ["0.0", "1e-130"], ["-1e-130", "-0.0"], ["1e-130", "1e-130"]] {
            parsed(&knots(ends), &isosurface(ends[1])).unwrap().check_values().unwrap();
        }
        for ends in [["-1e290", "1e290"], ["0.0", "1e-290"], ["-1e-290", "-0.0"], ["1e-290", "1e-290"]] {
            parsed(&knots(ends), "").unwrap().check_values().unwrap();
        }
    }

    #[test]
    fn other_values_are_refused_with_their_key() {
        for value in ["1e291", "1.7e308", "1e-291", "5e-324"] {
            let map = "map = \"viridis\"\nopacity = [[0, 0.5], [1, 0.5]]\n";
            let stops = format!("map = \"viridis\"\nrange = [0, 1]\nopacity = [[0, 0.5], [{value}, 0.5]]");
            for (key, scene) in [
                ("transfer.knots", parsed(&knots(["-1.0", value]).replace("-1.0", &format!("-{value}")), "")),
                ("transfer.knots", parsed(&knots(["0.0", value]), "")),
                ("transfer.range", parsed(&format!("{map}range = [0, {value}]"), "")),
                ("transfer.center", parsed(&format!("{map}range = [-1, 1]\ncenter = {value}"), "")),
                ("transfer.opacity", parsed(&stops, "")),
            ] {
                let text = scene.unwrap_err().to_string();
                assert!(text.contains(&format!("key {key}")) && text.contains(ALONE.text), "{value}: {text}");
            }
        }
        for value in ["1e101", "-1e101", "1.7e308", "1e-131", "-5e-324"] {
            let text = parsed(&knots(["0.0", "1.0"]), &isosurface(value)).unwrap_err().to_string();
            let key = text.contains("key isosurfaces.value");
            assert!(key && text.contains(SQUARED.text), "{value}: {text}");
        }
    }

    #[test]
    fn limits_of_values_depend_on_the_other_parts_of_a_scene() {
        let scene = parsed(&knots(["0.0", "1.0"]), &isosurface("0.5")).unwrap();
        let mut high = scene.clone();
        high.volumes[0].transfer.knots[1].value = 1e200;
        let mut small = scene;
        small.scenery.isosurfaces[0].value = -1e-200;
        let mut plain = high.clone();
        plain.scenery.isosurfaces.clear();
        plain.check_values().unwrap();
        plain.volumes[0].transfer.knots[1].value = 1e300;
        for (scene, value, magnitudes) in [
            (high, "function's value 1e200 of \"f\"", SQUARED),
            (small, "isosurface's value -1e-200", SQUARED),
            (plain, "function's value 1e300", ALONE),
        ] {
            let error = scene.check_values().unwrap_err();
            assert_eq!(error.kind(), ErrorKind::Scene);
            assert!(error.context().contains(value) && error.context().contains(magnitudes.text), "{error}");
        }
    }
}
