//! Gradients at the vertices, computed when somebody first asks: a device that computes its own does not.

use std::fmt;
use std::sync::OnceLock;

/// Those of a picture, level-fastest; none where it is drawn without light.
pub(crate) struct Gradients<'f> {
    known: OnceLock<Vec<[f32; 3]>>,
    compute: Box<dyn Fn() -> Vec<[f32; 3]> + Send + Sync + 'f>,
}

impl<'f> Gradients<'f> {
    /// What `compute` gives, on the threads of whoever asks first.
    pub fn of(compute: impl Fn() -> Vec<[f32; 3]> + Send + Sync + 'f) -> Self {
        Gradients { known: OnceLock::new(), compute: Box::new(compute) }
    }

    pub fn get(&self) -> &[[f32; 3]] {
        self.known.get_or_init(&self.compute)
    }

    /// To be completed by others.
    pub fn get_mut(&mut self) -> &mut [[f32; 3]] {
        self.get();
        self.known.get_mut().map_or(&mut [], |known| known)
    }

    /// Bytes that they take, if anybody has asked.
    pub fn bytes(&self) -> usize {
        self.known.get().map_or(0, |known| size_of_val(known.as_slice()))
    }

    /// Their memory.
    pub fn into_memory(self) -> Vec<[f32; 3]> {
        self.known.into_inner().unwrap_or_default()
    }
}

impl fmt::Debug for Gradients<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Gradients").field("bytes", &self.bytes()).finish_non_exhaustive()
    }
}
