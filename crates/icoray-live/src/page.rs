//! The page's files, which are embedded in the program.

/// A file of the page.
pub(crate) struct PageFile {
    pub path: &'static str,
    pub media_type: &'static str,
    pub bytes: &'static [u8],
}

macro_rules! files {
    ($($path:literal $name:literal $media_type:literal,)*) => {
        [$(PageFile {
            path: $path,
            media_type: $media_type,
            bytes: include_bytes!(concat!("../page/", $name)),
        },)*]
    };
}

const FILES: &[PageFile] = &files![
    "/" "index.html" "text/html; charset=utf-8",
    "/animate.js" "animate.js" "text/javascript; charset=utf-8",
    "/api.js" "api.js" "text/javascript; charset=utf-8",
    "/apng.js" "apng.js" "text/javascript; charset=utf-8",
    "/app.js" "app.js" "text/javascript; charset=utf-8",
    "/camera.js" "camera.js" "text/javascript; charset=utf-8",
    "/colour.js" "colour.js" "text/javascript; charset=utf-8",
    "/curve.js" "curve.js" "text/javascript; charset=utf-8",
    "/dom.js" "dom.js" "text/javascript; charset=utf-8",
    "/facts.js" "facts.js" "text/javascript; charset=utf-8",
    "/files.js" "files.js" "text/javascript; charset=utf-8",
    "/form.js" "form.js" "text/javascript; charset=utf-8",
    "/format.js" "format.js" "text/javascript; charset=utf-8",
    "/frames.js" "frames.js" "text/javascript; charset=utf-8",
    "/hand.js" "hand.js" "text/javascript; charset=utf-8",
    "/hints.js" "hints.js" "text/javascript; charset=utf-8",
    "/hover.js" "hover.js" "text/javascript; charset=utf-8",
    "/keys.js" "keys.js" "text/javascript; charset=utf-8",
    "/maps.js" "maps.js" "text/javascript; charset=utf-8",
    "/lines.js" "lines.js" "text/javascript; charset=utf-8",
    "/markers.js" "markers.js" "text/javascript; charset=utf-8",
    "/panel.js" "panel.js" "text/javascript; charset=utf-8",
    "/plot.js" "plot.js" "text/javascript; charset=utf-8",
    "/probe.js" "probe.js" "text/javascript; charset=utf-8",
    "/sender.js" "sender.js" "text/javascript; charset=utf-8",
    "/store.js" "store.js" "text/javascript; charset=utf-8",
    "/style.css" "style.css" "text/css; charset=utf-8",
    "/timeline.js" "timeline.js" "text/javascript; charset=utf-8",
    "/toml.js" "toml.js" "text/javascript; charset=utf-8",
    "/transfer-changes.js" "transfer-changes.js" "text/javascript; charset=utf-8",
    "/transfer-model.js" "transfer-model.js" "text/javascript; charset=utf-8",
    "/transfer-panel.js" "transfer-panel.js" "text/javascript; charset=utf-8",
    "/transfer-rows.js" "transfer-rows.js" "text/javascript; charset=utf-8",
    "/transfer.js" "transfer.js" "text/javascript; charset=utf-8",
    "/view.js" "view.js" "text/javascript; charset=utf-8",
    "/views.js" "views.js" "text/javascript; charset=utf-8",
    "/widgets.js" "widgets.js" "text/javascript; charset=utf-8",
];

/// The file at a path.
pub(crate) fn file(path: &str) -> Option<&'static PageFile> {
    FILES.iter().find(|file| file.path == path)
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
        let served = FILES.iter().map(|file| if file.path == "/" { "index.html" } else { &file.path[1..] });
        assert_eq!(served.map(str::to_owned).collect::<BTreeSet<_>>(), there);
        assert!(file("/app.js").is_some_and(|file| file.media_type.starts_with("text/javascript")));
        assert!(file("/../Cargo.toml").is_none() && file("").is_none());
    }
}
