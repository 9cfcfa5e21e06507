//! The generator, exported: an icosahedral mesh that owns its tables.
#![expect(non_camel_case_types, reason = "the names are C's")]

use crate::borrow::check_struct;
use crate::boundary::{Failure, guarded, status};
use crate::host::without_signals;
use crate::types::{ICORAY_F64, ICORAY_I32, icoray_grid, icoray_status};
use icoray_core::{Error, ErrorKind, IcosahedralMesh, Renderer};
use std::ptr;

/// A generated mesh that owns its tables.
pub struct icoray_mesh(IcosahedralMesh);

/// Creates the icosahedral mesh with 10*4^level + 2 cells, level 0 to 12, and stores it in *mesh; icoray_mesh_free
/// frees it.
///
/// # Safety
/// `mesh` is NULL or points to a writable pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_mesh_create(level: i32, mesh: *mut *mut icoray_mesh) -> icoray_status {
    status(&guarded(|| {
        if mesh.is_null() {
            return Err(Failure::null("mesh"));
        }
        // SAFETY: not NULL; the caller promises that it can be written.
        unsafe { mesh.write(ptr::null_mut()) };
        let wrong = |_| {
            Error::new(ErrorKind::Argument, format!("mesh level {level}, expected 0 to {}", icoray_core::MAX_LEVEL))
        };
        let level = u32::try_from(level).map_err(wrong)?;
        // Threads of its own, which end with the call: rayon's global ones would stay in the model.
        let made = without_signals(|| Renderer::new(0))?.run(|| IcosahedralMesh::new(level))?;
        // SAFETY: as above.
        unsafe { mesh.write(Box::into_raw(Box::new(icoray_mesh(made)))) };
        Ok(())
    }))
}

/// Fills *grid with the sizes and tables of the mesh (coordinates in double, indices from 0). The tables live until
/// icoray_mesh_free. The caller sets grid->struct_size before the call.
///
/// # Safety
/// `mesh` comes from icoray_mesh_create; `grid` is NULL or points to a writable icoray_grid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_mesh_grid(mesh: *const icoray_mesh, grid: *mut icoray_grid) -> icoray_status {
    status(&guarded(|| {
        if mesh.is_null() {
            return Err(Failure::null("mesh"));
        }
        // SAFETY: the caller promises at least a size_t there.
        unsafe { check_struct(grid.cast_const())? };
        // SAFETY: not NULL; the caller promises a live mesh.
        let mesh = unsafe { &(*mesh).0 };
        let filled = icoray_grid {
            struct_size: size_of::<icoray_grid>(),
            cells: mesh.cells() as i64,
            corners: mesh.lon_corner_rad.len() as i64,
            edges: (mesh.edge_corner.len() / 2) as i64,
            real_type: ICORAY_F64,
            index_type: ICORAY_I32,
            lon_center_rad: mesh.lon_center_rad.as_ptr().cast(),
            lat_center_rad: mesh.lat_center_rad.as_ptr().cast(),
            lon_corner_rad: mesh.lon_corner_rad.as_ptr().cast(),
            lat_corner_rad: mesh.lat_corner_rad.as_ptr().cast(),
            cell_corner: mesh.cell_corner.as_ptr().cast(),
            cell_corner_row: 6,
            corner_cell: mesh.corner_cell.as_ptr().cast(),
            corner_edge: mesh.corner_edge.as_ptr().cast(),
            edge_corner: mesh.edge_corner.as_ptr().cast(),
            ..Default::default()
        };
        // SAFETY: the size is right, so the caller promises the whole struct.
        unsafe { grid.write(filled) };
        Ok(())
    }))
}

/// Frees the mesh and sets *mesh to NULL. A NULL mesh is allowed. No context may still use the mesh's tables.
///
/// # Safety
/// `mesh` is NULL, or points to NULL or to a mesh from icoray_mesh_create that no context uses any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_mesh_free(mesh: *mut *mut icoray_mesh) -> icoray_status {
    status(&guarded(|| {
        if mesh.is_null() {
            return Err(Failure::null("mesh"));
        }
        // SAFETY: not NULL; the caller promises a pointer there.
        let owned = unsafe { mesh.replace(ptr::null_mut()) };
        if !owned.is_null() {
            // SAFETY: it came out of Box::into_raw in icoray_mesh_create, and *mesh no longer has it.
            drop(unsafe { Box::from_raw(owned) });
        }
        Ok(())
    }))
}
