//! The columns that a rank writes to its node's memory or sends to another node.

use super::GatherInputs;
use crate::ranks::corner_halo::CornerHalo;
use bytemuck::Pod;
use icoray_grid::threads::Threads;
use icoray_grid::{CornerColumns, Error, ErrorKind, Field, Grid, OwnedReals, Reals, Result};
use rayon::prelude::*;

/// Maximum number of bytes of averages that are computed at once.
const AVERAGES: usize = 4 << 20;

/// Columns of a rank, by number: those of its field, or averages at cells of a field at corners.
pub(super) struct ColumnSource<'f> {
    field: Field<'f>,
    /// Columns at all corners, if averages are requested.
    corners: Option<CornerColumns<'f>>,
    grid: &'f Grid<'f>,
    threads: &'f Threads,
}

impl<'f> ColumnSource<'f> {
    /// The columns of `field` or, with a halo and its received values, averages.
    pub fn new(
        field: &Field<'f>,
        inputs: &'f GatherInputs,
        halo: Option<(&'f CornerHalo, &'f OwnedReals)>,
    ) -> Result<Self> {
        let with_halo = |(halo, values): (&'f CornerHalo, _)| {
            CornerColumns::with_halo(*field, halo.rows(), halo.field(field, values)?)
        };
        let GatherInputs { threads, grid, .. } = *inputs;
        Ok(ColumnSource { field: *field, corners: halo.map(with_halo).transpose()?, grid, threads })
    }

    /// Calls `visit` with the rows and values of some columns, layer by layer.
    pub fn visit(&self, columns: &[(u32, u32)], visit: impl FnMut(u32, &[u8])) {
        match (&self.corners, self.field.samples()) {
            (Some(corners), _) => self.visit_averages(corners, columns, visit),
            (None, Reals::F32(data)) => visit_columns(data, &self.field, columns.iter().copied(), visit),
            (None, Reals::F64(data)) => visit_columns(data, &self.field, columns.iter().copied(), visit),
        }
    }

    fn visit_averages(&self, corners: &CornerColumns, columns: &[(u32, u32)], mut visit: impl FnMut(u32, &[u8])) {
        let most = (AVERAGES / (self.field.shape().layers * size_of::<f64>())).max(1);
        let mut memory = None;
        for columns in columns.chunks(most) {
            let cells = columns.par_iter().map(|(cell, _)| *cell);
            let values = self.threads.run(|| corners.averages(self.grid, cells, memory.take()));
            let bytes: &[u8] = match &values {
                OwnedReals::F32(values) => bytemuck::cast_slice(values),
                OwnedReals::F64(values) => bytemuck::cast_slice(values),
            };
            let width = bytes.len() / columns.len();
            columns.iter().zip(bytes.chunks_exact(width)).for_each(|((_, row), bytes)| visit(*row, bytes));
            memory = Some(values);
        }
    }
}

/// Calls `visit` with the rows and values of some columns of a field, layer by layer.
pub(in crate::ranks) fn visit_columns<S: Pod>(
    data: &[S],
    field: &Field,
    columns: impl Iterator<Item = (u32, u32)>,
    mut visit: impl FnMut(u32, &[u8]),
) {
    let (shape, elements) = (field.shape(), field.elements());
    let mut column = Vec::with_capacity(shape.layers);
    for (at, row) in columns {
        let base = elements.base(at as usize);
        if shape.layer_stride == 1 {
            let first = elements.at(base, 0);
            visit(row, bytemuck::cast_slice(&data[first..first + shape.layers]));
            continue;
        }
        column.clear();
        column.extend((0..shape.layers).map(|layer| data[elements.at(base, layer)]));
        visit(row, bytemuck::cast_slice(&column));
    }
}

/// Reads the columns of a message: `width` bytes each, behind the 8 bytes of the row.
pub(super) fn read_columns(
    bytes: &[u8],
    width: usize,
    rows: usize,
    mut column: impl FnMut(usize, &[u8]),
) -> Result<()> {
    for record in bytes.chunks(8 + width) {
        let cut = || Error::new(ErrorKind::Mpi, "a column of a message is cut short");
        let (row, values) = record.split_first_chunk().ok_or_else(cut)?;
        let row = u64::from_le_bytes(*row) as usize;
        if row >= rows || values.len() < width {
            return Err(Error::new(ErrorKind::Mpi, format!("a column of row {row} of {rows}")));
        }
        column(row, values);
    }
    Ok(())
}
