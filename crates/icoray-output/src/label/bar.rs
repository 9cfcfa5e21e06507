//! The colour bar: colour and opacity of each value.
//!
//! Values run along the bar. Across it, the part away from the ticks shows the colour itself, and none where the
//! opacity is zero; the part beside the ticks shows the colour with the opacity of one unit of length. Both are drawn
//! over a grey checkerboard. If the opacity does not depend on the value, the whole breadth shows the colour. An end beyond
//! which the field has values has an arrow.

use super::block::Block;
use super::canvas::srgb_byte;
use super::font::{Mask, Size};
use super::ticks::{Ticks, ticks};
use icoray_scene::painting::{OpacityOf, Painting};
use icoray_scene::{Scale, Scene, TransferFunction};
use std::array;

/// Linear greys of the checks.
const CHECKS: [f64; 2] = [0.20, 0.42];

/// The subject of a bar.
pub(super) struct Bar<'s> {
    /// The field whose values are shown.
    pub field: &'s str,
    /// The field that determines the opacity, if it is another one.
    pub opacity_by: Option<&'s str>,
    scale: Scale,
    range: [f64; 2],
    transfer: &'s TransferFunction,
    shows_opacity: bool,
    /// Least and greatest value of the field, if known.
    pub values: Option<[f64; 2]>,
}

/// Sizes in pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sizes {
    /// Text of the ticks.
    pub text: Size,
    /// Text of the caption.
    pub caption: Size,
    /// The bar's breadth.
    pub breadth: i64,
    /// Length of a tick.
    pub tick: i64,
    /// Gap between items.
    pub gap: i64,
    /// Breadth of lines.
    pub line: i64,
}

impl Sizes {
    /// Sizes beside a caption of `em` pixels per em.
    pub fn of(em: f64) -> Self {
        let pixels = |ems: f64| ((em * ems).round() as i64).max(1);
        Sizes {
            text: Size((0.9 * em) as f32),
            caption: Size(em as f32),
            breadth: pixels(1.2),
            tick: pixels(0.3),
            gap: pixels(0.3),
            line: pixels(0.07),
        }
    }

    /// Length of an arrow.
    fn arrow(self) -> i64 {
        (self.breadth / 2).max(2)
    }
}

impl<'s> Bar<'s> {
    /// A bar of all colours of a transfer function, opaque.
    pub fn opaque(scale: Scale, transfer: &'s TransferFunction) -> Self {
        Bar {
            field: "",
            opacity_by: None,
            scale,
            range: transfer.range(),
            transfer,
            shows_opacity: false,
            values: None,
        }
    }

    /// The bars of a scene: one for each distinct colouring by values. The legend has the colours of isosurfaces.
    pub fn all(scene: &'s Scene) -> Vec<Self> {
        let mut shown: Vec<Painting> = Vec::new();
        for painting in scene.paintings().into_iter().filter(|painting| !painting.has_one_value) {
            let has_own = painting.opacity != OpacityOf::Surface;
            if !shown.iter().any(|before| *before == painting || !has_own && has_colors_of(before, &painting)) {
                shown.push(painting);
            }
        }
        shown.into_iter().filter_map(Self::of).collect()
    }

    /// `None` if colours do not depend on the value.
    fn of(painting: Painting<'s>) -> Option<Self> {
        let Painting { field, transfer, coloring, opacity, has_one_value: _ } = painting;
        let coloring = coloring.and_then(|coloring| Some((coloring.scale(), coloring.fixed()?)));
        let (scale, range) = coloring.unwrap_or((Scale::Linear, transfer.range()));
        let opacity_by = if let OpacityOf::Other(other) = opacity { Some(other.field.as_str()) } else { None };
        let shows_opacity = opacity == OpacityOf::Itself;
        let values = None;
        (range[0] < range[1]).then_some(Bar { field, opacity_by, scale, range, transfer, shows_opacity, values })
    }

    /// The arrow at an end with values beyond it, pointing upwards, and its colour; that of the text at a clear end.
    fn arrow(&self, end: usize, sizes: Sizes) -> Option<(Mask, Option<[u8; 3]>)> {
        let values = self.values?;
        let is_beyond = if end == 0 { values[0] < self.range[0] } else { values[1] > self.range[1] };
        let (color, extinction) = self.transfer.at(self.range[end]);
        let color = (extinction > 0.0).then(|| color.map(|channel| srgb_byte(channel as f32)));
        let width = sizes.breadth + 2 * sizes.line;
        is_beyond.then(|| (Mask::triangle(width, sizes.arrow()), color))
    }

    /// Distance of a value from the bar's start, in pixels, on a bar of `length` pixels.
    fn along(&self, value: f64, length: i64) -> i64 {
        let [low, high] = self.range.map(|end| self.scale.forward(end));
        let part = (self.scale.forward(value) - low) / (high - low);
        ((part * length as f64).floor() as i64).clamp(0, length - 1)
    }

    /// The colours of pixel `at` of `length` along the bar, over its breadth from the far side to the ticks.
    fn across(&self, at: i64, length: i64, breadth: i64) -> impl Iterator<Item = [u8; 3]> {
        let [low, high] = self.range.map(|end| self.scale.forward(end));
        let place = low + (high - low) * (at as f64 + 0.5) / length as f64;
        let (color, extinction) = self.transfer.at(self.scale.backward(place));
        let solid = if extinction > 0.0 { 1.0 } else { 0.0 };
        let seen = if self.shows_opacity { -(-extinction).exp_m1() } else { solid };
        let check = (breadth / 6).max(2);
        (0..breadth).map(move |i| {
            let opacity = if 2 * i < breadth { solid } else { seen };
            let grey = CHECKS[((at / check + i / check) % 2) as usize];
            array::from_fn(|k| srgb_byte((opacity * color[k] + (1.0 - opacity) * grey) as f32))
        })
    }

    /// The largest number of labelled ticks whose labels do not overlap, along `length` pixels.
    fn ticks(&self, length: i64, room: impl Fn(&str) -> i64) -> Ticks {
        const MAX_TICKS: usize = 9;
        let fits = |ticks: &Ticks| {
            let pairs = ticks.major.windows(2);
            let mut apart = pairs.map(|pair| {
                let [a, b] = [&pair[0], &pair[1]].map(|(value, _)| self.along(*value, length));
                (b - a) - (room(&pair[0].1) + room(&pair[1].1)) / 2
            });
            apart.all(|apart| apart >= 0)
        };
        let mut tried = (2..=MAX_TICKS).rev().map(|max_width| ticks(self.scale, self.range, max_width));
        tried.find(fits).unwrap_or_else(|| ticks(self.scale, self.range, 2))
    }

    /// A vertical bar: values rise upwards, ticks and caption are at its right. The caption is at most `max_width` long.
    pub fn upright(&self, length: i64, max_width: i64, sizes: Sizes, caption: impl Fn(i32) -> Vec<String>) -> Block {
        let Sizes { text, breadth, tick, gap, line, .. } = sizes;
        let ticks = self.ticks(length, |_| text.height());
        let caption = caption_mask(&caption(ticks.exponent), sizes, max_width).upwards();
        let labels: Vec<Mask> = ticks.major.iter().map(|(_, label)| text.line(label)).collect();
        let widest = labels.iter().map(|mask| mask.width).max().unwrap_or(0);
        // Labels of the ends and a long caption extend beyond the bar.
        let top = (text.height() / 2).max((caption.height - length) / 2).max(line + sizes.arrow());
        let mut block = Block::default();
        if let Some((mask, color)) = self.arrow(0, sizes) {
            block.mark(0, top + length + line, mask.upwards().upwards(), color);
        }
        if let Some((mask, color)) = self.arrow(1, sizes) {
            block.mark(0, top - line - mask.height, mask, color);
        }
        let colors = (0..length).rev().flat_map(|at| self.across(at, length, breadth)).collect();
        block.colors(line, top, breadth, colors);
        block.outline([0, top - line, breadth + 2 * line, length + 2 * line], line);
        let x = breadth + 2 * line;
        let row = |value: f64| top + length - 1 - self.along(value, length);
        for value in &ticks.minor {
            block.rule(x, row(*value) - line / 2, tick / 2, line);
        }
        for ((value, _), mask) in ticks.major.iter().zip(labels) {
            block.rule(x, row(*value) - line / 2, tick, line);
            block.text(x + tick + gap, row(*value) - text.middle(), mask);
        }
        let y = top + (length - caption.height) / 2;
        block.text(x + tick + 2 * gap + widest, y, caption);
        block.height = block.height.max(2 * top + length);
        block
    }

    /// A horizontal bar: values rise to the right, ticks and caption are below it.
    pub fn lying(&self, length: i64, max_width: i64, sizes: Sizes, caption: impl Fn(i32) -> Vec<String>) -> Block {
        let Sizes { text, breadth, tick, gap, line, .. } = sizes;
        let ticks = self.ticks(length, |label| text.width(label) + 2 * gap);
        let caption = caption_mask(&caption(ticks.exponent), sizes, max_width);
        let labels: Vec<Mask> = ticks.major.iter().map(|(_, label)| text.line(label)).collect();
        let column = |value: f64| self.along(value, length);
        let ends = ticks.major.iter().zip(&labels).map(|((value, _), mask)| {
            let half = (mask.width + 1) / 2;
            (half - column(*value)).max(column(*value) + half - length)
        });
        let left = ends.max().unwrap_or(0).max((caption.width - length) / 2).max(line + sizes.arrow());
        let mut block = Block::default();
        if let Some((mask, color)) = self.arrow(0, sizes) {
            block.mark(left - line - mask.height, 0, mask.upwards(), color);
        }
        if let Some((mask, color)) = self.arrow(1, sizes) {
            block.mark(left + length + line, 0, mask.upwards().upwards().upwards(), color);
        }
        let rows: Vec<Vec<[u8; 3]>> = (0..length).map(|at| self.across(at, length, breadth).collect()).collect();
        let colors = (0..breadth as usize).flat_map(|i| rows.iter().map(move |row| row[i])).collect();
        block.colors(left, line, length, colors);
        block.outline([left - line, 0, length + 2 * line, breadth + 2 * line], line);
        let y = breadth + 2 * line;
        for value in &ticks.minor {
            block.rule(left + column(*value) - line / 2, y, line, tick / 2);
        }
        for ((value, _), mask) in ticks.major.iter().zip(labels) {
            block.rule(left + column(*value) - line / 2, y, line, tick);
            block.text(left + column(*value) - mask.width / 2, y + tick + gap / 2, mask);
        }
        let below = y + tick + gap / 2 + text.height();
        block.text(left + (length - caption.width) / 2, below, caption);
        block.width = block.width.max(2 * left + length);
        block
    }
}

/// Whether two colourings show values of one field in the same colours.
fn has_colors_of(one: &Painting, other: &Painting) -> bool {
    let colorings = one.coloring.zip(other.coloring);
    one.field == other.field && colorings.is_some_and(|(one, other)| one.has_colors_of(other))
}

/// The lines of a caption, none longer than `max_width` if it stays legible: a much longer caption is broken at
/// the blank nearest its middle.
fn caption_mask(lines: &[String], sizes: Sizes, max_width: i64) -> Mask {
    let broken = lines.iter().flat_map(|line| {
        let is_long = sizes.caption.width(line) * 4 > max_width * 5;
        let blanks = line.match_indices(' ').map(|(at, _)| at);
        match blanks.min_by_key(|at| at.abs_diff(line.len() / 2)).filter(|_| is_long) {
            Some(at) => vec![&line[..at], &line[at + 1..]],
            None => vec![line.as_str()],
        }
    });
    let broken: Vec<&str> = broken.collect();
    let longest = broken.iter().max_by_key(|line| sizes.caption.width(line));
    let size = longest.map_or(sizes.caption, |line| sizes.caption.fitting(line, max_width));
    Mask::below_each_other(&broken.iter().map(|line| size.line(line)).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_captions_are_broken_before_they_are_small() {
        let size = Size(14.0);
        let sizes = Sizes { text: size, caption: size, breadth: 1, tick: 1, gap: 1, line: 1 };
        let set = |text: &str, max_width: i64| {
            let mask = caption_mask(&[text.to_owned()], sizes, max_width);
            assert!(mask.width <= max_width, "{text}: {} of {max_width}", mask.width);
            mask
        };
        let text = "opacity by vertical velocity";
        let width = size.width(text);
        assert_eq!(set(text, width), size.line(text));
        // A caption that is a little too long is set smaller; a much longer one becomes two lines of whole words.
        assert!(set(text, width * 9 / 10).height < size.height());
        let broken = set(text, width * 6 / 10);
        assert_eq!((broken.height, broken.width), (2 * size.height(), size.width("vertical velocity")));
        assert!(set("nothing-to-break-here", 100).height < size.height());
    }
}
