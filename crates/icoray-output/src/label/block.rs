//! A block of text, lines and colours that are placed together.

use super::canvas::{Canvas, Rect};
use super::font::{Mask, Size};

/// Items at positions inside a rectangle.
#[derive(Debug, Clone, Default)]
pub(super) struct Block {
    pub width: i64,
    pub height: i64,
    items: Vec<(i64, i64, Item)>,
}

#[derive(Debug, Clone)]
enum Item {
    Text {
        mask: Mask,
        /// `None` for the colour of the other text.
        ink: Option<[u8; 3]>,
    },
    /// A rectangle of ink.
    Rule { width: i64, height: i64 },
    /// Rows of colours.
    Colors { width: i64, colors: Vec<[u8; 3]> },
}

impl Block {
    fn put(&mut self, x: i64, y: i64, width: i64, height: i64, item: Item) {
        self.width = self.width.max(x + width);
        self.height = self.height.max(y + height);
        self.items.push((x, y, item));
    }

    pub fn text(&mut self, x: i64, y: i64, mask: Mask) {
        self.mark(x, y, mask, None);
    }

    /// A mask in a colour, or in that of the text.
    pub fn mark(&mut self, x: i64, y: i64, mask: Mask, ink: Option<[u8; 3]>) {
        self.put(x, y, mask.width, mask.height, Item::Text { mask, ink });
    }

    pub fn rule(&mut self, x: i64, y: i64, width: i64, height: i64) {
        self.put(x, y, width, height, Item::Rule { width, height });
    }

    pub fn colors(&mut self, x: i64, y: i64, width: i64, colors: Vec<[u8; 3]>) {
        let height = colors.len() as i64 / width.max(1);
        self.put(x, y, width, height, Item::Colors { width, colors });
    }

    /// Inserts another block.
    pub fn block(&mut self, x: i64, y: i64, other: Block) {
        self.width = self.width.max(x + other.width);
        self.height = self.height.max(y + other.height);
        self.items.extend(other.items.into_iter().map(|(dx, dy, item)| (x + dx, y + dy, item)));
    }

    /// Blocks below each other, `gap` apart; right-aligned if `is_right`.
    pub fn below_each_other(blocks: Vec<Block>, gap: i64, is_right: bool) -> Self {
        let width = blocks.iter().map(|block| block.width).max().unwrap_or(0);
        let (mut all, mut y) = (Block::default(), 0);
        for block in blocks.into_iter().filter(|block| block.width > 0) {
            let (x, height) = (if is_right { width - block.width } else { 0 }, block.height);
            all.block(x, y, block);
            y += height + gap;
        }
        all
    }

    /// The outline of a rectangle.
    pub fn outline(&mut self, [x, y, width, height]: [i64; 4], line: i64) {
        self.rule(x, y, width, line);
        self.rule(x, y + height - line, width, line);
        self.rule(x, y + line, line, height - 2 * line);
        self.rule(x + width - line, y + line, line, height - 2 * line);
    }

    /// Lines below each other, none wider than `max_width`; right-aligned if `is_right`.
    pub fn lines(texts: &[String], size: Size, max_width: i64, is_right: bool) -> Self {
        let line = |text: &String| {
            let mut block = Block::default();
            block.text(0, 0, size.fitting(text, max_width).line(text));
            block
        };
        Self::below_each_other(texts.iter().map(line).collect(), 0, is_right)
    }

    /// The block with its last text in another colour.
    pub fn with_last_in(mut self, other: [u8; 3]) -> Self {
        let texts = self.items.iter_mut().rev();
        let last = texts.filter_map(|(_, _, item)| if let Item::Text { ink, .. } = item { Some(ink) } else { None });
        last.take(1).for_each(|ink| *ink = Some(other));
        self
    }

    /// The block's rectangle when its upper left corner is at (`x`, `y`).
    pub fn rect(&self, x: i64, y: i64) -> Rect {
        Rect { x, y, width: self.width, height: self.height }
    }

    pub fn draw(&self, canvas: &mut Canvas, left: i64, top: i64, ink: [u8; 3]) {
        for (x, y, item) in &self.items {
            let (x, y) = (left + x, top + y);
            match item {
                Item::Text { mask, ink: own } => canvas.stamp(x, y, mask, own.unwrap_or(ink)),
                Item::Rule { width, height } => {
                    canvas.fill(Rect { x, y, width: *width, height: *height }, ink, 1.0);
                }
                Item::Colors { width, colors } => {
                    for (row, colors) in (y..).zip(colors.chunks_exact(*width as usize)) {
                        (x..).zip(colors).for_each(|(x, color)| canvas.blend(x, row, *color, 1.0));
                    }
                }
            }
        }
    }
}
