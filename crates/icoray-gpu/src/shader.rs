//! The sources of the shaders, and their preprocessor.
//!
//! A line `#import NAME` includes `shaders/NAME.wgsl` before the rest of the file, once per shader. A line `#each TEXT`
//! is replaced by one line TEXT per page of the field, with the number of the page in place of PAGE.

macro_rules! sources {
    ($($name:literal)*) => {
        [$(($name, include_str!(concat!("../../../shaders/", $name, ".wgsl")))),*]
    };
}

/// All files in `shaders/`: name and text.
pub const SOURCES: [(&str, &str); 25] = sources! {
    "gradient" "gradients" "grid" "pages" "params" "parts" "picture" "pieces" "kernel/column"
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
    let (mut seen, mut whole) = (Vec::new(), String::new());
    add(text, pages, &mut seen, &mut whole);
    whole
}

fn add<'t>(text: &'t str, pages: usize, seen: &mut Vec<&'t str>, whole: &mut String) {
    let import = |line: &'t str| line.strip_prefix("#import ").map(str::trim);
    for name in text.lines().filter_map(import) {
        if !seen.contains(&name) {
            seen.push(name);
            let source = SOURCES.iter().find(|(known, _)| *known == name);
            add(source.unwrap_or_else(|| panic!("no shader is named {name}")).1, pages, seen, whole);
        }
    }
    for line in text.lines().filter(|line| import(line).is_none()) {
        match line.strip_prefix("#each ") {
            Some(each) => (0..pages).for_each(|page| {
                whole.push_str(&each.replace("PAGE", &page.to_string()));
                whole.push('\n');
            }),
            None => {
                whole.push_str(line);
                whole.push('\n');
            }
        }
    }
}
