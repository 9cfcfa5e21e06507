//! Completions, manual pages, the picture of colour maps, and films by a program that stands in for ffmpeg.

use crate::run::{Folder, fails, has, icoray, prints};
use std::fs;
use std::process::Command;

#[test]
fn completions_and_manual_pages_have_every_command() {
    let folder = Folder::new();
    folder.prints("manual share");
    let read = |name: &str| fs::read_to_string(folder.at("share").join(name)).unwrap();
    for path in [
        "bash-completion/completions/icoray",
        "zsh/site-functions/_icoray",
        "fish/vendor_completions.d/icoray.fish",
        "man/man1/icoray-render.1",
    ] {
        has(&read(path), &["render", "colormap", "isosurface"]);
    }
    has(&read("man/man1/icoray-render.1"), &["a first picture"]);
    for absent in ["icoray-study.1", "icoray-help.1", "icoray-help-render.1"] {
        assert!(!folder.at("share/man/man1").join(absent).exists(), "{absent}");
    }
    folder.fails("manual /proc/man", 1, &["/proc/man: cannot write the manual"]);
}

#[test]
fn colour_maps_are_drawn_and_named() {
    let folder = Folder::new();
    let parts = ["picture   new/maps.png\n", "names     ", "viridis, viridis_bright"];
    has(&folder.prints("colormaps -o new/maps.png"), &parts);
    assert!(image::open(folder.at("new/maps.png")).unwrap().width() > 1000);
}

#[test]
fn films_are_made_of_the_pixels_by_ffmpeg() {
    let folder = Folder::new();
    for (name, shade) in [("a.png", 10), ("b.png", 200)] {
        image::RgbaImage::from_pixel(3, 2, image::Rgba([shade, shade, shade, 255])).save(folder.at(name)).unwrap();
    }
    // By a process of its own: one that another test starts would hold a file open that this one writes.
    let install = |script: &str| {
        let write = "printf %s \"$1\" > ffmpeg && chmod +x ffmpeg";
        let done = Command::new("/bin/sh").args(["-c", write, "sh", script]).current_dir(folder.path()).status();
        assert!(done.unwrap().success());
    };
    let animate = |film: &str| {
        let mut command = icoray(folder.path());
        command.args(["animate", "a.png", "b.png", "-o", film, "--fps", "5"]).env("PATH", folder.path());
        command
    };
    let parts = ["film.mp4: expected the program ffmpeg for .mp4: install it, or take a name that ends in .png"];
    fails(&mut animate("film.mp4"), 1, &parts);
    for (film, options) in [("film.mp4", "-pix_fmt yuv420p -movflags +faststart"), ("film.gif", "[p]paletteuse")] {
        // The arguments without the last, the film's temporary name, and the pixels.
        let script = "#!/bin/sh\nfor film; do :; done\n{ echo \"$*\"; /bin/cat; } > \"$film\"\n";
        install(script);
        has(&prints(&mut animate(film)), &[&format!("animation {film} (3 x 2, 2 pictures, 5 per second")]);
        let made = folder.bytes(film);
        let line = made.iter().position(|byte| *byte == b'\n').unwrap();
        has(&String::from_utf8_lossy(&made[..line]), &["-f rawvideo -pix_fmt rgba -s 3x2 -r 5 -i - ", options]);
        let pixels = [[[10, 10, 10, 255]; 6], [[200, 200, 200, 255]; 6]].concat().concat();
        assert_eq!(made[line + 1..], pixels);
        install("#!/bin/sh\n/bin/cat > /dev/null\necho no codec >&2\nexit 1\n");
        fails(&mut animate(film), 1, &[&format!("{film}: ffmpeg cannot write it: no codec")]);
        assert_eq!(folder.bytes(film), made, "the film of before stays");
    }
    assert_eq!(folder.count(), 5, "temporary files are gone");
}
