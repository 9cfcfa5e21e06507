//! Vulkan without windows.

use std::ffi::CStr;
use wgpu::hal::vulkan;
use wgpu::hal::{InstanceDescriptor, api::Vulkan};

/// What wgpu asks for on top, so that windows could be drawn on. Where they are asked for, Mesa looks for a display, which may be
/// at the other end of a network, and libwayland prints an error where there is none.
const DISPLAYS: [&CStr; 3] = [c"VK_KHR_xlib_surface", c"VK_KHR_xcb_surface", c"VK_KHR_wayland_surface"];

/// Vulkan, if it is here.
#[allow(unsafe_code)]
pub(crate) fn instance() -> Option<wgpu::Instance> {
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
    // SAFETY: the instance was just made, of the kind that it says.
    instance.ok().map(|instance| unsafe { wgpu::Instance::from_hal::<Vulkan>(instance) })
}
