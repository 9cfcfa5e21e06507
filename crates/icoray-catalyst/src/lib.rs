//! An implementation of Catalyst 2: hosts that were built against Kitware's libcatalyst draw geodesic grids.
//!
//! libcatalyst loads `libcatalyst-icoray.so` where CATALYST_IMPLEMENTATION_NAME is `icoray`, and calls the functions of
//! [`catalyst_api_impl`] with nodes of Conduit. Layout: `conduit` nodes, by functions found at run time; `dump` files
//! of calls for `catalyst_replay`; `channels` what a call has, and `blueprint` the meshes and fields in a channel;
//! `elements` prisms, polygons and points; `columns` the columns that they stand in; `order` where the
//! values of columns are; `surface` the mesh of the sphere, of all ranks; `grid` and `fields` what the context gets;
//! `adaptor` a host from its first call to its last; `context` the context that draws; `peers` the host's ranks.
//!
//! No failure ends the host: each is a line in its standard error, and all functions return `catalyst_status_ok`.
//! Reference: Kitware's Catalyst 2, `catalyst_api.h` and `catalyst_impl.h`.

mod adaptor;
mod blueprint;
mod channels;
mod columns;
mod conduit;
mod context;
mod dump;
mod elements;
mod fields;
mod grid;
mod order;
mod peers;
mod surface;

use adaptor::Adaptor;
use conduit::{Conduit, Node, RawNode};
use dump::dump;
use icoray_context::boundary::protected;
use icoray_context::log::icoray_log_stderr;
use icoray_context::types::ICORAY_LOG_WARN;
use std::ffi::{CString, c_int};
use std::ptr;
use std::sync::{Mutex, PoisonError};

/// Catalyst's `struct catalyst_impl` of version 1.
#[repr(C)]
#[derive(Debug)]
pub struct Implementation {
    version: c_int,
    initialize: unsafe extern "C" fn(*const RawNode) -> c_int,
    execute: unsafe extern "C" fn(*const RawNode) -> c_int,
    finalize: unsafe extern "C" fn(*const RawNode) -> c_int,
    about: unsafe extern "C" fn(*mut RawNode) -> c_int,
    results: unsafe extern "C" fn(*mut RawNode) -> c_int,
}

/// The symbol that libcatalyst loads.
#[unsafe(no_mangle)]
pub static catalyst_api_impl: Implementation =
    Implementation { version: 1, initialize, execute, finalize, about, results };

/// `catalyst_status_ok`.
const OK: c_int = 0;

/// The host, between its first call and its last.
static HOST: Mutex<Option<Adaptor>> = Mutex::new(None);

/// Writes a line to the host's standard error.
fn say(message: &str) {
    let message = CString::new(message.replace('\0', "?")).unwrap_or_default();
    // SAFETY: a string.
    unsafe { icoray_log_stderr(ptr::null_mut(), ICORAY_LOG_WARN, message.as_ptr()) };
}

/// Runs a call; what fails is said.
fn call(code: impl FnOnce(&mut Option<Adaptor>) -> Result<(), String>) -> c_int {
    let run = || code(&mut HOST.lock().unwrap_or_else(PoisonError::into_inner));
    if let Err(message) = protected(run) {
        say(&message);
    }
    OK
}

/// Opens what draws, and loads the scene.
unsafe extern "C" fn initialize(params: *const RawNode) -> c_int {
    dump("initialize", params);
    call(|host| {
        if host.is_some() {
            return Err("catalyst_initialize was called twice: the scene of the first call stays".into());
        }
        let conduit = Conduit::find()?;
        // SAFETY: the host's node, for this call.
        let params = unsafe { Node::new(params, &conduit) }.ok_or("catalyst_initialize: NULL, expected a node")?;
        *host = Some(Adaptor::new(params).map_err(|e| e.to_string())?);
        Ok(())
    })
}

unsafe extern "C" fn execute(params: *const RawNode) -> c_int {
    dump("execute", params);
    call(|host| {
        let Some(adaptor) = host else { return Ok(()) };
        let conduit = Conduit::find()?;
        // SAFETY: the host's node, for this call.
        let params = unsafe { Node::new(params, &conduit) };
        if params.is_none() {
            // Other ranks have theirs, and wait for this one.
            say("catalyst_execute: NULL, expected a node");
        }
        let outcome = adaptor.execute(params);
        if outcome.is_err() {
            // Ranks are out of step.
            *host = None;
        }
        outcome.map_err(|e| e.to_string())
    })
}

/// Waits for pictures, and closes.
unsafe extern "C" fn finalize(params: *const RawNode) -> c_int {
    dump("finalize", params);
    call(|host| {
        *host = None;
        Ok(())
    })
}

/// Says what this is.
unsafe extern "C" fn about(params: *mut RawNode) -> c_int {
    call(|_| {
        let conduit = Conduit::find()?;
        // SAFETY: the host's node, for this call, which is to be filled.
        let Some(node) = (unsafe { Node::new(params, &conduit) }) else { return Ok(()) };
        node.set_text("catalyst/implementation", "icoray");
        node.set_text("catalyst/version", "2.0.0");
        node.set_text("catalyst/abi_version", "2");
        node.set_integer("catalyst/use_mpi", i64::from(cfg!(feature = "mpi")));
        node.set_text("icoray/version", env!("CARGO_PKG_VERSION"));
        Ok(())
    })
}

/// Says what the last frame cost.
unsafe extern "C" fn results(params: *mut RawNode) -> c_int {
    call(|host| {
        let conduit = Conduit::find()?;
        // SAFETY: the host's node, for this call, which is to be filled.
        if let (Some(node), Some(adaptor)) = (unsafe { Node::new(params, &conduit) }, host) {
            adaptor.fill_results(node);
        }
        Ok(())
    })
}
