//! What a field is called and measured in, for people.

/// A field's name in words and its unit, as the CF conventions have them in files.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash)]
pub struct Description {
    /// CF's `long_name`, such as "Potential temperature".
    pub long_name: Option<String>,
    /// CF's `units`, such as "K" or "m s-1", as written by the model.
    pub units: Option<String>,
}
