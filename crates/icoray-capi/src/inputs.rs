//! Exported: grid, layers, fields, heights and scene.

use crate::borrow::{self, Versioned, name, sized, text};
use crate::boundary::{Failure, Outcome};
use crate::handle::{icoray_ctx, with, with_all};
use crate::types::{icoray_array, icoray_grid, icoray_layers, icoray_ndarray, icoray_part, icoray_status};
use icoray_core::Description;
use std::ffi::c_char;

/// Hands over a grid's tables, which are checked whole; they are borrowed until icoray_close or the next icoray_grid_set
/// of that name. On failure the grid before, if any, stays, and so does its part (icoray_part_set). Waits for frames that
/// still read that one. A rank of icoray_open may have no cells, corners and edges, and tables that are NULL.
///
/// # Safety
/// `ctx` is open; `grid` is NULL or filled in as the header says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_grid_set(ctx: *mut icoray_ctx, grid: *const icoray_grid) -> icoray_status {
    // SAFETY: passed on.
    unsafe {
        with(ctx, |context| {
            let grid = sized(grid)?;
            let name = name(grid.name, "icoray_grid.name")?;
            context.set_grid(name, borrow::tables(grid)?)
        })
    }
}

/// Says which cells of a grid are this rank's own, where ranks have parts of it, or the whole grid and columns of some cells
/// each (icoray_part); after icoray_grid_set of that grid, and again after each one (ICORAY_ERR_ORDER where no grid was given).
/// On failure what was said before, if anything, stays.
///
/// From then on each rank draws its own part in whole pictures, and rays are put together of what ranks send each other. Of
/// columns, each node puts the fields together, and ranks draw tiles: bitwise the picture of one rank with the whole fields.
///
/// Collective over the communicator of icoray_open, with a grid of the same name on all. What fails on one rank is the
/// status of all: ICORAY_ERR_GRID where a cell is owned by two ranks or by none, a number is there twice or not in the grid, or
/// a halo is narrower than one cell. One process alone owns every cell, in the order of its tables, and draws as without this
/// call.
///
/// # Safety
/// `ctx` is open; `part` is NULL or filled in as the header says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_part_set(ctx: *mut icoray_ctx, part: *const icoray_part) -> icoray_status {
    // SAFETY: passed on.
    unsafe {
        with_all(ctx, |context| {
            context.set_part(|| {
                let part = sized(part)?;
                Ok((name(part.grid, "icoray_part.grid")?, borrow::part_cells(part)?))
            })
        })
    }
}

/// Hands over the layers' radii, which are copied.
///
/// # Safety
/// `ctx` is open; `layers` is NULL or filled in as the header says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_layers_set(
    ctx: *mut icoray_ctx,
    layers: *const icoray_layers,
) -> icoray_status {
    // SAFETY: passed on.
    unsafe {
        with(ctx, |context| {
            let layers = sized(layers)?;
            let name = name(layers.name, "icoray_layers.name")?;
            context.set_layers(name, borrow::radii(layers.radius_m, layers.count)?, layers.planet_radius_m)
        })
    }
}

/// Hands over a field under a name that scenes use; a field of that name before is replaced. The array is not read
/// now but at each icoray_execute that needs it, so it can be handed over once and change from step to step. A model whose
/// arrays move (time levels that are swapped) calls this before each icoray_execute; it takes no time. A scene of several fields
/// needs all of them, over one grid and its layers; some may be at centres and others at corners.
///
/// # Safety
/// `ctx` is open; `name` is NULL or a string; `array` is NULL or filled in as the header says, and its data live until
/// the field is replaced or the context closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_field_set(
    ctx: *mut icoray_ctx,
    name: *const c_char,
    array: *const icoray_array,
) -> icoray_status {
    // SAFETY: passed on.
    unsafe {
        with(ctx, |context| {
            let (name, array) = (text(name, "name")?, sized(array)?);
            context.set_field(name, array, icoray_array::NAME)
        })
    }
}

/// As icoray_field_set, for an array of which just the dimensions are known: which of them are layers and which columns
/// is found from grid and layers, which come first (ICORAY_ERR_ORDER); so does icoray_part_set where ranks have the whole grid.
/// Fortran's icoray_field_set comes here.
///
/// # Safety
/// As icoray_field_set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_field_set_ndarray(
    ctx: *mut icoray_ctx,
    name: *const c_char,
    array: *const icoray_ndarray,
) -> icoray_status {
    // SAFETY: passed on.
    unsafe {
        with(ctx, |context| {
            let (name, array) = (text(name, "name")?, sized(array)?);
            context.set_ndarray(name, array)
        })
    }
}

/// Hands over the heights of layers where these differ from column to column, as over mountains or a sea floor: metres above the
/// planet's surface, negative below it, a value for each cell (ICORAY_CENTER) and each layer of icoray_layers, in their order;
/// of the grid and layers that the array names. Only scenes with heights = "native" read them, at each icoray_execute, as they
/// are then; others draw with the radii of icoray_layers, and do not touch the array. NULL takes back the heights before, which
/// these replace.
///
/// In a column heights do not fall on the way up; layers may have no thickness. A column all of whose heights are missing (NaN
/// or fill_value) has the mean ones. What is wrong is ICORAY_ERR_LAYERS at icoray_execute. A rank of icoray_open with a part of
/// the grid, or columns of some cells, has heights of the cells of which it has fields.
///
/// # Safety
/// `ctx` is open; `heights` is NULL or filled in as the header says, and its data live until they are replaced, taken
/// back or the context closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_heights_set(
    ctx: *mut icoray_ctx,
    heights: *const icoray_array,
) -> icoray_status {
    // SAFETY: passed on.
    unsafe {
        with(ctx, |context| {
            let heights = if heights.is_null() { None } else { Some(sized(heights)?) };
            context.set_heights(heights, icoray_array::NAME)
        })
    }
}

/// As icoray_heights_set, for an array of which just the dimensions are known, as icoray_field_set_ndarray. Fortran's
/// icoray_heights_set comes here.
///
/// # Safety
/// As icoray_heights_set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_heights_set_ndarray(
    ctx: *mut icoray_ctx,
    heights: *const icoray_ndarray,
) -> icoray_status {
    // SAFETY: passed on.
    unsafe {
        with(ctx, |context| {
            let heights = if heights.is_null() { None } else { Some(sized(heights)?) };
            context.set_heights_ndarray(heights)
        })
    }
}

/// Says what a field is called, for labels in pictures and the text of their files: `long_name` such as "potential
/// temperature" and `units` such as "m s-1" (CF conventions), NULL or blank where there is none. It holds for the field of that name,
/// given before or after, until the next such call. The strings are copied.
///
/// # Safety
/// `ctx` is open; `name`, `long_name` and `units` are NULL or strings.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_field_describe(
    ctx: *mut icoray_ctx,
    name: *const c_char,
    long_name: *const c_char,
    units: *const c_char,
) -> icoray_status {
    // SAFETY: passed on.
    unsafe {
        with(ctx, |context| {
            let said = |from: *const c_char, what| -> Outcome<Option<String>> {
                let said = if from.is_null() { "" } else { text(from, what)?.trim() };
                Ok((!said.is_empty()).then(|| said.to_owned()))
            };
            let description =
                Description { long_name: said(long_name, "long_name")?, units: said(units, "units")? };
            context.describe_field(text(name, "name")?, description)
        })
    }
}

/// Reads the scene from a TOML file, of one picture or of several views, with all that says when they are drawn and how
/// their cameras move; a file of comments and blanks draws nothing. On failure (ICORAY_ERR_SCENE, with line and key) the scene
/// before, if any, stays.
///
/// # Safety
/// `ctx` is open; `path` is NULL or a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_scene_load(ctx: *mut icoray_ctx, path: *const c_char) -> icoray_status {
    // SAFETY: passed on.
    unsafe {
        with(ctx, |context| {
            let path = text(path, "path")?;
            let unread =
                |e| Failure::new(icoray_status::ICORAY_ERR_IO, format!("{path}: cannot read the scene: {e}"));
            let scene = std::fs::read_to_string(path).map_err(unread)?;
            context.set_scene(&scene).map_err(|f| Failure::new(f.status, format!("{path}: {}", f.message)))
        })
    }
}

/// As icoray_scene_load, from TOML text; text of comments and blanks draws nothing.
///
/// # Safety
/// `ctx` is open; `toml` is NULL or a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_scene_text(ctx: *mut icoray_ctx, toml: *const c_char) -> icoray_status {
    // SAFETY: passed on.
    unsafe { with(ctx, |context| context.set_scene(text(toml, "toml")?)) }
}
