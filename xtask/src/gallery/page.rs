//! The page: a section for each scene. Sections of scenes that are not rendered stay as they are.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use super::list::{Entry, GALLERY};
use crate::error::Error;
use crate::report::Table;

const HEAD: &str = "\
# Gallery

What the scenes in [examples/scenes](../scenes) show. `cargo xtask gallery` draws all of it anew; below each picture stand the scene,
the command that draws it, and what the frame said of itself: the largest and the mean error of a channel of a pixel (1 is full light),
as estimated while it was traced, and the seconds from the field's pointers to its pixels.

The wave is that of Jablonowski and Williamson (2006), computed by MPAS-Atmosphere 8.3.1 on 10,242 cells and 26 layers.
";

/// The page of the live view, whose screenshots are in the book.
const TAIL: &str = "
## The page of icoray view

A file, turned and coloured by hand, with a probe of one pixel; and a running model, watched and steered between its steps
([the page](../../docs/src/view.md)).

![the page with a file](../../docs/src/view.png)

![a probe](../../docs/src/view_probe.png)

![a running model](../../docs/src/view_model.png)
";

/// Errors and cost of a picture.
#[derive(Debug, PartialEq)]
pub struct Numbers {
    error_max: f64,
    error_mean: f64,
    seconds: f64,
}

impl Numbers {
    /// Those of one picture in the text of `report.csv`.
    pub fn of(csv: &str, picture: &str) -> Result<Self, Error> {
        let table = Table::read(csv);
        let number = |name: &str| {
            let lacking = || Error::Failed(format!("report.csv has no {name} of {picture}"));
            table.number("file", picture, name).ok_or_else(lacking)
        };
        Ok(Self {
            error_max: number("error_max")?,
            error_mean: number("error_mean")?,
            seconds: number("prepare_s")? + number("render_s")?,
        })
    }

    fn words(&self) -> String {
        let Numbers { error_max, error_mean, seconds } = self;
        format!("error ≤ {error_max:.1e}, mean {error_mean:.1e}; {seconds:.1} s")
    }
}

/// The sections of a page, by the names of their scenes.
#[derive(Debug, Default)]
pub struct Page {
    sections: BTreeMap<String, String>,
}

impl Page {
    /// Reads a page; a file that cannot be read is an empty page.
    pub fn read(path: &Path) -> Self {
        Self::parse(&fs::read_to_string(path).unwrap_or_default())
    }

    fn parse(text: &str) -> Self {
        let mut page = Self::default();
        for section in text.split("\n## ").skip(1) {
            if let Some(entry) = GALLERY.iter().find(|entry| section.lines().next() == Some(entry.title)) {
                page.sections.insert(entry.scene.into(), format!("\n## {}\n", section.trim_end()));
            }
        }
        page
    }

    /// Replaces a scene's section.
    pub fn put(&mut self, entry: &Entry, numbers: &[Numbers]) {
        self.sections.insert(entry.scene.into(), section(entry, numbers));
    }

    fn text(&self) -> String {
        let known = GALLERY.iter().filter_map(|entry| self.sections.get(entry.scene));
        known.fold(HEAD.to_owned(), |text, section| text + section) + TAIL
    }

    /// Writes the page.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        fs::write(path, self.text()).map_err(Error::while_doing(path.display()))
    }
}

fn section(entry: &Entry, numbers: &[Numbers]) -> String {
    let Entry { title, scene, seen, pictures, .. } = entry;
    let mut text = format!("\n## {title}\n\n");
    for picture in *pictures {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "![{}]({})", picture.what, picture.file);
    }
    let _ = writeln!(text, "\n{seen}\n\n[{scene}](../scenes/{scene}): `{}`\n", entry.command());
    for (picture, numbers) in pictures.iter().zip(numbers) {
        let _ = writeln!(text, "- {}: {}", picture.what, numbers.words());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers() -> Numbers {
        Numbers { error_max: 3.456e-4, error_mean: 2e-5, seconds: 1.26 }
    }

    #[test]
    fn numbers_are_those_of_the_picture() {
        let csv = "file,prepare_s,render_s,error_max,error_mean\na.png,1,2,3,4\n\"b, c.png\",1,0.26,3.456e-4,2e-5\n";
        assert_eq!(Numbers::of(csv, "b, c.png"), Ok(numbers()));
        let lost = Error::Failed("report.csv has no error_max of c.png".into());
        assert_eq!(Numbers::of(csv, "c.png"), Err(lost));
        assert_eq!(numbers().words(), "error ≤ 3.5e-4, mean 2.0e-5; 1.3 s");
    }

    #[test]
    fn a_section_that_is_not_drawn_stays() {
        let mut page = Page::default();
        for entry in GALLERY {
            page.put(entry, &entry.pictures.iter().map(|_| numbers()).collect::<Vec<_>>());
        }
        let whole = page.text();
        let mut again = Page::parse(&whole);
        assert_eq!(again.text(), whole);
        let first = &GALLERY[0];
        let slow: Vec<_> = first.pictures.iter().map(|_| Numbers { seconds: 77.0, ..numbers() }).collect();
        again.put(first, &slow);
        assert_eq!(again.text().matches("77.0 s").count(), first.pictures.len());
        assert_eq!(again.text().replace("77.0 s", "1.3 s"), whole);
    }
}
