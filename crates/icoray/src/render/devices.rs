//! Which device draws: found once for all pictures that ask alike.

use super::Renderer;
use crate::device::{Device, Devices, Reason, Wanted};
use crate::error::Error;
use crate::ground::Ground;
use crate::scene::{Backend, Precision, Scene};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// A device, or none: for a reason, or as nobody asked for one.
pub(super) type Found = Result<Arc<dyn Device>, Option<Reason>>;

/// What came of opening one.
type Tried = Result<Arc<dyn Device>, Reason>;

/// Devices that were opened, or not.
#[derive(Debug)]
pub(super) struct Opened {
    devices: Arc<dyn Devices>,
    known: Mutex<HashMap<Wanted, Tried>>,
}

impl Opened {
    pub fn new(devices: Arc<dyn Devices>) -> Self {
        Opened { devices, known: Mutex::default() }
    }

    fn open(&self, wanted: Wanted) -> Tried {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        // A driver that breaks is no reason for a picture to fail.
        let open = |wanted: &Wanted| {
            let opened = Error::of_panics(|| Ok(self.devices.open(wanted)));
            opened.unwrap_or_else(|panic| Err(Reason::new(panic.to_string())))
        };
        known.entry(wanted).or_insert_with_key(open).clone()
    }
}

/// One device, whatever is wanted.
#[derive(Debug)]
pub(super) struct One(pub Arc<dyn Device>);

impl Devices for One {
    fn open(&self, _: &Wanted) -> Tried {
        Ok(Arc::clone(&self.0))
    }
}

impl Renderer {
    /// The device that would draw `scene`, opened if it was not yet; `Err(None)` where nobody asks for one. Of the ranks on a
    /// node this is number `node_rank`.
    ///
    /// # Errors
    /// A [`Reason`] why the CPU draws although the scene asks for a device.
    pub fn device_for(&self, scene: &Scene, node_rank: usize) -> Result<Arc<dyn Device>, Option<Reason>> {
        if scene.backend == Backend::Cpu {
            return Err(None);
        }
        let Some(opened) = &self.devices else {
            let reason = Reason::new("this icoray was built without the GPU");
            return Err((scene.backend == Backend::Gpu).then_some(reason));
        };
        if scene.precision == Precision::F64 {
            return Err(Some(Reason::new("the scene asks for precision = \"f64\"")));
        }
        if !scene.scenery.is_plain() {
            return Err(Some(Reason::new(
                "the scene shows more than one volume between concentric layers, or cuts it",
            )));
        }
        if Ground::new(scene).is_some() {
            return Err(Some(Reason::new("the scene has land, sea or lines on its core")));
        }
        let adapter = scene.device.clone();
        let wanted = Wanted { adapter, or_processor: scene.backend == Backend::Gpu, node_rank };
        opened.open(wanted).map_err(Some)
    }
}
