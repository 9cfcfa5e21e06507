//! The paper's Figure 6: the pictures of [`radial`](icoray_reference::radial) and their differences from the ground
//! truth.

use crate::picture::{amplified, write_pixels};
use crate::results::{make_directory, progress, say};
use icoray::output::{Stamp, write_picture};
use icoray::{Frame, Method, Result};
use icoray_reference::radial::{Compared, Radial};
use std::io::Write;
use std::path::PathBuf;

/// Options of the figure.
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Bisections of the icosahedron; 5 is the paper's.
    #[arg(long, default_value_t = 5)]
    pub level: u32,
    /// Layers; 61 is the paper's.
    #[arg(long, default_value_t = 61)]
    pub layers: usize,
    /// Width and height of the pictures.
    #[arg(long, default_value_t = 512)]
    pub size: u32,
    /// Midpoint steps of the ground truth along each ray.
    #[arg(long, default_value_t = 4000)]
    pub steps: usize,
    /// Directory of the pictures.
    #[arg(long, default_value = "out/fig6")]
    pub out: PathBuf,
}

/// Writes the pictures and prints RMSE and maximum.
pub fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    make_directory(&options.out)?;
    let save = |name: String, frame: &Frame| write_picture(&options.out.join(name), frame);
    let Options { level, layers, size, steps, .. } = *options;
    say!(out, "{layers} layers, n = {level}, {size} x {size} pixels, linear premultiplied channels 0 to 1")?;
    let bar = progress(4, "fig6");
    for (name, method, is_lit) in [
        ("lit", Method::Exact, true),
        ("unlit", Method::Exact, false),
        ("lit_paper", Method::Paper, true),
        ("unlit_paper", Method::Paper, false),
    ] {
        bar.set_message(name);
        let radial = Radial { level, layers, size, steps, method, is_lit };
        let Compared { mut frame, truth, rmse, max, max_off_limb } = radial.compare()?;
        frame.stamp = Stamp::default();
        save(format!("fig6_{name}.png"), &frame)?;
        save(format!("fig6_{name}_truth.png"), &truth)?;
        let difference = amplified(&frame.pixels, &truth.pixels, 20.0);
        write_pixels(&options.out.join(format!("fig6_{name}_difference_x20.png")), [size; 2], difference)?;
        let seconds = frame.report.timing.render_s;
        bar.suspend(|| {
            say!(
                out,
                "{name:>12}: RMSE {rmse:.2e}, maximum {max:.2e} ({max_off_limb:.2e} off the core's limb), rendered in {seconds:.3} s"
            )
        })?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    say!(out, "pictures in {}", options.out.display())
}
