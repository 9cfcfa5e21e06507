//! A context of the C interface, for the calls that this library makes.

use icoray::{Error, ErrorKind, Grid, Result, Team};
use icoray_context::frames::{icoray_execute, icoray_report, icoray_wants};
use icoray_context::icoray_ctx;
use icoray_context::inputs::{
    icoray_field_set, icoray_heights_set, icoray_layers_set, icoray_part_set, icoray_refuse, icoray_scene_field,
    icoray_scene_load, scene_may_need_heights, set_checked_grid,
};
use icoray_context::log::icoray_log_stderr;
use icoray_context::open::{icoray_close, icoray_open_serial, last_error, open_over};
use icoray_context::types::{
    ICORAY_DISABLE, ICORAY_I64, ICORAY_LOG_WARN, ICORAY_OVERWRITE, icoray_array, icoray_config, icoray_frame_report,
    icoray_layers, icoray_part, icoray_status,
};
use std::ffi::{CStr, CString, c_char};
use std::ptr;
use std::sync::Arc;

use crate::surface::OwnedRows;

/// Directory of the pictures, in the host's working directory.
const OUTPUT_DIR: &CStr = c"pictures";

/// An open context; dropping it closes it, which is collective. Methods fail as the functions of C that they call.
pub struct Context(*mut icoray_ctx);

// SAFETY: the context locks itself.
unsafe impl Send for Context {}

impl Context {
    /// Opens a context over ranks, or for one process. Collective.
    pub fn open(team: Option<Team>) -> Result<Self> {
        let config = icoray_config {
            struct_size: size_of::<icoray_config>(),
            output_dir: OUTPUT_DIR.as_ptr(),
            threads: 0,
            existing: ICORAY_OVERWRITE,
            on_error: ICORAY_DISABLE,
            disable_after: 0,
            async_render: 0,
            writer_queue: 0,
            when_full: 0,
            log_level: ICORAY_LOG_WARN,
            log: Some(icoray_log_stderr),
            log_user: ptr::null_mut(),
        };
        let mut ctx = ptr::null_mut();
        // SAFETY: a filled-in config, and a pointer that is written.
        let status = unsafe {
            match team {
                Some(team) => open_over(&raw const config, team, &raw mut ctx),
                None => icoray_open_serial(&raw const config, &raw mut ctx),
            }
        };
        checked(status, ptr::null())?;
        Ok(Context(ctx))
    }

    /// Loads the scene. Collective.
    pub fn load_scene(&self, path: &str) -> Result<()> {
        let path = c_string(path);
        // SAFETY: an open context and a string.
        checked(unsafe { icoray_scene_load(self.0, path.as_ptr()) }, self.0)
    }

    /// The fields that the scene reads.
    pub fn scene_fields(&self) -> Vec<String> {
        let mut names = Vec::new();
        loop {
            let mut name: [c_char; 512] = [0; 512];
            // SAFETY: an open context and a buffer of that length.
            let status = unsafe { icoray_scene_field(self.0, names.len() as i64, name.as_mut_ptr(), name.len()) };
            if status != icoray_status::ICORAY_OK || name[0] == 0 {
                return names;
            }
            // SAFETY: the call has written a string.
            names.push(unsafe { CStr::from_ptr(name.as_ptr()) }.to_string_lossy().into_owned());
        }
    }

    /// Whether pictures may read the heights of layers.
    pub fn may_need_heights(&self) -> bool {
        let mut needs = false;
        // SAFETY: an open context.
        unsafe { scene_may_need_heights(self.0, &mut needs) };
        needs
    }

    /// Whether a picture may be due.
    pub fn wants(&self, step: i64, time_s: f64) -> bool {
        let mut wants = 0;
        // SAFETY: an open context and a number that is written.
        unsafe { icoray_wants(self.0, step, time_s, &raw mut wants) };
        wants != 0
    }

    /// Sets a checked grid, whose tables live until the next of that name or until the context is dropped.
    pub fn set_grid(&self, name: &str, grid: Arc<Grid<'static>>) -> Result<()> {
        // SAFETY: an open context; the caller keeps the tables.
        checked(unsafe { set_checked_grid(self.0, name, grid) }, self.0)
    }

    /// Sets the cells and corners that this rank's fields have. Collective.
    pub fn set_part(&self, grid: &str, cells: &OwnedRows, corners: &OwnedRows) -> Result<()> {
        let grid = c_string(grid);
        let part = icoray_part {
            struct_size: size_of::<icoray_part>(),
            grid: grid.as_ptr(),
            cells: cells.row.len() as i64,
            index_type: ICORAY_I64,
            cell_global: cells.row.as_ptr().cast(),
            owned_cells: 0,
            is_owned: cells.is_owned.as_ptr(),
            corners: corners.row.len() as i64,
            corner_global: if corners.row.is_empty() { ptr::null() } else { corners.row.as_ptr().cast() },
            owned_corners: 0,
            is_corner_owned: corners.is_owned.as_ptr(),
        };
        // SAFETY: an open context; tables that live until the call returns.
        checked(unsafe { icoray_part_set(self.0, &raw const part) }, self.0)
    }

    /// Sets the radii of layers, of the name of their grid.
    pub fn set_layers(&self, name: &CStr, radii: &[f64], planet_radius: f64) -> Result<()> {
        let layers = icoray_layers {
            struct_size: size_of::<icoray_layers>(),
            count: radii.len() as i64,
            radius_m: radii.as_ptr(),
            planet_radius_m: planet_radius,
            name: name.as_ptr(),
        };
        // SAFETY: an open context; radii that are copied.
        checked(unsafe { icoray_layers_set(self.0, &raw const layers) }, self.0)
    }

    /// Sets heights of points, or removes them.
    pub fn set_heights(&self, heights: Option<&icoray_array>) -> Result<()> {
        let heights = heights.map_or(ptr::null(), ptr::from_ref);
        // SAFETY: an open context; NULL or values that the caller keeps until it has executed.
        checked(unsafe { icoray_heights_set(self.0, heights) }, self.0)
    }

    pub fn set_field(&self, name: &str, values: &icoray_array) -> Result<()> {
        let name = c_string(name);
        // SAFETY: an open context; values that the caller keeps until it has executed.
        checked(unsafe { icoray_field_set(self.0, name.as_ptr(), values) }, self.0)
    }

    /// Records in the context that a field could not be set.
    pub fn refuse_field(&self, name: &str, why: &str) {
        self.refuse(c"icoray_field_set", name, why);
    }

    /// Records in the context that no grid could be set.
    pub fn refuse_grid(&self, why: &str) {
        self.refuse(c"icoray_grid_set", "", why);
    }

    fn refuse(&self, call: &CStr, name: &str, why: &str) {
        let (name, why) = (c_string(name), c_string(why));
        let status = icoray_status::ICORAY_ERR_ARGUMENT as i32;
        // SAFETY: an open context and strings. It returns the status that is given here.
        unsafe { icoray_refuse(self.0, call.as_ptr(), name.as_ptr(), status, why.as_ptr()) };
    }

    /// Draws what is due. Collective.
    pub fn execute(&self, step: i64, time_s: f64) -> Result<()> {
        // SAFETY: an open context, whose arrays are alive.
        checked(unsafe { icoray_execute(self.0, step, time_s, ptr::null()) }, self.0)
    }

    /// The report of the last frame, if there is one.
    pub fn report(&self) -> Option<icoray_frame_report> {
        // SAFETY: a struct of numbers, for which zeros are values.
        let mut report: icoray_frame_report = unsafe { std::mem::zeroed() };
        report.struct_size = size_of::<icoray_frame_report>();
        // SAFETY: an open context and a struct of that size.
        let status = unsafe { icoray_report(self.0, &raw mut report) };
        (status == icoray_status::ICORAY_OK).then_some(report)
    }
}

impl Drop for Context {
    fn drop(&mut self) {
        // The log has what failed.
        // SAFETY: an open context, which is not used again.
        unsafe { icoray_close(&raw mut self.0) };
    }
}

/// A string for C; a NUL in it, which no name has, is shown as a question mark.
pub fn c_string(text: &str) -> CString {
    CString::new(text.replace('\0', "?")).unwrap_or_default()
}

/// The failure of a call, with the message that the context or the thread has for it.
fn checked(status: icoray_status, ctx: *const icoray_ctx) -> Result<()> {
    if status == icoray_status::ICORAY_OK {
        return Ok(());
    }
    // SAFETY: NULL or an open context.
    Err(Error::new(ErrorKind::Argument, unsafe { last_error(ctx) }))
}
