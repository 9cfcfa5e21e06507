//! Measurements as rows of a table.

use super::benchmark::Row;
use super::machine::Bandwidth;
use super::options::{Options, cores};

pub(super) const COLUMNS: &str = "level,layers,cells,pixels,threads,transfer,light,tolerance,method,precision,frames,\
    frame_least_s,frame_median_s,prepare_s,render_s,rays,columns,frusta_crossed,frusta_read,scalar_pieces,\
    frusta_crossed_per_s,frusta_read_per_s,bytes_read,bandwidth_percent,field_bytes,derived_bytes";

/// Those that are printed.
pub(super) const PRINTED: &str = "transfer,light,tolerance,threads,frame_least_s,frame_median_s,prepare_s,render_s,\
    frusta_crossed_per_s,frusta_read_per_s,bytes_read,bandwidth_percent";

/// The bandwidths in words.
pub(super) fn bandwidths(all: &[Bandwidth]) -> String {
    let of = |b: &Bandwidth| format!("{:.1} GB/s on {}", 1e-9 * b.bytes_per_s, cores(&[b.threads]));
    format!("memory is read in order at {}", all.iter().map(of).collect::<Vec<_>>().join(", "))
}

/// Bytes per second that rays read, in percent of the memory bandwidth of as many threads.
pub(super) fn percent(row: &Row, all: &[Bandwidth]) -> f64 {
    let max = all.iter().find(|b| b.threads == row.report.threads).map_or(f64::NAN, |b| b.bytes_per_s);
    100.0 * row.bytes as f64 / row.report.timing.render_s / max
}

/// A row's cells.
pub(super) fn cells(row: &Row, options: &Options, bandwidths: &[Bandwidth]) -> Vec<String> {
    let (setting, timing, counts) = (&row.setting, &row.report.timing, &row.report.counts);
    let method = if setting.case.integrates { options.method.as_str() } else { "none" };
    let mut cells = vec![row.size.level.to_string(), row.size.layers.to_string(), row.cells.to_string()];
    cells.extend([options.pixels().to_string(), row.report.threads.to_string()]);
    cells.extend([setting.case.name.to_owned(), setting.light.to_string()]);
    cells.extend([format!("{:e}", setting.tolerance), method.to_owned(), options.precision.clone()]);
    cells.push(row.seconds.len().to_string());
    let seconds = [row.least_s(), row.median_s(), timing.prepare_s, timing.render_s];
    cells.extend(seconds.map(|s| format!("{s:.6}")));
    cells
        .extend([counts.rays, counts.columns, row.crossed, counts.frusta, counts.scalar_pieces].map(|n| n.to_string()));
    cells.extend(row.rates().map(|rate| format!("{rate:.4e}")));
    cells.extend([row.bytes.to_string(), format!("{:.2}", percent(row, bandwidths))]);
    cells.extend([row.field_bytes, row.report.bytes_derived].map(|n| n.to_string()));
    cells
}
