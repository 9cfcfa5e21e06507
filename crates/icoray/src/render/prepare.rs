//! What is known and made of a field before the first ray.

use super::Setting;
use super::derived::Derived;
use super::spare::{LightKey, SightKey};
use super::work::asked;
use crate::error::Result;
use crate::gradient::{self, Gradients, Wanted};
use crate::kernel::Real;
use crate::kernel::leap::Visible;
use crate::kernel::sample::{Sample, Samples};
use crate::kernel::transfer::Spans;
use crate::plan::{Sight, clear_values};
use crate::quality::{Deadline, Lights, Quality};
use crate::ranks::{Part, Ranks};
use crate::scene::Precision;

/// What is known of a field.
pub(super) struct Known {
    pub value_range: Option<[f64; 2]>,
    pub missing_values: u64,
    /// The scene's, or without light where there is no time for gradients.
    pub quality: Quality,
    pub deadline: Option<Deadline>,
}

impl Known {
    /// Of the setting's field. Collective.
    pub fn of<S: Sample>(setting: &Setting, ranks: &mut Ranks, samples: &Samples<S>) -> Result<Self> {
        let Setting { renderer, scene, plan, grid, part, field, start, .. } = *setting;
        let range = ranks.attempt(|| {
            renderer.run(|| {
                Ok(match part {
                    Some(part) => field.range_over(Some(&|cell| part.tells(cell))),
                    None => renderer.spare.range(&setting.source, || field.range()),
                })
            })
        });
        let mut range = ranks.together(range)?;
        if part.is_some() {
            range = Part::whole_range(ranks, range)?;
        }
        let (value_range, missing_values) = range;
        // Ranks with a part together share out the rays through it; those with other parts trace the same ones.
        let sharers = part.map_or(ranks.size(), |part| part.mates().len());
        let deadline = Deadline::of(scene, start, sharers);
        let mut quality = asked(scene);
        if let (Some(deadline), true) = (deadline, plan.shading.is_some()) {
            let some = || {
                let (cells, wanted) = (0..grid.cells().div_ceil(64), Wanted { visible: None, packed: false });
                drop(gradient::gradients(grid, &plan.radius, samples, cells, wanted, Gradients::none()));
            };
            let has_time = || !setting.needs_gradients() || deadline.has_time_for_gradients(1.0 / 64.0, some);
            let is_root = ranks.is_root();
            let has_time = ranks.attempt(|| renderer.run(|| Ok(!is_root || has_time())));
            let mine = has_time.map(|has_time| match has_time {
                true => quality,
                false => Quality { lights: Lights::Off, ..quality },
            });
            quality = ranks.agree_on_quality(mine)?;
        }
        Ok(Known { value_range, missing_values, quality, deadline })
    }

    pub fn is_lit(&self) -> bool {
        self.quality.lights != Lights::Off
    }
}

/// What can be seen of the field, and what it is known by.
pub(super) fn sight<'f, T: Real, S: Sample>(
    setting: &'f Setting,
    known: &Known,
    spans: &Spans<T>,
    samples: Samples<'f, S>,
) -> (SightKey, Derived<'f, Visible>) {
    let Setting { renderer, plan, grid, .. } = *setting;
    let leaps = renderer.savings.leaps;
    let clear = if leaps { clear_values(spans, &samples, known.value_range) } else { Vec::new() };
    let bits = clear.iter().map(|range| range.map(|value| value.wide().to_bits()));
    let key = SightKey { source: setting.source.clone(), falling: plan.falling, clear: bits.collect() };
    let sight = Sight { grid, samples, layers: plan.radius.len(), clear };
    let asked = key.clone();
    (key, Derived::of(move || renderer.spare.visible(&asked, |memory| sight.visible(memory))))
}

/// The gradients that light asks for, and what they are known by; `None` without light.
///
/// Other ranks are given those of halo cells, and what a device leaves may be anywhere: there they are whole, and all of them.
pub(super) fn gradients<'f, S: Sample>(
    setting: &'f Setting,
    known: &Known,
    samples: Samples<'f, S>,
    range: [f64; 2],
    (sight, visible): (&SightKey, &'f Derived<Visible>),
) -> (Option<LightKey>, Derived<'f, Gradients>) {
    let Setting { renderer, plan, grid, part, .. } = *setting;
    let is_own = setting.device.is_err() && part.is_none();
    let savings = renderer.savings;
    let packed = is_own && savings.packing && has_room_for_packing(setting);
    let visible = (is_own && savings.gradients).then_some(visible);
    let key = LightKey {
        source: setting.source.clone(),
        falling: plan.falling,
        range,
        radius: plan.radius.clone(),
        packed,
        sight: visible.map(|_| sight.clone()),
        heights: None,
    };
    if !known.is_lit() {
        return (None, Derived::of(Gradients::none));
    }
    let asked = key.clone();
    let compute = move || {
        let wanted = Wanted { visible: visible.map(Derived::get), packed };
        let all = |memory| gradient::gradients(grid, &plan.radius, &samples, 0..grid.cells(), wanted, memory);
        renderer.spare.gradients(&asked, all)
    };
    (Some(key), Derived::of(compute))
}

/// Whether the scene's tolerance is far above what packing does to light: it turns normals by 1e-5.
fn has_room_for_packing(setting: &Setting) -> bool {
    const TURN: f64 = 1e-5;
    let off =
        setting.plan.shading.map_or(0.0, |s| TURN * (s.diffuse + s.specular * s.shininess.max(1.0).sqrt()));
    setting.scene.precision == Precision::F32 && off <= 0.05 * setting.scene.tolerance
}

/// Makes ready what is asked for anyway, and completes gradients by those of other ranks. Collective.
pub(super) fn complete(
    setting: &Setting,
    ranks: &mut Ranks,
    visible: &Derived<Visible>,
    gradients: &mut Derived<Gradients>,
    is_lit: bool,
) -> Result<()> {
    let computed = ranks.attempt(|| {
        setting.renderer.run(|| {
            if setting.device.is_err() {
                visible.get();
            }
            if setting.needs_gradients() {
                gradients.get();
            }
            Ok(())
        })
    });
    ranks.together(computed)?;
    if let (Some(part), true) = (setting.part, is_lit) {
        let layers = setting.plan.radius.len();
        let all = gradients.get_mut().whole_mut();
        part.fill_halo(ranks, all, |all, cell| &mut all[cell as usize * layers..][..layers])?;
    }
    Ok(())
}
