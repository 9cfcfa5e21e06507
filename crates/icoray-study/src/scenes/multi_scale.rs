//! The multi-scale field under four transfer functions of 16 knots, from dense to opaque.

use icoray::{Result, Scene};

/// The opacity of a shell's thickness at a value.
pub(crate) type Opacity = fn(f64) -> f64;

pub(crate) const RANGE: [f64; 2] = [-1.0, 1.0];

/// Name and opacity of each transfer function over [`RANGE`].
pub(crate) const TRANSFERS: [(&str, Opacity); 4] = [
    ("dense", |_| 0.5),
    ("lobes", lobes),
    ("thin", |v| if (0.45..0.62).contains(&v) { 0.98 } else { 0.0 }),
    ("opaque", |v| if v > -0.2 { 0.999_999_9 } else { 0.0 }),
];

pub(crate) fn lobes(value: f64) -> f64 {
    if value.abs() > 0.3 { 0.98 * (value.abs() - 0.3) / 0.7 } else { 0.0 }
}

/// The scene of a transfer function; `rest` are lines before the tables, `light` tables after them.
pub(crate) fn scene(size: u32, opacity: Opacity, rest: &str, light: &str) -> Result<Scene> {
    globe("multi-scale", size, rest, &format!("knots = [\n{}]\n{light}", knots(16, opacity)))
}

/// The text of `count` knots over [`RANGE`], whose colours are not on a line.
pub(crate) fn knots(count: u32, opacity: Opacity) -> String {
    let knot = |i| {
        let v = RANGE[0] + (RANGE[1] - RANGE[0]) * f64::from(i) / f64::from(count - 1);
        let place = i * 16 / count;
        let (red, green, blue) = (128 + 8 * place, 90 + 6 * (i % 5), 255 - 12 * place);
        let opacity = opacity(v);
        format!("  {{ value = {v}, color = \"rgb({red} {green} {blue})\", opacity = {opacity} }},\n")
    };
    (0..count).map(knot).collect()
}

/// The text of a volume with these knots.
pub(crate) fn volume(field: &str, knots: &str) -> String {
    format!("[[volumes]]\nfield = \"{field}\"\ntransfer = {{ knots = [\n{knots}] }}\n")
}

pub(crate) const HEADLIGHT: &str = "[light]\nkind = \"headlight\"";

/// A scene of the whole globe: `rest` are lines before the tables, `transfer` is the text behind the header of the last
/// table.
pub(crate) fn globe(field: &str, size: u32, rest: &str, transfer: &str) -> Result<Scene> {
    view(size, &format!("field = \"{field}\"\n{rest}\n[transfer]\n{transfer}\n"))
}

/// A scene of the whole globe from the text of all but picture and camera.
pub(crate) fn view(size: u32, scene: &str) -> Result<Scene> {
    Scene::parse(&format!(
        "antialias = false\n{scene}\n[image]\nwidth = {size}\nheight = {size}\n\
         [camera]\nlon = 30\nlat = 25\ndistance = 3.2\nfov = 45\n"
    ))
}
