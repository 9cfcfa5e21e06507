//! Several rays per pixel, if a scene requests them ([`Scene::samples`](icoray_scene::Scene::samples)).
//!
//! The picture of one ray through each pixel's middle is drawn first; that ray is the first sample of its pixel. Rounds
//! of more samples follow, up to 4, 8, 16, 32 and 64 rays in all: the first for all pixels that may show the shell, the
//! others for those whose estimated error is above the tolerance. Rank 0 selects these from the whole picture. So the
//! samples of a pixel depend on the picture alone: not on tiles, threads or ranks.
//!
//! A pixel shows, in each channel,
//!
//! ```text
//! cₙ = Σ wᵢ (vᵢ - s·pᵢ) / Σ wᵢ
//! ```
//!
//! where vᵢ is the light of its n rays at the places pᵢ from its middle, and s the slope of the picture of one ray per
//! pixel: light that is linear over a pixel has its exact mean for any number of rays. The weights wᵢ are 1; with fewer
//! than 4 samples that of the middle is 2, as the few others are not spread evenly around it.
//!
//! Its sampling error, the distance from the mean over the pixel's area, is estimated from the change |cₙ - cₘ| by the
//! last round, scaled to the deviation of cₙ for rays that differ by chance: it is 2.5 times the root mean square of
//! the changes of the pixel and its eight neighbours. For smooth light, means of more and more even samples change by
//! more than their error.

mod pattern;
mod picture;

pub(crate) use pattern::Pattern;
pub(crate) use picture::{Sampled, SampledPicture, may_show_shell};

/// Numbers of rays of a pixel after each round of a picture with at most `samples` rays per pixel, and at least `edges`
/// for pixels at edges.
pub(crate) fn rounds(samples: u32, edges: u32) -> Vec<u32> {
    let most = samples.max(edges);
    let mut ends: Vec<u32> = (2..).map(|power| 1 << power).take_while(|end| *end < most).collect();
    ends.extend([samples, most]);
    ends.sort_unstable();
    ends.dedup();
    ends
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_double_the_rays_up_to_the_most() {
        assert_eq!(rounds(2, 0), [2]);
        assert_eq!(rounds(4, 0), [4]);
        assert_eq!(rounds(16, 8), [4, 8, 16]);
        assert_eq!(rounds(64, 0), [4, 8, 16, 32, 64]);
        // Pixels at edges take more rays than others.
        assert_eq!(rounds(2, 8), [2, 4, 8]);
        assert_eq!(rounds(6, 8), [4, 6, 8]);
        assert_eq!(rounds(11, 8), [4, 8, 11]);
    }
}
