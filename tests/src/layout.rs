//! Sizes, offsets and numbers of the ABI, which must be the same in C, Fortran and Rust.

use std::fmt::Write;

/// The library's own structs.
#[path = "../../crates/icoray-capi/src/types.rs"]
mod types;

/// Sizes, offsets and numbers where pointers have 64 bits. Programs that were compiled before rely on them: a change
/// here is a change of the ABI.
pub const LAYOUT: &str = include_str!("../c/layout.txt");

/// Sizes, offsets and numbers as Rust has them, in the form of `c/layout.txt`.
fn rust_layout() -> String {
    let mut lines = String::new();
    macro_rules! layout {
        ($($name:ident: $($member:ident)*;)*) => {$(
            writeln!(lines, "{} {}", stringify!($name), size_of::<types::$name>()).unwrap();
            $({
                let member = stringify!($member).trim_start_matches("r#");
                let offset = std::mem::offset_of!(types::$name, $member);
                writeln!(lines, "{}.{member} {offset}", stringify!($name)).unwrap();
            })*
        )*};
    }
    macro_rules! numbers {
        ($($name:expr,)*) => {$(
            writeln!(lines, "{} {}", stringify!($name).rsplit("::").next().unwrap().trim(), $name as i32).unwrap();
        )*};
    }
    layout! {
        icoray_config: struct_size output_dir threads existing on_error disable_after async_render
            writer_queue when_full log_level log log_user;
        icoray_grid: struct_size cells corners edges index_base real_type index_type lon_center_rad
            lat_center_rad lon_corner_rad lat_corner_rad cell_corner cell_corner_row cell_corner_count
            corner_cell corner_edge edge_corner name;
        icoray_part: struct_size grid cells index_type cell_global owned_cells is_owned corners corner_global
            owned_corners is_corner_owned;
        icoray_layers: struct_size count radius_m planet_radius_m name;
        icoray_array: struct_size data r#type location columns layers column_stride layer_stride block
            block_stride has_fill fill_value grid_name layers_name;
        icoray_ndarray: struct_size data r#type location rank has_fill fill_value extent stride grid_name
            layers_name;
        icoray_frame_report: struct_size;
    }
    for (figure, offset) in types::icoray_frame_report::OFFSETS {
        writeln!(lines, "icoray_frame_report.{figure} {offset}").unwrap();
    }
    layout! { icoray_status:; }
    let statuses = (0..).map_while(|number: i32| bytemuck::checked::try_cast::<_, types::icoray_status>(number).ok());
    statuses.for_each(|status| writeln!(lines, "{status:?} {}", status as i32).unwrap());
    numbers! {
        types::ICORAY_F32, types::ICORAY_F64, types::ICORAY_I32, types::ICORAY_I64, types::ICORAY_CENTER,
        types::ICORAY_CORNER, types::ICORAY_ALONE, types::ICORAY_TILES, types::ICORAY_FRAGMENTS,
        types::ICORAY_CPU, types::ICORAY_GPU, types::ICORAY_GPU_AND_CPU,
        types::ICORAY_NEVER_MODIFY, types::ICORAY_OVERWRITE, types::ICORAY_WARN,
        types::ICORAY_IGNORE, types::ICORAY_DISABLE, types::ICORAY_BLOCK, types::ICORAY_DROP_OLDEST,
        types::ICORAY_LOG_OFF, types::ICORAY_LOG_ERROR, types::ICORAY_LOG_WARN, types::ICORAY_LOG_INFO,
        types::ICORAY_LOG_DEBUG, types::ICORAY_MAX_RANK,
    }
    lines
}

/// Fails unless a program printed the version and the layout of Rust.
pub fn assert_layout_is_of_rust(printed: &str) {
    let (version, layout) = printed.split_once('\n').unwrap();
    assert_eq!(version, concat!("version ", env!("CARGO_PKG_VERSION")));
    assert_is_rust(layout);
}

/// Fails unless a layout is that of Rust.
pub fn assert_is_rust(layout: &str) {
    let rust = rust_layout();
    let first = rust.lines().zip(layout.lines()).find(|(a, b)| a != b);
    assert!(rust == layout, "they differ from Rust: {first:?}");
}
