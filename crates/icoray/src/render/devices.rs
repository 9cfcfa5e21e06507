//! Opens devices, once per request.

use crate::device::{Device, DeviceRequest, Devices, FallbackReason};
use icoray_grid::Error;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// The device of a picture; `Err(None)` if the scene requests none.
pub(super) type DeviceChoice = Result<Arc<dyn Device>, Option<FallbackReason>>;

/// The outcome of opening a device.
type OpenedDevice = Result<Arc<dyn Device>, FallbackReason>;

/// The outcomes of all requests so far.
#[derive(Debug)]
pub(super) struct DeviceCache {
    devices: Arc<dyn Devices>,
    known: Mutex<HashMap<DeviceRequest, OpenedDevice>>,
}

impl DeviceCache {
    pub fn new(devices: Arc<dyn Devices>) -> Self {
        DeviceCache { devices, known: Mutex::default() }
    }

    pub fn open(&self, wanted: DeviceRequest) -> OpenedDevice {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        // A panic of the driver falls back to the CPU.
        let open = |wanted: &DeviceRequest| {
            let opened = Error::of_panics(|| Ok(self.devices.open(wanted)));
            opened.unwrap_or_else(|panic| Err(FallbackReason::new(panic.to_string())))
        };
        known.entry(wanted).or_insert_with_key(open).clone()
    }
}

/// Returns the same device for every request.
#[derive(Debug)]
pub(super) struct SingleDevice(pub Arc<dyn Device>);

impl Devices for SingleDevice {
    fn open(&self, _: &DeviceRequest) -> OpenedDevice {
        Ok(Arc::clone(&self.0))
    }
}
