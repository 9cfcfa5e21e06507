//! The device that renders, and the list of GPUs.

use crate::input::one_of;
use clap::builder::TypedValueParser;
use icoray::device::FallbackReason;
use icoray::{Backend, Renderer, Result, Scene};

/// The parser of `--backend`.
pub fn backend() -> impl TypedValueParser<Value = Backend> {
    one_of([
        ("auto", Backend::Auto, "A GPU if there is a real one, else the CPU"),
        ("cpu", Backend::Cpu, "The CPU"),
        (
            "gpu",
            Backend::Gpu,
            "A GPU, or a processor that acts as one; the CPU for scenes that it does not support, with a note",
        ),
    ])
}

/// A renderer that may use the GPUs of the machine.
pub fn renderer(threads: usize) -> Result<Renderer> {
    let renderer = Renderer::new(threads)?;
    #[cfg(feature = "gpu")]
    let renderer = renderer.with_devices(std::sync::Arc::new(icoray_gpu::Gpus));
    Ok(renderer)
}

/// Describes the processor that rendered: `device`, or the CPU with the reason, or both.
pub fn drawn_on(device: Option<&str>, left_to_cpu: Option<&str>) -> String {
    match (device, left_to_cpu) {
        (None, None) => "the CPU".into(),
        (Some(device), None) => device.into(),
        (None, Some(reason)) => format!("the CPU: {reason}"),
        (Some(device), Some(reason)) => format!("{device}, in part the CPU: {reason}"),
    }
}

/// Describes the processor that would render a scene.
pub fn would_draw(renderer: &Renderer, scene: &Scene) -> String {
    match renderer.device_for(scene, 0) {
        Ok(device) => drawn_on(Some(&device.name()), None),
        Err(reason) => drawn_on(None, reason.as_ref().map(FallbackReason::to_string).as_deref()),
    }
}

/// One line for each GPU.
#[cfg(feature = "gpu")]
pub fn list() -> Vec<String> {
    let listed = match icoray_gpu::list() {
        Ok([]) => return vec!["no Vulkan adapter was found".into()],
        Ok(listed) => listed,
        Err(reason) => return vec![reason.to_string()],
    };
    let line =
        |(number, one): (usize, &icoray_gpu::Listed)| format!("{number}  {} ({}, {})", one.name, one.kind, one.driver);
    listed.iter().enumerate().map(line).collect()
}

/// A line that this build has no GPU support.
#[cfg(not(feature = "gpu"))]
pub fn list() -> Vec<String> {
    vec!["this icoray was built without the GPU".into()]
}
