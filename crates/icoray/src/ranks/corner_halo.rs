//! The corners around a rank's own cells whose values other ranks have.
//!
//! A cell's average needs the values at all of its corners. A rank has columns for all of them, but those that it does
//! not own may not have been computed here: their owners send them.

use super::Ranks;
use super::columns::visit_columns;
use super::corner_owners::OwnCorners;
use super::mesh::{Corner, Numbers};
use super::supply::ColumnLookup;
use super::wire::{decode_lists, encode_lists};
use bytemuck::Pod;
use icoray_grid::{CornerColumns, Error, ErrorKind, Field, OwnedReals, Reals, Result, Shape};

/// The exchange of columns at corners between the ranks of a decomposition.
#[derive(Debug, Clone)]
pub(super) struct CornerHalo {
    /// For each rank, the columns that it receives from this one.
    sends: Vec<Vec<u32>>,
    /// Number of columns received from each rank.
    receives: Vec<usize>,
    /// The row of each corner of this rank's tables among all received columns, or [`CornerColumns::OWN`].
    row: Vec<u32>,
    /// Whether an average of any rank reads this rank's own column of each corner.
    is_read: Vec<bool>,
}

impl CornerHalo {
    /// Finds the owners of the corners around this rank's own cells. A corner that is not in its owner's tables, which
    /// may omit those that are no triangles, is taken from this rank's field. Collective.
    pub fn find(
        ranks: &mut Ranks,
        numbers: &Numbers,
        lookup: &ColumnLookup,
        own_corners: Option<&OwnCorners>,
    ) -> Result<Self> {
        let grid = numbers.grid;
        let mut is_read = vec![false; grid.triangles()];
        for cell in (0..grid.cells()).filter(|cell| numbers.owns(*cell)) {
            grid.corners_of(cell as u32).for_each(|corner| is_read[corner as usize] = true);
        }
        let around: Vec<u32> = (0..grid.triangles() as u32).filter(|corner| is_read[*corner as usize]).collect();
        let owners = match own_corners {
            Some(own) => {
                let wanted: Vec<u64> = around.iter().map(|corner| own.numbers()[*corner as usize]).collect();
                own.find_owners(ranks, &wanted)?
            }
            None => around.iter().map(|corner| numbers.owner_of_corner(*corner as usize)).collect(),
        };
        let mut requests: Vec<Vec<(Corner, u32)>> = vec![Vec::new(); ranks.size()];
        for (corner, owner) in around.into_iter().zip(owners).filter(|(_, owner)| *owner as usize != numbers.rank) {
            requests[owner as usize].push((numbers.corner(corner as usize), corner));
        }
        let asked: Vec<Vec<Corner>> =
            requests.iter().map(|of| of.iter().map(|(corner, _)| *corner).collect()).collect();
        let received = decode_lists::<Corner>(&ranks.exchange(encode_lists(&asked))?);
        let received = ranks.collective(received)?;
        let (mut sends, mut answers) = (vec![Vec::new(); ranks.size()], vec![Vec::new(); ranks.size()]);
        for (rank, corners) in received.iter().enumerate() {
            for column in corners.iter().map(|corner| lookup.corner(corner)) {
                answers[rank].push(u8::from(column.is_some()));
                sends[rank].extend(column);
            }
        }
        let (mut row, mut receives, mut rows) = (vec![CornerColumns::OWN; grid.triangles()], Vec::new(), 0);
        for (requests, answers) in requests.iter().zip(ranks.exchange(answers)?) {
            let first = rows;
            for ((_, corner), _) in requests.iter().zip(answers).filter(|(_, has)| *has == 1) {
                (row[*corner as usize], is_read[*corner as usize]) = (rows, false);
                rows += 1;
            }
            receives.push((rows - first) as usize);
        }
        sends.iter().flatten().for_each(|column| is_read[*column as usize] = true);
        Ok(CornerHalo { sends, receives, row, is_read })
    }

    /// The row of each corner in the halo, or [`CornerColumns::OWN`].
    pub fn rows(&self) -> &[u32] {
        &self.row
    }

    /// Whether an average of any rank reads this rank's own column of a corner.
    pub fn reads(&self, corner: usize) -> bool {
        self.is_read[corner]
    }

    /// Receives the columns of a field at corners from other ranks, level-fastest. Collective.
    pub fn exchange(&self, ranks: &mut Ranks, field: &Field) -> Result<OwnedReals> {
        match field.samples() {
            Reals::F32(samples) => self.exchange_of(ranks, field, samples).map(OwnedReals::F32),
            Reals::F64(samples) => self.exchange_of(ranks, field, samples).map(OwnedReals::F64),
        }
    }

    fn exchange_of<S: Pod>(&self, ranks: &mut Ranks, field: &Field, samples: &[S]) -> Result<Vec<S>> {
        let messages = ranks.attempt(|| {
            let message = |columns: &Vec<u32>| {
                let mut bytes = Vec::new();
                let columns = columns.iter().map(|column| (*column, 0));
                visit_columns(samples, field, columns, |_, values| bytes.extend_from_slice(values));
                bytes
            };
            Ok(self.sends.iter().map(message).collect())
        });
        let messages = ranks.collective(messages)?;
        let received = ranks.exchange(messages)?;
        let width = field.shape().layers * size_of::<S>();
        let is_complete = received.iter().zip(&self.receives).all(|(bytes, columns)| bytes.len() == columns * width);
        let cut = || Error::new(ErrorKind::Mpi, "values at corners are cut short");
        ranks.collective(is_complete.then_some(()).ok_or_else(cut))?;
        Ok(received.iter().flat_map(|bytes| bytemuck::pod_collect_to_vec::<u8, S>(bytes)).collect())
    }

    /// The received columns of `field` as a field.
    pub fn field<'h>(&self, field: &Field, halo: &'h OwnedReals) -> Result<Field<'h>> {
        let shape = Shape::level_fastest(self.receives.iter().sum(), field.shape().layers);
        Field::new(halo.as_reals(), shape, field.location(), field.fill())
    }
}

impl Numbers<'_> {
    /// The rank that owns the first cell of a corner's row; this rank if the row has no cell.
    fn owner_of_corner(&self, corner: usize) -> u32 {
        let first = self.cells_at(corner).into_iter().flatten().next();
        first.map_or(self.rank as u32, |cell| self.owner[cell])
    }
}
