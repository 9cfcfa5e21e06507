//! The sample file that the command writes.

use crate::run::{Folder, has};
use std::fs;

/// Values of a field at a time.
fn values(file: &icoray_netcdf::Dataset, name: &str, time: usize) -> Vec<f64> {
    let read = file.read_field(name, time).unwrap();
    let values = read.values();
    (0..values.len()).map(|i| values.get(i)).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[test]
fn the_sample_is_small_conserves_its_tracer_and_shows_its_fields() {
    let folder = Folder::new();
    let printed = folder.prints("sample s.nc");
    assert_eq!(printed, "sample    s.nc; icoray render s.nc draws it\n");
    let path = folder.at("s.nc");
    assert!(fs::metadata(&path).unwrap().len() < 2_000_000);
    let file = icoray_netcdf::open(&path).unwrap();
    let names: Vec<&str> = file.likely_fields().iter().map(|info| info.name.as_str()).collect();
    assert_eq!(names, ["tracer", "theta", "vorticity"]);
    // The flow has no divergence: what it carries keeps its mean over the cells, which have nearly one area, while it
    // moves.
    for (name, spread) in [("tracer", 1.0), ("theta", 45.0)] {
        let [early, late] = [0, 1].map(|time| values(&file, name, time));
        let moved = early.iter().zip(&late).map(|(early, late)| (late - early).abs()).fold(0.0, f64::max);
        assert!((mean(&early) - mean(&late)).abs() < 0.005 * spread && moved > 0.3 * spread, "{name}: {moved}");
    }
    // The circulation around a sphere is 0.
    let vorticity = values(&file, "vorticity", 0);
    let largest = vorticity.iter().copied().fold(0.0, f64::max);
    assert!(mean(&vorticity).abs() < 0.02 * largest && (5e-5..2e-4).contains(&largest), "{largest}");
    // Its first pictures show the fields.
    for field in names {
        let text = folder.prints(&format!("render s.nc --field {field} --size 120x96 -o a.png"));
        has(&text, &["time 1 (2000-01-03_00:00:00)"]);
        let picture = image::open(folder.at("a.png")).unwrap().to_rgb8();
        // The ground is grey.
        let is_shown = |pixel: &&image::Rgb<u8>| pixel.0.iter().max().unwrap() - pixel.0.iter().min().unwrap() > 60;
        let share = picture.pixels().filter(is_shown).count() as f64 / (120.0 * 96.0);
        assert!((0.05..0.7).contains(&share), "{field}: {share}");
    }
}
