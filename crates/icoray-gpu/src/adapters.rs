//! Which of a machine's adapters draws.

use crate::gpu::{Gpu, Most, because};
use crate::instance::instance;
use icoray::Adapter;
use icoray::device::{Device, Devices, Reason, Wanted};
use std::fmt;
use std::sync::{Arc, OnceLock};

/// Kinds of adapters, the fastest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A GPU with memory of its own.
    Discrete,
    /// A GPU that shares the processor's memory.
    Integrated,
    /// A part of a GPU, or of another machine's.
    Virtual,
    /// A processor that acts as a GPU, which is no faster than the CPU renderer.
    Processor,
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
    /// Its name.
    pub name: String,
    /// Its driver's name and version.
    pub driver: String,
    /// What it is.
    pub kind: Kind,
}

impl Listed {
    fn of(adapter: &wgpu::Adapter) -> Self {
        let wgpu::AdapterInfo { name, driver, driver_info, device_type, .. } = adapter.get_info();
        let kind = match device_type {
            wgpu::DeviceType::DiscreteGpu => Kind::Discrete,
            wgpu::DeviceType::IntegratedGpu => Kind::Integrated,
            wgpu::DeviceType::VirtualGpu => Kind::Virtual,
            wgpu::DeviceType::Cpu | wgpu::DeviceType::Other => Kind::Processor,
        };
        Listed { name, driver: format!("{driver} {driver_info}"), kind }
    }
}

/// The adapters of this machine, in the order of their numbers.
///
/// # Errors
/// A [`Reason`] where there is no Vulkan.
pub fn list() -> Result<&'static [Listed], Reason> {
    // Looked for once in a process: it takes a tenth of a second, and loads every driver.
    static LISTED: OnceLock<Result<Vec<Listed>, Reason>> = OnceLock::new();
    let listed = LISTED.get_or_init(|| Ok(adapters()?.iter().map(Listed::of).collect()));
    listed.as_deref().map_err(Clone::clone)
}

fn adapters() -> Result<Vec<wgpu::Adapter>, Reason> {
    Ok(pollster::block_on(instance()?.enumerate_adapters(wgpu::Backends::VULKAN)))
}

/// The number of the adapter that is wanted: of those that fit one of the fastest kind, another for each rank of the node.
fn choose(all: &[Listed], wanted: &Wanted) -> Result<usize, Reason> {
    let names = || all.iter().map(|one| one.name.as_str()).collect::<Vec<_>>();
    let fits = |(number, one): &(usize, &Listed)| match &wanted.adapter {
        None => true,
        Some(Adapter::Number(wish)) => number == wish,
        Some(Adapter::Name(part)) => one.name.to_lowercase().contains(&part.to_lowercase()),
    };
    let fitting: Vec<_> = all.iter().enumerate().filter(fits).collect();
    let Some(kind) = fitting.iter().map(|(_, one)| one.kind).min() else {
        return because(match &wanted.adapter {
            Some(Adapter::Number(number)) if !all.is_empty() => {
                format!("no adapter has the number {number} of {:?}", names())
            }
            Some(Adapter::Name(part)) if !all.is_empty() => {
                format!("no adapter is named {part:?} of {:?}", names())
            }
            _ => "no Vulkan adapter was found".into(),
        });
    };
    let fastest: Vec<_> = fitting.into_iter().filter(|(_, one)| one.kind == kind).collect();
    let (number, one) = fastest[wanted.node_rank % fastest.len()];
    if kind == Kind::Processor && !wanted.or_processor {
        return because(format!("{} is a processor, which only backend = \"gpu\" uses", one.name));
    }
    Ok(number)
}

/// The GPUs of this machine, for a renderer.
#[derive(Debug, Clone, Copy, Default)]
pub struct Gpus;

impl Devices for Gpus {
    fn open(&self, wanted: &Wanted) -> Result<Arc<dyn Device>, Reason> {
        Ok(Arc::new(open(wanted, Most::default())?))
    }
}

fn open(wanted: &Wanted, most: Most) -> Result<Gpu, Reason> {
    let listed = list()?;
    let number = choose(listed, wanted)?;
    match adapters()?.get(number).filter(|adapter| Listed::of(adapter) == listed[number]) {
        Some(adapter) => Gpu::open(adapter, most),
        None => because(format!("{} is no longer available", listed[number].name)),
    }
}

impl Gpu {
    /// Opens the adapter, or the fastest one, be it a processor that acts as a GPU.
    ///
    /// # Errors
    /// A [`Reason`] where there is no such adapter, or it cannot do what the kernel needs.
    pub fn new(adapter: Option<Adapter>) -> Result<Self, Reason> {
        Self::with_most(adapter, Most::default())
    }

    /// [`Self::new`], but no more than `most` of it is used.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_most(adapter: Option<Adapter>, most: Most) -> Result<Self, Reason> {
        open(&Wanted { adapter, or_processor: true, node_rank: 0 }, most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn listed(kinds: &[(&str, Kind)]) -> Vec<Listed> {
        kinds
            .iter()
            .map(|(name, kind)| Listed { name: (*name).into(), driver: String::new(), kind: *kind })
            .collect()
    }

    fn wanted(adapter: Option<Adapter>, node_rank: usize) -> Wanted {
        Wanted { adapter, or_processor: false, node_rank }
    }

    #[test]
    fn ranks_of_a_node_go_to_the_fastest_in_turn() {
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

    #[test]
    fn processors_are_taken_where_they_are_asked_for() {
        let node = listed(&[("llvmpipe", Kind::Processor)]);
        let reason = choose(&node, &wanted(None, 0)).unwrap_err().to_string();
        assert!(reason.contains("llvmpipe is a processor"), "{reason}");
        assert_eq!(choose(&node, &Wanted { or_processor: true, ..wanted(None, 3) }), Ok(0));
    }

    #[test]
    fn what_is_not_there_is_said() {
        let node = listed(&[("A", Kind::Discrete)]);
        for (adapters, adapter, words) in [
            (&node[..0], None, "no Vulkan adapter"),
            (&node[..0], Some(Adapter::Number(0)), "no Vulkan adapter"),
            (&node, Some(Adapter::Number(1)), "no adapter has the number 1 of [\"A\"]"),
            (&node, Some(Adapter::Name("B".into())), "no adapter is named \"B\" of [\"A\"]"),
        ] {
            let reason = choose(adapters, &wanted(adapter, 0)).unwrap_err().to_string();
            assert!(reason.contains(words), "{reason}");
        }
    }
}
