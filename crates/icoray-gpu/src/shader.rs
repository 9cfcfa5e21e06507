//! The preprocessor of the shaders, whose sources are in the crate `icoray-shaders`.
//!
//! A line `#import NAME` includes `shaders/NAME.wgsl` before the rest of the file, once per shader. A line `#each TEXT`
//! is replaced by one line TEXT per page of the field, with the number of the page in place of PAGE. A line `#scene
//! TEXT` is TEXT in shaders of scenes that show more than one volume and a core, and a line `#plain TEXT` in all
//! others; elsewhere it is left out, as are the other lines of [`Contents`]. A line `#volume TEXT` is replaced by one
//! line TEXT per volume, with the number of the volume in place of VOLUME, as drivers may limit the iterations of all
//! loops together.

pub use icoray_shaders::SOURCES;

/// The contents of a scene that need code of their own: all other shaders omit it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Contents {
    /// More than one volume and a core: lines `#scene`, else `#plain`.
    pub scenery: bool,
    /// Number of volumes, if there are several or the only one's opacity is that of another field: lines `#several`;
    /// else 0: lines `#single`.
    pub volumes: usize,
    /// Places whose light the host computes: lines `#painted`.
    pub painted: bool,
    /// Layers at other heights over each cell: lines `#native`, else `#concentric`.
    pub native: bool,
}

impl Contents {
    /// The tags of lines that are kept, and of those that are left out.
    fn tags(self) -> [[&'static str; 2]; 4] {
        let pairs = [
            (self.scenery, ["#scene ", "#plain "]),
            (self.volumes > 0, ["#several ", "#single "]),
            (self.painted, ["#painted ", "#unpainted "]),
            (self.native, ["#native ", "#concentric "]),
        ];
        pairs.map(|(is, [with, without])| if is { [with, without] } else { [without, with] })
    }
}

/// The shader `name` of a scene with its imports, for a field of `pages` pages.
///
/// # Panics
/// If there is no such shader.
pub fn compose(name: &str, contents: Contents, pages: usize) -> String {
    expand(&format!("#import {name}"), contents, pages)
}

/// `text` with its imports, of a scene and for a field of `pages` pages.
///
/// # Panics
/// If it imports a shader that does not exist.
pub fn expand(text: &str, contents: Contents, pages: usize) -> String {
    let mut composer =
        Composer { pages, volumes: contents.volumes, tags: contents.tags(), seen: Vec::new(), whole: String::new() };
    composer.add(text);
    composer.whole
}

struct Composer<'t> {
    pages: usize,
    volumes: usize,
    /// See [`Contents::tags`].
    tags: [[&'static str; 2]; 4],
    /// The names of the files that are included.
    seen: Vec<&'t str>,
    whole: String,
}

impl<'t> Composer<'t> {
    fn add(&mut self, text: &'t str) {
        let import = |line: &'t str| line.strip_prefix("#import ").map(str::trim);
        let tags = self.tags;
        let lines = text.lines().filter(|line| !tags.iter().any(|[_, left_out]| line.starts_with(left_out)));
        let untagged = |line: &'t str| tags.iter().find_map(|[kept, _]| line.strip_prefix(kept)).unwrap_or(line);
        let lines: Vec<&str> = lines.map(untagged).collect();
        for name in lines.iter().copied().filter_map(import) {
            if !self.seen.contains(&name) {
                self.seen.push(name);
                let source = SOURCES.iter().find(|(known, _)| *known == name);
                self.add(source.unwrap_or_else(|| panic!("no shader is named {name}")).1);
            }
        }
        for line in lines.into_iter().filter(|line| import(line).is_none()) {
            let repeated = |prefix: &str, name: &str, count: usize| {
                let text = line.strip_prefix(prefix)?;
                Some((0..count).map(|number| text.replace(name, &number.to_string())).collect::<Vec<_>>())
            };
            let each = repeated("#each ", "PAGE", self.pages).or_else(|| repeated("#volume ", "VOLUME", self.volumes));
            for line in each.unwrap_or_else(|| vec![line.to_owned()]) {
                self.whole.push_str(&line);
                self.whole.push('\n');
            }
        }
    }
}
