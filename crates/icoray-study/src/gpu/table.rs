//! Measurements as rows of a table, and as tables in Markdown.

use super::benchmark::{Benchmark, Row};
use crate::results::{threads, three_digits};
use icoray_gpu::Peaks;
use std::fmt::Write as _;

pub(super) const COLUMNS: &str = "transfer,width,height,light,tolerance,device_ms,-device_clock,-prepare_ms,upload_ms,\
    -bytes_uploaded,end_to_end_ms,cpu_ms,-columns,-frusta,frusta_per_s,-bytes_read,memory_percent,-flops,f32_percent,\
    -upload_bytes_per_s,upload_percent,rmse_to_cpu,max_to_cpu";

fn percent(rate: f64, max: f64) -> f64 {
    100.0 * rate / max
}

/// Percents of the device's memory, arithmetic and bus.
fn percents(gpu: &Row, peaks: &Peaks) -> [f64; 3] {
    [
        percent(gpu.cost.bytes / gpu.device_s(), peaks.memory),
        percent(gpu.cost.flops / gpu.device_s(), peaks.flops),
        percent(gpu.upload(), peaks.host_to_device),
    ]
}

pub(super) fn cells(row: &Row, peaks: &Peaks) -> Vec<String> {
    let ms = |seconds: f64| format!("{:.4}", 1e3 * seconds);
    let (width, height) = row.setting.size;
    let [memory, f32, upload] = percents(row, peaks).map(|percent| format!("{percent:.2}"));
    let (device, counts) = (&row.report.device, &row.report.counts);
    let mut cells = vec![row.transfer.to_owned(), width.to_string(), height.to_string()];
    cells.extend([row.setting.light().to_owned(), format!("{:e}", row.setting.tolerance)]);
    cells.extend([ms(row.device_s()), u8::from(device.device_s.is_some()).to_string()]);
    cells.extend([ms(row.report.timing.prepare_s), ms(device.upload_s), device.bytes_uploaded.to_string()]);
    cells.extend([ms(row.end_s), ms(row.cpu_s), counts.columns.to_string(), counts.frusta.to_string()]);
    cells.push(format!("{:.4e}", row.rate()));
    cells.extend([format!("{:.0}", row.cost.bytes), memory, format!("{:.0}", row.cost.flops), f32]);
    cells.extend([format!("{:.4e}", row.upload()), upload]);
    cells.extend([row.difference.rmse, row.difference.max].map(|difference| format!("{difference:.2e}")));
    cells
}

/// The device's rates in words.
pub(super) fn peaks(peaks: &Peaks) -> String {
    let giga = |rate: f64| format!("{:.*}", if rate < 1e11 { 1 } else { 0 }, 1e-9 * rate);
    format!(
        "host to device {} GB/s ({} through a staging buffer), back {} GB/s, memory {} GB/s, f32 {} Gflop/s",
        giga(peaks.host_to_device),
        giga(peaks.staged),
        giga(peaks.readback),
        giga(peaks.memory),
        giga(peaks.flops)
    )
}

fn ms(seconds: f64) -> String {
    three_digits(1e3 * seconds)
}

/// Minimum and maximum of a number over pictures.
fn span(rows: &[Row], number: impl Fn(&Row) -> f64, show: impl Fn(f64) -> String) -> String {
    let numbers = || rows.iter().map(&number);
    let (min, max) = (show(numbers().fold(f64::INFINITY, f64::min)), show(numbers().fold(f64::NEG_INFINITY, f64::max)));
    if min == max { max } else { format!("{min} to {max}") }
}

/// Two tables, a row for each size, light and tolerance.
pub(super) fn markdown(all: &[Vec<Row>], grid: &str, name: &str, benchmark: &Benchmark) -> String {
    let mut text = format!(
        "Milliseconds for a frame of {grid}, 16 knots, f32, on {name}: by the device's clock, from end to end with upload and \
         readback in brackets, and on the CPU's {}:\n\n\
         | `icoray-study gpu` | | | dense | lobes | thin shell | opaque |\n|---|---|---|---|---|---|---|\n\
         | the paper, one GTX 580, 512 × 512, its four fields | unlit | | 494 | 783 | 755 | 689 |\n",
        threads(benchmark.cpu.threads())
    );
    for rows in all {
        let setting = rows[0].setting;
        let (width, height) = setting.size;
        let _ = write!(text, "| {width} × {height} | {} | {:e} |", setting.light(), setting.tolerance);
        for row in rows {
            let _ = write!(text, " {} ({}); {} |", ms(row.device_s()), ms(row.end_s), ms(row.cpu_s));
        }
        text += "\n";
    }
    let _ = write!(
        text,
        "\nMinimum and maximum over the four transfer functions; percents are of what was measured in the same run ({}). A frustum \
         counts as 12 bytes and 224 operations, a column as 64 and 1087, a pixel as 44 bytes; light as 36 bytes more in each \
         frustum and column. Caches give a part of the bytes again. Differences are from the CPU's picture:\n\n\
         | | | | frusta/s | of memory | of f32 | upload, GB/s | of host to device | RMSE | largest |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
        peaks(&benchmark.peaks)
    );
    let whole = |percent: f64| format!("{percent:.0} %");
    let small = |number: f64| format!("{number:.1e}");
    for rows in all {
        let setting = rows[0].setting;
        let max = |number: fn(&Row) -> f64| small(rows.iter().map(number).fold(0.0, f64::max));
        let _ = writeln!(
            text,
            "| {} × {} | {} | {:e} | {} | {} | {} | {} | {} | {} | {} |",
            setting.size.0,
            setting.size.1,
            setting.light(),
            setting.tolerance,
            span(rows, Row::rate, small),
            span(rows, |gpu| percents(gpu, &benchmark.peaks)[0], whole),
            span(rows, |gpu| percents(gpu, &benchmark.peaks)[1], whole),
            span(rows, |gpu| 1e-9 * gpu.upload(), |rate| format!("{rate:.1}")),
            span(rows, |gpu| percents(gpu, &benchmark.peaks)[2], whole),
            max(|gpu| gpu.difference.rmse),
            max(|gpu| gpu.difference.max)
        );
    }
    text
}
