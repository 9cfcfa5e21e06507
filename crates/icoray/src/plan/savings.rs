/// Optimisations of a renderer, each of which can be switched off to measure its effect: pictures stay the same within
/// their errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Savings {
    /// Rays skip blocks that the transfer function makes clear, without reading them.
    pub empty_space: bool,
    /// Rays start at the uppermost visible layer. Requires `empty_space`.
    pub layers: bool,
    /// Rays end where the light from behind is within the tolerance.
    pub ends: bool,
    /// Gradients are computed in visible blocks only, over cells that rays can pass. Requires `empty_space`.
    pub gradients: bool,
    /// Gradients are packed if the tolerance permits it.
    pub packing: bool,
    /// Frusta are integrated several at a time.
    pub lanes: bool,
    /// Tiles that miss the globe are filled without tracing their pixels.
    pub tiles: bool,
    /// Ranges, averages, visible blocks and gradients of a field are reused while the field is borrowed.
    pub reuse: bool,
}

impl Savings {
    /// All of them.
    pub const ALL: Self = Self::each(true);

    /// None of them.
    pub const NONE: Self = Self::each(false);

    const fn each(is_on: bool) -> Self {
        Savings {
            empty_space: is_on,
            layers: is_on,
            ends: is_on,
            gradients: is_on,
            packing: is_on,
            lanes: is_on,
            tiles: is_on,
            reuse: is_on,
        }
    }
}

impl Default for Savings {
    fn default() -> Self {
        Self::ALL
    }
}
