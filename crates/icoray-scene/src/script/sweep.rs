//! Sweeps: lists of values whose product is drawn at each step.

use crate::camera::Camera;
use crate::scene::Scene;

/// The lists of a sweep; the last one varies fastest.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Sweep {
    pub axes: Vec<Axis>,
    /// The camera's values that are not swept; `Some` if its position is swept.
    pub place: Option<CameraPlace>,
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

/// A camera above a place, as [`Camera::above`] has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CameraPlace {
    pub lon_deg: f64,
    pub lat_deg: f64,
    pub distance: f64,
    pub fov_deg: f64,
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
        let mut place = self.place;
        for (axis, &number) in self.axes.iter().zip(numbers) {
            match (axis, &mut place) {
                (Axis::Lon(lon), Some(place)) => place.lon_deg = lon[number],
                (Axis::Lat(lat), Some(place)) => place.lat_deg = lat[number],
                (Axis::Distance(distance), Some(place)) => place.distance = distance[number],
                (Axis::Exaggeration(exaggeration), _) => scene.exaggeration = exaggeration[number],
                (Axis::Field(field), _) => scene.volumes[0].field.clone_from(&field[number]),
                (Axis::Lon(_) | Axis::Lat(_) | Axis::Distance(_), None) => {
                    unreachable!("a camera that is swept has a place")
                }
            }
        }
        if let Some(CameraPlace { lon_deg, lat_deg, distance, fov_deg }) = place {
            let camera = Camera::above(lon_deg, lat_deg, distance, fov_deg);
            scene.camera = camera.expect("swept numbers are finite and in range");
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
