//! MPAS files as grids, layers and fields.
