//! Random scenes on levels of detail: every pixel against the model's grid.

use crate::results::say;
use icoray::{Error, ErrorKind, Renderer, Result};
use icoray_reference::comparison::median;
use icoray_reference::random::{Checked, RandomScene, check_levels};
use std::io::Write;

/// Levels of the finest mesh, of 10,242 cells.
const LEVELS: u32 = 2;

/// Checks the scenes of the seeds from `seed` on, on each level of their grids; prints those with pixels beyond their
/// error, and a line for each level.
///
/// # Errors
/// [`ErrorKind::Internal`] where a pixel is farther from that of the model's grid than it reports.
pub(super) fn run(count: u64, seed: u64, threads: usize, out: &mut dyn Write) -> Result<()> {
    let finest = Renderer::new(threads)?;
    let levels = (1..=LEVELS).map(|level| Ok(Renderer::new(threads)?.on_level(level))).collect::<Result<Vec<_>>>()?;
    let mut groups = vec![Checked::default(); levels.len()];
    for seed in seed..seed + count {
        for (group, checked) in groups.iter_mut().zip(check_levels(&RandomScene::with_levels(seed)?, &finest, &levels)?)
        {
            checked.failures.iter().try_for_each(|failure| say!(out, "{failure}"))?;
            group.add(checked);
        }
    }
    say!(out, "level  scenes    pixels  beyond    known true/reported reported/true")?;
    let mut sum = Checked::default();
    for (number, group) in (1..).zip(groups) {
        let Checked { scenes, pixels, beyond, worst, ratios, .. } = &group;
        let (known, ratio) = (ratios.len(), median(ratios.clone()));
        say!(out, "{number:>5} {scenes:>7} {pixels:>9} {beyond:>7} {known:>8} {worst:>13.3} {ratio:>13.1}")?;
        sum.add(group);
    }
    let found = format!("{} of {} pixels have errors above the reported ones", sum.beyond, sum.pixels);
    say!(out, "{count} scenes: {found}")?;
    if sum.beyond > 0 { Err(Error::new(ErrorKind::Internal, found)) } else { Ok(()) }
}
