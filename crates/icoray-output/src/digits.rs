//! The dozen characters that label the bar of an error map, three dots wide and five high.

/// Columns of dots from one character to the next.
pub(super) const ADVANCE: usize = 4;
/// Rows of dots.
pub(super) const HEIGHT: usize = 5;

/// Rows of a character from the top, three dots each, the highest bit on the left.
const GLYPHS: [(char, [u8; HEIGHT]); 12] = [
    ('0', [0b111, 0b101, 0b101, 0b101, 0b111]),
    ('1', [0b010, 0b110, 0b010, 0b010, 0b111]),
    ('2', [0b111, 0b001, 0b111, 0b100, 0b111]),
    ('3', [0b111, 0b001, 0b011, 0b001, 0b111]),
    ('4', [0b101, 0b101, 0b111, 0b001, 0b001]),
    ('5', [0b111, 0b100, 0b111, 0b001, 0b111]),
    ('6', [0b111, 0b100, 0b111, 0b101, 0b111]),
    ('7', [0b111, 0b001, 0b010, 0b010, 0b010]),
    ('8', [0b111, 0b101, 0b111, 0b101, 0b111]),
    ('9', [0b111, 0b101, 0b111, 0b001, 0b111]),
    ('e', [0b000, 0b111, 0b111, 0b100, 0b111]),
    ('-', [0b000, 0b000, 0b111, 0b000, 0b000]),
];

/// Column and row of each dot of `text`; characters other than digits, `e` and `-` are gaps.
pub(super) fn dots(text: &str) -> Vec<(usize, usize)> {
    let mut dots = Vec::new();
    for (place, character) in text.chars().enumerate() {
        let Some((_, rows)) = GLYPHS.iter().find(|(c, _)| *c == character) else { continue };
        for (y, row) in rows.iter().enumerate() {
            let lit = (0..3).filter(|x| row & (0b100 >> x) != 0);
            dots.extend(lit.map(|x| (place * ADVANCE + x, y)));
        }
    }
    dots
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dots_draw_the_text() {
        let mut rows = vec![vec![' '; 4 * ADVANCE]; HEIGHT];
        for (x, y) in dots("1e-7") {
            rows[y][x] = '#';
        }
        let drawn: Vec<String> = rows.iter().map(|r| r.iter().collect::<String>().trim_end().into()).collect();
        let expected = [" #          ###", "##  ###       #", " #  ### ###  #", " #  #        #", "### ###      #"];
        assert_eq!(drawn, expected);
        assert!(dots("x ").is_empty());
    }
}
