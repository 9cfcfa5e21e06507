//! The multi-scale field under four transfer functions of 16 knots, from dense to opaque.

use icoray::{Result, Scene};
use std::fmt::Write as _;

/// The opacity of a shell's thickness at a value.
pub(crate) type Opacity = fn(f64) -> f64;

/// The range of the transfer functions.
pub(crate) const RANGE: [f64; 2] = [-1.0, 1.0];

/// Name and opacity of each transfer function over [`RANGE`].
pub(crate) const TRANSFERS: [(&str, Opacity); 4] = [
    ("dense", |_| 0.5),
    ("lobes", |v| if v.abs() > 0.3 { 0.98 * (v.abs() - 0.3) / 0.7 } else { 0.0 }),
    ("thin", |v| if (0.45..0.62).contains(&v) { 0.98 } else { 0.0 }),
    ("opaque", |v| if v > -0.2 { 0.999_999_9 } else { 0.0 }),
];

/// The scene of a transfer function; `rest` are lines before the tables, `light` tables after them.
pub(crate) fn scene(size: u32, opacity: Opacity, rest: &str, light: &str) -> Result<Scene> {
    let mut knots = String::new();
    for i in 0..16 {
        let v = RANGE[0] + (RANGE[1] - RANGE[0]) * f64::from(i) / 15.0;
        let (red, blue) = (128 + 8 * i, 255 - 12 * i);
        let _ = writeln!(
            knots,
            "  {{ value = {v}, color = \"rgb({red} {} {blue})\", opacity = {} }},",
            90 + 6 * (i % 5),
            opacity(v)
        );
    }
    globe("multi-scale", size, rest, &format!("knots = [\n{knots}]\n{light}"))
}

/// The table of a light from the eye.
pub(crate) const HEADLIGHT: &str = "[light]\nkind = \"headlight\"";

/// A scene of the whole globe: `rest` are lines before the tables, `transfer` is the text behind the header of the last
/// table.
pub(crate) fn globe(field: &str, size: u32, rest: &str, transfer: &str) -> Result<Scene> {
    Scene::parse(&format!(
        "field = \"{field}\"\nantialias = false\n{rest}\n[image]\nwidth = {size}\nheight = {size}\n\
         [camera]\nlon = 30\nlat = 25\ndistance = 3.2\nfov = 45\n[transfer]\n{transfer}\n"
    ))
}
