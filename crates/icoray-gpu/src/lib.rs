//! icoray's kernel on the GPU, through wgpu. The compute shader `shaders/kernel/X.wgsl` mirrors
//! `crates/icoray-kernel/src/X.rs` function by function; the Rust files explain the algorithms.
//!
//! A [`Gpu`] is a [`Device`](icoray::device::Device) of a [`Renderer`](icoray::Renderer). It draws scenes in `f32`,
//! with the errors and counts of the CPU renderer. The CPU draws scenes that the shaders do not support or that do not
//! fit on the device; a [`FallbackReason`](icoray::device::FallbackReason) states the reason. Nothing panics if there
//! is no GPU.
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
//! println!("drawn by {}", frame.report.device.name.as_deref().unwrap_or("the CPU"));
//! # Ok(())
//! # }
//! ```
#![deny(unsafe_code)]

mod adapters;
mod bands;
mod context;
mod culling;
mod device_field;
mod field_store;
mod gpu;
pub mod layout;
mod mesh;
mod peaks;
mod picture;
mod pieces;
mod pipelines;
mod pool;
mod readback;
mod scenery;
pub mod shader;
mod staging;
mod timestamps;
mod trace_fragments;
mod trace_pixels;

pub use adapters::{Kind, Listed, instance, list};
pub use gpu::{Gpu, Gpus, MemoryLimits};
pub use peaks::Peaks;
