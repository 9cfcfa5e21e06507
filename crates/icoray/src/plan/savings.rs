/// What a renderer leaves out where a scene does not need it. Switched off to see what each saves; pictures are the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Savings {
    /// Rays leap over what the transfer function makes clear, without reading it.
    pub leaps: bool,
    /// Frusta are integrated several at a time.
    pub lanes: bool,
}

impl Savings {
    /// All of them.
    pub const ALL: Self = Savings { leaps: true, lanes: true };
}

impl Default for Savings {
    fn default() -> Self {
        Self::ALL
    }
}
