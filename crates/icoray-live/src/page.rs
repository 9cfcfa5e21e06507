//! The page's files, which are embedded in the program.

/// A file of the page.
pub(crate) struct PageFile {
    name: &'static str,
    pub bytes: &'static [u8],
}

macro_rules! files {
    ($($name:literal)*) => {
        &[$(PageFile { name: $name, bytes: include_bytes!(concat!("../page/", $name)) },)*]
    };
}

const FILES: &[PageFile] = files![
    "animate.js" "api.js" "apng.js" "app.js" "camera.js" "colour.js" "curve.js" "dom.js" "facts.js" "files.js"
    "form.js" "format.js" "frames.js" "hand.js" "hints.js" "hover.js" "index.html" "keys.js" "lines.js" "maps.js"
    "markers.js" "panel.js" "plot.js" "probe.js" "sender.js" "store.js" "style.css" "timeline.js" "toml.js"
    "transfer-changes.js" "transfer-model.js" "transfer-panel.js" "transfer-rows.js" "transfer.js" "view.js" "views.js"
    "widgets.js"
];

impl PageFile {
    /// The media type, by the ending of the name.
    pub fn media_type(&self) -> &'static str {
        match self.name.rsplit_once('.') {
            Some((_, "html")) => "text/html; charset=utf-8",
            Some((_, "css")) => "text/css; charset=utf-8",
            _ => "text/javascript; charset=utf-8",
        }
    }
}

/// The file at a path.
pub(crate) fn file(path: &str) -> Option<&'static PageFile> {
    let name = if path == "/" { "index.html" } else { path.strip_prefix('/')? };
    FILES.iter().find(|file| file.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::{fs, path::Path};

    #[test]
    fn all_files_of_the_folder_are_served() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("page");
        let there = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let there: BTreeSet<String> = there.collect();
        assert_eq!(FILES.iter().map(|file| file.name.to_owned()).collect::<BTreeSet<_>>(), there);
        for (path, kind) in [("/", "text/html"), ("/app.js", "text/javascript"), ("/style.css", "text/css")] {
            assert!(file(path).unwrap().media_type().starts_with(kind), "{path}");
        }
        assert!(file("/../Cargo.toml").is_none() && file("").is_none());
    }
}
