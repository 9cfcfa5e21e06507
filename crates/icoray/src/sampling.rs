//! Several rays per pixel, where a scene asks for them ([`Scene::samples`](icoray_scene::Scene::samples)).
//!
//! The picture of one ray through each pixel's middle is drawn first; that ray is the first sample of its pixel. Rounds
//! of more samples follow, up to 4, 8, 16, 32 and 64 rays in all: the first of all pixels that may show the shell, the
//! others of those whose estimated error is above the tolerance. Rank 0 decides which these are from the whole picture.
//! So the samples of a pixel depend on the picture alone: not on tiles, threads or ranks.
//!
//! A pixel shows the mean v̄ of its n rays. Its sampling error, the distance from the mean over the pixel's area, is
//! estimated as
//!
//! ```text
//! t · sqrt(Σ |vᵢ - v̄ - s·(pᵢ - p̄)|² / (n (n - 1))) + |s·p̄|
//! ```
//!
//! in each channel: pᵢ are the places of the samples from the pixel's middle, s is the slope of the picture at the
//! pixel, and t is Student's factor of 95 %. Light that is linear over a pixel has a mean that samples around the middle
//! find, so that only what the slope leaves counts as noise; the last term is what p̄ is off the middle.

mod moments;
mod pattern;
mod picture;
mod round;

pub(crate) use moments::Moments;
pub(crate) use picture::SampledPicture;
pub(crate) use round::SampleRound;

/// Rays of a pixel in all, after each round of a picture with at most `samples` rays per pixel, and with `edges` at
/// least so many of pixels at edges.
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
        // Pixels at edges take more than others.
        assert_eq!(rounds(2, 8), [2, 4, 8]);
        assert_eq!(rounds(6, 8), [4, 6, 8]);
        assert_eq!(rounds(11, 8), [4, 8, 11]);
    }
}
