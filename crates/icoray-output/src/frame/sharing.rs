//! The distribution of a picture over ranks.

use icoray_scene::Scheme;
use std::fmt;

/// The distribution of a picture over ranks, with the reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sharing {
    /// Tiles or fragments.
    pub scheme: Scheme,
    why: &'static str,
    /// How ranks obtained the field, if they were given columns of it.
    gathered: Option<&'static str>,
}

impl Sharing {
    /// A scheme with the reason for it.
    pub fn because(scheme: Scheme, why: &'static str) -> Self {
        Sharing { scheme, why, gathered: None }
    }

    /// The scheme for a field that was gathered in each node's memory, or in each rank's own if none could be shared;
    /// with the grid, if ranks have parts of it.
    pub fn of_gathered(self, has_parts: bool, is_refused: bool) -> Self {
        let gathered = match (has_parts, is_refused) {
            (false, false) => "the field is assembled once per node",
            (false, true) => "the field is assembled once per rank, as nodes cannot share memory",
            (true, false) => "its ranks' parts and the field are assembled once per node",
            (true, true) => "parts and the field are assembled once per rank, as nodes cannot share memory",
        };
        let is_of_node = has_parts && !is_refused && self.scheme == Scheme::Tiles;
        let why = if is_of_node { "each node has the whole grid" } else { self.why };
        Sharing { gathered: Some(gathered), why, ..self }
    }
}

impl fmt::Display for Sharing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let scheme = if self.scheme == Scheme::Fragments { "fragments" } else { "tiles" };
        write!(f, "{scheme}: {}", self.why)?;
        self.gathered.map_or(Ok(()), |gathered| write!(f, ", {gathered}"))
    }
}
