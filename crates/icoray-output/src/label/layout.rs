//! Placement of labels in corners and margins that the planet leaves free.

use super::bar::{Bar, Sizes};
use super::block::Block;
use super::canvas::{Canvas, Rect, srgb_byte};
use super::font::Size;
use super::words::{self, Key};
use crate::frame::{Frame, Legend};
use glam::DVec3;
use icoray_scene::{LabelPlace, Scale, TransferFunction};

/// One em as a fraction of the picture's shorter side.
const EM: f64 = 1.0 / 36.0;
/// Smallest legible em in pixels.
const MIN_EM: f64 = 9.0;
/// Fraction of the planet that a bar may hide and still count as hiding nothing.
const HIDES_NONE: f64 = 0.01;
/// Opacity of the panel behind labels over the planet.
const PANEL: f32 = 0.8;
/// Luminance with the same contrast to white as to black (WCAG 2).
const EVEN: f64 = 0.179;

/// Minimum length of one of several bars, in em.
const MIN_SLOT: f64 = 5.5;
/// Length from which a bar beside others counts as full-sized, in em.
const WIDE_SLOT: f64 = 14.0;

/// Alignment of a bar along its side.
#[derive(Debug, Clone, Copy)]
enum Along {
    Middle,
    End,
}

/// A placement of bars.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    side: LabelPlace,
    along: Along,
    /// Fraction of the side's length that a bar takes.
    part: f64,
}

/// Placements in order of preference.
const CANDIDATES: [Candidate; 6] = [
    Candidate { side: LabelPlace::Right, along: Along::Middle, part: 0.6 },
    Candidate { side: LabelPlace::Bottom, along: Along::Middle, part: 0.6 },
    Candidate { side: LabelPlace::Left, along: Along::Middle, part: 0.6 },
    Candidate { side: LabelPlace::Right, along: Along::End, part: 0.36 },
    Candidate { side: LabelPlace::Left, along: Along::End, part: 0.36 },
    Candidate { side: LabelPlace::Bottom, along: Along::End, part: 0.36 },
];

/// Bars with their upper left corner.
struct PlacedBars {
    block: Block,
    x: i64,
    y: i64,
    side: LabelPlace,
}

/// Data that all steps of the layout use.
struct Page<'f> {
    frame: &'f Frame,
    legend: &'f Legend,
    sizes: Sizes,
    title: Size,
    notes: Size,
    margin: i64,
    width: i64,
    height: i64,
    ink: [u8; 3],
    /// Colour of an error above the tolerance.
    warning: [u8; 3],
    paper: [u8; 3],
}

/// Draws all labels into the picture.
pub(crate) fn draw(canvas: &mut Canvas, frame: &Frame, legend: &Legend) {
    let page = Page::new(canvas, frame, legend);
    match legend.labels.place {
        LabelPlace::Below => page.below(canvas),
        place => page.inside(canvas, place),
    }
}

/// Adds rows of `paper` below a picture, with a bar of the colours of a transfer function in them.
pub(crate) fn draw_bar(
    canvas: &mut Canvas,
    scale: Scale,
    transfer: &TransferFunction,
    caption: &str,
    [ink, paper]: [[u8; 3]; 2],
) {
    let [width, height] = [canvas.width, canvas.height].map(i64::from);
    let sizes = Sizes::of(em(width, height));
    let margin = sizes.breadth / 2;
    let block =
        Bar::opaque(scale, transfer).lying(share(0.8, width), width - 2 * margin, sizes, |_| vec![caption.to_owned()]);
    canvas.extend((block.height + 2 * margin) as u32, [paper[0], paper[1], paper[2], 255]);
    block.draw(canvas, (width - block.width) / 2, height + margin, ink);
}

/// One em in pixels.
fn em(width: i64, height: i64) -> f64 {
    (width.min(height) as f64 * EM).max(MIN_EM)
}

/// The length of a bar along a side; pictures that are too small for it are drawn all the same.
fn share(part: f64, side: i64) -> i64 {
    ((part * side as f64) as i64).max(8)
}

/// Fraction of a side that several bars take, from the fraction that a single bar takes.
fn several(part: f64, count: usize) -> f64 {
    (part * (1.0 + 0.5 * (count - 1) as f64)).min(0.95)
}

impl<'f> Page<'f> {
    fn new(canvas: &Canvas, frame: &'f Frame, legend: &'f Legend) -> Self {
        let [width, height] = [canvas.width, canvas.height].map(i64::from);
        let em = em(width, height) * legend.labels.size;
        let pixels = |ems: f64| ((em * ems).round() as i64).max(1);
        let size = |ems: f64| Size((em * ems) as f32);
        // A transparent picture is labelled as on white paper.
        let back = legend.scene.background.unwrap_or([1.0; 3]);
        let is_dark = 0.2126 * back[0] + 0.7152 * back[1] + 0.0722 * back[2] < EVEN;
        let auto = if is_dark { [0.9; 3] } else { [0.01; 3] };
        let [ink, paper] = [legend.labels.color.unwrap_or(auto), back].map(|c| c.map(|v| srgb_byte(v as f32)));
        // Orange, or red where the text is dark.
        let warning = if is_dark { [255, 150, 0] } else { [190, 0, 0] };
        let (title, notes, margin) = (size(1.15), size(0.8), pixels(0.8));
        let sizes = Sizes::of(em);
        Page { frame, legend, sizes, title, notes, margin, width, height, ink, warning, paper }
    }

    /// A block of notes; the last one is in another colour if it reports an error above the tolerance.
    fn notes(&self, notes: &[String], max_width: i64, is_right: bool) -> Block {
        let block = Block::lines(notes, self.notes, max_width, is_right);
        if words::is_over(self.frame, self.legend) { block.with_last_in(self.warning) } else { block }
    }

    fn em(&self) -> f64 {
        f64::from(self.sizes.caption.0)
    }

    fn bars(&self) -> Vec<Bar<'f>> {
        let mut bars = if self.legend.labels.bar { Bar::all(&self.legend.scene) } else { Vec::new() };
        let known = &self.frame.report.value_ranges;
        let values = |field: &str| known.iter().find(|(name, _)| name == field).map(|(_, values)| *values);
        bars.iter_mut().for_each(|bar| bar.values = values(bar.field));
        bars
    }

    fn caption(&self, bar: &Bar, exponent: i32) -> Vec<String> {
        words::caption(self.frame, self.legend, bar, exponent)
    }

    /// Fraction of a rectangle in which the planet is visible.
    fn hidden(&self, rect: Rect) -> f64 {
        const STEPS: i64 = 24;
        let camera = &self.legend.scene.camera;
        let eye = DVec3::from_array(camera.eye());
        let outside = eye.length_squared() - self.legend.outer * self.legend.outer;
        // Those of the canvas, which may be larger than the frame.
        let [width, height] = [self.width as u32, self.height as u32];
        let meets = |i: i64, j: i64| {
            let x = (rect.x + rect.width * i / (STEPS - 1)).clamp(0, self.width - 1);
            let y = (rect.y + rect.height * j / (STEPS - 1)).clamp(0, self.height - 1);
            let direction = DVec3::from_array(camera.direction(x as u32, y as u32, width, height));
            let towards = -eye.dot(direction);
            outside <= 0.0 || towards > 0.0 && towards * towards >= outside
        };
        let points = (0..STEPS * STEPS).filter(|at| meets(at % STEPS, at / STEPS)).count();
        points as f64 / (STEPS * STEPS) as f64
    }

    /// As many bars as fit, each with its upper left corner: one after the other along their side, the first at the top
    /// or at the left.
    fn set_bars(&self, bars: &[Bar], Candidate { side, along, part }: Candidate) -> PlacedBars {
        let Page { width, height, margin, .. } = *self;
        let is_upright = side != LabelPlace::Bottom;
        let length = if is_upright { height } else { width };
        // Several bars leave room for the title above them.
        let above = if is_upright && bars.len() > 1 { self.title_height() + margin / 2 } else { 0 };
        let room = length - 2 * margin - above;
        let bars = &bars[..bars.len().min((room / (MIN_SLOT * self.em()) as i64).max(1) as usize)];
        let block = match bars {
            [bar] => {
                // A caption in the middle of an upright bar ends below the title.
                let title = if is_upright { self.title_height() + margin / 2 } else { 0 };
                let max_width =
                    if matches!(along, Along::Middle) { (room - 2 * title).max(length / 2) } else { length / 2 };
                self.set_bar(bar, is_upright, share(part, length), max_width)
            }
            _ => self.set_row(bars, is_upright, share(several(part, bars.len()), length).min(room)),
        };
        let end = |whole: i64, block: i64, above: i64| match along {
            Along::Middle => (whole + above - block) / 2,
            Along::End => whole - margin - block,
        };
        let (x, y) = match side {
            LabelPlace::Bottom => (end(width, block.width, 0), height - margin - block.height),
            LabelPlace::Left => (margin, end(height, block.height, above)),
            _ => (width - margin - block.width, end(height, block.height, above)),
        };
        PlacedBars { block, x, y, side }
    }

    fn set_bar(&self, bar: &Bar, is_upright: bool, length: i64, max_width: i64) -> Block {
        let caption = |exponent| self.caption(bar, exponent);
        match is_upright {
            true => bar.upright(length, max_width, self.sizes, caption),
            false => bar.lying(length, max_width, self.sizes, caption),
        }
    }

    /// Several bars of equal length one after the other in `room` pixels.
    fn set_row(&self, bars: &[Bar], is_upright: bool, room: i64) -> Block {
        let (count, gap) = (bars.len() as i64, self.margin);
        let slot = ((room - gap * (count - 1)) / count).max(8);
        // The labels of a bar's ends extend beyond it.
        let out = if is_upright { self.sizes.text.height() } else { (2.0 * self.em()) as i64 };
        let mut row = Block::default();
        for (i, bar) in (0..).zip(bars) {
            let block = self.set_bar(bar, is_upright, (slot - out).max(8), slot);
            // A caption at the smallest legible size may need more room.
            let begin = |taken: i64| if i == 0 { 0 } else { (i * (slot + gap)).max(taken + gap / 2) };
            match is_upright {
                true => row.block(0, begin(row.height), block),
                false => row.block(begin(row.width), 0, block),
            }
        }
        row
    }

    fn inside(&self, canvas: &mut Canvas, place: LabelPlace) {
        let mut side = LabelPlace::Right;
        let bars = self.bars();
        if !bars.is_empty() {
            let candidates = CANDIDATES.iter().filter(|candidate| place == LabelPlace::Auto || candidate.side == place);
            let mut best: Option<(f64, PlacedBars)> = None;
            for candidate in candidates {
                let placed = self.set_bars(&bars, *candidate);
                let hidden = self.hidden(placed.block.rect(placed.x, placed.y));
                if best.as_ref().is_none_or(|(min, _)| hidden + HIDES_NONE < *min) {
                    best = Some((hidden, placed));
                }
                if hidden <= HIDES_NONE {
                    break;
                }
            }
            if let Some((_, placed)) = best {
                side = placed.side;
                self.put(canvas, &placed.block, placed.x, placed.y);
            }
        }
        self.corners(canvas, side);
    }

    /// Title and notes beside a bar on this side.
    fn corners(&self, canvas: &mut Canvas, side: LabelPlace) {
        let Page { width, height, margin, .. } = *self;
        let notes = words::notes(self.frame, self.legend);
        let is_right = side != LabelPlace::Right;
        let max_width = (width - 3 * margin) / 2;
        let mut blocks = self.keys(max_width);
        blocks.push(self.notes(&notes, max_width, is_right));
        let notes = Block::below_each_other(blocks, margin / 4, is_right);
        let x = if is_right { width - margin - notes.width } else { margin };
        let y = if side == LabelPlace::Bottom { margin } else { height - margin - notes.height };
        self.put(canvas, &notes, x, y);
        let beside = if side == LabelPlace::Bottom { notes.width + margin } else { 0 };
        self.put_title(canvas, width - 2 * margin - beside);
    }

    /// Height of the title in pixels.
    fn title_height(&self) -> i64 {
        words::title(self.frame, self.legend).len() as i64 * self.title.height()
    }

    /// Legends of the isosurfaces of each field, in rows of at most `max_width` pixels.
    fn keys(&self, max_width: i64) -> Vec<Block> {
        let Sizes { gap, line, .. } = self.sizes;
        let (size, edge) = (self.notes, (0.75 * self.notes.0) as i64);
        let piece = |color: Option<[f64; 3]>, text: &str| {
            let (mut block, mut x) = (Block::default(), 0);
            if let Some(color) = color {
                let y = size.middle() - edge / 2;
                let color = color.map(|channel| srgb_byte(channel as f32));
                block.colors(0, y, edge, vec![color; (edge * edge) as usize]);
                block.outline([0, y, edge, edge], line);
                x = edge + gap;
            }
            block.text(x, 0, size.line(text));
            block
        };
        let key = |key: Key| {
            let values = key.values.iter().map(|(value, color)| piece(*color, value));
            let pieces = std::iter::once(piece(None, &key.name)).chain(values);
            let (mut block, mut x, mut y) = (Block::default(), 0, 0);
            for piece in pieces {
                if x > 0 && x + piece.width > max_width {
                    x = 0;
                    y = block.height;
                }
                let width = piece.width;
                block.block(x, y, piece);
                x += width + 2 * gap;
            }
            block
        };
        let keys = if self.legend.labels.bar { words::keys(self.frame, self.legend) } else { Vec::new() };
        keys.into_iter().map(key).collect()
    }

    /// Draws the title, each line on a panel of its own if the planet is behind it.
    fn put_title(&self, canvas: &mut Canvas, most: i64) {
        let (x, mut y, pad) = (self.margin, self.margin, self.margin / 2);
        let lines = words::title(self.frame, self.legend);
        for (i, line) in lines.iter().enumerate() {
            let block = Block::lines(std::slice::from_ref(line), self.title, most, false);
            let rect = block.rect(x, y);
            if self.hidden(rect) > HIDES_NONE {
                // Panels of successive lines meet.
                let [above, below] = [i == 0, i + 1 == lines.len()].map(|is_end| if is_end { pad } else { 0 });
                let (width, height) = (rect.width + 2 * pad, rect.height + above + below);
                canvas.fill(Rect { x: x - pad, y: y - above, width, height }, self.paper, PANEL);
            }
            block.draw(canvas, x, y, self.ink);
            y += block.height;
        }
    }

    /// Draws a block, on a panel if the planet is behind it.
    fn put(&self, canvas: &mut Canvas, block: &Block, x: i64, y: i64) {
        if block.width == 0 {
            return;
        }
        let rect = block.rect(x, y);
        if self.hidden(rect) > HIDES_NONE {
            canvas.fill(rect.grown(self.margin / 2), self.paper, PANEL);
        }
        block.draw(canvas, x, y, self.ink);
    }

    /// Bars below the picture: side by side if there is room, else below each other.
    fn rows_below(&self, bars: &[Bar]) -> Vec<Block> {
        let Page { width, margin, .. } = *self;
        let max_width = width - 2 * margin;
        let slot = (max_width as f64 / bars.len().max(1) as f64) as i64 - margin;
        match bars {
            [_, _, ..] if slot as f64 >= WIDE_SLOT * self.em() => vec![self.set_row(bars, false, max_width)],
            _ => bars.iter().map(|bar| self.set_bar(bar, false, share(0.8, width), max_width)).collect(),
        }
    }

    /// Rows below the picture: title and notes, and below them the bar.
    fn below(&self, canvas: &mut Canvas) {
        let Page { width, height, margin, .. } = *self;
        let notes = words::notes(self.frame, self.legend).join(" · ");
        let notes: Vec<String> = Some(notes).filter(|text| !text.is_empty()).into_iter().collect();
        let notes = self.notes(&notes, (width - 3 * margin) / 2, true);
        let title = words::title(self.frame, self.legend);
        let title = Block::lines(&title, self.title, width - 3 * margin - notes.width, false);
        let bars = self.bars();
        let rows = self.rows_below(&bars);
        let mut y = height + margin;
        let text = title.height.max(notes.height);
        let beside = width - margin - notes.width;
        let blocks = [(title, margin, y), (notes, beside, y)];
        if text > 0 {
            y += text + margin / 2;
        }
        let mut rest = Vec::new();
        let keys = self.keys(width - 2 * margin).into_iter().map(|key| (margin, key));
        for (x, block) in keys.chain(rows.into_iter().map(|row| ((width - row.width) / 2, row))) {
            let height = block.height;
            rest.push((block, x, y));
            y += height + margin / 2;
        }
        let end = if rest.is_empty() { y + margin / 2 } else { y };
        let paper = match self.legend.scene.background {
            Some(_) => [self.paper[0], self.paper[1], self.paper[2], 255],
            None => [0; 4],
        };
        canvas.extend((end - height) as u32, paper);
        for (block, x, y) in blocks.into_iter().chain(rest) {
            block.draw(canvas, x, y, self.ink);
        }
    }
}
