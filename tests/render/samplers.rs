//! Ways to spread random numbers against each other: the same picture, by other samples.

use crate::common::{assert_same_means, means_over_seeds};
use crate::resume::scene;
use raymini::scene::{AmbientOcclusion, Choice, Mode, SamplerChoice};

/// A ball of glass in direct light, with several shadow and occlusion rays to a sample, and in all light: the means of 48 pixels over 200
/// seeds, α = 0.001 over both.
#[test]
fn independent_samples_lead_to_the_same_picture() {
    for mode in [Mode::Direct, Mode::Path] {
        let mut scene = scene();
        scene.render.mode = mode;
        scene.render.shadow_samples = 3;
        scene.render.ambient_occlusion = AmbientOcclusion {
            enabled: true,
            samples: 6,
            radius: 0.2,
        };
        scene.camera.aperture_radius = 0.1;
        [scene.render.width, scene.render.height] = [8, 6];
        scene.render.samples_per_pixel = 8;
        let means = SamplerChoice::ALL.iter().map(|&(sampler, _)| {
            scene.render.sampler = sampler;
            let first = 1000 * (sampler as u64);
            means_over_seeds(&scene, first..first + 200)
        });
        let means: Vec<_> = means.collect();
        assert_ne!(means[0], means[1], "{mode:?}: by other samples");
        assert_same_means(&means[0], &means[1], &format!("{mode:?}"));
    }
}
