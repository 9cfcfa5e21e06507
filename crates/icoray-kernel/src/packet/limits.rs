//! Limits of the tables from which packets of rays gather.

use icoray_simd::Table;

/// The first of a frame's tables that is too long for gathers, in words: the field's values, the gradients at the
/// vertices. If there is one, rays are traced one at a time or, for values, these are read one
/// at a time, which takes several times longer.
pub fn beyond_gathers(values: usize, gradient_words: usize) -> Option<String> {
    let tables = [
        (values, "values of the field", Table::<f32>::MAX),
        (gradient_words, "numbers of gradients", Table::<u64>::MAX),
    ];
    let (count, name, max) = tables.into_iter().find(|(count, _, max)| count > max)?;
    Some(format!("{count} {name}, expected at most {max}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_that_are_too_long_are_named() {
        assert_eq!(beyond_gathers(1 << 32, 1 << 32), None);
        let text = beyond_gathers((1 << 32) + 1, 0).unwrap();
        assert_eq!(text, "4294967297 values of the field, expected at most 4294967296");
        assert!(beyond_gathers(0, 1 << 33).unwrap().contains("gradients"));
    }
}
