//! The device that draws a scene.

use std::fmt;

/// The device that traces rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Backend {
    /// A GPU where there is one, else the CPU.
    #[default]
    Auto,
    /// The CPU.
    Cpu,
    /// A GPU, or a processor that acts as one; the CPU where there is neither, and for what they cannot do.
    Gpu,
}

/// Which of several GPUs.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Adapter {
    /// The one of this number, from 0 (`icoray devices` lists them).
    Number(usize),
    /// Devices whose name contains this text, in any case.
    Name(String),
}

/// Text of a user: a number, or else a part of a name.
impl From<&str> for Adapter {
    fn from(text: &str) -> Self {
        text.parse().map_or_else(|_| Adapter::Name(text.to_owned()), Adapter::Number)
    }
}

impl fmt::Display for Adapter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Adapter::Number(number) => write!(f, "{number}"),
            Adapter::Name(name) => write!(f, "{name:?}"),
        }
    }
}
