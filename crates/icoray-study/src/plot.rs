//! Charts of error and time on logarithmic axes, as SVG.

use crate::results::{io_error, write_file};
use icoray::Result;
use plotters::coord::combinators::WithKeyPoints;
use plotters::prelude::*;
use std::path::Path;

/// Colours for the colour-blind (Okabe and Ito), the first for the subject of a chart.
const COLORS: [RGBColor; 10] = [
    RGBColor(213, 94, 0),
    RGBColor(230, 159, 0),
    RGBColor(0, 0, 0),
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(86, 180, 233),
    RGBColor(120, 120, 120),
    RGBColor(204, 121, 167),
    RGBColor(120, 60, 150),
    RGBColor(110, 70, 20),
];

const SIZE: (u32, u32) = (900, 560);
const LEGEND: u32 = 250;
/// Lower limit of coordinates: a logarithmic axis has no zero.
const LEAST: f64 = 1e-12;

#[derive(Debug, Clone)]
pub struct Line {
    pub name: String,
    /// Which colour and marker: equal for the same method in all charts.
    pub style: usize,
    /// Points in the order in which they are joined.
    pub points: Vec<(f64, f64)>,
}

/// A chart on logarithmic axes.
pub struct Chart {
    pub title: String,
    pub x: String,
    pub y: String,
    pub lines: Vec<Line>,
}

impl Chart {
    /// Writes the chart as SVG.
    pub fn write(&self, path: &Path) -> Result<()> {
        let mut text = String::new();
        self.draw(&mut text).map_err(|e| io_error(path, e.to_string()))?;
        write_file(path, text)
    }

    fn draw<'t>(&self, text: &'t mut String) -> std::result::Result<(), Box<dyn std::error::Error + 't>> {
        let root = SVGBackend::with_string(text, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let (left, right) = root.split_horizontally(SIZE.0 - LEGEND);
        let points = || self.lines.iter().flat_map(|line| line.points.iter().map(|p| shown(*p)));
        let x = Axis::new(points().map(|p| p.0));
        let y = Axis::new(points().map(|p| p.1));
        let mut chart = ChartBuilder::on(&left)
            .caption(&self.title, ("sans-serif", 20))
            .margin(12)
            .x_label_area_size(48)
            .y_label_area_size(76)
            .build_cartesian_2d(x.range(), y.range())?;
        chart
            .configure_mesh()
            .x_desc(&self.x)
            .y_desc(&self.y)
            .x_label_formatter(&label)
            .y_label_formatter(&label)
            .label_style(("sans-serif", 14))
            .axis_desc_style(("sans-serif", 16))
            .bold_line_style(RGBColor(190, 190, 190))
            .light_line_style(RGBColor(235, 235, 235))
            .draw()?;
        // The first line is drawn last, over the others.
        for line in self.lines.iter().rev() {
            let color = COLORS[line.style % COLORS.len()];
            let mark = |at| EmptyElement::at(at) + Polygon::new(outline(line.style), color.filled());
            let width = if line.style == 0 { 3 } else { 2 };
            let points = line.points.iter().map(|p| shown(*p));
            chart.draw_series(LineSeries::new(points.clone(), color.stroke_width(width)))?;
            chart.draw_series(points.map(mark))?;
        }
        for (row, line) in (0i32..).zip(&self.lines) {
            let (y, color) = (60 + 28 * row, COLORS[line.style % COLORS.len()]);
            right.draw(&PathElement::new([(6, y), (38, y)], color.stroke_width(2)))?;
            let mark = EmptyElement::at((22, y)) + Polygon::new(outline(line.style), color.filled());
            right.draw(&mark)?;
            right.draw(&Text::new(line.name.clone(), (46, y - 6), ("sans-serif", 14)))?;
        }
        root.present()?;
        Ok(())
    }
}

fn shown((x, y): (f64, f64)) -> (f64, f64) {
    (x.clamp(LEAST, 1.0 / LEAST), y.clamp(LEAST, 1.0 / LEAST))
}

/// A logarithmic axis: its ends, the values with labels, and those between.
struct Axis {
    ends: [f64; 2],
    labelled: Vec<f64>,
    light: Vec<f64>,
}

impl Axis {
    /// Around the values, with a margin; at least two thirds of a decade.
    fn new(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values.fold((f64::INFINITY, 0.0f64), |(l, h), v| (l.min(v), h.max(v)));
        let (low, high) = if low > high { (0.1, 10.0) } else { (low, high) };
        let (low, high) = (low.log10(), high.log10());
        let margin = (0.05 * (high - low)).max(1.0 / 3.0 - 0.5 * (high - low)).max(0.05);
        let (low, high) = (low - margin, high + margin);
        let digits: &[u32] = if high - low < 2.2 { &[1, 2, 5] } else { &[1] };
        let inside = |v: &f64| (low..=high).contains(&v.log10());
        let decades = (low.floor() as i32)..=(high.ceil() as i32);
        // Powers of ten are read from text: products of rounded ones would not be the nearest numbers.
        let of = move |digits: Vec<u32>| {
            let ticks = decades.clone().flat_map(move |e| {
                let read = |d: &u32| format!("{d}e{e}").parse::<f64>().unwrap_or(f64::NAN);
                digits.iter().map(read).collect::<Vec<_>>()
            });
            ticks.filter(inside).collect::<Vec<f64>>()
        };
        Axis { ends: [10f64.powf(low), 10f64.powf(high)], labelled: of(digits.to_vec()), light: of((2..10).collect()) }
    }

    fn range(self) -> WithKeyPoints<LogCoord<f64>> {
        let [low, high] = self.ends;
        (low..high).log_scale().with_key_points(self.labelled).with_light_points(self.light)
    }
}

/// A number in decimal notation near 1, else as a multiple of a power of ten.
fn label(value: &f64) -> String {
    let text = format!("{value:e}");
    let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    if (1e-3..1e4).contains(value) {
        return format!("{value}");
    }
    let raised = |c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        c => char::from_u32('⁰' as u32 + c as u32 - '0' as u32).unwrap_or(c),
    };
    let power: String = exponent.chars().map(raised).collect();
    if digits == "1" { format!("10{power}") } else { format!("{digits}·10{power}") }
}

/// A marker's outline in pixels around its point: a disc, square, diamond, triangle or hourglass. Styles of like
/// colours have other shapes.
fn outline(style: usize) -> Vec<(i32, i32)> {
    match style {
        0 | 5 => vec![(2, 5), (5, 2), (5, -2), (2, -5), (-2, -5), (-5, -2), (-5, 2), (-2, 5)],
        1 | 6 => vec![(-5, -5), (5, -5), (5, 5), (-5, 5)],
        2 | 7 => vec![(0, -6), (6, 0), (0, 6), (-6, 0)],
        3 => vec![(0, -6), (6, 5), (-6, 5)],
        4 => vec![(0, 6), (6, -5), (-6, -5)],
        _ => vec![(-6, -6), (6, -6), (-6, 6), (6, 6)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_short() {
        for (value, text) in
            [(1e-3, "0.001"), (0.2, "0.2"), (1.0, "1"), (1e3, "1000"), (1e-12, "10⁻¹²"), (5e4, "5·10⁴")]
        {
            assert_eq!(label(&value), text);
        }
    }

    #[test]
    fn axes_have_labels_inside_their_ends() {
        let axis = Axis::new([0.02, 30.0].into_iter());
        assert_eq!(axis.labelled, [0.1, 1.0, 10.0]);
        assert!(axis.ends[0] < 0.02 && axis.ends[1] > 30.0);
        assert!(axis.light.contains(&0.02) && !axis.light.contains(&1.0));
        // However near the values lie, two labels at least.
        for value in [1.0, 1.3, 1.5, 2.0, 3.0, 5.0, 7.0, 9.9] {
            assert!(Axis::new([value].into_iter()).labelled.len() >= 2, "{value}");
        }
        assert!(Axis::new(std::iter::empty()).labelled.len() >= 2);
    }
}
