//! The Vulkan instance, without extensions for windows.

use icoray::device::FallbackReason;
use std::ffi::CStr;
use std::sync::OnceLock;
use wgpu::hal::{InstanceDescriptor, api::Vulkan, vulkan};

/// Window-system extensions, which wgpu requests by default. With them Mesa connects to a display, possibly over a
/// network, and libwayland prints an error if there is none.
const WINDOW_EXTENSIONS: [&CStr; 3] = [c"VK_KHR_xlib_surface", c"VK_KHR_xcb_surface", c"VK_KHR_wayland_surface"];

/// Whether the program has a dynamic linker. Without one drivers cannot be loaded: glibc tries to, and may crash.
#[cfg(target_os = "linux")]
#[allow(unsafe_code)]
fn has_dynamic_linker() -> bool {
    // SAFETY: reads a number, the address of the dynamic linker that the kernel has loaded.
    unsafe { libc::getauxval(libc::AT_BASE) != 0 }
}

#[cfg(not(target_os = "linux"))]
fn has_dynamic_linker() -> bool {
    true
}

/// Vulkan where there is a GPU; the first list of adapters, which is made once, sets it.
static KEPT: OnceLock<wgpu::Instance> = OnceLock::new();

/// Opens Vulkan. Where there is a GPU, it stays open until the process ends.
///
/// # Errors
/// A [`FallbackReason`] if there is no Vulkan loader, or the program cannot load drivers.
pub fn instance() -> Result<wgpu::Instance, FallbackReason> {
    KEPT.get().cloned().map_or_else(open, Ok)
}

/// Keeps Vulkan open.
pub(crate) fn keep(instance: wgpu::Instance) {
    KEPT.get_or_init(|| instance);
}

#[allow(unsafe_code)]
fn open() -> Result<wgpu::Instance, FallbackReason> {
    if !has_dynamic_linker() {
        return Err(FallbackReason::new("the program is wholly static, and can load no drivers"));
    }
    let descriptor = InstanceDescriptor {
        name: "icoray",
        flags: wgpu::InstanceFlags::default(),
        memory_budget_thresholds: Default::default(),
        backend_options: Default::default(),
        telemetry: None,
        display: None,
    };
    let without_windows = |args: vulkan::CreateInstanceCallbackArgs| {
        args.extensions.retain(|extension| !WINDOW_EXTENSIONS.contains(extension));
    };
    // SAFETY: wgpu uses the removed extensions to create surfaces only, and this crate creates none.
    let instance = unsafe { vulkan::Instance::init_with_callback(&descriptor, Some(Box::new(without_windows))) };
    let instance = instance.map_err(|_| FallbackReason::new("no Vulkan adapter was found"))?;
    // SAFETY: the instance was created above, by the Vulkan backend.
    Ok(unsafe { wgpu::Instance::from_hal::<Vulkan>(instance) })
}
