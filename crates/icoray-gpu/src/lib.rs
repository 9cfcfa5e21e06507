//! The kernel of icoray on the GPU, through wgpu: compute shaders in `shaders/`, of which `shaders/kernel/X.wgsl` mirrors
//! `crates/icoray/src/kernel/X.rs` function by function. The explanations stand in the Rust files.
//!
//! Unlit scenes in `f32` are drawn, with the CPU renderer's errors and counts. Whatever else a scene asks for, and whatever a
//! device cannot hold or does, is a [`Reason`] to draw on the CPU instead: nothing here panics for want of a GPU.
//!
//! ```no_run
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let (scene, grid, layers, field): (icoray::Scene, icoray::Grid, icoray::Layers, icoray::Field) = todo();
//! # fn todo<T>() -> T { unimplemented!() }
//! use icoray_gpu::{Choice, Gpu, Outcome};
//!
//! let renderer = icoray::Renderer::new(0)?;
//! let gpu = Gpu::new(&Choice::Any)?;
//! let mesh = gpu.mesh(&grid)?;
//! let frame = match gpu.render(&renderer, &scene, &mesh, &layers, &field)? {
//!     Outcome::Drawn(frame) => *frame,
//!     Outcome::Left(reason) => {
//!         eprintln!("drawn on the CPU: {reason}");
//!         renderer.render(&scene, &grid, &layers, &field)?
//!     }
//! };
//! # Ok(())
//! # }
//! ```
#![forbid(unsafe_code)]

mod draw;
mod gpu;
pub mod layout;
mod mesh;
mod peaks;
mod scene;
pub mod shader;
mod times;

pub use gpu::{Choice, Gpu, Reason};
pub use mesh::Mesh;
pub use peaks::Peaks;

use icoray::Frame;

/// What became of a scene that was to be drawn.
#[derive(Debug)]
pub enum Outcome {
    /// The picture.
    Drawn(Box<Frame>),
    /// It is for the CPU.
    Left(Reason),
}
