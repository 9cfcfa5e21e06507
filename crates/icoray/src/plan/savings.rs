/// What a renderer leaves out where a scene does not need it. Switched off to see what each saves: pictures are the same, or as
/// near to the exact integral as their errors say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Savings {
    /// Rays leap over what the transfer function makes clear, without reading it.
    pub leaps: bool,
    /// Rays begin at the uppermost layer that can be seen. Only where they leap.
    pub layers: bool,
    /// Rays end where what lies behind is within the tolerance.
    pub ends: bool,
    /// Gradients are computed where light can be seen. Elsewhere only where rays leap.
    pub gradients: bool,
    /// Gradients are packed, where the tolerance has room for it.
    pub packing: bool,
    /// Frusta are integrated several at a time.
    pub lanes: bool,
    /// Tiles beside the globe are not looked at pixel by pixel.
    pub tiles: bool,
    /// What was found of a field serves all pictures of it, while nobody can write to it.
    pub reuse: bool,
    /// A frame of which nothing has changed is not drawn again: the last one is given. To know that costs a pass over the field and
    /// a copy of the frame, so that it is for those who draw more often than the field changes, and not in [`Self::ALL`].
    pub unchanged: bool,
}

impl Savings {
    /// All of them that cost next to nothing.
    pub const ALL: Self = Savings {
        leaps: true,
        layers: true,
        ends: true,
        gradients: true,
        packing: true,
        lanes: true,
        tiles: true,
        reuse: true,
        unchanged: false,
    };

    /// None of them.
    pub const NONE: Self = Savings {
        leaps: false,
        layers: false,
        ends: false,
        gradients: false,
        packing: false,
        lanes: false,
        tiles: false,
        reuse: false,
        unchanged: false,
    };
}

impl Default for Savings {
    fn default() -> Self {
        Self::ALL
    }
}
