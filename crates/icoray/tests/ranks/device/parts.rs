//! Fragments of which a device traces some tiles: the CPU traces all tiles that it does not return.

use super::{Manner, Painter, assert_left, count_painted, painted, renderer_with, scene, world};
use crate::common::{on_ranks, picture};
use icoray::device::{
    Band, BoundarySignature, Device, DeviceCost, FallbackReason, Fragment, Fragments, Job, OwnedColumns, RayFragments,
    Rect, Traced, TracedFragment,
};
use icoray::{Frame, FrameReport};
use std::sync::Arc;

/// A [`Painter`] who knows parts of grids too: one fragment for each ray, in front of all else.
#[derive(Debug)]
struct PartPainter(Manner);

impl Device for PartPainter {
    fn name(&self) -> String {
        "part painter".into()
    }

    fn trace(&self, _: &Job, _: &(dyn Fn(Band) + Sync)) -> Result<DeviceCost, FallbackReason> {
        Err(FallbackReason::new("there is no whole"))
    }

    fn fragments(
        &self,
        job: &Job,
        own: &OwnedColumns,
        give: &(dyn Fn(Fragments) + Sync),
    ) -> Result<DeviceCost, FallbackReason> {
        let owned = (0..job.grid().triangles()).filter(|triangle| own.triangles.has(*triangle)).count();
        assert!(job.is_part() && (1..job.grid().triangles()).contains(&owned), "{owned}");
        assert!(own.lowest_facet < 1.0 && own.lowest_facet > 0.9 && own.reach > 1.0);
        let tiles: Vec<Rect> = job.tiles().collect();
        let all = |tiles: &[Rect]| {
            let rays: Vec<Traced> = tiles.iter().flat_map(|tile| painted(job, *tile)).collect();
            let passed = rays.iter().map(|ray| RayFragments { counts: ray.counts, fragments: 1 });
            let fragment = |ray: &Traced| {
                let Traced { color, alpha: absorbed, error, variance, .. } = *ray;
                let fragment = Fragment {
                    t: [-1e3, f64::INFINITY],
                    color,
                    alpha: absorbed,
                    error,
                    variance,
                    surfaces: BoundarySignature::default(),
                };
                TracedFragment { fragment, painted: None }
            };
            (passed.collect::<Vec<_>>(), rays.iter().map(fragment).collect::<Vec<_>>())
        };
        let band = |first: usize, end: usize| {
            let (rays, all) = all(&tiles[first..end]);
            give(Fragments { first, rays: &rays, all: &all });
        };
        let torn = || {
            let (rays, all) = all(&tiles[..2]);
            give(Fragments { first: 0, rays: &rays, all: &all[1..] });
        };
        self.0.give(tiles.len(), band, torn)?;
        Ok(DeviceCost { device_s: Some(0.25), ..DeviceCost::default() })
    }
}

/// One of two ranks has a device.
#[test]
fn fragments_of_a_device_are_sent_and_the_cpu_traces_the_rest() {
    let world = world();
    let scene = scene("ranks = \"fragments\"");
    let draw = |device: Option<Arc<dyn Device>>| -> (Frame, FrameReport) {
        let (frame, mut reports) = picture(on_ranks(2, |ranks| {
            let renderer = renderer_with(device.clone().filter(|_| ranks.rank() == 1));
            world.draw_over(&renderer, &scene, ranks).unwrap()
        }));
        (frame, reports.remove(1))
    };
    let (alone, _) = draw(None);
    let met = alone.report.counts.rays as usize;
    assert_eq!(count_painted(&alone, &alone), 0);
    let (frame, report) = draw(Some(Painter::new(Manner::All)));
    assert!(frame.pixels == alone.pixels && report.device.name.is_none());
    assert!(report.device.left_to_cpu.unwrap().contains("painter does not trace rays through parts"));
    for (manner, painted, word) in [
        (Manner::All, met..=met, None),
        (Manner::Backwards, met..=met, None),
        (Manner::Twice, met..=met, None),
        (Manner::Some, met / 5..=met / 2, Some("used up")),
        (Manner::Panic, 0..=met / 4, Some("part painter: internal error: the brush is broken")),
        (Manner::Torn, 0..=0, Some("part painter: internal error")),
    ] {
        let (frame, report) = draw(Some(Arc::new(PartPainter(manner))));
        let count = count_painted(&frame, &alone);
        println!("{manner:?}: {count} of {met}");
        assert!(painted.contains(&count), "{manner:?}: {count} pixels of {met}");
        assert_eq!(report.device.name.is_some(), manner != Manner::Torn, "{manner:?}");
        assert_left(&report.device, word, &format!("{manner:?}"));
        assert_eq!(frame.report.device.left_to_cpu, None);
    }
}
