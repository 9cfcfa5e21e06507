//! Choice of the device: a GPU or a processor that acts as one, if requested and present; else the CPU, with a reason.

use crate::files::folder;
use crate::made::Made;
use crate::run::{difference, has, icoray, prints, scene, texts};
use icoray_test_support::{Need, skip_because};
use std::collections::HashMap;
use std::path::Path;

/// An unlit scene, with keys before it.
fn unlit(keys: &str) -> String {
    let lit = scene("theta", 0.0, 42.0);
    format!("antialias = false\n{keys}\n{}", lit.split_once("[light]").unwrap().0)
}

/// The adapters. If there are none, skips the test.
fn adapters() -> Option<Vec<String>> {
    let text = prints(icoray(Path::new(".")).arg("devices"));
    let is_listed = text.starts_with("0  ");
    if !is_listed {
        skip_because(if cfg!(feature = "gpu") { Need::Gpu } else { Need::Long }, &text);
    }
    is_listed.then(|| text.lines().map(str::to_owned).collect())
}

#[test]
fn a_gpu_draws_where_the_scene_or_the_command_asks_for_one() {
    let Some(adapters) = adapters() else { return };
    let by_scene = folder(&Made::history(), &unlit("backend = \"gpu\"\ndevice = 0"));
    let name = adapters[0].strip_prefix("0  ").unwrap().split(" (").next().unwrap();
    has(&by_scene.render("-o gpu.png"), &[&format!("drawn on  {name}"), "rays      5792, "]);
    let text = by_scene.render("-o cpu.png --backend cpu");
    has(&text, &["drawn on  the CPU\n"]);
    assert!(difference(&by_scene.at("gpu.png"), &by_scene.at("cpu.png")).max <= 1);
    let says = texts(&by_scene.at("gpu.png"));
    assert!(says.iter().any(|(key, text)| key == "device" && text.starts_with(name)), "{says:?}");
    assert!(texts(&by_scene.at("cpu.png")).iter().all(|(key, _)| key != "device"));
    let by_command = folder(&Made::history(), &unlit("backend = \"cpu\""));
    // A name may have blanks.
    let upper = name.to_uppercase();
    let mut command = icoray(by_command.path());
    command.args(["made.nc", "--scene", "scene.toml", "-v", "-o", "a.png", "--backend", "gpu", "--device", &upper]);
    has(&prints(&mut command), &[&format!("drawn on  {name}")]);
    let text = by_command.render("--time all -o all --backend gpu");
    assert_eq!(text.matches("drawn on  ").count(), 3, "{text}");
    let rows = csv::Reader::from_path(by_command.at("all/report.csv")).unwrap().into_deserialize();
    let uploaded =
        rows.map(|row: csv::Result<HashMap<String, String>>| row.unwrap()["bytes_uploaded"].parse().unwrap());
    // The field each time, the grid once.
    let [first, second, third] = uploaded.collect::<Vec<u64>>()[..] else { panic!("three pictures") };
    assert!(first > second && second == third && third >= 4 * 42 * 4, "{first}, {second}, {third}");
    // A plan says who would draw.
    has(&by_scene.prints("plan made.nc --scene scene.toml"), &[&format!("\ndrawn on {name}")]);
}

#[test]
fn processors_draw_only_if_a_gpu_is_requested() {
    let Some(adapters) = adapters() else { return };
    let folder = folder(&Made::history(), &unlit(""));
    let text = folder.render("-o out.png");
    if adapters.iter().all(|adapter| adapter.contains("(processor that acts as a GPU, ")) {
        has(&text, &["drawn on  the CPU: ", "backend = \"gpu\" uses"]);
    } else {
        assert!(!text.contains("drawn on  the CPU"), "{text}");
    }
}

#[test]
fn the_cpu_draws_where_no_adapter_is_found() {
    let folder = folder(&Made::history(), &unlit(""));
    let missing = folder.at("none.json");
    folder.render("-o cpu.png --backend cpu");
    // Drivers are looked for by the first only where there is a GPU.
    for (backend, reason) in [("auto", ": no "), ("gpu", ": no Vulkan adapter was found\n")] {
        let mut command = icoray(folder.path());
        command.args(["render", "made.nc", "--scene", "scene.toml", "-v", "-o", "out.png", "--backend", backend]);
        // Either name, as loaders of Vulkan have known it.
        let text = prints(command.env("VK_DRIVER_FILES", &missing).env("VK_ICD_FILENAMES", &missing));
        let reason = if cfg!(feature = "gpu") { reason } else { "" };
        has(&text, &[&format!("drawn on  the CPU{reason}")]);
        assert_eq!(difference(&folder.at("out.png"), &folder.at("cpu.png")).max, 0);
    }
}

#[test]
fn the_cpu_draws_where_the_named_device_is_not_found() {
    let folder = folder(&Made::history(), &unlit(""));
    let Some(adapters) = adapters() else { return };
    for (device, words) in
        [("99", "no adapter has the number 99 of ["), ("Voodoo", "no adapter is named \"Voodoo\" of [")]
    {
        let parts = ["drawn on  the CPU: ", words, adapters[0][3..].split(" (").next().unwrap()];
        has(&folder.render(&format!("-o out.png --backend gpu --device {device}")), &parts);
    }
}
