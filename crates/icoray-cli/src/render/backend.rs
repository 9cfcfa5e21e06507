//! Who draws: the CPU, or a GPU where there is one that can.

use icoray::Renderer;

/// What `--backend` asks for.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Backend {
    /// The CPU
    Cpu,
    /// A GPU, or what acts as one; the CPU for what that cannot, which is said
    Gpu,
    /// A GPU where there is a real one, else the CPU
    Auto,
}

/// The renderer with the device that `backend` asks for, or why there is none.
pub fn with_device(renderer: Renderer, backend: Backend) -> (Renderer, Option<String>) {
    if backend == Backend::Cpu {
        return (renderer, None);
    }
    match open(backend) {
        Ok(device) => (renderer.with_device(device), None),
        Err(reason) => (renderer, Some(reason)),
    }
}

#[cfg(feature = "gpu")]
fn open(backend: Backend) -> Result<std::sync::Arc<dyn icoray::device::Device>, String> {
    let gpu = icoray_gpu::Gpu::new(&icoray_gpu::Choice::Any).map_err(|reason| reason.to_string())?;
    if backend == Backend::Auto && gpu.is_processor() {
        return Err(format!("{} is a processor itself", icoray::device::Device::name(&gpu)));
    }
    Ok(std::sync::Arc::new(gpu))
}

#[cfg(not(feature = "gpu"))]
fn open(_: Backend) -> Result<std::sync::Arc<dyn icoray::device::Device>, String> {
    Err("this icoray was built without the feature \"gpu\"".into())
}
