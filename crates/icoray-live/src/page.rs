//! The page's files, which are in the program.

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
];

/// The file at a path.
pub(crate) fn file(path: &str) -> Option<&'static PageFile> {
    FILES.iter().find(|file| file.path == path)
}
