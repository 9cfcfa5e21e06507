//! Marks of cells or triangles, a bit each.

use std::borrow::Cow;

/// Marks by number, 32 in a word, the lowest bit first. The last word is zero: an index that is lowered to it finds no
/// mark.
#[derive(Debug, Clone)]
pub struct Marks<'m>(Cow<'m, [u32]>);

impl<'m> Marks<'m> {
    /// Marks of the numbers from 0 on.
    pub fn new(marks: impl IntoIterator<Item = bool>) -> Self {
        let mut words = Vec::new();
        for (at, is_marked) in marks.into_iter().enumerate() {
            if at % 32 == 0 {
                words.push(0);
            }
            words[at / 32] |= u32::from(is_marked) << (at % 32);
        }
        words.push(0);
        Marks(words.into())
    }

    /// The marks of [`Self::words`].
    pub fn of_words(words: &'m [u32]) -> Self {
        Marks(words.into())
    }

    /// The words.
    pub fn words(&self) -> &[u32] {
        &self.0
    }

    /// Whether a number is marked; false for numbers out of range.
    #[inline]
    pub fn has(&self, number: usize) -> bool {
        self.0.get(number / 32).is_some_and(|word| word >> (number % 32) & 1 == 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_bits_of_words_behind_which_nothing_is_marked() {
        let is_marked = |number: usize| number * number % 7 == 2;
        for count in [0, 1, 31, 32, 33, 100] {
            let marks = Marks::new((0..count).map(is_marked));
            assert_eq!((marks.words().len(), marks.words().last()), (count.div_ceil(32) + 1, Some(&0)));
            let read = Marks::of_words(marks.words());
            assert!((0..count + 70).all(|number| read.has(number) == (number < count && is_marked(number))));
        }
    }
}
