//! The `direct` mode: light that reaches a surface straight from the lights and from the background.

use super::light::PreparedLight;
use super::prepare::PreparedScene;
use super::run::RayCounts;
use super::surface::SurfacePoint;
use crate::math::{Ray, Vec3};
use crate::scene::Shadows;

/// Radiance that arrives against `ray`.
pub fn radiance(scene: &PreparedScene, ray: &Ray, rays: &mut RayCounts) -> Vec3 {
    let Some(hit) = scene.accelerator().intersect(ray, f32::INFINITY) else {
        return scene.background().radiance(ray.direction);
    };
    let point = SurfacePoint::new(scene.geometry(), ray, &hit);
    let material = scene.material(point.object);
    if material.is_black() {
        return Vec3::ZERO;
    }

    let mut radiance = material.diffuse
        * scene
            .background()
            .mean_over_hemisphere(point.shading_normal);
    for light in scene.lights() {
        radiance += light_from(scene, light, &point, rays);
    }
    radiance
}

/// What `point` reflects of one light towards `wo`.
fn light_from(
    scene: &PreparedScene,
    light: &PreparedLight,
    point: &SurfacePoint,
    rays: &mut RayCounts,
) -> Vec3 {
    let towards = light.position - point.position;
    let distance_squared = towards.length_squared();
    let Some(wi) = towards.try_normalize() else {
        return Vec3::ZERO;
    };

    // No ray where nothing would be reflected anyway.
    let cosine = point.cosine(wi);
    if cosine <= 0.0 {
        return Vec3::ZERO;
    }
    let material = scene.material(point.object);
    let reflected = material.reflected(
        scene.phong_model(),
        point.shading_normal,
        point.wo,
        wi,
        cosine,
    );
    if reflected == Vec3::ZERO {
        return Vec3::ZERO;
    }

    if scene.shadows() != Shadows::Off {
        rays.shadow += 1;
        if scene
            .accelerator()
            .occluded(&point.ray_to(light.position), 1.0)
        {
            return Vec3::ZERO;
        }
    }
    reflected * light.intensity / distance_squared
}
