//! Scenes with `backend = "gpu"` through the C ABI: in C and under mpirun, on any adapter, which may be a processor,
//! and without one.

use icoray_test_support::{Need, skip, skip_because};
use icoray_tests::native::{checked, command, compile_c};
use icoray_tests::pictures::{difference, files};
use icoray_tests::ranks::FIRST;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

/// Largest difference of a channel and root of the mean square, as for the renderer's own pictures.
const MAX: f64 = 1e-3;
const RMSE: f64 = 2e-5;

/// Whether an adapter is here. If none is, skips the test.
fn has_adapter() -> bool {
    match icoray_gpu::list() {
        Ok(adapters) if !adapters.is_empty() => return true,
        Ok(_) => skip(Need::Gpu),
        Err(reason) => skip_because(Need::Gpu, reason),
    }
    false
}

/// A command that finds no driver, by either name that loaders of Vulkan have known.
fn without_drivers(command: &mut Command) -> &mut Command {
    command.env("VK_DRIVER_FILES", "/none.json").env("VK_ICD_FILENAMES", "/none.json")
}

/// Compares the pictures of two directories.
fn compare(one: &Path, other: &Path, max: f64) {
    let names: Vec<String> = files(one).into_keys().collect();
    assert!(!names.is_empty() && files(other).keys().eq(&names), "{names:?}");
    for name in names {
        let [largest, rmse] = difference(&one.join(&name), &other.join(&name));
        assert!(largest <= max && rmse <= RMSE.max(max / 10.0), "{name}: {largest:e}, rmse {rmse:e}");
    }
}

#[test]
fn a_model_s_pictures_are_those_of_the_cpu_on_any_adapter() {
    if !has_adapter() {
        return;
    }
    let directory = TempDir::new().unwrap();
    let program = compile_c(&["gpu", "host_common", "check"]);
    let out = directory.path().join("pictures");
    checked(command(program, directory.path()).arg(&out).arg("here"), "gpu", 100);
    let at = |name: &str| out.join(name);
    for one in ["gpu", "async"] {
        compare(&at(one), &at("cpu"), MAX);
    }
    compare(&at("async"), &at("gpu"), 0.0);
    compare(&at("other"), &at("cpu"), 0.0);
}

#[test]
fn a_model_goes_on_without_any_adapter() {
    let directory = TempDir::new().unwrap();
    let program = compile_c(&["gpu", "host_common", "check"]);
    let mut run = command(program, directory.path());
    let out = directory.path().join("pictures");
    checked(without_drivers(&mut run).arg(&out).arg("gone"), "gpu", 100);
    for one in ["gpu", "async", "other", "auto"] {
        compare(&out.join(one), &out.join("cpu"), 0.0);
    }
}

#[test]
fn ranks_share_an_adapter() {
    if !has_adapter() || !FIRST.is_there() {
        return;
    }
    let directory = TempDir::new().unwrap();
    let program = FIRST.compile((FIRST.library)(), "mpi_gpu");
    let at = |name: &str| directory.path().join(name);
    let serial = |name: &str, backend: &str| {
        let mut run = command(&program, directory.path());
        checked(run.arg(at(name)).arg(backend).arg("serial"), "mpi_gpu", 20);
    };
    serial("cpu", "cpu");
    serial("one", "gpu");
    compare(&at("one"), &at("cpu"), MAX);
    for ranks in [2, 3] {
        let to = at(&ranks.to_string());
        let mut run = FIRST.on_ranks(ranks, &program, directory.path());
        checked(run.arg(&to).arg("gpu"), "mpi_gpu", 20);
        compare(&to, &at("one"), 0.0);
        // One rank finds no adapter, and draws on the CPU.
        let to = at(&format!("{ranks} mixed"));
        let mut run = FIRST.on_ranks(ranks, &program, directory.path());
        checked(run.arg(&to).arg("gpu").arg("mixed"), "mpi_gpu", 20);
        compare(&to, &at("cpu"), MAX);
    }
}
