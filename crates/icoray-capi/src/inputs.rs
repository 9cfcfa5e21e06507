//! Exported: grid, layers, fields, heights and scene.

use crate::borrow::{self, ArrayInput, argument, name, sized, text};
use crate::boundary::Failure;
use crate::context::{PartInput, SceneSource};
use crate::handle::CallKind::{AfterFrames, Collective, Local};
use crate::handle::{icoray_ctx, with};
use crate::types::{icoray_array, icoray_grid, icoray_layers, icoray_ndarray, icoray_part, icoray_status};
use std::ffi::{c_char, c_void};
use std::ptr;

/// Sets a grid: checks all its tables and borrows them until icoray_close or the next icoray_grid_set of the same
/// name. A rank of icoray_open may have no cells, corners and edges; its tables may then be NULL.
///
/// It first waits for frames that are rendered in the background (async_render), as these may read the previous grid.
/// Over several ranks that is collective: with async_render all ranks call icoray_grid_set at the same place among
/// their collective calls.
///
/// On failure (ICORAY_ERR_GRID names table, row and value) the previous grid of that name, if any, and its
/// icoray_part stay in effect.
///
/// # Safety
/// `ctx` is open; `grid` is NULL or points to an initialised icoray_grid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_grid_set(ctx: *mut icoray_ctx, grid: *const icoray_grid) -> icoray_status {
    // SAFETY: passed on.
    unsafe {
        with(ctx, AfterFrames("icoray_grid_set"), |context| {
            let grid = sized(grid)?;
            let name = name(grid.name, "icoray_grid.name")?;
            context.set_grid(name, borrow::tables(grid))
        })
    }
}

/// Sets a grid of points, for models whose columns have places and no tables of neighbours (physics on spectral elements,
/// unstructured waves). The cells are the points, in their order, and the corners the Delaunay triangles of the points,
/// which icoray makes and owns: both arrays are read during the call only. Fields at centres have a value for each point.
///
/// The points cover the sphere or regions: a triangle whose circumcircle is more than 5 times as large as others at its
/// points lies outside. Of points less than 3e-7 rad (2 m on the Earth) apart, as at the poles of a lat-lon grid, one
/// is a vertex of triangles, and the values at the others are not shown. With the ranks of icoray_open each rank gives
/// all points, and icoray_part_set then states which of them are its columns. The same points give the same grid on all
/// ranks.
///
/// - `name`: the name of the grid, for contexts with several grids; NULL is the unnamed grid. It replaces a grid of that
///   name, as icoray_grid_set does, and waits for frames as that does.
/// - `cells`: number of points, at least 3 that are not on one great circle.
/// - `real_type`: type of both arrays: ICORAY_F32 or ICORAY_F64.
/// - `lon_rad`, `lat_rad`: longitudes and latitudes, `cells` values each, radians.
///
/// On failure (ICORAY_ERR_GRID names a point that is not finite or looks like degrees, and the number of points that span
/// no area) the previous grid of that name, if any, stays in effect.
///
/// # Safety
/// `ctx` is open; `name` is NULL or a string; `lon_rad` and `lat_rad` are NULL or point to `cells` values.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_points_set(
    ctx: *mut icoray_ctx,
    name: *const c_char,
    cells: i64,
    real_type: i32,
    lon_rad: *const c_void,
    lat_rad: *const c_void,
) -> icoray_status {
    // SAFETY: passed on.
    unsafe {
        with(ctx, AfterFrames("icoray_points_set"), |context| {
            context.set_points(borrow::name(name, "name")?, borrow::points(cells, real_type, [lon_rad, lat_rad]))
        })
    }
}

/// Declares which cells of a grid belong to this rank, where ranks have parts of the grid, or the whole grid and some
/// columns of the fields (icoray_part). It is called after icoray_grid_set of that grid, and again after each further
/// one (ICORAY_ERR_ORDER if no grid was set). The tables of `part` are read during the call only.
///
/// Each node assembles the fields, and with parts the grid, in memory that its ranks share. If there is one node, or
/// with columns, ranks render tiles: bitwise the picture of one rank with the whole grid and fields. With parts on
/// several nodes, each node renders its cells in the whole picture, and the fragments of rays are exchanged and
/// composed.
///
/// Collective over the communicator of icoray_open, with a grid of the same name on all ranks. A failure on one rank
/// is the status of all ranks: ICORAY_ERR_GRID if a cell or corner is owned by two ranks or by none, a number occurs
/// twice or is not in the grid, or a halo is narrower than one cell. On failure the previous part, if any, stays in
/// effect. A single process owns every cell and corner, in the order of its tables, and renders as without this call.
///
/// # Safety
/// `ctx` is open; `part` is NULL or points to an initialised icoray_part.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_part_set(ctx: *mut icoray_ctx, part: *const icoray_part) -> icoray_status {
    // SAFETY: passed on.
    unsafe {
        with(ctx, Collective, |context| {
            context.set_part(|| {
                let part = sized(part)?;
                let grid = name(part.grid, "icoray_part.grid")?;
                Ok(PartInput { grid, cells: borrow::part_cells(part)?, corners: borrow::part_corners(part)? })
            })
        })
    }
}

/// Sets the radii of layers, which are copied. ICORAY_ERR_LAYERS if they are not positive, finite and strictly
/// monotone.
///
/// # Safety
/// `ctx` is open; `layers` is NULL or points to an initialised icoray_layers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_layers_set(ctx: *mut icoray_ctx, layers: *const icoray_layers) -> icoray_status {
    // SAFETY: passed on.
    unsafe {
        with(ctx, Local, |context| {
            let layers = sized(layers)?;
            let name = name(layers.name, "icoray_layers.name")?;
            context.set_layers(name, borrow::radii(layers.radius_m, layers.count), layers.planet_radius_m)
        })
    }
}

/// Sets a field under the name that scenes use; it replaces a field of the same name. The array is borrowed and read at
/// each icoray_execute that needs it; the call itself stores the description only. It belongs into the time loop,
/// before icoray_execute: models swap time levels, and a pointer that is given once shows the step before at every odd
/// step. Where values change at every second or third step only and the array was not given anew, the log has a
/// warning, once for a field. A scene of several fields needs all of them, on the same grid and layers; some may be at
/// centres and others at corners.
///
/// # Safety
/// `ctx` is open; `name` is NULL or a string; `array` is NULL or points to an initialised icoray_array, whose data
/// live until the field is replaced or the context is closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_field_set(
    ctx: *mut icoray_ctx,
    name: *const c_char,
    array: *const icoray_array,
) -> icoray_status {
    // SAFETY: passed on.
    unsafe {
        with(ctx, Local, |context| {
            let name = text(name, "name")?;
            let array = sized(array).and_then(|array| ArrayInput::new(array, context.is_shared()));
            context.set_field(name, array)
        })
    }
}

/// As icoray_field_set, for an array given by its dimensions: which of them are layers and which are columns is found
/// from the grid and layers, which must be set before (ICORAY_ERR_ORDER), as must icoray_part_set where ranks have
/// the whole grid and some columns. The Fortran procedure icoray_field_set calls this function.
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
        with(ctx, Local, |context| {
            let name = text(name, "name")?;
            let array = sized(array).and_then(|array| context.ndarray_input("icoray_field_set_ndarray", array));
            context.set_field(name, array)
        })
    }
}

/// Sets the heights of layers that differ from column to column (terrain, a sea floor): metres above the planet's
/// surface, negative below it, one value for each cell (ICORAY_CENTER) or corner (ICORAY_CORNER, ICON's triangles) and
/// each layer of icoray_layers, in their order, for the grid and layers that the array names. The array is borrowed and
/// replaces earlier heights; NULL removes them. Scenes with heights = "native" read it at each icoray_execute; other
/// scenes use the radii of icoray_layers and do not read it.
///
/// From the innermost layer outwards, the heights of a column must not decrease; equal heights are allowed. A column
/// whose heights are all missing (NaN or fill_value) has the mean heights. Heights at corners are averaged to cells as
/// fields are, over the corners of a cell that have heights; a cell without such a corner has the mean heights. Wrong
/// heights are ICORAY_ERR_LAYERS at icoray_execute, with the cell or corner, the layers and the values. On a rank with
/// a part of the grid, or with some columns, the array has the same cells or corners as the rank's fields.
///
/// # Safety
/// `ctx` is open; `heights` is NULL or points to an initialised icoray_array, whose data live until they are replaced
/// or removed or the context is closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_heights_set(ctx: *mut icoray_ctx, heights: *const icoray_array) -> icoray_status {
    // SAFETY: passed on.
    unsafe {
        with(ctx, Local, |context| {
            let input = |array| ArrayInput::new(array, context.is_shared());
            let array = (!heights.is_null()).then(|| sized(heights).and_then(input));
            context.set_heights(array.transpose())
        })
    }
}

/// As icoray_heights_set, for an array given by its dimensions, as in icoray_field_set_ndarray. The Fortran procedure
/// icoray_heights_set calls this function.
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
        with(ctx, Local, |context| {
            let input = |array| context.ndarray_input("icoray_heights_set_ndarray", array);
            let array = (!heights.is_null()).then(|| sized(heights).and_then(input));
            context.set_heights(array.transpose())
        })
    }
}

/// Records that a binding of another language has refused what the model gave to `call`, before it called this library:
/// the message is that of the context's last failed call and is logged, and an icoray_execute that lacks what was
/// refused states the reason. An array that icoray_field_set had for a field is not read any more. The Fortran module
/// calls this function. Returns `status`, or ICORAY_ERR_ARGUMENT if that is none of ICORAY_ERR_NULL,
/// ICORAY_ERR_ARGUMENT and ICORAY_ERR_ORDER.
///
/// - `call`: the name of the function, such as "icoray_field_set".
/// - `name`: the name of the grid, layers or field; NULL or "" if it has none.
///
/// # Safety
/// `ctx` is open; `call`, `name` and `message` are NULL or strings.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_refuse(
    ctx: *mut icoray_ctx,
    call: *const c_char,
    name: *const c_char,
    status: i32,
    message: *const c_char,
) -> icoray_status {
    use icoray_status::{ICORAY_ERR_ARGUMENT, ICORAY_ERR_NULL, ICORAY_ERR_ORDER};
    let known = [ICORAY_ERR_NULL, ICORAY_ERR_ORDER].into_iter().find(|known| *known as i32 == status);
    let status = known.unwrap_or(ICORAY_ERR_ARGUMENT);
    // SAFETY: passed on.
    unsafe {
        with(ctx, Local, |context| {
            let (call, name) = (text(call, "call")?, borrow::name(name, "name")?);
            context.refuse(call, name, Failure::new(status, text(message, "message")?))
        })
    }
}

/// Sets the long name (such as "potential temperature") and the units (such as "m s-1", CF conventions) of a field,
/// for labels in pictures and for the text in their files. Either may be NULL or blank. They apply to the field of
/// that name, set before or later, until the next such call. The strings are copied.
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
        with(ctx, Local, |context| {
            let (long_name, units) = (borrow::name(long_name, "long_name")?, borrow::name(units, "units")?);
            context.describe_field(text(name, "name")?, long_name, units)
        })
    }
}

/// Loads the scene from a TOML file: one picture or several views, with their triggers and camera motions. A file
/// that has only comments draws nothing. A view that names a field alone (field = "theta") has the colours, opacities and
/// camera that suit the first values that it shows, and keeps them. On failure (ICORAY_ERR_SCENE names line and key;
/// ICORAY_ERR_IO if the file cannot be read, or pictures of that name or in that folder could not be written) the previous
/// scene, if any, stays in effect.
///
/// Collective over the communicator of icoray_open. Rank 0 reads its file and sends the text to the other ranks, whose
/// paths are not read; NULL is refused on every rank. A failure on one rank is the status of all ranks.
///
/// # Safety
/// `ctx` is open; `path` is NULL or a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_scene_load(ctx: *mut icoray_ctx, path: *const c_char) -> icoray_status {
    // SAFETY: passed on.
    unsafe {
        with(ctx, Collective, |context| {
            context.set_scene("icoray_scene_load", || Ok(SceneSource::File(text(path, "path")?)))
        })
    }
}

/// As icoray_scene_load, from TOML text. Collective: all ranks use the text of rank 0.
///
/// # Safety
/// `ctx` is open; `toml` is NULL or a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_scene_text(ctx: *mut icoray_ctx, toml: *const c_char) -> icoray_status {
    // SAFETY: passed on.
    unsafe {
        with(ctx, Collective, |context| {
            context.set_scene("icoray_scene_text", || Ok(SceneSource::Text(text(toml, "toml")?)))
        })
    }
}

/// Copies the name of one of the model's fields that the scene reads into `name`, `len` bytes with its NUL: of those of
/// all pictures and conditions at any step, each once, number `index` from 0. Past the last one, and for a scene that
/// draws nothing, it copies an empty string: for models that must request fields before the first step. A page that
/// steers the scene later (`[live]`) may show other fields.
///
/// ICORAY_ERR_ORDER without a scene; ICORAY_ERR_ARGUMENT if the name does not fit, or `index` is negative. The call is
/// local, with the same answers on all ranks of icoray_open.
///
/// # Safety
/// `ctx` is open; `name` is NULL or has room for `len` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_scene_field(
    ctx: *mut icoray_ctx,
    index: i64,
    name: *mut c_char,
    len: usize,
) -> icoray_status {
    // SAFETY: passed on.
    unsafe {
        with(ctx, Local, |context| {
            let at = usize::try_from(index).map_err(|_| argument(format!("index: {index}, expected 0 or more")))?;
            let fields = context.scene_fields()?;
            let field = fields.get(at).map_or("", String::as_str);
            if name.is_null() {
                return Err(Failure::null("name"));
            }
            if field.len() >= len {
                let message = format!("len: {len}, expected at least {}: field {field:?}", field.len() + 1);
                return Err(argument(message));
            }
            // SAFETY: not NULL, and the caller promises `len` bytes, of which these are at most all.
            ptr::copy_nonoverlapping(field.as_ptr(), name.cast(), field.len());
            name.add(field.len()).write(0);
            Ok(())
        })
    }
}
