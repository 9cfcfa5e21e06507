//! Name and units of a field, for legends and messages.

/// A field's name and units as files and models give them (CF conventions' `long_name` and `units`).
#[derive(Debug, Clone, PartialEq, Eq, Default, Hash)]
pub struct Description {
    /// Long name of the field, such as "potential temperature".
    pub long_name: Option<String>,
    /// Its units, such as "m s-1".
    pub units: Option<String>,
}

/// Units of length, in lower case.
const LENGTH: [&str; 5] = ["m", "meter", "metre", "meters", "metres"];

/// Words of the names of precipitation, in lower case.
const PRECIPITATION: [&str; 4] = ["precipitation", "rain", "rainfall", "snowfall"];

impl Description {
    /// Whether the units are metres.
    pub fn is_length(&self) -> bool {
        self.units.as_ref().is_some_and(|units| LENGTH.contains(&units.to_ascii_lowercase().as_str()))
    }

    /// Whether the values are amounts or rates of precipitation, by the long name or by CF's `standard_name`.
    pub fn is_precipitation(&self, standard_name: Option<&str>) -> bool {
        let names = self.long_name.as_deref().into_iter().chain(standard_name);
        let mut words = names.flat_map(|name| name.split(|c: char| !c.is_alphanumeric()));
        words.any(|word| PRECIPITATION.contains(&word.to_lowercase().as_str()))
    }
}
