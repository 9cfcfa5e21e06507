//! Shown, saved and rendered pictures have the same bits.

use crate::browser::Browser;
use crate::page::{Shown, hash};
use crate::run::wait_until;
use fantoccini::Locator;
use image::codecs::png::PngDecoder;
use image::{AnimationDecoder, DynamicImage, ImageReader};
use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;

/// A file that the page saves, once it is whole.
fn saved(browser: &Browser, name: &str) -> PathBuf {
    let path = browser.downloads.path().join(name);
    // The browser gives a file its name when it is whole.
    wait_until(&format!("{name} is saved"), || path.is_file());
    path
}

fn picture(path: PathBuf) -> DynamicImage {
    ImageReader::open(path).unwrap().decode().unwrap()
}

#[test]
fn a_saved_scene_renders_the_bits_that_are_seen() {
    let Some(Shown { browser, folder, .. }) = &Shown::start() else { return };
    let [from, goal] = [[0.5, 0.5], [0.42, 0.6]].map(|place| browser.place(place));
    browser.changed_by(|| browser.drag(from, goal));
    browser.changed_by(|| browser.wheel(from, -100));
    browser.click("#colours summary");
    browser.changed_by(|| browser.click("#colours .swatch[aria-checked='false']"));
    let (text, seen) = (browser.text(), browser.canvas_hash());

    browser.click("#tab-files");
    browser.click("#save-scene");
    let scene = saved(browser, "scene.toml");
    browser.until_text("#status", "saved as scene.toml");
    assert_eq!(std::fs::read_to_string(&scene).unwrap(), text);
    assert_eq!(browser.js("return document.getElementById('scene-text').textContent;"), *text);
    std::fs::copy(&scene, folder.at("scene.toml")).unwrap();
    let command = browser.js("return document.getElementById('command').textContent;");
    let command = command.as_str().unwrap();
    assert_eq!(command, "icoray render made.nc --scene scene.toml --time 2");
    for format in ["png", "exr"] {
        browser.click(&format!("#save-{format}"));
        let on_page = picture(saved(browser, &format!("picture.{format}"))).to_rgba32f();
        let name = format!("rendered.{format}");
        folder.prints(&format!("{} -o {name}", command.strip_prefix("icoray ").unwrap()));
        let rendered = picture(folder.at(&name));
        assert!(on_page == rendered.to_rgba32f(), "{format}: other pixels");
        if format == "png" {
            let rendered = rendered.to_rgb8();
            assert_eq!(rendered.width(), browser.number("canvas.width") as u32);
            assert_eq!(hash(rendered.into_raw().into_iter()), seen, "the canvas has other pixels");
        }
    }

    // Loaded again after other changes it is the same picture.
    browser.changed_by(|| browser.drag(from, goal));
    assert_ne!(browser.canvas_hash(), seen);
    let input = browser.wait(browser.client().find(Locator::Css("#load-file")));
    browser.changed_by(|| browser.wait(input.send_keys(scene.to_str().unwrap())));
    browser.until_text("#status", "scene.toml is loaded");
    assert_eq!((browser.text(), browser.canvas_hash()), (text, seen));
    browser.is_quiet();
}

#[test]
fn an_animation_has_the_pictures_of_all_times() {
    let Some(Shown { browser, folder, .. }) = &Shown::start() else { return };
    browser.click("#tab-files");
    browser.click("#save-scene");
    std::fs::copy(saved(browser, "scene.toml"), folder.at("scene.toml")).unwrap();
    browser.click("#save-animation");
    let path = saved(browser, "animation.png");
    browser.until_text("#save-animation", "Save animation");
    let decoder = PngDecoder::new(BufReader::new(File::open(path).unwrap())).unwrap();
    let frames = decoder.apng().unwrap().into_frames().collect_frames().unwrap();
    assert_eq!(frames.len(), 3);
    for (time, frame) in frames.into_iter().enumerate() {
        let name = format!("{time}.png");
        folder.prints(&format!("render made.nc --scene scene.toml --time {time} -o {name}"));
        let rendered = picture(folder.at(&name)).to_rgba8();
        assert!(rendered == frame.into_buffer(), "time {time} has other pixels");
    }
    browser.is_quiet();
}
