//! The sources of the shaders, and their preprocessor.
//!
//! A line `#import NAME` includes `shaders/NAME.wgsl` before the rest of the file, once per shader. A line `#each TEXT`
//! is replaced by one line TEXT per page of the field, with the number of the page in place of PAGE. A line `#scene TEXT`
//! is TEXT in the shader `scene`, and a line `#plain TEXT` in all others; elsewhere it is left out.

macro_rules! sources {
    ($($name:literal)*) => {
        [$(($name, include_str!(concat!("../../../shaders/", $name, ".wgsl")))),*]
    };
}

/// All files in `shaders/`: name and text.
pub const SOURCES: [(&str, &str); 32] = sources! {
    "gradient" "gradients" "grid" "pages" "params" "parts" "picture" "pieces" "scene" "scenery" "kernel/column"
    "kernel/general/clips" "kernel/general/frustum" "kernel/general/isosurfaces" "kernel/general/surfaces" "kernel/signature"
    "kernel/roundoff" "kernel/lit" "kernel/piece" "kernel/plane" "kernel/ray" "kernel/ray/fragment"
    "kernel/real" "kernel/sample" "kernel/segment" "kernel/shade" "kernel/transfer" "kernel/turn" "kernel/walk"
    "kernel/wide" "measure/multiply" "measure/stream"
};

/// The shader `name` with its imports, for a field of one page.
///
/// # Panics
/// If there is no such shader.
pub fn compose(name: &str) -> String {
    compose_for(name, 1)
}

/// The shader `name` with its imports, for a field of `pages` pages.
///
/// # Panics
/// If there is no such shader.
pub fn compose_for(name: &str, pages: usize) -> String {
    expand_for(&format!("#import {name}"), pages)
}

/// `text` with its imports, for a field of one page.
///
/// # Panics
/// If it imports a shader that does not exist.
pub fn expand(text: &str) -> String {
    expand_for(text, 1)
}

fn expand_for(text: &str, pages: usize) -> String {
    let is_scene = text.lines().any(|line| line.trim() == "#import scene");
    let mut composer = Composer { pages, is_scene, seen: Vec::new(), whole: String::new() };
    composer.add(text);
    composer.whole
}

/// A shader that is put together.
struct Composer<'t> {
    pages: usize,
    is_scene: bool,
    /// The names of the files that it has.
    seen: Vec<&'t str>,
    whole: String,
}

impl<'t> Composer<'t> {
    fn add(&mut self, text: &'t str) {
        let import = |line: &'t str| line.strip_prefix("#import ").map(str::trim);
        let (kept, left_out) = if self.is_scene { ("#scene ", "#plain ") } else { ("#plain ", "#scene ") };
        let lines = text.lines().filter(|line| !line.starts_with(left_out));
        let lines: Vec<&str> = lines.map(|line| line.strip_prefix(kept).unwrap_or(line)).collect();
        for name in lines.iter().copied().filter_map(import) {
            if !self.seen.contains(&name) {
                self.seen.push(name);
                let source = SOURCES.iter().find(|(known, _)| *known == name);
                self.add(source.unwrap_or_else(|| panic!("no shader is named {name}")).1);
            }
        }
        for line in lines.into_iter().filter(|line| import(line).is_none()) {
            match line.strip_prefix("#each ") {
                Some(each) => (0..self.pages).for_each(|page| {
                    self.whole.push_str(&each.replace("PAGE", &page.to_string()));
                    self.whole.push('\n');
                }),
                None => {
                    self.whole.push_str(line);
                    self.whole.push('\n');
                }
            }
        }
    }
}
