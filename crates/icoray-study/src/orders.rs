//! Orders of convergence, in the sense of Etiene et al. 2014 (doi:10.1109/TVCG.2013.90): the power of two by which the
//! error falls when a step is halved or the mesh bisected. An error in a formula or in its code shows as a lost order.

use crate::results::{progress, say};
use glam::DVec3;
use icoray::{Renderer, Result, Scene};
use icoray_reference::comparison::Comparison;
use icoray_reference::methods::{Method, Sampling};
use icoray_reference::oracle;
use icoray_reference::sphere::Sphere;
use std::io::Write;

/// Options of the measurement.
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Threads; 0 is all.
    #[arg(long, default_value_t = 0)]
    pub threads: usize,
}

struct Sizes {
    /// Bisections of the icosahedron and layers while steps are halved.
    level: u32,
    layers: usize,
    /// Width and height of the pictures.
    pixels: u32,
    /// The first step, planet radii, and how often it is halved.
    step: f64,
    halvings: u32,
    /// Largest number of bisections while the mesh is refined, from 1 on.
    levels: u32,
    /// Values along a side of pre-integrated tables.
    table: usize,
}

const SIZES: Sizes = Sizes { level: 3, layers: 7, pixels: 48, step: 0.04, halvings: 4, levels: 4, table: 1024 };

/// How smooth a transfer function is over the field's range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// No knot inside: extinction and colour linear in the value.
    Smooth,
    /// Knots inside.
    Kinks,
    /// Knots that share values inside: steps.
    Steps,
}

impl Kind {
    const ALL: [Kind; 3] = [Kind::Smooth, Kind::Kinks, Kind::Steps];

    fn knots(self) -> &'static str {
        match self {
            Kind::Smooth => {
                r##"{ value = -1.5, color = "#2040ff", extinction = 0.5 }, { value = 1.5, color = "orange", extinction = 0.1 }"##
            }
            Kind::Kinks => {
                r##"{ value = -0.5, color = "#2040ff", extinction = 0.6 }, { value = -0.1, color = "white", extinction = 0 },
{ value = 0.2, color = "yellow", extinction = 0 }, { value = 0.5, color = "red", extinction = 0.8 }"##
            }
            Kind::Steps => {
                r##"{ value = -0.2, color = "#2040ff", extinction = 0.4 }, { value = -0.2, color = "white", extinction = 0 },
{ value = 0.3, color = "yellow", extinction = 0 }, { value = 0.3, color = "red", extinction = 0.6 }"##
            }
        }
    }
}

/// Errors of a method over halved steps or mesh sizes.
#[derive(Debug, Clone, PartialEq)]
struct Series {
    /// The method's name, without its step.
    pub method: &'static str,
    pub kind: Kind,
    /// Steps in planet radii, or mean distances of neighbouring cells in radians.
    pub sizes: Vec<f64>,
    /// Root-mean-square error over all channels at each size, against the method's own limit.
    pub rmse: Vec<f64>,
    /// How far that limit is from the oracle, root-mean-square; `None` where the oracle is the limit.
    pub from_oracle: Option<f64>,
}

impl Series {
    /// Order from each size to the next.
    fn orders(&self) -> Vec<f64> {
        let pairs = self.rmse.windows(2).zip(self.sizes.windows(2));
        pairs.map(|(e, h)| (e[0] / e[1]).ln() / (h[0] / h[1]).ln()).collect()
    }
}

/// A smooth field in [-1, 1].
fn field(p: DVec3) -> f64 {
    (3.0 * p.x + 2.0 * p.z).sin() * (2.5 * p.y - 4.0 * (p.length() - 1.0)).cos()
}

fn scene(kind: Kind, size: u32) -> Result<Scene> {
    Scene::parse(&format!(
        "field = \"smooth\"\nprecision = \"f64\"\nantialias = false\nbackground = \"transparent\"\ncore = \"transparent\"\n[image]\nwidth = {size}\n\
         height = {size}\n[camera]\nlon = 25\nlat = 20\ndistance = 3.6\nfov = 42\n[transfer]\nunit_length = 0.15\nknots = [ {} ]",
        kind.knots()
    ))
}

/// Halves the step of each method.
fn in_step(sizes: &Sizes, renderer: &Renderer, kind: Kind) -> Result<Vec<Series>> {
    let sphere = Sphere::new(sizes.level, sizes.layers, [1.0, 1.3], field)?;
    let steps: Vec<f64> = (0..=sizes.halvings).map(|i| sizes.step / f64::from(1u32 << i)).collect();
    sphere.with_job(&scene(kind, sizes.pixels)?, |job| {
        let truth = oracle::picture(job, renderer)?;
        let of = |sampling: Sampling| {
            let picture = |step: f64| Ok(sampling.at(step).render(job, renderer)?.pixels);
            // Other interpolants than the wedge's have limits of their own.
            let is_wedge = matches!(sampling, Sampling::Uniform | Sampling::PreIntegrated { .. });
            let own = if is_wedge { None } else { Some(picture(steps[steps.len() - 1] / 8.0)?) };
            let error = |pixels: &[[f32; 4]]| match &own {
                Some(own) => Comparison::new(pixels, own).rmse,
                None => Comparison::new(pixels, &truth).rmse,
            };
            let errors = steps.iter().map(|h| Ok(error(&picture(*h)?))).collect::<Result<_>>()?;
            let from_oracle = own.as_ref().map(|own| Comparison::new(own, &truth).rmse);
            Ok(Series { method: sampling.name(), kind, sizes: steps.clone(), rmse: errors, from_oracle })
        };
        Sampling::all(sizes.table).into_iter().map(of).collect()
    })
}

/// Bisects mesh and layers: the error of each method, with small steps, against the oracle on the same mesh.
fn in_mesh(sizes: &Sizes, renderer: &Renderer, kind: Kind) -> Result<Vec<Series>> {
    let step = sizes.step / f64::from(1u32 << (sizes.halvings + 1));
    let sampled = [Sampling::Tetrahedra, Sampling::MeanValue, Sampling::Constant].map(|s| (s.name(), s.at(step)));
    let methods = [&[("paper", Method::Paper)], &sampled[..]].concat();
    let empty =
        |&(method, _): &(&'static str, Method)| Series { method, kind, sizes: vec![], rmse: vec![], from_oracle: None };
    let mut list: Vec<Series> = methods.iter().map(empty).collect();
    let scene = scene(kind, sizes.pixels)?;
    for level in 1..=sizes.levels {
        let sphere = Sphere::new(level, 1 + (1 << level), [1.0, 1.3], field)?;
        sphere.with_job(&scene, |job| {
            let truth = oracle::picture(job, renderer)?;
            for (series, (_, method)) in list.iter_mut().zip(&methods) {
                series.sizes.push(1.107 / f64::from(1u32 << level));
                series.rmse.push(Comparison::new(&method.render(job, renderer)?.pixels, &truth).rmse);
            }
            Ok(())
        })?;
    }
    Ok(list)
}

fn print(out: &mut dyn Write, list: &[Series]) -> Result<()> {
    for s in list {
        let numbers = |v: &[f64]| v.iter().map(|e| format!("{e:8.1e}")).collect::<Vec<_>>().join(" ");
        let orders = s.orders().iter().map(|o| format!("{o:5.2}")).collect::<Vec<_>>().join(" ");
        let limit = s.from_oracle.map_or(String::new(), |d| format!(", limit {d:.1e} from the oracle"));
        let kind = format!("{:?}", s.kind).to_lowercase();
        say!(out, "{kind:>6} {:>30}: {}  order {orders}{limit}", s.method, numbers(&s.rmse))?;
    }
    Ok(())
}

/// Measures and prints a line per method and transfer function.
pub fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    let renderer = Renderer::new(options.threads)?;
    say!(
        out,
        "RMSE over premultiplied channels; {} bisections, {} layers, steps from {} planet radii on, halved",
        SIZES.level,
        SIZES.layers,
        SIZES.step
    )?;
    const IN_MESH: [Kind; 2] = [Kind::Smooth, Kind::Kinks];
    let bar = progress(Kind::ALL.len() + IN_MESH.len(), "orders");
    bar.set_message("steps");
    for kind in Kind::ALL {
        let list = in_step(&SIZES, &renderer, kind)?;
        bar.suspend(|| print(out, &list))?;
        bar.inc(1);
    }
    bar.set_message("meshes");
    let levels = SIZES.levels;
    bar.suspend(|| say!(out, "against the oracle on the same mesh, 1 to {levels} bisections"))?;
    for kind in IN_MESH {
        let list = in_mesh(&SIZES, &renderer, kind)?;
        bar.suspend(|| print(out, &list))?;
        bar.inc(1);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: Sizes = Sizes { level: 2, layers: 5, pixels: 24, halvings: 3, table: 512, ..SIZES };

    /// The least and greatest order of the series.
    fn range(series: &Series) -> [f64; 2] {
        let orders = series.orders();
        [orders.iter().fold(f64::INFINITY, |m, o| m.min(*o)), orders.iter().fold(0.0, |m, o| m.max(*o))]
    }

    #[test]
    fn no_order_in_the_step_is_lost() {
        for (kind, second) in [(Kind::Smooth, 2.0), (Kind::Kinks, 2.0), (Kind::Steps, 1.0)] {
            for series in in_step(&SMALL, &Renderer::new(0).unwrap(), kind).unwrap() {
                let expected =
                    if ["constant", "pre-integrated, no attenuation"].contains(&series.method) { 1.0 } else { second };
                let [low, high] = range(&series);
                println!("{kind:?} {}: {low:.2} to {high:.2}", series.method);
                let slack = if expected > 1.5 { 0.25 } else { 0.35 };
                assert!(low > expected - slack && high < expected + 2.0 * slack, "{series:?}");
            }
        }
    }

    #[test]
    fn no_order_in_the_mesh_is_lost() {
        for series in in_mesh(&SMALL, &Renderer::new(0).unwrap(), Kind::Smooth).unwrap() {
            let expected = if series.method == "constant" { 1.0 } else { 2.0 };
            let last = *series.orders().last().unwrap();
            println!("{}: {:?}", series.method, series.orders());
            assert!(last > expected - 0.2 && last < expected + 0.7, "{series:?}");
        }
    }
}
