//! The fields of a frame, by name.

use icoray_grid::{Error, ErrorKind, Field, Layers, Location, Reals, Result, Shape};
use icoray_scene::{Heights, Scene, did_you_mean};

/// Borrowed fields by name.
///
/// A single field, `(&field).into()`, is the first one of any scene, by any name.
#[derive(Debug, Clone, Default)]
pub struct Fields<'f> {
    /// With its name, which is empty for a single field of any name.
    named: Vec<(String, Field<'f>)>,
    heights: Option<Field<'f>>,
}

impl<'f> Fields<'f> {
    /// Fields by name; the first of those with the same name counts.
    pub fn new<N: Into<String>>(named: impl IntoIterator<Item = (N, Field<'f>)>) -> Self {
        let named = named.into_iter().map(|(name, field)| (name.into(), field)).collect();
        Fields { named, ..Fields::default() }
    }

    /// Adds the heights of each column's layers, if there are any, which scenes request with
    /// [`Heights::Native`](icoray_scene::Heights).
    ///
    /// `heights` has one column per cell or per corner, and as many layers as [`Layers`](icoray_grid::Layers), in their
    /// order: metres above the planet's surface, negative below it. Heights must not decrease upwards; layers may have
    /// no thickness, as below a sea floor. A column without any height takes the mean heights of `Layers`. Heights at
    /// corners are averaged to cells as fields are ([`ComputedField`](icoray_grid::ComputedField)), over the columns that
    /// have heights. Heights are checked when a frame is drawn.
    #[must_use]
    pub fn with_heights(self, heights: impl Into<Option<Field<'f>>>) -> Self {
        Fields { heights: heights.into(), ..self }
    }

    /// Repeats the values of 2D fields, which have one layer, on each of `layers`.
    #[must_use]
    pub fn on_layers(mut self, layers: &Layers) -> Self {
        self.named.iter_mut().for_each(|(_, field)| *field = field.on_layers(layers.count()));
        self
    }

    /// The heights of each column's layers, if given.
    pub fn heights(&self) -> Option<&Field<'f>> {
        self.heights.as_ref()
    }

    /// The field `name`, if that is the scene's first; without a name, the first of all fields.
    ///
    /// # Errors
    /// As [`Fields::get`].
    pub fn first(&self, name: &str) -> Result<&Field<'f>> {
        let first = self.named.first().filter(|(known, _)| name.is_empty() || known.is_empty());
        first.map_or_else(|| self.get(name), |(_, field)| Ok(field))
    }

    /// The field called `name`.
    ///
    /// # Errors
    /// [`ErrorKind::Scene`] with the names of the fields that are there.
    pub fn get(&self, name: &str) -> Result<&Field<'f>> {
        let found = self.named.iter().find(|(known, _)| known == name);
        found.map(|(_, field)| field).ok_or_else(|| {
            let known: Vec<&str> = self.named.iter().map(|(name, _)| name.as_str()).collect();
            let hint = did_you_mean(name, known.iter().copied());
            let known = if known == [""] { "only the first field".into() } else { format!("{known:?}") };
            Error::new(ErrorKind::Scene, format!("the scene shows field {name:?}{hint}, and there is {known}"))
        })
    }

    /// The fields that `scene` needs, each by its name, in the order of [`Scene::model_fields`], and the heights if it
    /// needs them.
    ///
    /// # Errors
    /// As [`Fields::get`], also where the scene needs heights and there are none.
    pub(crate) fn needed_by(&self, scene: &Scene) -> Result<Self> {
        let of = |number, name| if number == 0 { self.first(name) } else { self.get(name) };
        let names = scene.model_fields().into_iter().enumerate();
        let named = names.map(|(number, name)| Ok((name.to_owned(), *of(number, name)?)));
        let named = named.collect::<Result<_>>()?;
        let heights = match (scene.scenery.heights, self.heights) {
            (Heights::Mean, _) => None,
            (Heights::Native, Some(heights)) => Some(heights),
            (Heights::Native, None) => {
                let message = "the scene has heights = \"native\", and no heights of columns are given";
                return Err(Error::new(ErrorKind::Scene, message));
            }
        };
        Ok(Fields { named, heights })
    }

    /// Adds those of `others` whose names are not there yet, and their heights if there are none.
    #[must_use]
    pub fn with(mut self, others: Self) -> Self {
        let is_new = |all: &[(String, Field)], name: &str| !all.iter().any(|(known, _)| known == name);
        for (name, field) in others.named {
            if is_new(&self.named, &name) {
                self.named.push((name, field));
            }
        }
        Fields { heights: self.heights.or(others.heights), ..self }
    }

    /// Names and fields.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Field<'f>)> {
        self.named.iter().map(|(name, field)| (name.as_str(), field))
    }
}

impl<'f> From<&Field<'f>> for Fields<'f> {
    fn from(field: &Field<'f>) -> Self {
        Fields::new([("", *field)])
    }
}

/// Location and shape of a field's values, independent of their storage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct FieldLayout {
    pub location: Location,
    pub columns: usize,
    pub layers: usize,
}

impl FieldLayout {
    pub fn of(field: &Field) -> Self {
        let Shape { columns, layers, .. } = *field.shape();
        FieldLayout { location: field.location(), columns, layers }
    }

    /// The level-fastest values as a field.
    pub fn field(self, values: Reals<'_>, fill: Option<f64>) -> Field<'_> {
        Field::new(values, Shape::level_fastest(self.columns, self.layers), self.location, fill)
            .expect("the values were made for this shape")
    }
}
