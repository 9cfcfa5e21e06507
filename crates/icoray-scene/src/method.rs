//! How pieces of rays are integrated.

/// How a piece is integrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// f linear over the piece, colour the mean of its ends (the paper's piecewise linear approximation).
    Paper,
    /// The bend of f kept, colour to the scene's tolerance.
    #[default]
    Exact,
}
