//! Lines of text as masks: DejaVu Sans, of which Latin, Greek, exponents and mathematical signs are embedded.

use ab_glyph::{Font, FontRef, Glyph, PxScale, ScaleFont, point};
use icoray_grid::printable;
use std::sync::LazyLock;

static FONT: LazyLock<FontRef<'static>> = LazyLock::new(|| {
    let bytes = include_bytes!("../../data/DejaVuSans-subset.ttf");
    FontRef::try_from_slice(bytes).expect("the embedded font is whole")
});

/// Height of the middle of a digit above the baseline, in em.
const MIDDLE: f32 = 0.365;

/// Coverage of each pixel by the ink of a text.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Mask {
    /// Pixels in a row.
    pub width: i64,
    /// Number of rows.
    pub height: i64,
    /// Rows from the top, 0 to 1.
    pub ink: Vec<f32>,
}

/// Font size in pixels per em.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Size(pub f32);

impl Size {
    fn scale(self) -> PxScale {
        let per_em = FONT.units_per_em().expect("the embedded font says so");
        PxScale::from(self.0 * FONT.height_unscaled() / per_em)
    }

    /// Distance from the top of a line to its baseline, in pixels.
    pub fn baseline(self) -> i64 {
        FONT.as_scaled(self.scale()).ascent().ceil() as i64
    }

    /// Distance from the top of a line to the middle of a digit, in pixels.
    pub fn middle(self) -> i64 {
        self.baseline() - (MIDDLE * self.0).round() as i64
    }

    /// Line height in pixels.
    pub fn height(self) -> i64 {
        self.baseline() + (-FONT.as_scaled(self.scale()).descent()).ceil() as i64
    }

    /// Positions of a text's glyphs on the baseline, and its advance width. Control characters are escaped.
    fn set(self, text: &str) -> (Vec<Glyph>, f32) {
        let (scale, baseline) = (self.scale(), self.baseline() as f32);
        let font = FONT.as_scaled(scale);
        let mut x = 0.0;
        let place = |character| {
            let id = FONT.glyph_id(character);
            let glyph = id.with_scale_and_position(scale, point(x, baseline));
            x += font.h_advance(id);
            glyph
        };
        (printable(text).chars().map(place).collect(), x)
    }

    /// Width of a line of text in pixels.
    pub fn width(self, text: &str) -> i64 {
        self.set(text).1.ceil() as i64
    }

    /// This size, or the smaller one at which a text fits into `max_width` pixels, but not below the legible minimum.
    pub fn fitting(self, text: &str, max_width: i64) -> Self {
        const MIN_SIZE: f32 = 7.0;
        let width = self.width(text);
        if width <= max_width {
            self
        } else {
            Size((self.0 * max_width as f32 / width as f32).max(MIN_SIZE.min(self.0)))
        }
    }

    /// A line of text.
    pub fn line(self, text: &str) -> Mask {
        let (glyphs, width) = self.set(text);
        let (width, height) = (width.ceil() as i64, self.height());
        let mut mask = Mask { width, height, ink: vec![0.0; (width * height) as usize] };
        for outline in glyphs.into_iter().filter_map(|glyph| FONT.outline_glyph(glyph)) {
            let bounds = outline.px_bounds();
            outline.draw(|x, y, ink| {
                let (x, y) = (bounds.min.x as i64 + i64::from(x), bounds.min.y as i64 + i64::from(y));
                if (0..width).contains(&x) && (0..height).contains(&y) {
                    let there = &mut mask.ink[(y * width + x) as usize];
                    *there = (*there + ink).min(1.0);
                }
            });
        }
        mask
    }
}

impl Mask {
    /// Centred lines below each other.
    pub(super) fn below_each_other(lines: &[Mask]) -> Self {
        let width = lines.iter().map(|line| line.width).max().unwrap_or(0);
        let row = |line: &Mask, y: i64| {
            let (before, start) = ((width - line.width) / 2, (y * line.width) as usize);
            let mut row = vec![0.0; width as usize];
            let ink = &line.ink[start..start + line.width as usize];
            row[before as usize..before as usize + ink.len()].copy_from_slice(ink);
            row
        };
        let rows = lines.iter().flat_map(|line| (0..line.height).flat_map(move |y| row(line, y)));
        Mask { width, height: lines.iter().map(|line| line.height).sum(), ink: rows.collect() }
    }

    /// A triangle that points upwards.
    pub(super) fn triangle(width: i64, height: i64) -> Self {
        let ink = |x: i64, y: i64| {
            let half = 0.5 * width as f32 * (y as f32 + 0.5) / height as f32;
            (half - (x as f32 + 0.5 - 0.5 * width as f32).abs() + 0.5).clamp(0.0, 1.0)
        };
        Mask { width, height, ink: (0..height).flat_map(|y| (0..width).map(move |x| ink(x, y))).collect() }
    }

    /// The mask rotated by 90 degrees, reading upwards.
    pub(super) fn upwards(&self) -> Self {
        let (width, height) = (self.height, self.width);
        let from = |x: i64, y: i64| self.ink[(x * self.width + self.width - 1 - y) as usize];
        let ink = (0..height).flat_map(|y| (0..width).map(move |x| from(x, y))).collect();
        Mask { width, height, ink }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first and the last row and column with ink.
    fn extent(mask: &Mask) -> [i64; 4] {
        let inked = |i: &i64| mask.ink[*i as usize] > 0.5;
        let all: Vec<i64> = (0..mask.width * mask.height).filter(inked).collect();
        let columns = || all.iter().map(|i| i % mask.width);
        let rows = || all.iter().map(|i| i / mask.width);
        [rows().min(), rows().max(), columns().min(), columns().max()].map(Option::unwrap)
    }

    #[test]
    fn digits_stand_on_the_baseline_about_the_middle() {
        for em in [10.0, 14.0, 60.0] {
            let size = Size(em);
            let [top, bottom, left, right] = extent(&size.line("0488"));
            assert!((bottom + 1 - size.baseline()).abs() as f32 <= 1.0 + em / 40.0, "{em}");
            assert!(((top + bottom + 1) / 2 - size.middle()).abs() <= 1, "{em}");
            // DejaVu's digits are 0.729 em high and 0.636 em apart.
            assert!(((bottom + 1 - top) as f32 - 0.74 * em).abs() <= 1.5 + em / 40.0, "{em}");
            assert!((size.width("0488") as f32 - 4.0 * 0.636 * em).abs() <= 1.5, "{em}");
            assert!(left >= 0 && right < size.width("0488"));
        }
    }

    #[test]
    fn all_texts_of_labels_have_glyphs() {
        let blank = FONT.glyph_id('\u{fffe}');
        for character in "−⁻⁰¹²³⁴⁵⁶⁷⁸⁹×≤≥≈±°·µθζφΔ∂∇ÄÖÜéñ–—∞".chars()
        {
            assert_ne!(FONT.glyph_id(character), blank, "{character}");
        }
        assert!(Size(20.0).line("⁻¹").ink.iter().any(|ink| *ink > 0.5));
    }

    #[test]
    fn control_characters_are_set_as_escapes() {
        assert_eq!(Size(20.0).line("K\u{1b}"), Size(20.0).line(r"K\u{1b}"));
    }

    #[test]
    fn turned_text_reads_upwards() {
        let mask = Mask { width: 3, height: 2, ink: vec![0.0, 0.1, 0.2, 1.0, 0.5, 0.6] };
        let turned = mask.upwards();
        assert_eq!((turned.width, turned.height), (2, 3));
        assert_eq!(turned.ink, [0.2, 0.6, 0.1, 0.5, 0.0, 1.0]);
    }

    #[test]
    fn lines_stand_in_the_middle_below_each_other() {
        let mask = |width, ink: &[f32]| Mask { width, height: ink.len() as i64 / width, ink: ink.to_vec() };
        let lines = [mask(3, &[0.1, 0.2, 0.3]), mask(1, &[1.0, 0.5])];
        let both = mask(3, &[0.1, 0.2, 0.3, 0.0, 1.0, 0.0, 0.0, 0.5, 0.0]);
        assert_eq!(Mask::below_each_other(&lines), both);
        assert_eq!(Mask::below_each_other(&lines[..1]), lines[0]);
    }

    #[test]
    fn long_texts_are_set_smaller() {
        let size = Size(20.0);
        assert_eq!(size.fitting("K", 100), size);
        let text = "a name that is longer than that";
        assert!(size.fitting(text, 200).width(text) <= 202);
        assert_eq!(size.fitting(text, 3), Size(7.0));
    }
}
