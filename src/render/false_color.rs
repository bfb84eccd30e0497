//! Pictures of what the renderer sees instead of light: the first tool when a picture looks wrong.

use super::ambient_occlusion::ambient_occlusion;
use super::camera::CameraRay;
use super::camera_samples::CameraSample;
use super::kernel::Kernel;
use super::material::PreparedMaterial;
use super::phong::Phong;
use super::prepare::PreparedScene;
use super::sampler::{Decision, Dimension};
use super::stops::Stops;
use super::texturing::Texturing;
use crate::math::Vec3;
use std::borrow::Borrow;

/// Which property of the surface a pixel shows.
#[derive(Clone, Copy, Debug)]
pub enum FalseColor {
    AmbientOcclusion,
    Normals,
    Depth,
    Albedo,
    Facing,
    Object,
    Steps,
}

/// The property of the first surface along `camera_ray`; black where there is none, and of no use when stopped.
pub fn color<K: Kernel>(
    scene: &PreparedScene,
    which: FalseColor,
    camera_ray: &CameraRay,
    &CameraSample { sampler, hit, .. }: &CameraSample,
    stops: &Stops<'_>,
    tally: &mut K::Tally,
) -> Vec3 {
    if let FalseColor::Steps = which {
        let visits = scene
            .accelerator()
            .visits(&camera_ray.ray, f32::INFINITY, false);
        return steps_color(visits.nodes + visits.blocks);
    }
    let Some(hit) = hit else {
        return Vec3::ZERO;
    };
    let mut point = scene.surface(&camera_ray.ray, &hit);
    let material = scene.material(point.object);
    let albedo = if let PreparedMaterial::Phong(phong) = material {
        let texturing = K::Texturing::from_eye(scene, camera_ray);
        let phong = texturing.at(scene, phong, &mut point, Some(&hit));
        Borrow::<Phong>::borrow(&phong).albedo()
    } else {
        material.albedo()
    };
    match which {
        FalseColor::AmbientOcclusion => {
            let samples = scene.settings().ambient_occlusion.samples;
            let turns = sampler.turns(Dimension::once(Decision::AmbientOcclusion), samples);
            Vec3::splat(ambient_occlusion(scene, &point, &turns, stops, tally, |_| Vec3::ZERO).free)
        }
        FalseColor::Normals => (point.shading_normal + 1.0) / 2.0,
        #[expect(clippy::cast_possible_truncation, reason = "the picture is f32")]
        FalseColor::Depth => {
            let distance =
                (camera_ray.start + f64::from(point.distance)) / scene.geometry().frame().scale();
            Vec3::splat(distance as f32)
        }
        FalseColor::Albedo => albedo,
        FalseColor::Facing => {
            let cosine = point.shading_normal.dot(point.wo).abs();
            if point.front {
                Vec3::new(0.0, cosine, 0.0)
            } else {
                Vec3::new(cosine, 0.0, 0.0)
            }
        }
        FalseColor::Object => object_color(point.object),
        FalseColor::Steps => unreachable!("they are known without a hit"),
    }
}

/// How many steps have the last colour of [`steps_color`].
pub const MOST_STEPS: u64 = 255;

/// The colour of that many steps, linear: black for none, then over red and yellow to white for [`MOST_STEPS`] and more. Equal factors
/// are equally far apart: most rays take few steps, and some very many.
#[must_use]
pub fn steps_color(steps: u64) -> Vec3 {
    let share = (steps as f32 + 1.0).log2() / (MOST_STEPS as f32 + 1.0).log2();
    let heat = share.min(1.0) * 3.0;
    Vec3::new(heat, heat - 1.0, heat - 2.0).clamp(Vec3::ZERO, Vec3::ONE)
}

/// A colour of its own for every object: hues a golden section apart are far from their neighbours.
fn object_color(object: usize) -> Vec3 {
    const GOLDEN_SECTION: f32 = 0.618_034;
    let hue = (object as f32 * GOLDEN_SECTION).fract() * 6.0;
    // Full saturation, as in the HSV hexcone (Smith 1978), lifted from black.
    let channel = |shift: f32| {
        let distance = ((hue + shift) % 6.0 - 3.0).abs() - 1.0;
        0.2 + 0.7 * distance.clamp(0.0, 1.0)
    };
    Vec3::new(channel(0.0), channel(4.0), channel(2.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_steps_are_brighter() {
        assert_eq!(steps_color(0), Vec3::ZERO);
        assert_eq!(steps_color(MOST_STEPS), Vec3::ONE);
        assert_eq!(steps_color(u64::MAX), Vec3::ONE);
        let sums: Vec<f32> = (0..=MOST_STEPS)
            .map(|n| steps_color(n).element_sum())
            .collect();
        assert!(sums.windows(2).all(|pair| pair[0] < pair[1]));
    }

    #[test]
    fn neighbouring_objects_differ_in_color() {
        let colors: Vec<Vec3> = (0..12).map(object_color).collect();
        for (i, a) in colors.iter().enumerate() {
            for b in &colors[..i] {
                assert!(a.distance(*b) > 0.1, "{a} {b}");
            }
        }
    }
}
