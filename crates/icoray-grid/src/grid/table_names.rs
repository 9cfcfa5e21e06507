//! Names a place in a table in words: in the notation of the language that counts like the tables, and with the names
//! that models give to the table.

use super::tables::GridTables;

/// Names of the tables in the files and sources of models. Cells of icoray are ICON's vertices, corners its
/// cells.
const MODELS: [(&str, &str); 7] = [
    ("center", "MPAS lonCell, latCell; ICON vlon, vlat"),
    ("corner", "MPAS lonVertex, latVertex; ICON clon, clat"),
    ("cell_corner", "MPAS verticesOnCell, ICON cells_of_vertex"),
    ("cell_corner_count", "MPAS nEdgesOnCell"),
    ("corner_cell", "MPAS cellsOnVertex, ICON vertex_of_cell"),
    ("corner_edge", "MPAS edgesOnVertex, ICON edge_of_cell"),
    ("edge_corner", "MPAS verticesOnEdge, ICON adjacent_cell_of_edge"),
];

/// The models' names of `table`, in brackets; empty for other names.
fn models(table: &str) -> String {
    let found = MODELS.iter().find(|(name, _)| *name == table);
    found.map_or_else(String::new, |(_, models)| format!(" ({models})"))
}

/// `table` with the names that models have for it.
pub(super) fn named(table: &str) -> String {
    format!("{table}{}", models(table))
}

/// The number in the tables of a row that is counted from 0.
pub(super) fn number_of(t: &GridTables, row: u32) -> i64 {
    i64::from(row) + i64::from(t.index_base)
}

/// Row `r`, from 0, of a table of one column, and the models' names: `center[7]`, or `center(8)` from 1.
pub(super) fn item(t: &GridTables, table: &str, r: usize) -> String {
    let text = if t.index_base == 0 { format!("[{r}]") } else { format!("({})", r + 1) };
    format!("{table}{text}{}", models(table))
}

/// Row `r`, from 0: `corner_cell[3]`, or `corner_cell(:, 4)` if numbers begin at 1, as in Fortran.
pub(super) fn row(t: &GridTables, table: &str, r: usize) -> String {
    if t.index_base == 0 { format!("{table}[{r}]") } else { format!("{table}(:, {})", r + 1) }
}

/// Column `column` of row `r`, both from 0: `corner_cell[3][1]`, or `corner_cell(2, 4)` if numbers begin at 1.
pub(super) fn entry(t: &GridTables, table: &str, r: usize, column: usize) -> String {
    if t.index_base == 0 { format!("{table}[{r}][{column}]") } else { format!("{table}({}, {})", column + 1, r + 1) }
}

/// [`row`], and the models' names of the table.
pub(super) fn named_row(t: &GridTables, table: &str, r: usize) -> String {
    row(t, table, r) + &models(table)
}

/// [`entry`], and the models' names of the table.
pub(super) fn named_entry(t: &GridTables, table: &str, r: usize, column: usize) -> String {
    entry(t, table, r, column) + &models(table)
}

/// Two rows, and the models' names of the table.
pub(super) fn rows(t: &GridTables, table: &str, a: usize, b: usize) -> String {
    format!("{} and {}{}", row(t, table, a), row(t, table, b), models(table))
}
