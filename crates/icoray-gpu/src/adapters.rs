//! The Vulkan instance, without extensions for windows; the adapters of this machine, and the choice of one.

use icoray::Adapter;
use icoray::device::{DeviceRequest, FallbackReason};
use std::ffi::CStr;
use std::path::Path;
use std::sync::OnceLock;
use std::{fmt, fs};
use wgpu::hal::{InstanceDescriptor, api::Vulkan, vulkan};

/// Prefixes of the names of GPU device nodes: NVIDIA's own driver, Windows' below Linux, Adreno, Mali.
const NODES: [&str; 4] = ["nvidia", "dxg", "kgsl", "mali"];

/// The kind of an adapter. Faster kinds compare as less.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A GPU with its own memory.
    Discrete,
    /// A GPU that shares the processor's memory.
    Integrated,
    /// A virtual GPU.
    Virtual,
    /// A CPU driver such as lavapipe, which is no faster than the CPU renderer.
    Processor,
}

impl From<wgpu::DeviceType> for Kind {
    fn from(of: wgpu::DeviceType) -> Self {
        match of {
            wgpu::DeviceType::DiscreteGpu => Kind::Discrete,
            wgpu::DeviceType::IntegratedGpu => Kind::Integrated,
            wgpu::DeviceType::VirtualGpu => Kind::Virtual,
            wgpu::DeviceType::Cpu | wgpu::DeviceType::Other => Kind::Processor,
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Kind::Discrete => "discrete GPU",
            Kind::Integrated => "integrated GPU",
            Kind::Virtual => "virtual GPU",
            Kind::Processor => "processor that acts as a GPU",
        })
    }
}

/// An adapter of this machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Listed {
    /// Name.
    pub name: String,
    /// Name and version of the driver.
    pub driver: String,
    /// Kind.
    pub kind: Kind,
}

impl Listed {
    fn of(adapter: &wgpu::Adapter) -> Self {
        let wgpu::AdapterInfo { name, driver, driver_info, device_type, .. } = adapter.get_info();
        Listed { name, driver: format!("{driver} {driver_info}"), kind: device_type.into() }
    }
}

/// The adapters of this machine, in the order of their numbers.
///
/// # Errors
/// A [`FallbackReason`] if there is no Vulkan.
pub fn list() -> Result<&'static [Listed], FallbackReason> {
    // Once per process: enumeration takes about 0.1 s and loads every driver.
    static LISTED: OnceLock<Result<Vec<Listed>, FallbackReason>> = OnceLock::new();
    let listed = LISTED.get_or_init(|| Ok(adapters()?.iter().map(Listed::of).collect()));
    listed.as_deref().map_err(Clone::clone)
}

fn adapters() -> Result<Vec<wgpu::Adapter>, FallbackReason> {
    let instance = instance()?;
    let all = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::VULKAN));
    if all.iter().any(|adapter| Listed::of(adapter).kind != Kind::Processor) {
        KEPT.get_or_init(|| instance);
    }
    Ok(all)
}

/// The number of the adapter that `wanted` selects: among those that fit, one of the fastest kind. The ranks of a node
/// take them in turn.
fn choose(all: &[Listed], wanted: &DeviceRequest) -> Result<usize, FallbackReason> {
    let names = || all.iter().map(|one| one.name.as_str()).collect::<Vec<_>>();
    let fits = |(number, one): &(usize, &Listed)| match &wanted.adapter {
        None => true,
        Some(Adapter::Number(wish)) => number == wish,
        Some(Adapter::Name(part)) => one.name.to_lowercase().contains(&part.to_lowercase()),
    };
    let fitting: Vec<_> = all.iter().enumerate().filter(fits).collect();
    let Some(kind) = fitting.iter().map(|(_, one)| one.kind).min() else {
        return Err(FallbackReason::new(match &wanted.adapter {
            Some(Adapter::Number(number)) if !all.is_empty() => {
                format!("no adapter has the number {number} of {:?}", names())
            }
            Some(Adapter::Name(part)) if !all.is_empty() => {
                format!("no adapter is named {part:?} of {:?}", names())
            }
            _ => "no Vulkan adapter was found".into(),
        }));
    };
    let fastest: Vec<_> = fitting.into_iter().filter(|(_, one)| one.kind == kind).collect();
    let (number, one) = fastest[wanted.node_rank % fastest.len()];
    if kind == Kind::Processor && !wanted.or_processor {
        let reason = format!("{} is a processor, which only backend = \"gpu\" uses", one.name);
        return Err(FallbackReason::new(reason));
    }
    Ok(number)
}

/// Whether there is any GPU, by the nodes that Linux's drivers create for them in `dev`; on other systems always true.
fn may_have_gpu(dev: &Path) -> bool {
    let has_node = |folder: &Path, names: &[&str]| {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        let mut nodes = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
        nodes.any(|node| names.iter().any(|name| node.starts_with(name)))
    };
    cfg!(not(target_os = "linux")) || has_node(&dev.join("dri"), &["renderD"]) || has_node(dev, &NODES)
}

/// Finds the adapter that `wanted` selects. `dev` is the folder of device nodes.
///
/// The loader of Vulkan loads all drivers, and with that of a processor a compiler, which takes 50 MB of the model's
/// memory. So no driver is loaded if only a GPU is wanted and there is none.
pub(crate) fn find(wanted: &DeviceRequest, dev: &Path) -> Result<wgpu::Adapter, FallbackReason> {
    if wanted.adapter.is_none() && !wanted.or_processor && !may_have_gpu(dev) {
        let reason = "no GPU was found; backend = \"gpu\" uses a processor that acts as one";
        return Err(FallbackReason::new(reason));
    }
    let listed = list()?;
    let number = choose(listed, wanted)?;
    let adapter = adapters()?.into_iter().nth(number).filter(|adapter| Listed::of(adapter) == listed[number]);
    adapter.ok_or_else(|| FallbackReason::new(format!("{} is no longer available", listed[number].name)))
}

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

#[cfg(test)]
mod tests {
    use super::*;

    fn listed(kinds: &[(&str, Kind)]) -> Vec<Listed> {
        kinds.iter().map(|(name, kind)| Listed { name: (*name).into(), driver: String::new(), kind: *kind }).collect()
    }

    fn wanted(adapter: Option<Adapter>, node_rank: usize) -> DeviceRequest {
        DeviceRequest { adapter, or_processor: false, node_rank }
    }

    #[test]
    fn ranks_of_a_node_take_the_fastest_adapters_in_turn() {
        let node = listed(&[
            ("llvmpipe", Kind::Processor),
            ("NVIDIA H100", Kind::Discrete),
            ("Intel", Kind::Integrated),
            ("NVIDIA H100", Kind::Discrete),
            ("AMD", Kind::Discrete),
        ]);
        let of = |adapter: Option<Adapter>| {
            (0..5).map(|rank| choose(&node, &wanted(adapter.clone(), rank)).unwrap()).collect::<Vec<_>>()
        };
        assert_eq!(of(None), [1, 3, 4, 1, 3]);
        assert_eq!(of(Some(Adapter::Name("nvidia".into()))), [1, 3, 1, 3, 1]);
        assert_eq!(of(Some(Adapter::Name("INTEL".into()))), [2; 5]);
        assert_eq!(of(Some(Adapter::Number(4))), [4; 5]);
    }

    /// Set in the process that looks for a GPU where there is none.
    #[cfg(target_os = "linux")]
    const CHILD: &str = "ICORAY_TEST_DEVICE_NODES";

    /// In a process of its own, as other tests load drivers.
    #[cfg(target_os = "linux")]
    #[test]
    fn no_driver_is_loaded_where_there_is_no_gpu() {
        if let Some(dev) = std::env::var_os(CHILD) {
            let reason = find(&wanted(None, 0), Path::new(&dev)).unwrap_err().to_string();
            assert!(reason.starts_with("no GPU was found"), "{reason}");
            let loaded = fs::read_to_string("/proc/self/maps").unwrap();
            assert!(!loaded.contains("vulkan") && !loaded.contains("LLVM"), "{loaded}");
            return;
        }
        let dev = tempfile::tempdir().unwrap();
        fs::create_dir(dev.path().join("dri")).unwrap();
        // A graphics card without rendering, as servers have for their consoles.
        fs::write(dev.path().join("dri/card0"), "").unwrap();
        let test = "adapters::tests::no_driver_is_loaded_where_there_is_no_gpu";
        let mut command = std::process::Command::new(std::env::current_exe().unwrap());
        let output = command.args(["--exact", test, "--test-threads=1"]).env(CHILD, dev.path()).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
        for node in ["dri/renderD128", "nvidia0", "dxg"] {
            assert!(!may_have_gpu(dev.path()), "{node}");
            fs::write(dev.path().join(node), "").unwrap();
            assert!(may_have_gpu(dev.path()), "{node}");
            fs::remove_file(dev.path().join(node)).unwrap();
        }
    }

    /// Also a processor, unless it is asked for.
    #[test]
    fn missing_adapters_are_reported() {
        let node = listed(&[("llvmpipe", Kind::Processor)]);
        assert_eq!(choose(&node, &DeviceRequest { or_processor: true, ..wanted(None, 3) }), Ok(0));
        for (adapters, adapter, words) in [
            (&node[..], None, "llvmpipe is a processor"),
            (&node[..0], None, "no Vulkan adapter"),
            (&node[..0], Some(Adapter::Number(0)), "no Vulkan adapter"),
            (&node, Some(Adapter::Number(1)), "no adapter has the number 1 of [\"llvmpipe\"]"),
            (&node, Some(Adapter::Name("B".into())), "no adapter is named \"B\" of [\"llvmpipe\"]"),
        ] {
            let reason = choose(adapters, &wanted(adapter, 0)).unwrap_err().to_string();
            assert!(reason.contains(words), "{reason}");
        }
    }
}
