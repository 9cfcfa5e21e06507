//! The renderer itself: its threads, its devices, and its cache between pictures.

use super::frame_cache::FrameCache;
use super::levels::LevelChoice;
use crate::derive::DerivedFieldCache;
use crate::device::{Device, DeviceRequest, Devices, FallbackReason, unsupported};
use crate::plan::Savings;
use crate::ranges::Ranges;
use fearless_simd::Level;
use icoray_grid::Error;
use icoray_grid::threads::Threads;
use icoray_grid::vectors::packets;
use icoray_scene::{Backend, Precision, Scene};
use std::collections::HashMap;
use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// A renderer with its own threads, which end when it is dropped, and optionally a device.
///
/// ```
/// use icoray::{Field, Grid, IcosahedralMesh, Layers, Location, Renderer, Scene};
///
/// let mesh = IcosahedralMesh::new(2)?;
/// let grid = Grid::new(mesh.tables())?;
/// let layers = Layers::from_heights(&[0.0, 1e6], 6.371e6)?;
/// let values = vec![1.0f32; 2 * grid.cells()];
/// let field = Field::level_fastest(&values, 2, Location::Center)?;
/// let scene = Scene::parse(
///     "field = 'one'
///      image = { width = 8, height = 8 }
///      camera = { lon = 0, lat = 0, distance = 3 }
///      transfer = { map = 'viridis', range = [0, 2], opacity = [[0, 0.5], [2, 0.5]] }",
/// )?;
/// let renderer = Renderer::new(1)?;
/// let frame = renderer.render(&scene, &grid, &layers, &field)?;
/// // Premultiplied linear RGBA, row by row from the top left.
/// assert_eq!((frame.width, frame.height, frame.pixels.len()), (8, 8, 64));
/// assert!(f64::from(frame.error[0]) <= 1e-3);
/// # Ok::<(), icoray::Error>(())
/// ```
#[derive(Debug)]
pub struct Renderer {
    pub(crate) threads: Threads,
    devices: Option<Arc<dyn Devices>>,
    /// The outcomes of all requests for a device so far.
    opened: Mutex<HashMap<DeviceRequest, OpenedDevice>>,
    pub(super) savings: Savings,
    pub(super) integrates: bool,
    pub(super) level_choice: LevelChoice,
    pub(super) progress: Option<Progress>,
    pub(super) stop: Option<Arc<AtomicBool>>,
    pub(super) memory_limit: Option<u64>,
    pub(super) frame_cache: FrameCache,
    pub(super) ranges: Ranges,
    pub(super) derived: DerivedFieldCache,
}

impl Renderer {
    /// A renderer with `threads` threads, or as many as the affinity mask allows for 0.
    ///
    /// # Errors
    /// [`ErrorKind::Io`](icoray_grid::ErrorKind::Io) when the threads cannot be started.
    pub fn new(threads: usize) -> icoray_grid::Result<Self> {
        Ok(Renderer {
            threads: Threads::new(threads)?,
            devices: None,
            opened: Mutex::default(),
            savings: Savings::ALL,
            integrates: true,
            level_choice: LevelChoice::Finest,
            progress: None,
            stop: None,
            memory_limit: None,
            frame_cache: FrameCache::default(),
            ranges: Ranges::default(),
            derived: DerivedFieldCache::default(),
        })
    }

    /// Sets the optimisations: for measurements.
    #[must_use]
    pub fn with_savings(self, savings: Savings) -> Self {
        Renderer { savings, frame_cache: self.frame_cache.with_reuse(savings.reuse), ..self }
    }

    /// Rays only walk and interpolate: frusta of unlit `exact` scenes are stored for integration in batches, which is
    /// left out. For measurements.
    #[doc(hidden)]
    #[must_use]
    pub fn without_integrals(self) -> Self {
        Renderer { integrates: false, ..self }
    }

    /// Traces pictures on coarser grids, made of some of the cells, where the error that this adds is within the
    /// tolerance, or where a time budget leaves no time for the grid itself. For fields that are drawn many times, as
    /// by a page: the second picture of a field's values without a time budget makes the grids, once per grid, in as
    /// much time as several pictures, and finds the largest differences of values, in less time than a picture.
    ///
    /// Applies to a single volume between concentric layers in f32, of grids of more than 64,000 cells, on the CPU, in
    /// one process, without a memory limit. [`Quality::level`](icoray_scene::Quality::level) says which grid was used.
    #[must_use]
    pub fn with_levels(self) -> Self {
        Renderer { level_choice: LevelChoice::WithinTolerance, ..self }
    }

    /// Traces pictures on this level of detail, or on the coarsest one of a grid with fewer, whatever its error, from
    /// the first picture and for grids of more than 800 cells. For measurements.
    #[doc(hidden)]
    #[must_use]
    pub fn on_level(self, level: u32) -> Self {
        Renderer { level_choice: LevelChoice::Fixed(level), ..self }
    }

    /// The machine's vector instructions, if rays are traced in packets.
    pub(super) fn vectors(&self) -> Option<Level> {
        self.savings.lanes.then(packets).flatten()
    }

    /// Adds devices, which trace rays of scenes that request it ([`Scene::backend`]), as far as they support them.
    #[must_use]
    pub fn with_devices(self, devices: Arc<dyn Devices>) -> Self {
        Renderer { devices: Some(devices), opened: Mutex::default(), ..self }
    }

    /// Adds one device.
    #[must_use]
    pub fn with_device(self, device: Arc<dyn Device>) -> Self {
        self.with_devices(Arc::new(SingleDevice(device)))
    }

    /// Calls `report(finished, total)` after each tile of a picture that this process draws, from the thread that drew
    /// it. `total` is the number of these tiles. The calls of one picture come in any order; there are none for probes
    /// of a time budget and for pixels that are traced again after the last tile: those at edges, or all if the scene
    /// requests several samples.
    ///
    /// ```
    /// use std::sync::Arc;
    ///
    /// let renderer = icoray::Renderer::new(1)?
    ///     .with_progress(Arc::new(|finished, total| eprintln!("{finished} of {total} tiles")));
    /// # Ok::<(), icoray::Error>(())
    /// ```
    #[must_use]
    pub fn with_progress(self, report: Arc<dyn Fn(usize, usize) + Send + Sync>) -> Self {
        Renderer { progress: Some(Progress(report)), ..self }
    }

    /// Traces no more tiles while `stop` is set: a frame that is being drawn is then returned soon, incomplete. For
    /// frames that are out of date before they are finished.
    ///
    /// Over several ranks, either all ranks or none set it.
    #[must_use]
    pub fn with_stop(self, stop: Arc<AtomicBool>) -> Self {
        Renderer { stop: Some(stop), ..self }
    }

    /// Whether the frame that is being drawn is to be abandoned.
    pub(super) fn is_stopped(&self) -> bool {
        self.stop.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed))
    }

    /// Limits the memory of a frame, beyond that kept from previous frames, to `bytes` bytes:
    /// [`Plan::memory`](crate::Plan::memory) returns the memory of a frame. The default limit is the system's free
    /// memory.
    #[must_use]
    pub fn with_memory_limit(self, bytes: u64) -> Self {
        Renderer { memory_limit: Some(bytes), ..self }
    }

    /// Number of threads.
    pub fn threads(&self) -> usize {
        self.threads.count()
    }

    /// Runs `work` on the renderer's threads: parallel passes inside use them and no others.
    pub fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        self.threads.run(work)
    }

    /// The device that would draw `scene`, opened if it was not yet; `Err(None)` if the scene requests none. Among the
    /// ranks on a node this is number `node_rank`.
    ///
    /// # Errors
    /// A [`FallbackReason`] why the CPU draws although the scene requests a device.
    pub fn device_for(&self, scene: &Scene, node_rank: usize) -> Result<Arc<dyn Device>, Option<FallbackReason>> {
        if scene.backend == Backend::Cpu {
            return Err(None);
        }
        let Some(devices) = &self.devices else {
            let reason = FallbackReason::new("this icoray was built without the GPU");
            return Err((scene.backend == Backend::Gpu).then_some(reason));
        };
        if scene.samples > 1 {
            return Err(Some(FallbackReason::new(format!("the scene asks for samples = {}", scene.samples))));
        }
        if scene.precision == Precision::F64 {
            return Err(Some(FallbackReason::new("the scene asks for precision = \"f64\"")));
        }
        if let Some(reason) = unsupported(scene) {
            return Err(Some(FallbackReason::new(reason)));
        }
        let adapter = scene.device.clone();
        let wanted = DeviceRequest { adapter, or_processor: scene.backend == Backend::Gpu, node_rank };
        // A panic of the driver falls back to the CPU.
        let open = |wanted: &DeviceRequest| {
            let opened = Error::of_panics(|| Ok(devices.open(wanted)));
            opened.unwrap_or_else(|panic| Err(FallbackReason::new(panic.to_string())))
        };
        let mut opened = self.opened.lock().unwrap_or_else(PoisonError::into_inner);
        opened.entry(wanted).or_insert_with_key(open).clone().map_err(Some)
    }
}

/// The device of a picture; `Err(None)` if the scene requests none.
pub(super) type DeviceChoice = Result<Arc<dyn Device>, Option<FallbackReason>>;

/// The outcome of opening a device.
type OpenedDevice = Result<Arc<dyn Device>, FallbackReason>;

/// Returns the same device for every request.
#[derive(Debug)]
struct SingleDevice(pub Arc<dyn Device>);

impl Devices for SingleDevice {
    fn open(&self, _: &DeviceRequest) -> OpenedDevice {
        Ok(Arc::clone(&self.0))
    }
}

/// The caller's function of the numbers of finished and of all tiles.
#[derive(Clone)]
pub(super) struct Progress(pub Arc<dyn Fn(usize, usize) + Send + Sync>);

impl fmt::Debug for Progress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Progress")
    }
}
