//! The kernel of icoray on the GPU, through wgpu: compute shaders in `shaders/`, of which `shaders/kernel/X.wgsl` mirrors
//! `crates/icoray/src/kernel/X.rs` function by function. The explanations stand in the Rust files.
//!
//! A [`Gpu`] is a [`Device`](icoray::device::Device) for a [`Renderer`](icoray::Renderer): scenes in `f32`, with the CPU
//! renderer's errors and counts. Whatever else a scene asks for, and whatever a device cannot hold or does, is a
//! [`Reason`](icoray::device::Reason) to draw on the CPU instead: nothing here panics for want of a GPU.
//!
//! ```no_run
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let (scene, grid, layers, field): (icoray::Scene, icoray::Grid, icoray::Layers, icoray::Field) = todo();
//! # fn todo<T>() -> T { unimplemented!() }
//! use icoray_gpu::Gpus;
//! use std::sync::Arc;
//!
//! let renderer = icoray::Renderer::new(0)?.with_devices(Arc::new(Gpus));
//! let frame = renderer.render(&scene, &grid, &layers, &field)?;
//! println!("drawn by {}", frame.report.device.as_deref().unwrap_or("the CPU"));
//! # Ok(())
//! # }
//! ```
#![deny(unsafe_code)]

mod adapters;
mod band;
mod draw;
mod gpu;
mod gradient;
mod groups;
mod held;
mod instance;
pub mod layout;
mod light;
mod mesh;
mod part;
mod peaks;
mod readback;
mod scene;
mod select;
pub mod shader;
mod staging;
mod starts;
mod store;
mod times;

pub use adapters::{Gpus, Kind, Listed, list};
pub use gpu::{Gpu, Most};
pub use peaks::Peaks;
