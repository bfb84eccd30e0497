//! What ends the taking of samples in the middle: between two of them, and within one that takes long.
//!
//! A sample may take a million rays. What traces them looks here now and then, after so many that looking costs nothing next to them, and
//! leaves out the rest when asked to end; such a sample is [thrown away](super::PreparedScene::gathered) whole.

use std::ops::Range;

use crate::control::{CancelToken, Throttle};

/// Who may ask.
#[derive(Clone, Copy, Debug)]
pub struct Stops<'a> {
    /// Whoever asked for the render.
    pub cancel: &'a CancelToken,
    /// Another thread that cannot go on.
    pub halt: &'a CancelToken,
    /// Whoever pauses the render.
    pub throttle: &'a Throttle,
}

impl Stops<'_> {
    /// Turns of something, of a ray or few each, from one look to the next: well below a millisecond's work in nearly all scenes.
    pub const TURNS: u32 = 64;

    /// Whether somebody asks to end, who will not take that back. Waits while the render is paused.
    #[inline]
    pub fn is_asked(&self) -> bool {
        self.throttle.wait_while_paused();
        self.cancel.is_cancelled() || self.halt.is_cancelled()
    }

    /// Whether something that has taken `turns` turns goes on: whether somebody asks to end is looked at after every [`Self::TURNS`].
    #[inline]
    pub fn lets_go_on(&self, turns: u32) -> bool {
        !turns.is_multiple_of(Self::TURNS) || !self.is_asked()
    }

    /// The turns below `count`, in parts between which it is looked whether somebody asks to end: there are no more then.
    #[inline]
    pub fn parts(&self, count: u32) -> impl Iterator<Item = Range<u32>> {
        let starts = (0..count).step_by(Self::TURNS as usize);
        starts
            .take_while(|&first| first == 0 || !self.is_asked())
            .map(move |first| first..count.min(first + Self::TURNS))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::geometry::shapes;
    use crate::math::{DVec3, Degrees};
    use crate::render::PreparedScene;
    use crate::render::camera_samples::SampleId;
    use crate::render::kernel::Plain;
    use crate::render::run::RayCounts;
    use crate::render::texturing::Untextured;
    use crate::scene::{
        Background, Camera, Facing, Light, Material, Mode, Object, RadianceMap, RenderSettings,
        Rgb, Scene, Textures,
    };

    #[test]
    fn turns_end_soon_after_somebody_asks() {
        for is_cancelled in [true, false] {
            let (cancel, halt, throttle) = Default::default();
            let asks: &CancelToken = if is_cancelled { &cancel } else { &halt };
            let stops = Stops {
                cancel: &cancel,
                halt: &halt,
                throttle: &throttle,
            };
            let turns: Vec<u32> = stops.parts(200).flatten().collect();
            assert_eq!(turns, (0..200).collect::<Vec<_>>());
            assert_eq!(stops.parts(0).count(), 0);
            assert!((1..200).all(|turns| stops.lets_go_on(turns)));
            let mut left = stops.parts(200);
            assert_eq!(left.next(), Some(0..64));
            asks.cancel();
            assert_eq!(left.next(), None);
            let going_on = (1..).take_while(|&turns| stops.lets_go_on(turns));
            assert_eq!(going_on.count(), 63);
        }
    }

    /// The inside of a closed room, one pixel of which sees the floor.
    fn room(material: Material) -> Scene {
        let mut scene = Scene::default();
        scene.meshes.insert(
            "room".into(),
            Arc::new(shapes::cuboid(DVec3::NEG_ONE, DVec3::ONE)),
        );
        scene.materials.insert("wall".into(), material);
        scene.objects.push(Object {
            mesh: "room".into(),
            material: Some("wall".into()),
            ..Object::default()
        });
        scene.camera = Camera {
            eye: DVec3::new(0.0, -0.9, 0.5),
            target: DVec3::new(0.1, 0.3, -0.8),
            ..Camera::default()
        };
        scene.render = RenderSettings {
            width: 1,
            height: 1,
            max_bounces: RenderSettings::MAX_BOUNCES,
            roulette: false,
            ..RenderSettings::default()
        };
        scene
    }

    fn matt() -> Scene {
        let material = Material::Phong {
            diffuse: Rgb::ONE,
            specular: Rgb::ZERO,
            shininess: 1.0,
            textures: Textures::default(),
        };
        room(material)
    }

    fn lit(lights: u32, shadow_samples: u32) -> Scene {
        let mut scene = matt();
        let light = |number| Light::Disk {
            center: DVec3::new(0.0, f64::from(number) / f64::from(lights) - 0.5, 0.8),
            facing: Facing::Normal(DVec3::NEG_Z),
            radius: 0.1,
            radiance: Rgb::ONE,
            visible: false,
        };
        scene.lights = (0..lights).map(light).collect();
        scene.render.shadow_samples = shadow_samples;
        scene
    }

    /// Occlusion is looked for by as many rays as can be; `is_image`: where the background is an image.
    fn under_sky(is_image: bool) -> Scene {
        let mut scene = matt();
        scene.render.ambient_occlusion.enabled = true;
        scene.render.ambient_occlusion.samples = RenderSettings::MAX_RAYS_PER_SAMPLE;
        scene.background = if is_image {
            let (map, _) = RadianceMap::cleaned(2, 1, vec![[1.0; 3]; 2]);
            scene.images.insert("sky".into(), Arc::new(map));
            Background::Image {
                image: "sky".into(),
                up: DVec3::Z,
                rotation: Degrees(0.0),
                scale: 1.0,
            }
        } else {
            Background::Constant { radiance: Rgb::ONE }
        };
        scene
    }

    fn shining() -> Scene {
        let mut scene = matt();
        let radiance = Rgb::ONE;
        scene
            .materials
            .insert("lamp".into(), Material::Emitter { radiance });
        scene.objects.push(Object {
            mesh: "room".into(),
            material: Some("lamp".into()),
            scale: 0.1,
            ..Object::default()
        });
        scene.render.shadow_samples = RenderSettings::MAX_RAYS_PER_SAMPLE;
        scene
    }

    fn in_mode(mode: Mode, mut scene: Scene) -> Scene {
        scene.render.mode = mode;
        scene
    }

    /// The rays of the only sample of `scene`, and whether it is one, where somebody asks to end from the beginning or nobody does.
    fn rays_of_sample(scene: &Scene, is_asked: bool) -> (u64, bool) {
        let cancel = CancelToken::new();
        let prepared = PreparedScene::prepare(scene, None, &cancel);
        let prepared = prepared.expect("can be rendered").expect("nobody cancels");
        let (halt, throttle) = Default::default();
        let stops = Stops {
            cancel: &cancel,
            halt: &halt,
            throttle: &throttle,
        };
        if is_asked {
            cancel.cancel();
        }
        let mut rays = RayCounts::default();
        let begun = prepared.begin(SampleId::default(), &mut rays);
        let gathered = prepared.gathered::<Plain<Untextured>>(&begun, &stops, &mut rays);
        (rays.total(), gathered.is_some())
    }

    /// The samples that take longest of all are cut short, however they take their time, and none that is cut counts.
    #[test]
    fn a_sample_of_very_many_rays_ends_soon_after_somebody_asks() {
        let most = RenderSettings::MAX_RAYS_PER_SAMPLE;
        let mirrors = || {
            let reflectance = Rgb::ONE;
            let mut scene = room(Material::Mirror { reflectance });
            scene.background = Background::Constant { radiance: Rgb::ONE };
            scene
        };
        let scenes = [
            ("shadow rays of one light", lit(1, most)),
            ("few shadow rays of many lights", lit(32, 63)),
            ("many shadow rays of many lights", lit(32, most)),
            ("shadow rays of lights that are chosen", lit(1000, most)),
            ("shadow rays of an object that shines", shining()),
            ("occlusion", under_sky(false)),
            ("occlusion under an image", under_sky(true)),
            (
                "occlusion as a picture",
                in_mode(Mode::Ao, under_sky(false)),
            ),
            ("mirrors", mirrors()),
            ("paths in mirrors", in_mode(Mode::Path, mirrors())),
            ("paths from wall to wall", in_mode(Mode::Path, lit(1, 1))),
        ];
        for (what, scene) in scenes {
            let (rays, is_sample) = rays_of_sample(&scene, true);
            assert!(!is_sample, "{what}");
            assert!(rays <= 300, "{what}: {rays} rays");
            let (rays, is_sample) = rays_of_sample(&scene, false);
            assert!(is_sample, "{what}");
            assert!(rays > 2000, "{what}: {rays} rays");
        }
    }
}
