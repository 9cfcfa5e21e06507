//! Vulkan without windows.

use crate::gpu::because;
use icoray::device::Reason;
use std::ffi::CStr;
use wgpu::hal::vulkan;
use wgpu::hal::{InstanceDescriptor, api::Vulkan};

/// What wgpu asks for on top, so that windows could be drawn on. Where they are asked for, Mesa looks for a display, which may be
/// at the other end of a network, and libwayland prints an error where there is none.
const DISPLAYS: [&CStr; 3] = [c"VK_KHR_xlib_surface", c"VK_KHR_xcb_surface", c"VK_KHR_wayland_surface"];

/// Whether the program has a dynamic linker, without which drivers cannot be loaded: glibc would try, and may crash.
#[cfg(target_os = "linux")]
#[allow(unsafe_code)]
fn has_dynamic_linker() -> bool {
    // SAFETY: asks for a number, the address of the dynamic linker that the kernel has loaded.
    unsafe { libc::getauxval(libc::AT_BASE) != 0 }
}

#[cfg(not(target_os = "linux"))]
fn has_dynamic_linker() -> bool {
    true
}

/// Vulkan, if it is here.
#[allow(unsafe_code)]
pub(crate) fn instance() -> Result<wgpu::Instance, Reason> {
    if !has_dynamic_linker() {
        return because("the program is wholly static, and can load no drivers");
    }
    let descriptor = InstanceDescriptor {
        name: "icoray",
        flags: wgpu::InstanceFlags::default(),
        memory_budget_thresholds: Default::default(),
        backend_options: Default::default(),
        telemetry: None,
        display: None,
    };
    let no_displays = |args: vulkan::CreateInstanceCallbackArgs| {
        args.extensions.retain(|extension| !DISPLAYS.contains(extension));
    };
    // SAFETY: what the callback takes away is looked at where a surface is made only, and none is.
    let instance = unsafe { vulkan::Instance::init_with_callback(&descriptor, Some(Box::new(no_displays))) };
    let instance = instance.or_else(|_| because("no Vulkan adapter was found"))?;
    // SAFETY: the instance was just made, of the kind that it says.
    Ok(unsafe { wgpu::Instance::from_hal::<Vulkan>(instance) })
}
