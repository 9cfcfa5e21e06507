//! Converts the caller's pointers to slices and strings; all assumptions about foreign memory are here.

use crate::boundary::{Failure, Outcome};
use crate::types::{
    ICORAY_CENTER, ICORAY_CORNER, ICORAY_F32, ICORAY_F64, ICORAY_I32, ICORAY_I64, ICORAY_MAX_RANK, icoray_array,
    icoray_config, icoray_frame_report, icoray_grid, icoray_layers, icoray_ndarray, icoray_part, icoray_status,
};
use icoray_core::{
    ColumnCount, Dimension, Field, GridTables, Indices, Layers, Location, LonLat, Owned, PartCells, PartCorners, Reals,
    Shape,
};
use std::ffi::{CStr, c_char, c_void};

pub(crate) fn argument(message: String) -> Failure {
    Failure::new(icoray_status::ICORAY_ERR_ARGUMENT, message)
}

/// The failure of a member of icoray_config.
pub(crate) fn config_error(member: &str, value: i32, expected: &str) -> Failure {
    argument(format!("icoray_config.{member}: {value}, expected {expected}"))
}

/// A struct that begins with its size.
pub(crate) trait Versioned {
    const NAME: &'static str;
}

macro_rules! versioned {
    ($($name:ident),*) => {$(
        impl Versioned for $name {
            const NAME: &'static str = stringify!($name);
        }
    )*};
}
versioned!(icoray_config, icoray_grid, icoray_part, icoray_layers, icoray_array, icoray_ndarray, icoray_frame_report);

/// Borrows a caller's struct after checking its size.
///
/// # Safety
/// `pointer` is NULL or points to a readable `size_t` followed by as many bytes as that number says.
pub(crate) unsafe fn sized<'a, T: Versioned>(pointer: *const T) -> Outcome<&'a T> {
    // SAFETY: passed on.
    unsafe { check_struct(pointer)? };
    // SAFETY: not NULL, aligned, and the size is right, so the caller promises the whole struct.
    Ok(unsafe { &*pointer })
}

/// Fails for NULL, a misaligned pointer, and a struct of another size than this library's.
///
/// # Safety
/// As [`sized`].
pub(crate) unsafe fn check_struct<T: Versioned>(pointer: *const T) -> Outcome<()> {
    if pointer.is_null() {
        return Err(Failure::null(T::NAME));
    }
    if !pointer.is_aligned() {
        return Err(argument(format!("{}: {pointer:?} is not aligned to {} bytes", T::NAME, align_of::<T>())));
    }
    // SAFETY: not NULL, aligned, and the caller promises that a size_t can be read there.
    let size = unsafe { pointer.cast::<usize>().read() };
    if size == size_of::<T>() {
        return Ok(());
    }
    let message = format!(
        "{}.struct_size: {size}, expected {} (header and library differ, or it was not set)",
        T::NAME,
        size_of::<T>()
    );
    Err(Failure::new(icoray_status::ICORAY_ERR_STRUCT_SIZE, message))
}

/// Borrows a string.
///
/// # Safety
/// `pointer` is NULL or points to a NUL-terminated string that lives for `'a`.
pub(crate) unsafe fn text<'a>(pointer: *const c_char, what: &str) -> Outcome<&'a str> {
    if pointer.is_null() {
        return Err(Failure::null(what));
    }
    // SAFETY: not NULL; the caller promises the NUL.
    let text = unsafe { CStr::from_ptr(pointer) };
    text.to_str().map_err(|_| argument(format!("{what}: {text:?} is not UTF-8")))
}

/// Borrows a name; NULL is the empty name.
///
/// # Safety
/// As [`text`].
pub(crate) unsafe fn name<'a>(pointer: *const c_char, what: &str) -> Outcome<&'a str> {
    // SAFETY: passed on.
    if pointer.is_null() { Ok("") } else { unsafe { text(pointer, what) } }
}

/// The names of a grid and of layers.
///
/// # Safety
/// Both are NULL or strings that live for `'a`.
pub(crate) unsafe fn names<'a>(grid: *const c_char, layers: *const c_char) -> Outcome<[&'a str; 2]> {
    // SAFETY: passed on.
    unsafe { Ok([name(grid, "grid_name")?, name(layers, "layers_name")?]) }
}

/// Far more rows than 32-bit indices can name; sums and small multiples of such numbers cannot overflow.
const MAX_COUNT: i64 = i32::MAX as i64 * 4;

fn count(value: i64, what: &str) -> Outcome<usize> {
    usize::try_from(value)
        .ok()
        .filter(|_| value <= MAX_COUNT)
        .ok_or_else(|| argument(format!("{what}: {value}, expected 0 to {MAX_COUNT}")))
}

/// Borrows an array. The pointer is not checked if `len` is 0: a rank without cells has no tables.
///
/// # Safety
/// `pointer` is NULL or points to `len` elements that live, unchanged, for `'a`.
unsafe fn slice<'a, T>(pointer: *const T, len: usize, what: &str) -> Outcome<&'a [T]> {
    if len == 0 {
        return Ok(&[]);
    }
    if pointer.is_null() {
        return Err(Failure::null(what));
    }
    if !pointer.is_aligned() {
        return Err(argument(format!("{what}: {pointer:?} is not aligned to {} bytes", align_of::<T>())));
    }
    if len.checked_mul(size_of::<T>()).is_none_or(|bytes| bytes > isize::MAX as usize) {
        return Err(argument(format!("{what}: {len} elements are more than the address space holds")));
    }
    // SAFETY: not NULL, aligned, small enough; the caller promises the elements.
    Ok(unsafe { std::slice::from_raw_parts(pointer, len) })
}

/// The type of the elements of arrays: its number, and the member that has the number, for messages.
#[derive(Clone, Copy)]
struct ElementType<'m> {
    number: i32,
    member: &'m str,
}

/// # Safety
/// As [`slice`], for elements of the type `of`.
unsafe fn reals<'a>(pointer: *const c_void, of: ElementType, len: usize, what: &str) -> Outcome<Reals<'a>> {
    let ElementType { number, member } = of;
    match number {
        // SAFETY: passed on.
        ICORAY_F32 => unsafe { slice(pointer.cast::<f32>(), len, what) }.map(Reals::F32),
        // SAFETY: passed on.
        ICORAY_F64 => unsafe { slice(pointer.cast::<f64>(), len, what) }.map(Reals::F64),
        _ => Err(argument(format!("{member}: {number}, expected ICORAY_F32 (1) or ICORAY_F64 (2)"))),
    }
}

/// # Safety
/// As [`slice`], for elements of the type `of`.
unsafe fn indices<'a>(pointer: *const c_void, of: ElementType, len: usize, what: &str) -> Outcome<Indices<'a>> {
    let ElementType { number, member } = of;
    match number {
        // SAFETY: passed on.
        ICORAY_I32 => unsafe { slice(pointer.cast::<i32>(), len, what) }.map(Indices::I32),
        // SAFETY: passed on.
        ICORAY_I64 => unsafe { slice(pointer.cast::<i64>(), len, what) }.map(Indices::I64),
        _ => Err(argument(format!("{member}: {number}, expected ICORAY_I32 (3) or ICORAY_I64 (4)"))),
    }
}

/// The places of points.
///
/// # Safety
/// Each pointer is NULL or points to `cells` elements of `real_type`, which live unchanged for `'a`.
pub(crate) unsafe fn points<'a>(
    cells: i64,
    real_type: i32,
    [lon_rad, lat_rad]: [*const c_void; 2],
) -> Outcome<LonLat<'a>> {
    let (cells, kind) = (count(cells, "cells")?, ElementType { number: real_type, member: "real_type" });
    // SAFETY: the caller promises these arrays with this length.
    unsafe {
        Ok(LonLat {
            lon_rad: reals(lon_rad, kind, cells, "lon_rad")?,
            lat_rad: reals(lat_rad, kind, cells, "lat_rad")?,
        })
    }
}

/// The tables of a grid.
///
/// # Safety
/// Every pointer in `grid` is NULL or points to as many elements as its comment in the header says, which live
/// unchanged for `'a`.
pub(crate) unsafe fn tables<'a>(grid: &icoray_grid) -> Outcome<GridTables<'a>> {
    let cells = count(grid.cells, "icoray_grid.cells")?;
    let corners = count(grid.corners, "icoray_grid.corners")?;
    let edges = count(grid.edges, "icoray_grid.edges")?;
    let row = count(grid.cell_corner_row, "icoray_grid.cell_corner_row")?;
    let corner_entries = cells
        .checked_mul(row)
        .ok_or_else(|| argument(format!("icoray_grid.cell_corner_row: {row} times {cells} cells overflows")))?;
    let kind = ElementType { number: grid.real_type, member: "icoray_grid.real_type" };
    let whole = ElementType { number: grid.index_type, member: "icoray_grid.index_type" };
    // SAFETY: the caller promises these tables with these lengths.
    unsafe {
        Ok(GridTables {
            index_base: grid.index_base,
            center: LonLat {
                lon_rad: reals(grid.lon_center_rad, kind, cells, "icoray_grid.lon_center_rad")?,
                lat_rad: reals(grid.lat_center_rad, kind, cells, "icoray_grid.lat_center_rad")?,
            },
            corner: LonLat {
                lon_rad: reals(grid.lon_corner_rad, kind, corners, "icoray_grid.lon_corner_rad")?,
                lat_rad: reals(grid.lat_corner_rad, kind, corners, "icoray_grid.lat_corner_rad")?,
            },
            cell_corner: indices(grid.cell_corner, whole, corner_entries, "icoray_grid.cell_corner")?,
            cell_corner_row: row,
            cell_corner_count: if grid.cell_corner_count.is_null() {
                None
            } else {
                Some(indices(grid.cell_corner_count, whole, cells, "icoray_grid.cell_corner_count")?)
            },
            corner_cell: indices(grid.corner_cell, whole, 3 * corners, "icoray_grid.corner_cell")?,
            corner_edge: indices(grid.corner_edge, whole, 3 * corners, "icoray_grid.corner_edge")?,
            edge_corner: indices(grid.edge_corner, whole, 2 * edges, "icoray_grid.edge_corner")?,
        })
    }
}

/// The cells of a part of a grid.
///
/// # Safety
/// Every pointer in `part` is NULL or points to as many elements as its comment in the header says, which live
/// unchanged for `'a`.
pub(crate) unsafe fn part_cells<'a>(part: &icoray_part) -> Outcome<PartCells<'a>> {
    let cells = count(part.cells, "icoray_part.cells")?;
    let kind = ElementType { number: part.index_type, member: "icoray_part.index_type" };
    // SAFETY: the caller promises both tables with this length.
    unsafe {
        let global = indices(part.cell_global, kind, cells, "icoray_part.cell_global")?;
        let names = ["icoray_part.is_owned", "icoray_part.owned_cells"];
        let owned = owned(part.is_owned, part.owned_cells, cells, names)?;
        Ok(PartCells { global, owned })
    }
}

/// The corners of a rank's fields, if it has any.
///
/// # Safety
/// As [`part_cells`].
pub(crate) unsafe fn part_corners<'a>(part: &icoray_part) -> Outcome<Option<PartCorners<'a>>> {
    let corners = count(part.corners, "icoray_part.corners")?;
    if corners == 0 && part.corner_global.is_null() {
        return Ok(None);
    }
    let kind = ElementType { number: part.index_type, member: "icoray_part.index_type" };
    let names = ["icoray_part.is_corner_owned", "icoray_part.owned_corners"];
    // SAFETY: the caller promises both tables with this length.
    unsafe {
        let global = indices(part.corner_global, kind, corners, "icoray_part.corner_global")?;
        let owned = owned(part.is_corner_owned, part.owned_corners, corners, names)?;
        Ok(Some(PartCorners { global, owned }))
    }
}

/// # Safety
/// As [`slice`], for the marks.
unsafe fn owned<'a>(marks: *const i32, first: i64, len: usize, names: [&str; 2]) -> Outcome<Owned<'a>> {
    if marks.is_null() {
        return Ok(Owned::First(count(first, names[1])?));
    }
    // SAFETY: passed on.
    unsafe { slice(marks, len, names[0]) }.map(Owned::Marked)
}

/// The radii of layers.
///
/// # Safety
/// `radius_m` is NULL or points to `count` doubles.
pub(crate) unsafe fn radii<'a>(radius_m: *const f64, layers: i64) -> Outcome<&'a [f64]> {
    let layers = count(layers, "icoray_layers.count")?;
    // SAFETY: passed on.
    unsafe { slice(radius_m, layers, "icoray_layers.radius_m") }
}

fn stride(value: i64, what: &str) -> Outcome<isize> {
    isize::try_from(value).map_err(|_| argument(format!("{what}: {value} is too large")))
}

/// The location of values.
pub(crate) fn location(value: i32, of: &str) -> Outcome<Location> {
    match value {
        ICORAY_CENTER => Ok(Location::Center),
        ICORAY_CORNER => Ok(Location::Corner),
        other => Err(argument(format!("{of}.location: {other}, expected ICORAY_CENTER (0) or ICORAY_CORNER (1)"))),
    }
}

/// The shape of an array with dimensions that has the `expected` columns and `layers` layers.
pub(crate) fn shape_of(array: &icoray_ndarray, expected: &ColumnCount, layers: usize) -> Outcome<Shape> {
    let rank = usize::try_from(array.rank)
        .ok()
        .filter(|r| (1..=ICORAY_MAX_RANK).contains(r))
        .ok_or_else(|| argument(format!("icoray_ndarray.rank: {}, expected 1 to {ICORAY_MAX_RANK}", array.rank)))?;
    let dimensions = (0..rank).map(|d| {
        Ok(Dimension {
            extent: count(array.extent[d], &format!("icoray_ndarray.extent[{d}]"))?,
            stride: stride(array.stride[d], &format!("icoray_ndarray.stride[{d}]"))?,
        })
    });
    Ok(Shape::of_dimensions(&dimensions.collect::<Outcome<Vec<_>>>()?, expected, layers)?)
}

/// An array that the model has set, with the names of its grid and layers.
pub(crate) struct ArrayInput {
    /// Its columns, layers and strides are in `shape`, and its names, which need not outlive the call, below.
    array: icoray_array,
    shape: Shape,
    /// The name of the C struct in messages.
    of: &'static str,
    pub grid: String,
    pub layers: String,
}

// SAFETY: the array is read only inside calls on the context, in which the model keeps it alive and unchanged.
unsafe impl Send for ArrayInput {}

impl ArrayInput {
    /// Checks everything but the values.
    pub fn new(array: &icoray_array, is_shared: bool) -> Outcome<Self> {
        let shape = Shape {
            columns: count(array.columns, "icoray_array.columns")?,
            layers: count(array.layers, "icoray_array.layers")?,
            offset: 0,
            column_stride: stride(array.column_stride, "icoray_array.column_stride")?,
            layer_stride: stride(array.layer_stride, "icoray_array.layer_stride")?,
            block: count(array.block, "icoray_array.block")?,
            block_stride: stride(array.block_stride, "icoray_array.block_stride")?,
        };
        Self::of_shape(*array, shape, icoray_array::NAME, is_shared)
    }

    /// [`Self::new`] of an array with dimensions, which has this shape.
    pub fn of_dimensions(array: &icoray_ndarray, shape: Shape, is_shared: bool) -> Outcome<Self> {
        let icoray_ndarray { data, r#type, location, has_fill, fill_value, grid_name, layers_name, .. } = *array;
        let none = icoray_array::default();
        let array = icoray_array { data, r#type, location, has_fill, fill_value, grid_name, layers_name, ..none };
        Self::of_shape(array, shape, icoray_ndarray::NAME, is_shared)
    }

    fn of_shape(array: icoray_array, shape: Shape, of: &'static str, is_shared: bool) -> Outcome<Self> {
        let mut input = ArrayInput { array, shape, of, grid: String::new(), layers: String::new() };
        input.field(None)?;
        // SAFETY: the caller of icoray_field_set or icoray_heights_set promises two strings.
        [input.grid, input.layers] = unsafe { names(array.grid_name, array.layers_name)? }.map(str::to_owned);
        if shape.columns == 0 && !is_shared {
            return Err(Failure::new(icoray_status::ICORAY_ERR_FIELD, "0 columns, expected at least 1"));
        }
        Ok(input)
    }

    /// Whether the array has one value per column.
    pub fn is_2d(&self) -> bool {
        self.shape.layers == 1
    }

    /// Borrows the array as a field until the call on the context returns. The values of a 2D field, which has one layer,
    /// are repeated on each of `layers`.
    pub fn field<'a>(&self, layers: Option<&Layers>) -> Outcome<Field<'a>> {
        let ArrayInput { array, mut shape, of, .. } = *self;
        let member = |name: &str| format!("{of}.{name}");
        // Columns of stride 0 are an error: all would have one value. Layers may have stride 0: a 2D field shown as a
        // shell.
        let blocks = if shape.block == 0 { 1 } else { shape.columns.div_ceil(shape.block) };
        let inside = if shape.block == 0 { shape.columns } else { shape.block };
        for (name, value, count) in
            [("column_stride", shape.column_stride, inside), ("block_stride", shape.block_stride, blocks)]
        {
            if value == 0 && count > 1 {
                return Err(argument(format!("{of}.{name}: 0, expected the elements between {count} of them")));
            }
        }
        if let (1, Some(layers)) = (shape.layers, layers) {
            shape.layers = layers.count();
            shape.layer_stride = 0;
        }
        let location = location(array.location, of)?;
        let named_by = member("type");
        let kind = ElementType { number: array.r#type, member: &named_by };
        if shape.columns == 0 {
            // SAFETY: of no elements.
            let none = unsafe { reals(array.data, kind, 0, &member("data"))? };
            return Ok(Field::new(none, shape, location, None)?);
        }
        if array.data.is_null() {
            return Err(Failure::null(&member("data")));
        }
        // The slice begins at the lowest element, which lies before `data` for negative strides.
        let Some((low, high)) = shape.extent() else {
            let message =
                format!("{} columns of {} layers, expected at least one of each", shape.columns, shape.layers);
            return Err(Failure::new(icoray_status::ICORAY_ERR_FIELD, message));
        };
        let reach = |element: i128| isize::try_from(element).ok().filter(|e| e.checked_mul(8).is_some());
        let (Some(low), Some(high)) = (reach(low), reach(high)) else {
            return Err(argument(format!(
                "{of}: the strides reach elements {low} to {high}, beyond the address space"
            )));
        };
        shape.offset = low.unsigned_abs();
        let size = if array.r#type == ICORAY_F32 { 4 } else { 8 };
        let first = array.data.wrapping_byte_offset(low * size);
        // SAFETY: the model promises all elements from the lowest to the highest that the strides reach, and that they
        // live and do not change until icoray_execute returns.
        let samples = unsafe { reals(first, kind, high.abs_diff(low) + 1, &member("data"))? };
        // An array of floats holds the mark as a float: (double)-9.9999e30f is another number than -9.9999e30.
        let fill_value = if array.r#type == ICORAY_F32 { f64::from(array.fill_value as f32) } else { array.fill_value };
        let fill = (array.has_fill != 0).then_some(fill_value);
        Ok(Field::new(samples, shape, location, fill)?)
    }
}
