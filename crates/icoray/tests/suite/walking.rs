//! A renderer that only walks and interpolates, for measurements of these steps.

use crate::common::{at_centers, icosahedral};
use icoray::{Layers, Renderer, Scene};

#[test]
fn without_integrals_rays_meet_all_frusta_and_bring_no_light() {
    let (_, grid) = icosahedral(3);
    let layers = Layers::new((0..9).map(|l| 1.0 + 0.02 * f64::from(l)).collect(), 1.0).unwrap();
    let values: Vec<f32> = (0..grid.cells() * 9).map(|i| (i % 9) as f32 + (i % 7) as f32).collect();
    let field = at_centers(&values, 9);
    let scene = |opacity: f64| {
        let text = format!(
            "field = \"f\"\nantialias = false\ncore = \"transparent\"\nbackground = \"transparent\"\n[image]\nwidth = 32\nheight = 24\n[camera]\nlon = 10\nlat = 40\ndistance = 3\n[transfer]\n\
             map = \"viridis\"\nrange = [0, 16]\nopacity = [[0, {opacity}], [16, {opacity}]]"
        );
        Scene::parse(&text).unwrap()
    };
    let draw = |renderer: &Renderer, opacity| renderer.render(&scene(opacity), &grid, &layers, &field).unwrap();
    let [whole, walking] = [Renderer::new(2).unwrap(), Renderer::new(2).unwrap().without_integrals()];
    let (all, ended) = (draw(&whole, 0.01), draw(&whole, 0.999_999_9));
    assert!(ended.report.counts.frusta < all.report.counts.frusta);
    let walked = draw(&walking, 0.999_999_9);
    assert_eq!(walked.report.counts, all.report.counts);
    assert!(walked.pixels.iter().all(|pixel| *pixel == [0.0; 4]) && ended.pixels.iter().any(|p| p[3] > 0.9));
}
