//! Random scenes of all kinds, every pixel against the oracle.

use crate::results::say;
use icoray::{Error, ErrorKind, Precision, Renderer, Result};
use icoray_reference::comparison::median;
use icoray_reference::random::{Checked, KINDS, RandomScene, check};
use std::io::Write;

/// Checks the scenes of the seeds from `seed` on; prints those with pixels beyond their error, and a line for each
/// kind, light and precision.
///
/// # Errors
/// [`ErrorKind::Internal`] where the error of a pixel is above the reported one.
pub(super) fn run(count: u64, seed: u64, renderer: &Renderer, all: &Renderer, out: &mut dyn Write) -> Result<()> {
    let mut groups = vec![Checked::default(); 4 * KINDS.len()];
    for seed in seed..seed + count {
        let drawn = RandomScene::new(seed)?;
        let checked = check(&drawn, renderer, all)?;
        checked.failures.iter().try_for_each(|failure| say!(out, "{failure}"))?;
        let kind = KINDS.iter().position(|kind| *kind == drawn.kind).expect("the kinds are those of the list");
        let is_lit = usize::from(drawn.scene.lighting.is_some());
        let is_double = usize::from(drawn.scene.precision == Precision::F64);
        groups[4 * kind + 2 * is_lit + is_double].add(checked);
    }
    say!(
        out,
        "kind              light       scenes    pixels  beyond  undecided true/reported reported/true  seconds"
    )?;
    let mut sum = Checked::default();
    for (i, group) in groups.into_iter().enumerate().filter(|(_, group)| group.scenes > 0) {
        say!(
            out,
            "{:<17} {:<6} {:<4} {:>6} {:>9} {:>7} {:>10} {:>13.2} {:>13.1} {:>8.2}",
            KINDS[i / 4],
            ["unlit", "lit"][i / 2 % 2],
            ["f32", "f64"][i % 2],
            group.scenes,
            group.pixels,
            group.beyond,
            group.undecided,
            group.worst,
            median(group.ratios.clone()),
            group.seconds
        )?;
        sum.add(group);
    }
    let Checked { pixels, beyond, undecided, .. } = sum;
    let found = format!("{beyond} of {pixels} pixels have errors above the reported ones, {undecided} are undecided");
    say!(out, "{count} scenes: {found}")?;
    if beyond > 0 { Err(Error::new(ErrorKind::Internal, found)) } else { Ok(()) }
}
