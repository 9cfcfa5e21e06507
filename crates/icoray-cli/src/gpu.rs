//! Options for the device that renders, and the list of GPUs.

use icoray::device::FallbackReason;
use icoray::{Adapter, Renderer, Result, Scene};

/// The processor that draws, if the command names one.
#[derive(clap::Args)]
pub struct DeviceOptions {
    /// Processor that draws, instead of the scene's backend
    #[arg(long, value_name = "BACKEND", value_enum)]
    backend: Option<Backend>,
    /// One of several GPUs, instead of the scene's device: its number in `icoray devices`, or a part of its name
    #[arg(long, value_name = "N|NAME")]
    device: Option<Adapter>,
}

/// [`icoray::Backend`] as an option.
#[derive(Clone, Copy, clap::ValueEnum)]
enum Backend {
    /// A GPU if there is a real one, else the CPU
    Auto,
    /// The CPU
    Cpu,
    /// A GPU, or a processor that acts as one; the CPU for scenes that it does not support, with a note
    Gpu,
}

impl DeviceOptions {
    /// The options, and whether each is given.
    pub fn given(&self) -> [(&'static str, bool); 2] {
        [("--backend", self.backend.is_some()), ("--device", self.device.is_some())]
    }

    /// Overrides backend and device of the scene.
    pub fn apply(&self, scene: &mut Scene) {
        if let Some(backend) = self.backend() {
            scene.backend = backend;
        }
        if self.device.is_some() {
            scene.device.clone_from(&self.device);
        }
    }

    pub fn backend(&self) -> Option<icoray::Backend> {
        self.backend.map(|word| match word {
            Backend::Auto => icoray::Backend::Auto,
            Backend::Cpu => icoray::Backend::Cpu,
            Backend::Gpu => icoray::Backend::Gpu,
        })
    }

    pub fn device(&self) -> Option<&Adapter> {
        self.device.as_ref()
    }
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
