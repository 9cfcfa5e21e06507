//! Layer radii and the shell of a scene.

use crate::error::{Error, ErrorKind, Result};
use std::hash::{DefaultHasher, Hash, Hasher};

/// The radii of a field's layers.
///
/// ```
/// use icoray_grid::Layers;
///
/// // Interfaces of a model's layers, surface first, in metres above a sphere with the Earth's radius.
/// let interfaces = Layers::from_heights(&[0.0, 500.0, 2e3, 12e3], 6.371e6)?;
/// let levels = interfaces.midpoints()?;
/// assert_eq!((interfaces.count(), levels.count()), (4, 3));
/// assert_eq!(levels.radius_m()[0], 6.371e6 + 250.0);
/// # Ok::<(), icoray_grid::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Layers {
    radius_m: Vec<f64>,
    planet_radius_m: f64,
}

impl Layers {
    /// Layers at `radius_m`, measured from the planet's centre, in the order of the field's layers: strictly rising
    /// (surface first) or strictly falling (top first), any spacing.
    ///
    /// # Units
    /// Metres, or any one unit for both arguments. Rendering is in planet radii.
    ///
    /// # Errors
    /// [`ErrorKind::Layers`] names the first layer that is not finite, not positive or not strictly monotone, counted
    /// from 1; also for heights in place of radii, or other units: those that begin below a hundredth of the planet's
    /// radius and end below half of it, and those above a hundred planet radii.
    pub fn new(radius_m: Vec<f64>, planet_radius_m: f64) -> Result<Self> {
        let count = radius_m.len();
        let bad = |context| Err(Error::new(ErrorKind::Layers, context));
        if !(planet_radius_m.is_finite() && planet_radius_m > 0.0) {
            return bad(format!("planet radius {planet_radius_m}, expected a positive number"));
        }
        if radius_m.len() < 2 {
            return bad(format!("{} layers, expected at least 2", radius_m.len()));
        }
        if let Some(l) = radius_m.iter().position(|r| !(r.is_finite() && *r > 0.0)) {
            return bad(format!(
                "layer {} of {count}: radius {}, expected a positive number: radii are from the planet's centre",
                l + 1,
                radius_m[l]
            ));
        }
        let rising = radius_m[1] > radius_m[0];
        if let Some(l) = radius_m.windows(2).position(|w| w[0] == w[1] || (w[1] > w[0]) != rising) {
            return bad(format!(
                "layers {} and {} of {count}: radii {} and {}, expected strictly {} as between the first two",
                l + 1,
                l + 2,
                radius_m[l],
                radius_m[l + 1],
                if rising { "rising" } else { "falling" }
            ));
        }
        let [first, last] = [radius_m[0], radius_m[count - 1]];
        let near = |radius: f64| (0.5..2.0).contains(&(radius / planet_radius_m));
        let advice = if near(1e3 * first) && near(1e3 * last) {
            "the radii look like kilometres, the planet's radius like metres: give both in metres"
        } else if near(1e-3 * first) && near(1e-3 * last) {
            "the radii look like metres, the planet's radius like kilometres: give both in metres"
        } else {
            "add that to heights"
        };
        let [low, high] = [first.min(last), first.max(last)].map(|radius| radius / planet_radius_m);
        if low < 0.01 && high < 0.5 || low > 100.0 {
            return bad(format!(
                "radii {first} to {last}, expected radii from the planet's centre, whose surface is at {planet_radius_m}: \
                 {advice}"
            ));
        }
        Ok(Layers { radius_m, planet_radius_m })
    }

    /// Layers at heights above (or, negative, below) the surface of a planet, in the unit of its radius.
    ///
    /// # Errors
    /// As [`Layers::new`].
    pub fn from_heights(height_m: &[f64], planet_radius_m: f64) -> Result<Self> {
        Self::new(height_m.iter().map(|h| planet_radius_m + h).collect(), planet_radius_m)
    }

    /// Number of layers.
    pub fn count(&self) -> usize {
        self.radius_m.len()
    }

    /// The radii as given, in the order of the field's layers.
    pub fn radius_m(&self) -> &[f64] {
        &self.radius_m
    }

    /// The planet's radius, in the unit of the layers' radii.
    pub fn planet_radius_m(&self) -> f64 {
        self.planet_radius_m
    }

    /// The lowest and the highest height over the planet's surface.
    fn height_range(&self) -> [f64; 2] {
        let [a, b] = [self.radius_m[0], self.radius_m[self.count() - 1]].map(|r| r - self.planet_radius_m);
        [a.min(b), a.max(b)]
    }

    /// Number of layers, range of heights and a hash of all radii, as text: different radii give different text.
    pub fn describe(&self) -> String {
        let mut hasher = DefaultHasher::new();
        self.radius_m.iter().chain([&self.planet_radius_m]).for_each(|radius| radius.to_bits().hash(&mut hasher));
        let [low, high] = self.height_range();
        format!("{}, at heights {low} to {high} m (hash {:016x})", self.count(), hasher.finish())
    }

    /// The layers midway between these: where full levels lie when these are the interfaces.
    ///
    /// # Errors
    /// [`ErrorKind::Layers`] when there are fewer than 3 interfaces.
    pub fn midpoints(&self) -> Result<Self> {
        Self::new(self.radius_m.windows(2).map(|w| 0.5 * (w[0] + w[1])).collect(), self.planet_radius_m)
    }

    /// The layers on which a field with `layers` layers lies: these, or, with one fewer, those midway between.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] when the number fits neither.
    pub fn for_field(&self, layers: usize) -> Result<Self> {
        let bad = |expected: String| Err(Error::new(ErrorKind::Field, format!("{layers} layers, expected {expected}")));
        match self.count() {
            n if layers == n => Ok(self.clone()),
            n if layers + 1 == n && layers > 1 => self.midpoints(),
            2 => bad("2 (on the layers)".into()),
            n => bad(format!("{n} (on the layers) or {} (midway between them)", n - 1)),
        }
    }

    /// Whether the field's first layer is the outermost.
    pub fn is_falling(&self) -> bool {
        self.radius_m[0] > self.radius_m[1]
    }

    /// Radii in planet radii, rising, heights above the planet's surface stretched by `exaggeration`.
    ///
    /// # Errors
    /// [`ErrorKind::Scene`] when the stretched layers reach the planet's centre or are no longer apart.
    pub fn shell(&self, exaggeration: f64) -> Result<Vec<f64>> {
        let stretch = |r: &f64| 1.0 + exaggeration * (r - self.planet_radius_m) / self.planet_radius_m;
        let mut shell: Vec<f64> = self.radius_m.iter().map(stretch).collect();
        if self.is_falling() {
            shell.reverse();
        }
        let fine = shell[0] > 0.0 && shell.windows(2).all(|w| w[0] < w[1]) && shell.iter().all(|r| r.is_finite());
        if !fine {
            let [low, high] = self.height_range();
            let context = format!(
                "exaggeration {exaggeration}: heights {low} to {high} m are stretched to {} to {} m, expected layers \
                 that stay apart, above the planet's centre at {} m",
                exaggeration * low,
                exaggeration * high,
                -self.planet_radius_m
            );
            return Err(Error::new(ErrorKind::Scene, context));
        }
        Ok(shell)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_radii_are_named() {
        for (radii, part) in [
            (vec![1.0], "1 layers"),
            (vec![1.0, f64::NAN, 3.0], "layer 2 of 3"),
            (vec![1.0, 2.0, 2.0], "layers 2 and 3 of 3"),
            (vec![1.0, 2.0, 1.5], "strictly rising"),
            (vec![3.0, 2.0, 2.5], "strictly falling"),
            (vec![-1.0, 2.0], "layer 1 of 2: radius -1"),
            (vec![0.0, 2.0], "radii are from the planet's centre"),
            (vec![0.005, 0.1], "expected radii from the planet's centre"),
            (vec![0.4, 0.001], "add that to heights"),
            (vec![1e-3, 1.02e-3], "the radii look like kilometres, the planet's radius like metres"),
            (vec![1020.0, 1000.0], "the radii look like metres, the planet's radius like kilometres"),
        ] {
            let error = Layers::new(radii, 1.0).unwrap_err();
            assert!(error.to_string().contains(part), "{error}");
        }
        assert!(Layers::new(vec![1.0, 2.0], 0.0).is_err());
        // The inner half of a planet, and heights that reach beyond half of a small one's radius.
        assert!(Layers::new(vec![0.02, 0.3], 1.0).is_ok() && Layers::new(vec![0.005, 0.6], 1.0).is_ok());
    }

    #[test]
    fn a_stretch_beyond_the_centre_is_reported_in_metres() {
        let layers = Layers::from_heights(&[-11e3, 0.0], 6.371e6).unwrap();
        let error = layers.shell(600.0).unwrap_err().to_string();
        let said = "exaggeration 600: heights -11000 to 0 m are stretched to -6600000 to 0 m";
        assert!(error.contains(said) && error.contains("centre at -6371000 m"), "{error}");
    }

    #[test]
    fn a_field_lies_on_the_layers_or_midway_between() {
        let layers = Layers::new(vec![1.0, 2.0, 4.0], 1.0).unwrap();
        assert_eq!(layers.for_field(3).unwrap(), layers);
        assert_eq!(layers.for_field(2).unwrap().radius_m(), [1.5, 3.0]);
        for (count, wrong) in [(3, 1), (3, 4), (2, 1)] {
            let layers = Layers::new((1..=count).map(f64::from).collect(), 1.0).unwrap();
            assert_eq!(layers.for_field(wrong).unwrap_err().kind(), ErrorKind::Field, "{count} {wrong}");
        }
    }

    #[test]
    fn falling_layers_make_the_same_shell() {
        let up = Layers::from_heights(&[0.0, 1.0, 3.0], 10.0).unwrap();
        let down = Layers::from_heights(&[3.0, 1.0, 0.0], 10.0).unwrap();
        assert_eq!(up.shell(2.0).unwrap(), down.shell(2.0).unwrap());
        assert_eq!(up.shell(2.0).unwrap()[2], 1.6);
        assert_eq!(up.midpoints().unwrap().radius_m(), [10.5, 12.0]);
    }
}
