//! Time budgets: picks the quality of a frame from measured costs.

use crate::raster::Raster;
use icoray_scene::{Lights, Quality, Scene};
use std::time::Instant;

/// Maximum tolerance that a budget may choose.
const LOOSEST: f64 = 1e-2;
/// Approximate number of pixels that are traced to measure the cost of a frame.
const PROBE: f64 = 400.0;
/// Maximum fraction of the time left for one more measurement on a device.
const DEVICE_PROBE: f64 = 0.1;
/// Ratio of the time left to the estimated time from which a better quality is tried.
const TO_SPARE: f64 = 1.2;
/// Planned fraction of the time left, since a probe is not exact.
const MARGIN: f64 = 0.8;
/// Maximum fraction of a budget for gradients before light is left out.
const GRADIENTS: f64 = 0.5;

/// Time that a frame may take, counted from its start.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Deadline {
    start: Instant,
    seconds: f64,
    /// The largest step between traced pixels.
    largest_step: u32,
    /// Number of ranks that divide the rays.
    ranks: f64,
}

impl Deadline {
    /// The deadline of the scene, if it has one, for a frame that `ranks` ranks draw.
    pub fn of(scene: &Scene, start: Instant, ranks: usize) -> Option<Self> {
        let Scene { time_budget_ms, largest_step, .. } = *scene;
        time_budget_ms.map(|ms| Deadline { start, seconds: ms / 1000.0, largest_step, ranks: ranks as f64 })
    }

    /// Seconds left for planning.
    fn left(&self) -> f64 {
        MARGIN * (self.seconds - self.start.elapsed().as_secs_f64()).max(0.0)
    }

    /// Whether there is time for something that takes `seconds` seconds.
    pub fn has_time_for(&self, seconds: f64) -> bool {
        seconds <= self.left()
    }

    /// Whether there is time for gradients; `sample` computes the fraction `part` of them to measure their cost.
    pub fn has_time_for_gradients(&self, part: f64, sample: impl FnOnce()) -> bool {
        let start = Instant::now();
        sample();
        start.elapsed().as_secs_f64() / part <= GRADIENTS * self.left()
    }

    /// The best quality that keeps the deadline; `trace` traces a raster in a quality, on a device or on the CPU, on a
    /// number of coarser levels.
    pub fn pick(
        &self,
        asked: Quality,
        raster: Raster,
        (on_device, levels): (bool, u32),
        mut trace: impl FnMut(&Quality, Raster),
    ) -> Quality {
        let best = choose(asked, raster, self.left(), (self.ranks, levels), |quality, left| {
            let seconds = |raster: Raster| {
                let start = Instant::now();
                trace(quality, raster);
                start.elapsed().as_secs_f64()
            };
            if on_device { Cost::on_device(raster, left, seconds) } else { Cost::on_cpu(raster, seconds) }
        });
        Quality { pixel_step: best.pixel_step.min(self.largest_step), ..best }
    }
}

/// The measured cost of a picture in one quality.
#[derive(Debug, Clone, Copy)]
struct Cost {
    /// Seconds of the measurement.
    spent: f64,
    /// Seconds independent of the number of pixels.
    fixed: f64,
    /// Additional seconds for tracing all pixels.
    pixels: f64,
}

impl Cost {
    /// Measures some pixels, each of which takes its time.
    fn on_cpu(raster: Raster, mut seconds: impl FnMut(Raster) -> f64) -> Self {
        let probe = probe(raster);
        let spent = seconds(probe);
        Cost { spent, fixed: 0.0, pixels: spent / probe.part() }
    }

    /// Measures more and more pixels, while `left` seconds permit it: on a device that is not fully used, more pixels
    /// take almost no more time.
    fn on_device(raster: Raster, left: f64, mut seconds: impl FnMut(Raster) -> f64) -> Self {
        let mut last = Raster { step: probe(raster).step.next_power_of_two(), ..raster };
        let mut took = seconds(last);
        let mut cost = Cost { spent: took, fixed: 0.0, pixels: took / last.part() };
        while last.step > 2 {
            let finer = Raster { step: last.step / 2, ..raster };
            if took * finer.part() / last.part() > DEVICE_PROBE * (left - cost.spent) {
                break;
            }
            let before = std::mem::replace(&mut took, seconds(finer));
            // It may be fully used only now, so that more pixels take longer than these did; at most in proportion.
            let most = took / finer.part();
            let slope = ((took - before) / (finer.part() - last.part())).clamp(0.0, most);
            cost.spent += took;
            cost.pixels = 0.5 * (slope + most);
            cost.fixed = took - cost.pixels * finer.part();
            last = finer;
        }
        cost
    }

    /// Seconds if `ranks` ranks trace a fraction `part` of the pixels.
    fn of(&self, part: f64, ranks: f64) -> f64 {
        self.fixed + self.pixels * part / ranks
    }
}

/// The raster of some [`PROBE`] pixels.
pub(crate) fn probe(raster: Raster) -> Raster {
    let pixels = f64::from(raster.width) * f64::from(raster.height);
    Raster { step: ((pixels / PROBE).sqrt() as u32).clamp(1, Quality::LARGEST_STEP), ..raster }
}

/// The best quality that takes at most `left` seconds if `ranks` share the rays: first the tolerance is increased, then
/// light is made coarse, then coarser levels are traced, then pixels are left out. `measure` returns the cost of a
/// quality, given the time left.
///
/// Costs are measured from the cheapest quality upwards, each only if there is time to spare for it: probing a much too
/// expensive quality would itself take too much time.
fn choose(
    asked: Quality,
    raster: Raster,
    mut left: f64,
    (ranks, levels): (f64, u32),
    mut measure: impl FnMut(&Quality, f64) -> Cost,
) -> Quality {
    let loose = Quality { tolerance: asked.tolerance.max(LOOSEST), ..asked };
    let coarse = Quality { lights: asked.lights.min(Lights::Coarse), ..loose };
    let mut best = coarse;
    let mut cost = measure(&best, left);
    left -= cost.spent;
    while cost.of(1.0, ranks) > left && best.level < levels {
        best.level += 1;
        cost = measure(&best, left);
        left -= cost.spent;
    }
    if best.level > 0 && cost.of(1.0, ranks) <= left {
        return best;
    }
    if cost.of(1.0, ranks) > left {
        let fits = |step: &u32| cost.of(Raster { step: *step, ..raster }.part(), ranks) <= left;
        return Quality { pixel_step: (2..Quality::LARGEST_STEP).find(fits).unwrap_or(Quality::LARGEST_STEP), ..best };
    }
    for better in [loose, asked] {
        if better == best {
            continue;
        }
        if cost.of(1.0, ranks) * TO_SPARE > left {
            break;
        }
        cost = measure(&better, left);
        left -= cost.spent;
        if cost.of(1.0, ranks) > left {
            break;
        }
        best = better;
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    const RASTER: Raster = Raster { width: 512, height: 512, step: 1 };

    /// The quality chosen for `ms` where each traced pixel takes `us` microseconds, less what the quality saves.
    fn pick_for(ms: f64, us: f64, ranks: f64) -> Quality {
        let asked = Quality { tolerance: 1e-5, lights: Lights::Full, ..Quality::default() };
        choose(asked, RASTER, ms / 1000.0, (ranks, 0), |quality, _| {
            let saved = if quality.tolerance > 1e-4 { 0.5 } else { 1.0 };
            let saved = if quality.lights == Lights::Full { saved } else { 0.5 * saved };
            Cost::on_cpu(RASTER, |raster| 1e-6 * us * saved * raster.part() * f64::from(raster.width * raster.height))
        })
    }

    #[test]
    fn quality_goes_down_with_the_budget_tolerance_first_pixels_last() {
        let whole = 512.0 * 512.0 / 1000.0 * 2.0;
        let pick = |part: f64| {
            let Quality { pixel_step, tolerance, lights, .. } = pick_for(part * whole, 2.0, 1.0);
            (pixel_step, tolerance, lights)
        };
        assert_eq!(pick(2.0), (1, 1e-5, Lights::Full));
        assert_eq!(pick(0.9), (1, 1e-2, Lights::Full));
        assert_eq!(pick(0.5), (1, 1e-2, Lights::Coarse));
        assert_eq!(pick_for(0.5 * whole, 2.0, 4.0).tolerance, 1e-5, "ranks share the rays");
        let (step, _, lights) = pick(0.15);
        assert!(step > 1 && step < 6 && lights == Lights::Coarse, "{step} {lights:?}");
        assert_eq!(pick_for(1e-3, 2.0, 1.0).pixel_step, Quality::LARGEST_STEP);
    }

    /// Each level takes half of the time of the one below.
    #[test]
    fn levels_are_traced_before_pixels_are_left_out() {
        let pick = |ms: f64, levels| {
            let rays = |raster: Raster| raster.part() * f64::from(raster.width * raster.height);
            choose(Quality::default(), RASTER, ms / 1000.0, (1.0, levels), |quality, _| {
                Cost::on_cpu(RASTER, |raster| 1e-6 * 0.5f64.powi(quality.level as i32) * rays(raster))
            })
        };
        let whole = 512.0 * 512.0 / 1000.0;
        for (part, levels, wanted) in [(1.2, 2, (0, 1)), (0.6, 2, (1, 1)), (0.3, 2, (2, 1)), (0.3, 0, (0, 2))] {
            let Quality { level, pixel_step, .. } = pick(part * whole, levels);
            assert_eq!((level, pixel_step), wanted, "{part} of the time, {levels} levels");
        }
        let least = pick(0.05 * whole, 2);
        assert!(least.level == 2 && least.pixel_step > 1, "{least:?}");
    }

    #[test]
    fn a_raster_is_no_coarser_than_the_scene_allows() {
        let deadline = Deadline { start: Instant::now(), seconds: 0.0, largest_step: 5, ranks: 1.0 };
        let asked = Quality { tolerance: 1e-5, lights: Lights::Full, ..Quality::default() };
        // The clock has moved on when a probe ends.
        let takes_time = |_: &Quality, _: Raster| {
            let start = Instant::now();
            while start.elapsed().is_zero() {}
        };
        let raster = Raster { width: 640, height: 480, step: 1 };
        assert_eq!(deadline.pick(asked, raster, (false, 0), takes_time).pixel_step, 5);
    }

    /// A device that is full at 50,000 rays, up to which it takes 2 ms.
    #[test]
    fn a_device_is_measured_until_it_is_full() {
        let seconds = |raster: Raster| {
            let rays = raster.part() * f64::from(RASTER.width * RASTER.height);
            2e-3 * (rays / 5e4).max(1.0)
        };
        let whole = seconds(RASTER);
        let cost = Cost::on_device(RASTER, 1.0, seconds);
        let found = cost.of(1.0, 1.0);
        assert!((0.7..=1.05).contains(&(found / whole)), "{found} of {whole}: {cost:?}");
        assert!(cost.spent < 0.015, "{cost:?}");
        // No time to measure more than once.
        let cost = Cost::on_device(RASTER, 0.01, seconds);
        assert!(cost.spent == 2e-3 && cost.of(1.0, 1.0) > whole, "{cost:?}");
        // One that takes its time for each ray, as a processor does.
        let cost = Cost::on_device(RASTER, 1.0, |raster| 2.0 * raster.part());
        assert!((cost.of(1.0, 1.0) - 2.0).abs() < 1e-9 && cost.spent < 0.2, "{cost:?}");
        assert!((cost.of(0.5, 4.0) - 0.25).abs() < 1e-9, "{cost:?}");
    }
}
