//! Files of the arguments of calls, for `catalyst_replay`.

use crate::conduit::{RawNode, Symbols};
use crate::peers::{Peers, teams_of_host};
use icoray_context::boundary::protected;
use std::ffi::{c_int, c_void};
use std::fs::{File, create_dir, remove_file};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// libcatalyst's function that writes the arguments of a call.
type Stub = unsafe extern "C" fn(*const RawNode) -> c_int;

/// Writes the arguments of a call where the host's environment asks for it by CATALYST_DATA_DUMP_DIRECTORY, if all
/// ranks can make files there: libcatalyst's function throws an exception where they cannot. Collective, as that one is.
pub fn dump(call: &str, params: *const RawNode) {
    let Some(directory) = std::env::var_os("CATALYST_DATA_DUMP_DIRECTORY") else { return };
    let Some(function) = Symbols::of_process().find(call, "catalyst_stub_") else { return };
    let checked = protected(|| {
        let given = if params.is_null() { Err("a node is NULL".into()) } else { Ok(()) };
        all_can_write(Path::new(&directory), given)
    });
    match checked {
        // SAFETY: libcatalyst's stubs of the calls have this type; the node is the host's, which it gave for this call.
        Ok(()) => unsafe {
            std::mem::transmute::<*mut c_void, Stub>(function)(params);
        },
        Err(why) => say_once(&why),
    }
}

/// Whether all ranks can make files in a directory, which is made where it is missing. Collective.
fn all_can_write(directory: &Path, given: Result<(), String>) -> Result<(), String> {
    let [team, _] = teams_of_host(None).map_err(|e| e.to_string())?.map_or([None, None], |teams| teams.map(Some));
    let mut peers = Peers::new(team);
    // What fails here is seen from the files. The others wait for it.
    let is_made = peers.rank() == 0 && create_dir(directory).is_ok();
    peers.share(is_made).map_err(|e| e.to_string())?;
    let mine = given.and_then(|()| can_write(&directory.join(format!("icoray.{}", peers.rank()))));
    peers.share(mine).map_err(|e| e.to_string())?.into_iter().collect()
}

/// Makes a file, and removes it.
fn can_write(path: &Path) -> Result<(), String> {
    let made = File::create(path).and_then(|_| remove_file(path));
    made.map_err(|e| format!("{}: {e}", path.display()))
}

fn say_once(why: &str) {
    static IS_SAID: AtomicBool = AtomicBool::new(false);
    if !IS_SAID.swap(true, Relaxed) {
        crate::say(&format!("CATALYST_DATA_DUMP_DIRECTORY: no files for catalyst_replay are written: {why}"));
    }
}
