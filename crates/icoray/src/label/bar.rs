//! The colour bar: which value has which colour, and how much of it is seen.
//!
//! Along the bar goes the scale. Of its breadth the far part is the colour itself, bare where nothing is to be seen; the
//! part beside the ticks shows it as opaque as one unit of length of it is. Behind both are checks of grey.

use super::block::Block;
use super::font::{Mask, Size};
use super::ticks::{Ticks, ticks};
use crate::output::srgb_byte;
use crate::scene::{Scale, Scene, TransferFunction};
use std::array;

/// Linear greys of the checks.
const CHECKS: [f64; 2] = [0.20, 0.42];

/// What a bar is of.
pub(super) struct Bar<'s> {
    scale: Scale,
    range: [f64; 2],
    transfer: &'s TransferFunction,
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
    /// Between things.
    pub gap: i64,
    /// Breadth of lines.
    pub line: i64,
}

impl<'s> Bar<'s> {
    /// The bar of a scene; `None` where its colours do not depend on the value.
    pub fn of(scene: &'s Scene) -> Option<Self> {
        let coloring =
            scene.coloring.as_ref().and_then(|coloring| Some((coloring.scale(), coloring.fixed()?)));
        let (scale, range) = coloring.unwrap_or((Scale::Linear, scene.transfer.range()));
        (range[0] < range[1]).then_some(Bar { scale, range, transfer: &scene.transfer })
    }

    /// Pixels from the bar's start to a value, along `length` of them.
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
        let seen = -(-extinction).exp_m1();
        let check = (breadth / 6).max(2);
        (0..breadth).map(move |i| {
            let opacity = if 2 * i < breadth { solid } else { seen };
            let grey = CHECKS[((at / check + i / check) % 2) as usize];
            array::from_fn(|k| srgb_byte((opacity * color[k] + (1.0 - opacity) * grey) as f32))
        })
    }

    /// The most ticks with labels whose labels stay apart, along `length` pixels.
    fn ticks(&self, length: i64, room: impl Fn(&str) -> i64) -> Ticks {
        const MOST: usize = 9;
        let fits = |ticks: &Ticks| {
            let pairs = ticks.major.windows(2);
            let mut apart = pairs.map(|pair| {
                let [a, b] = [&pair[0], &pair[1]].map(|(value, _)| self.along(*value, length));
                (b - a) - (room(&pair[0].1) + room(&pair[1].1)) / 2
            });
            apart.all(|apart| apart >= 0)
        };
        let mut tried = (2..=MOST).rev().map(|most| ticks(self.scale, self.range, most));
        tried.find(fits).unwrap_or_else(|| ticks(self.scale, self.range, 2))
    }

    /// Upright, its values rising upwards, ticks and caption at its right. The caption is no longer than `most`.
    pub fn upright(&self, length: i64, most: i64, sizes: Sizes, caption: impl Fn(i32) -> String) -> Block {
        let Sizes { text, breadth, tick, gap, line, .. } = sizes;
        let ticks = self.ticks(length, |_| text.height());
        let caption = caption_line(&caption(ticks.exponent), sizes, most).upwards();
        let labels: Vec<Mask> = ticks.major.iter().map(|(_, label)| text.line(label)).collect();
        let widest = labels.iter().map(|mask| mask.width).max().unwrap_or(0);
        // Labels of the ends and a long caption stand out.
        let top = (text.height() / 2).max((caption.height - length) / 2);
        let mut block = Block::default();
        let colors = (0..length).rev().flat_map(|at| self.across(at, length, breadth)).collect();
        block.colors(line, top, breadth, colors);
        frame(&mut block, [0, top - line, breadth + 2 * line, length + 2 * line], line);
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

    /// Lying, its values rising to the right, ticks and caption below it.
    pub fn lying(&self, length: i64, most: i64, sizes: Sizes, caption: impl Fn(i32) -> String) -> Block {
        let Sizes { text, breadth, tick, gap, line, .. } = sizes;
        let ticks = self.ticks(length, |label| text.width(label) + 2 * gap);
        let caption = caption_line(&caption(ticks.exponent), sizes, most);
        let labels: Vec<Mask> = ticks.major.iter().map(|(_, label)| text.line(label)).collect();
        let column = |value: f64| self.along(value, length);
        let ends = ticks.major.iter().zip(&labels).map(|((value, _), mask)| {
            let half = (mask.width + 1) / 2;
            (half - column(*value)).max(column(*value) + half - length)
        });
        let left = ends.max().unwrap_or(0).max((caption.width - length) / 2).max(line);
        let mut block = Block::default();
        let rows: Vec<Vec<[u8; 3]>> =
            (0..length).map(|at| self.across(at, length, breadth).collect()).collect();
        let colors = (0..breadth as usize).flat_map(|i| rows.iter().map(move |row| row[i])).collect();
        block.colors(left, line, length, colors);
        frame(&mut block, [left - line, 0, length + 2 * line, breadth + 2 * line], line);
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

fn caption_line(text: &str, sizes: Sizes, most: i64) -> Mask {
    sizes.caption.fitting(text, most).line(text)
}

/// The outline of a rectangle.
fn frame(block: &mut Block, [x, y, width, height]: [i64; 4], line: i64) {
    block.rule(x, y, width, line);
    block.rule(x, y + height - line, width, line);
    block.rule(x, y + line, line, height - 2 * line);
    block.rule(x + width - line, y + line, line, height - 2 * line);
}
