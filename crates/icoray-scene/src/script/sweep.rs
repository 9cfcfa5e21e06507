//! Sweeps: lists of values whose product is drawn at each step.

use crate::camera::Camera;
use crate::scene::Scene;

/// The lists of a sweep; the last one varies fastest.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Sweep {
    pub axes: Vec<Axis>,
}

/// A list of values, at least one.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Axis {
    Lon(Vec<f64>),
    Lat(Vec<f64>),
    Distance(Vec<f64>),
    Exaggeration(Vec<f64>),
    Field(Vec<String>),
}

impl Axis {
    /// Its key in `[sweep]`, its placeholder, and its column in a database.
    pub fn name(&self) -> &'static str {
        match self {
            Axis::Lon(_) => "lon",
            Axis::Lat(_) => "lat",
            Axis::Distance(_) => "distance",
            Axis::Exaggeration(_) => "exaggeration",
            Axis::Field(_) => "field",
        }
    }

    fn len(&self) -> usize {
        match self {
            Axis::Lon(v) | Axis::Lat(v) | Axis::Distance(v) | Axis::Exaggeration(v) => v.len(),
            Axis::Field(names) => names.len(),
        }
    }

    fn text(&self, number: usize, of_value: fn(f64) -> String) -> String {
        match self {
            Axis::Lon(v) | Axis::Lat(v) | Axis::Distance(v) | Axis::Exaggeration(v) => of_value(v[number]),
            Axis::Field(names) => names[number].clone(),
        }
    }

    pub fn is_of_camera(&self) -> bool {
        matches!(self, Axis::Lon(_) | Axis::Lat(_) | Axis::Distance(_))
    }
}

impl Sweep {
    /// Number of pictures; 1 for an empty sweep.
    pub fn count(&self) -> usize {
        self.axes.iter().map(Axis::len).product()
    }

    /// All combinations: for each list, the index of a value.
    pub fn combinations(&self) -> impl Iterator<Item = Vec<usize>> {
        (0..self.count()).map(|number| {
            let mut rest = number;
            let mut numbers: Vec<usize> = Vec::with_capacity(self.axes.len());
            for axis in self.axes.iter().rev() {
                numbers.push(rest % axis.len());
                rest /= axis.len();
            }
            numbers.reverse();
            numbers
        })
    }

    /// Names and values of a combination; `of_value` writes numbers.
    pub fn values(&self, numbers: &[usize], of_value: fn(f64) -> String) -> Vec<(&'static str, String)> {
        let axes = self.axes.iter().zip(numbers);
        axes.map(|(axis, number)| (axis.name(), axis.text(*number, of_value))).collect()
    }

    /// Applies a combination to the scene.
    pub fn apply(&self, scene: &mut Scene, numbers: &[usize]) {
        let [mut lon, mut lat, mut distance, fov] = scene.camera.place();
        for (axis, &number) in self.axes.iter().zip(numbers) {
            match axis {
                Axis::Lon(values) => lon = values[number],
                Axis::Lat(values) => lat = values[number],
                Axis::Distance(values) => distance = values[number],
                Axis::Exaggeration(values) => scene.exaggeration = values[number],
                Axis::Field(names) => scene.volumes[0].field.clone_from(&names[number]),
            }
        }
        if self.axes.iter().any(Axis::is_of_camera) {
            scene.camera = Camera::above(lon, lat, distance, fov).expect("swept numbers are finite and in range");
        }
    }

    /// Whether the sweep has a list of that name.
    pub fn has(&self, name: &str) -> bool {
        self.axes.iter().any(|axis| axis.name() == name)
    }

    /// The fields that the sweep names.
    pub fn fields(&self) -> &[String] {
        let fields = self.axes.iter().find_map(|axis| match axis {
            Axis::Field(names) => Some(names.as_slice()),
            _ => None,
        });
        fields.unwrap_or_default()
    }
}
