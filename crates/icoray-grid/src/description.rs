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

impl Description {
    /// Whether the units are metres.
    pub fn is_length(&self) -> bool {
        self.units.as_ref().is_some_and(|units| LENGTH.contains(&units.to_ascii_lowercase().as_str()))
    }
}
