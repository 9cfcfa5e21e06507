//! The corners around a rank's own cells whose values other ranks have.
//!
//! A cell's average needs the values at all of its corners. A rank has columns for all of them, but those that it does
//! not own may not have been computed here: their owners send them.

use super::columns::visit_columns;
use super::mesh::{Corner, Numbers};
use super::owners::OwnCorners;
use super::supply::ColumnLookup;
use super::{RankLists, RankMessages, Ranks};
use bytemuck::Pod;
use icoray_grid::{CornerColumns, Error, ErrorKind, Field, OwnedReals, Reals, Result, Shape};
use std::collections::BTreeMap;

/// The exchange of columns at corners between the ranks of a decomposition.
#[derive(Debug, Clone)]
pub(super) struct CornerHalo {
    /// The columns that other ranks receive from this one.
    sends: RankLists<u32>,
    /// Number of columns received from each rank that sends any.
    receives: BTreeMap<usize, usize>,
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
            None => {
                // The owner of the first cell of a row; this rank if the row has no cell.
                let first = |corner: &u32| numbers.cells_at(*corner as usize).into_iter().flatten().next();
                let owner = |corner| first(corner).map_or(numbers.rank as u32, |cell| numbers.owner[cell]);
                around.iter().map(owner).collect()
            }
        };
        let (mut asked, mut requests) = (RankLists::<Corner>::new(), RankLists::<u32>::new());
        for (corner, owner) in around.into_iter().zip(owners).filter(|(_, owner)| *owner as usize != numbers.rank) {
            asked.entry(owner as usize).or_default().push(numbers.corner(corner as usize));
            requests.entry(owner as usize).or_default().push(corner);
        }
        let received = ranks.exchange_lists(&asked)?;
        let (mut sends, mut answers) = (RankLists::new(), RankMessages::new());
        for (rank, corners) in received {
            let columns: Vec<Option<u32>> = corners.iter().map(|corner| lookup.corner(corner)).collect();
            answers.insert(rank, columns.iter().map(|column| u8::from(column.is_some())).collect());
            sends.insert(rank, columns.into_iter().flatten().collect());
        }
        let (mut row, mut receives, mut rows) = (vec![CornerColumns::OWN; grid.triangles()], BTreeMap::new(), 0);
        for (rank, answers) in ranks.exchange(answers)? {
            let (first, requests) = (rows, requests.get(&rank).into_iter().flatten());
            for (corner, _) in requests.zip(answers).filter(|(_, has)| *has == 1) {
                (row[*corner as usize], is_read[*corner as usize]) = (rows, false);
                rows += 1;
            }
            receives.insert(rank, (rows - first) as usize);
        }
        receives.retain(|_, columns| *columns > 0);
        sends.values().flatten().for_each(|column| is_read[*column as usize] = true);
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
        let messages = ranks.collective_work(|| {
            let message = |(rank, columns): (&usize, &Vec<u32>)| {
                let mut bytes = Vec::new();
                let columns = columns.iter().map(|column| (*column, 0));
                visit_columns(samples, field, columns, |_, values| bytes.extend_from_slice(values));
                (*rank, bytes)
            };
            Ok(self.sends.iter().map(message).collect())
        })?;
        let received = ranks.exchange(messages)?;
        let width = field.shape().layers * size_of::<S>();
        let expected = self.receives.iter().map(|(rank, columns)| (*rank, columns * width));
        let is_complete = received.iter().map(|(rank, bytes)| (*rank, bytes.len())).eq(expected);
        let cut = || Error::new(ErrorKind::Mpi, "values at corners are cut short");
        ranks.collective(is_complete.then_some(()).ok_or_else(cut))?;
        Ok(received.values().flat_map(|bytes| bytemuck::pod_collect_to_vec::<u8, S>(bytes)).collect())
    }

    /// The received columns of `field` as a field.
    pub fn field<'h>(&self, field: &Field, halo: &'h OwnedReals) -> Result<Field<'h>> {
        let shape = Shape::level_fastest(self.receives.values().sum(), field.shape().layers);
        Field::new(halo.as_reals(), shape, field.location(), field.fill())
    }
}
