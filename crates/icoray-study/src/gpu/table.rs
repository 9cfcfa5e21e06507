//! Measurements as rows of a table, and as tables in Markdown.

use super::benchmark::{Benchmark, OnGpu, Row};
use crate::results::{threads, three_digits};
use icoray_gpu::Peaks;
use std::fmt::Write as _;

pub(super) const COLUMNS: &str = "transfer,width,height,light,tolerance,device_ms,device_clock,prepare_ms,upload_ms,\
    bytes_uploaded,end_to_end_ms,cpu_ms,columns,frusta,frusta_per_s,bytes_read,memory_percent,flops,\
    f32_percent,upload_bytes_per_s,upload_percent,rmse_to_cpu,max_to_cpu,left_to_cpu";

pub(super) const PRINTED: &str = "transfer,width,height,light,tolerance,device_ms,upload_ms,end_to_end_ms,cpu_ms,\
    frusta_per_s,memory_percent,f32_percent,upload_percent,rmse_to_cpu,max_to_cpu,left_to_cpu";

fn percent(rate: f64, max: f64) -> f64 {
    100.0 * rate / max
}

/// Percents of the device's memory, arithmetic and bus.
fn percents(gpu: &OnGpu, peaks: &Peaks) -> [f64; 3] {
    [
        percent(gpu.cost.bytes / gpu.device_s(), peaks.memory),
        percent(gpu.cost.flops / gpu.device_s(), peaks.flops),
        percent(gpu.upload(), peaks.host_to_device),
    ]
}

/// A row's cells; those of the GPU are empty if the picture was left to the CPU.
pub(super) fn cells(row: &Row, peaks: &Peaks) -> Vec<String> {
    let ms = |seconds: f64| format!("{:.4}", 1e3 * seconds);
    let (width, height) = row.setting.size;
    let mut cells = vec![row.transfer.to_owned(), width.to_string(), height.to_string()];
    cells.extend([row.setting.light().to_owned(), format!("{:e}", row.setting.tolerance)]);
    let gpu = match &row.gpu {
        Ok(gpu) => gpu,
        Err(reason) => {
            cells.extend([const { String::new() }; 19]);
            (cells[11], cells[23]) = (ms(row.cpu_s), reason.clone());
            return cells;
        }
    };
    let [memory, f32, upload] = percents(gpu, peaks).map(|percent| format!("{percent:.2}"));
    let (device, counts) = (&gpu.report.device, &gpu.report.counts);
    cells.extend([ms(gpu.device_s()), u8::from(device.device_s.is_some()).to_string()]);
    cells.extend([ms(gpu.report.timing.prepare_s), ms(device.upload_s), device.bytes_uploaded.to_string()]);
    cells.extend([ms(gpu.end_s), ms(row.cpu_s), counts.columns.to_string(), counts.frusta.to_string()]);
    cells.push(format!("{:.4e}", gpu.rate()));
    cells.extend([format!("{:.0}", gpu.cost.bytes), memory, format!("{:.0}", gpu.cost.flops), f32]);
    cells.extend([
        format!("{:.4e}", gpu.upload()),
        upload,
        format!("{:.2e}", gpu.difference.rmse),
        format!("{:.2e}", gpu.difference.max),
    ]);
    cells.push(String::new());
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
fn span(rows: &[&OnGpu], number: impl Fn(&OnGpu) -> f64, show: impl Fn(f64) -> String) -> String {
    let numbers = || rows.iter().map(|gpu| number(gpu));
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
            let cell = match &row.gpu {
                Ok(gpu) => format!(" {} ({}); {} |", ms(gpu.device_s()), ms(gpu.end_s), ms(row.cpu_s)),
                Err(_) => format!(" -; {} |", ms(row.cpu_s)),
            };
            text += &cell;
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
        let drawn: Vec<&OnGpu> = rows.iter().filter_map(|row| row.gpu.as_ref().ok()).collect();
        if drawn.is_empty() {
            continue;
        }
        let setting = rows[0].setting;
        let max = |number: fn(&OnGpu) -> f64| small(drawn.iter().map(|gpu| number(gpu)).fold(0.0, f64::max));
        let _ = writeln!(
            text,
            "| {} × {} | {} | {:e} | {} | {} | {} | {} | {} | {} | {} |",
            setting.size.0,
            setting.size.1,
            setting.light(),
            setting.tolerance,
            span(&drawn, OnGpu::rate, small),
            span(&drawn, |gpu| percents(gpu, &benchmark.peaks)[0], whole),
            span(&drawn, |gpu| percents(gpu, &benchmark.peaks)[1], whole),
            span(&drawn, |gpu| 1e-9 * gpu.upload(), |rate| format!("{rate:.1}")),
            span(&drawn, |gpu| percents(gpu, &benchmark.peaks)[2], whole),
            max(|gpu| gpu.difference.rmse),
            max(|gpu| gpu.difference.max)
        );
    }
    let reasons = all.iter().flatten().filter_map(|row| row.gpu.as_ref().err());
    let mut printed: Vec<&String> = Vec::new();
    for reason in reasons {
        if !printed.contains(&reason) {
            let _ = write!(text, "\nLeft to the CPU (-): {reason}\n");
            printed.push(reason);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::benchmark::Setting;
    use super::*;

    #[test]
    fn a_picture_that_is_left_to_the_cpu_has_its_reason() {
        let setting = Setting { size: (8, 4), is_lit: true, tolerance: 1e-2 };
        let row = Row { setting, transfer: "dense", gpu: Err("too large".into()), cpu_s: 0.25 };
        let peaks = Peaks { host_to_device: 1.0, staged: 1.0, readback: 1.0, memory: 1.0, flops: 1.0 };
        let cells = cells(&row, &peaks);
        let cell = |name: &str| cells[COLUMNS.split(',').position(|known| known == name).unwrap()].as_str();
        assert_eq!(cells.len(), COLUMNS.split(',').count());
        assert_eq!((cell("cpu_ms"), cell("left_to_cpu"), cell("device_ms")), ("250.0000", "too large", ""));
        assert_eq!((cell("transfer"), cell("light"), cell("tolerance")), ("dense", "lit", "1e-2"));
    }
}
