//! Where labels go: into corners and margins that the planet leaves free.

use super::bar::{Bar, Sizes};
use super::block::Block;
use super::canvas::{Canvas, Rect};
use super::font::Size;
use super::{Legend, Place, words};
use crate::frame::Frame;
use crate::output::srgb_byte;
use glam::DVec3;

/// Of the picture's shorter side, one em.
const EM: f64 = 1.0 / 36.0;
/// The least em that can be read, in pixels.
const LEAST_EM: f64 = 9.0;
/// Part of the planet that a bar may hide and still be said to hide none.
const HIDES_NONE: f64 = 0.01;
/// How much of what lies behind labels over the planet is covered.
const PANEL: f32 = 0.8;
/// Luminance with the same contrast to white as to black (WCAG 2).
const EVEN: f64 = 0.179;

/// Where on its side a bar stands.
#[derive(Debug, Clone, Copy)]
enum Along {
    Middle,
    End,
}

/// A side, a place there, and which part of the picture's side the bar takes.
type Candidate = (Place, Along, f64);

/// In the order in which they are liked.
const CANDIDATES: [Candidate; 6] = [
    (Place::Right, Along::Middle, 0.6),
    (Place::Bottom, Along::Middle, 0.6),
    (Place::Left, Along::Middle, 0.6),
    (Place::Right, Along::End, 0.36),
    (Place::Left, Along::End, 0.36),
    (Place::Bottom, Along::End, 0.36),
];

/// What all of the steps need.
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
    paper: [u8; 3],
}

/// Puts all labels into the picture.
pub(super) fn draw(canvas: &mut Canvas, frame: &Frame, legend: &Legend) {
    let page = Page::new(canvas, frame, legend);
    match legend.labels.place {
        Place::Below => page.below(canvas),
        place => page.inside(canvas, place),
    }
}

/// The length of a bar along a side; pictures that are too small for it are drawn all the same.
fn share(part: f64, side: i64) -> i64 {
    ((part * side as f64) as i64).max(8)
}

impl<'f> Page<'f> {
    fn new(canvas: &Canvas, frame: &'f Frame, legend: &'f Legend) -> Self {
        let [width, height] = [canvas.width, canvas.height].map(i64::from);
        let em = (width.min(height) as f64 * EM).max(LEAST_EM) * legend.labels.size;
        let pixels = |ems: f64| ((em * ems).round() as i64).max(1);
        let size = |ems: f64| Size((em * ems) as f32);
        let sizes = Sizes {
            text: size(0.9),
            caption: size(1.0),
            breadth: pixels(1.2),
            tick: pixels(0.3),
            gap: pixels(0.3),
            line: pixels(0.07),
        };
        // A transparent picture is put on white paper.
        let back = legend.scene.background.unwrap_or([1.0; 3]);
        let is_dark = 0.2126 * back[0] + 0.7152 * back[1] + 0.0722 * back[2] < EVEN;
        let auto = if is_dark { [0.9; 3] } else { [0.01; 3] };
        let [ink, paper] =
            [legend.labels.color.unwrap_or(auto), back].map(|c| c.map(|v| srgb_byte(v as f32)));
        let (title, notes, margin) = (size(1.15), size(0.8), pixels(0.8));
        Page { frame, legend, sizes, title, notes, margin, width, height, ink, paper }
    }

    fn bar(&self) -> Option<Bar<'_>> {
        Bar::of(&self.legend.scene).filter(|_| self.legend.labels.bar)
    }

    fn caption(&self, exponent: i32) -> String {
        words::caption(self.frame, self.legend, exponent)
    }

    /// Part of a rectangle in which the planet is seen.
    fn hidden(&self, rect: Rect) -> f64 {
        const STEPS: i64 = 24;
        let camera = &self.legend.scene.camera;
        let eye = DVec3::from_array(camera.eye());
        let outside = eye.length_squared() - self.legend.outer * self.legend.outer;
        let [width, height] = [self.frame.width, self.frame.height];
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

    /// A bar with its upper left corner.
    fn set_bar(&self, bar: &Bar, (place, along, part): Candidate) -> (Block, i64, i64) {
        let Page { width, height, margin, sizes, .. } = *self;
        let caption = |exponent| self.caption(exponent);
        let end = |whole: i64, block: i64| match along {
            Along::Middle => (whole - block) / 2,
            Along::End => whole - margin - block,
        };
        if place == Place::Bottom {
            let most = if matches!(along, Along::Middle) { width - 2 * margin } else { width / 2 };
            let block = bar.lying(share(part, width), most, sizes, caption);
            let at = (end(width, block.width), height - margin - block.height);
            return (block, at.0, at.1);
        }
        let most = if matches!(along, Along::Middle) { height - 2 * margin } else { height / 2 };
        let block = bar.upright(share(part, height), most, sizes, caption);
        let x = if place == Place::Left { margin } else { width - margin - block.width };
        let y = end(height, block.height);
        (block, x, y)
    }

    fn inside(&self, canvas: &mut Canvas, place: Place) {
        let mut side = Place::Right;
        if let Some(bar) = self.bar() {
            let candidates = CANDIDATES.iter().filter(|(side, ..)| place == Place::Auto || *side == place);
            let mut best: Option<(f64, Place, (Block, i64, i64))> = None;
            for candidate in candidates {
                let (block, x, y) = self.set_bar(&bar, *candidate);
                let hidden = self.hidden(block.rect(x, y));
                if best.as_ref().is_none_or(|(least, ..)| hidden + HIDES_NONE < *least) {
                    best = Some((hidden, candidate.0, (block, x, y)));
                }
                if hidden <= HIDES_NONE {
                    break;
                }
            }
            if let Some((_, found, (block, x, y))) = best {
                side = found;
                self.put(canvas, &block, x, y);
            }
        }
        self.corners(canvas, side);
    }

    /// Title and notes beside a bar on this side.
    fn corners(&self, canvas: &mut Canvas, side: Place) {
        let Page { width, height, margin, .. } = *self;
        let notes = words::notes(self.frame, self.legend);
        let is_right = side != Place::Right;
        let notes = Block::lines(&notes, self.notes, (width - 3 * margin) / 2, is_right);
        let x = if is_right { width - margin - notes.width } else { margin };
        let y = if side == Place::Bottom { margin } else { height - margin - notes.height };
        self.put(canvas, &notes, x, y);
        let beside = if side == Place::Bottom { notes.width + margin } else { 0 };
        let title = words::title(self.frame, self.legend);
        let title = Block::lines(&title, self.title, width - 2 * margin - beside, false);
        self.put(canvas, &title, margin, margin);
    }

    /// Draws a block, on a panel where the planet would be behind it.
    fn put(&self, canvas: &mut Canvas, block: &Block, x: i64, y: i64) {
        if block.width == 0 {
            return;
        }
        let rect = block.rect(x, y).grown(self.margin / 2);
        if self.hidden(rect) > HIDES_NONE {
            canvas.fill(rect, self.paper, PANEL);
        }
        block.draw(canvas, x, y, self.ink);
    }

    /// Rows below the picture: title and notes, and below them the bar.
    fn below(&self, canvas: &mut Canvas) {
        let Page { width, height, margin, .. } = *self;
        let notes = words::notes(self.frame, self.legend).join(" · ");
        let notes: Vec<String> = Some(notes).filter(|text| !text.is_empty()).into_iter().collect();
        let notes = Block::lines(&notes, self.notes, (width - 3 * margin) / 2, true);
        let title = words::title(self.frame, self.legend);
        let title = Block::lines(&title, self.title, width - 3 * margin - notes.width, false);
        let caption = |exponent| self.caption(exponent);
        let length = share(0.8, width);
        let bar = self.bar().map(|bar| bar.lying(length, width - 2 * margin, self.sizes, caption));
        let mut y = height + margin;
        let text = title.height.max(notes.height);
        let blocks = [Some((title, margin, y)), Some((notes.clone(), width - margin - notes.width, y))];
        if text > 0 {
            y += text + margin / 2;
        }
        let bar = bar.map(|bar| ((width - bar.width) / 2, bar)).map(|(x, bar)| (bar, x, y));
        let end = bar.as_ref().map_or(y, |(bar, ..)| y + bar.height) + margin / 2;
        let paper = match self.legend.scene.background {
            Some(_) => [self.paper[0], self.paper[1], self.paper[2], 255],
            None => [0; 4],
        };
        canvas.extend((end - height) as u32, paper);
        for (block, x, y) in blocks.into_iter().flatten().chain(bar) {
            block.draw(canvas, x, y, self.ink);
        }
    }
}
