//! The shaders' sources, and how one is put together of those that it imports.
//!
//! A line `#import NAME` in `shaders/` asks for `shaders/NAME.wgsl`, once and before the rest of the file. Nothing more is
//! needed: WGSL does not mind the order of declarations. What follows `#each` at the beginning of a line stands there once for
//! each page of the field, with the page's number in place of PAGE.

/// Every file in `shaders/`, by its name there.
pub const SOURCES: [(&str, &str); 24] = [
    ("gradient", include_str!("../../../shaders/gradient.wgsl")),
    ("gradients", include_str!("../../../shaders/gradients.wgsl")),
    ("grid", include_str!("../../../shaders/grid.wgsl")),
    ("pages", include_str!("../../../shaders/pages.wgsl")),
    ("params", include_str!("../../../shaders/params.wgsl")),
    ("parts", include_str!("../../../shaders/parts.wgsl")),
    ("picture", include_str!("../../../shaders/picture.wgsl")),
    ("pieces", include_str!("../../../shaders/pieces.wgsl")),
    ("kernel/column", include_str!("../../../shaders/kernel/column.wgsl")),
    ("kernel/doubt", include_str!("../../../shaders/kernel/doubt.wgsl")),
    ("kernel/lit", include_str!("../../../shaders/kernel/lit.wgsl")),
    ("kernel/piece", include_str!("../../../shaders/kernel/piece.wgsl")),
    ("kernel/plane", include_str!("../../../shaders/kernel/plane.wgsl")),
    ("kernel/ray", include_str!("../../../shaders/kernel/ray.wgsl")),
    ("kernel/ray/fragment", include_str!("../../../shaders/kernel/ray/fragment.wgsl")),
    ("kernel/real", include_str!("../../../shaders/kernel/real.wgsl")),
    ("kernel/sample", include_str!("../../../shaders/kernel/sample.wgsl")),
    ("kernel/segment", include_str!("../../../shaders/kernel/segment.wgsl")),
    ("kernel/shade", include_str!("../../../shaders/kernel/shade.wgsl")),
    ("kernel/transfer", include_str!("../../../shaders/kernel/transfer.wgsl")),
    ("kernel/walk", include_str!("../../../shaders/kernel/walk.wgsl")),
    ("kernel/wide", include_str!("../../../shaders/kernel/wide.wgsl")),
    ("measure/multiply", include_str!("../../../shaders/measure/multiply.wgsl")),
    ("measure/stream", include_str!("../../../shaders/measure/stream.wgsl")),
];

/// The source named `name` with all that it imports, for a field of one page.
///
/// # Panics
/// When there is no such source.
pub fn compose(name: &str) -> String {
    compose_for(name, 1)
}

/// The source named `name` with all that it imports, for a field of `pages` pages.
///
/// # Panics
/// When there is no such source.
pub fn compose_for(name: &str, pages: usize) -> String {
    expand_for(&format!("#import {name}"), pages)
}

/// `text` with all that it imports, for a field of one page.
///
/// # Panics
/// When it imports what is not there.
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
