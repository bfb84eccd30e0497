//! The `direct` mode: at the first surface that is neither mirror nor glass, the light that arrives straight from lights and
//! background. Mirrors and glass are followed along one path, never a tree.

mod aiming;
mod shading;
mod shadow_rays;

use super::camera::CameraRay;
use super::eye_path::EyePath;
use super::kernel::Kernel;
use super::layers::Gathered;
use super::material::PreparedMaterial;
use super::phong::Phong;
use super::plan::Feature;
use super::prepare::{PreparedScene, Seen};
use super::sampler::Sampler;
use super::stops::Stops;
use super::texturing::Texturing;
use crate::accel::Hit;
use crate::math::Vec3;
use shading::Shading;
use std::borrow::Borrow;

pub use shading::MOST_SUMMED;

/// The light that arrives against `camera_ray`, which makes that `hit`; not all of it when stopped.
pub fn gather<K: Kernel>(
    scene: &PreparedScene,
    camera_ray: CameraRay,
    hit: Option<Hit>,
    sampler: Sampler,
    stops: &Stops<'_>,
    tally: &mut K::Tally,
) -> Gathered<K::Parts> {
    let mut path = EyePath::<K>::new(scene, camera_ray, hit, stops);
    loop {
        let mut point = match path.seen() {
            Seen::Background => {
                let direction = path.ray.direction.normalize();
                path.meet_background(scene.background().radiance(direction), 1.0);
                break;
            }
            Seen::Disk(met) => {
                path.meet_disk(&met, 1.0);
                break;
            }
            Seen::Surface(point) => point,
        };
        path.absorb(&point);
        let material = scene.material(point.object);
        if let PreparedMaterial::Emitter { radiance } = *material {
            path.meet_emitter(radiance, 1.0);
            break;
        }
        if path.end_if_spent(material) {
            break;
        }
        match material {
            PreparedMaterial::Phong(phong) => {
                let hit = path.hit.as_ref();
                let phong = path.texturing.at(scene, phong, &mut point, hit);
                let phong: &Phong = phong.borrow();
                if !phong.is_black() || scene.does(Feature::DarkRays) {
                    let mut shading = Shading::<K> {
                        scene,
                        phong,
                        point: &point,
                        media: &path.media,
                        mirror: point.mirror_direction(),
                        sampler,
                        bounce: path.bounce,
                        stops,
                        parts: &mut path.gathered.parts,
                        tally,
                    };
                    let ambient = shading.reflected_background();
                    let lobes = shading.light_from_all();
                    let (beginning, throughput) = (path.beginning, path.throughput);
                    path.gathered.add_ambient(beginning, throughput * ambient);
                    path.gathered.add_reflected(beginning, lobes * throughput);
                }
                break;
            }
            PreparedMaterial::Specular(specular) => {
                path.deflect(specular, &point, &sampler, tally);
            }
            PreparedMaterial::Emitter { .. } => unreachable!("emitters end the path above"),
        }
        if path.throughput == Vec3::ZERO && !scene.does(Feature::DarkRays) {
            break;
        }
        if !path.go_on(tally) {
            break;
        }
    }
    path.gathered
}
