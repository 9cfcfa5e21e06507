//! An ocean without land cells, under which only the core is drawn: synthetic temperatures on a real mesh of
//! MPAS-Ocean.

use crate::made::{Made, Values};
use crate::real::{data, example};
use crate::run::{Folder, has, icoray, prints, shows_something};
use netcdf::Options;
use std::path::{Path, PathBuf};

/// Depths of the layers' bottoms.
const DEPTH_M: [f64; 12] = [50., 100., 200., 350., 550., 800., 1200., 1700., 2400., 3300., 4400., 5500.];

/// A history of one time: warm water near the surface of the tropics, a thermocline that rises and falls, and a floor
/// that is shallow at coasts and ridges. Only the mesh's cells are real.
fn history(mesh: &Path) -> Made {
    let file = icoray_netcdf::open(mesh).unwrap();
    let at = file.mesh().tables().center;
    let layers = DEPTH_M.len();
    let (mut temperature, mut levels) = (Vec::new(), Vec::new());
    for cell in 0..file.mesh().cells() {
        let (lon, lat) = (at.lon_rad.get(cell), at.lat_rad.get(cell));
        let ridge = (3.0 * lon + (4.0 * lat).sin()).sin() * (2.0 * lat + 0.5).cos();
        let depth = 4200.0 - 3000.0 * ridge.max(0.0);
        let last = DEPTH_M.iter().filter(|bottom| **bottom <= depth).count();
        let bend = 1.0 + 0.6 * (5.0 * lon).sin() * (6.0 * lat).cos();
        levels.push(last as i32);
        temperature.extend((0..layers).map(|layer| {
            let surface = 28.0 * lat.cos().powi(2) - 1.0;
            let below = (-DEPTH_M[layer] / (400.0 * bend)).exp();
            // Below its floor MPAS-Ocean writes a large number, which no attribute need declare.
            if layer < last { (1.5 + (surface - 1.5) * below) as f32 } else { -1e34 }
        }));
    }
    let mut made = Made::of(
        [("nCells", levels.len()), ("nVertLevels", layers), ("StrLen", 64), ("Time", 0)],
        [("on_a_sphere", "YES".into()), ("sphere_radius", 6_371_220.0.into())],
    );
    made.add("refBottomDepth", &["nVertLevels"], Values::F64(DEPTH_M.to_vec()));
    made.add("maxLevelCell", &["nCells"], Values::I32(levels));
    made.add("xtime", &["Time", "StrLen"], Values::Text(format!("{:<64}", "0010-07-01_00:00:00").into_bytes()));
    made.add("temperature", &["Time", "nCells", "nVertLevels"], Values::F32(temperature));
    made.last().attributes = vec![("units", "degrees Celsius".into()), ("long_name", "potential temperature".into())];
    made
}

#[test]
fn the_ocean_ends_at_coasts_and_at_its_floor() {
    let Some(mesh) = data("spherical_grid_500km_landculled.nc") else { return };
    let folder = Folder::new();
    // A place to look at the picture, and at the file, afterwards.
    let kept = std::env::var_os("ICORAY_TEST_KEEP").map(PathBuf::from);
    let at = kept.as_deref().unwrap_or(folder.path());
    history(Path::new(&mesh)).write_to(&at.join("ocean.nc"), Options::_64BIT_DATA);
    let size = if kept.is_some() { "720x540" } else { "96x72" };
    let input = ["ocean.nc", "--mesh", &mesh];
    let options = ["--scene", &example("ocean"), "--size", size, "-o", "ocean.png"];
    let text = prints(icoray(at).arg("render").args(input).args(options));
    has(&text, &["field     temperature at cells, 12 layers, time 0 (0010-07-01_00:00:00)", " degrees Celsius, "]);
    // -1e34 is not in the range, and what is below the floor is missing.
    let range = text.lines().find(|line| line.starts_with("range")).unwrap();
    let words: Vec<&str> = range.split_whitespace().collect();
    let (low, high) = (words[1].parse::<f64>().unwrap(), words[3].parse::<f64>().unwrap());
    assert!(low > -2.0 && high < 30.0, "{range}");
    assert!(words[words.len() - 2].parse::<usize>().unwrap() > 2000, "{range}");
    let (width, height) = size.split_once('x').unwrap();
    shows_something(&at.join("ocean.png"), width.parse().unwrap(), height.parse().unwrap());
    let text = prints(icoray(at).arg("info").args(input));
    has(&text, &["12 between 13 interfaces (refBottomDepth): from 0.0 m to -5500.0 m", "is not known"]);
}
