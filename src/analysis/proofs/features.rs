//! What the plan leaves out: each feature in a scene without need of it, and done for nothing.

use super::once::grid;
use super::{Bench, Case, Finding, Measured, NOBODY_CANCELS, Proof, outcome_of, trial_of};
use crate::math::{DVec3, Degrees};
use crate::render::{Decision, Feature, Used, Work};
use crate::scene::{
    Background, Camera, Facing, Light, LightSampling, Material, Mode, Object, Rgb, Scene, Shadows,
};

/// See the module's description.
pub const CASES: &[Case] = &[
    Case {
        left_out: "points in the pixel",
        when: "one sample per pixel, or no antialiasing",
        counted: "numbers for them",
        proof: Proof::Planned {
            feature: Some(Feature::PixelPoints),
            count: |work| work.draws(Decision::Pixel),
            change: |scene| scene.render.antialiasing = false,
        },
    },
    Case {
        left_out: "points on the lens",
        when: "aperture 0, or no depth of field",
        counted: "numbers for them",
        proof: Proof::Planned {
            feature: Some(Feature::Lens),
            count: |work| work.draws(Decision::Lens),
            change: |scene| scene.camera.aperture_radius = 0.0,
        },
    },
    Case {
        left_out: "an eye ray for every sample",
        when: "all samples of a pixel look along one line",
        counted: "eye rays beyond one for each pixel",
        proof: Proof::Planned {
            feature: Some(Feature::EyeRays),
            count: |work| work.rays.camera - work.pixels,
            change: |scene| {
                scene.camera.aperture_radius = 0.0;
                scene.render.antialiasing = false;
            },
        },
    },
    Case {
        left_out: "shadow rays",
        when: "no light shines",
        counted: "shadow rays",
        proof: Proof::Planned {
            feature: Some(Feature::DarkRays),
            count: |work| work.rays.shadow,
            change: put_lights_out,
        },
    },
    Case {
        left_out: "shadow rays",
        when: "shadows are off",
        counted: "shadow rays",
        proof: Proof::Planned {
            feature: Some(Feature::ShadowRays),
            count: |work| work.rays.shadow,
            change: |scene| scene.render.shadows = Shadows::Off,
        },
    },
    Case {
        left_out: "shadow rays to lights behind the surface or black",
        when: "always",
        counted: "shadow rays beyond one a sample, of a floor before one of three lights",
        proof: Proof::Planned {
            feature: Some(Feature::DarkRays),
            count: |work| work.rays.shadow - work.samples,
            change: |scene| *scene = floor_before_one_of_three_lights(),
        },
    },
    Case {
        left_out: "points on lights",
        when: "shadows are hard, or no light has an area",
        counted: "numbers for them",
        proof: Proof::Planned {
            feature: Some(Feature::LightPoints),
            count: |work| work.draws(Decision::Light),
            change: |scene| {
                scene.lights.push(Light::Disk {
                    center: DVec3::new(0.0, -3.0, 6.0),
                    facing: Facing::Target(DVec3::ZERO),
                    radius: 0.5,
                    radiance: Rgb::splat(20.0),
                    visible: false,
                });
                scene.render.shadows = Shadows::Hard;
            },
        },
    },
    Case {
        left_out: "looking for glass before lights",
        when: "nothing is of glass: any hit will do",
        counted: "shadow rays that ask for the nearest hit",
        proof: Proof::Planned {
            feature: Some(Feature::GlassShadows),
            count: |work| work.shadow_rays_for_glass,
            change: |scene| scene.render.glass = false,
        },
    },
    Case {
        left_out: "rays into the hemisphere",
        when: "ambient occlusion is off, or the background black",
        counted: "rays for it",
        proof: Proof::Planned {
            feature: Some(Feature::Occlusion),
            count: |work| work.rays.ambient_occlusion,
            change: |scene| scene.render.ambient_occlusion.enabled = false,
        },
    },
    Case {
        left_out: "bounces",
        when: "mode path, one bounce, lights are aimed at",
        counted: "bounce rays",
        proof: Proof::Planned {
            feature: Some(Feature::DarkRays),
            count: |work| work.rays.bounce,
            change: keep_to_aimed_light,
        },
    },
    Case {
        left_out: "directions of bounces",
        when: "the same",
        counted: "numbers for them",
        proof: Proof::Planned {
            feature: Some(Feature::LastRays),
            count: |work| work.draws(Decision::Direction),
            change: keep_to_aimed_light,
        },
    },
    Case {
        left_out: "roulette",
        when: "paths end before, or it is off",
        counted: "numbers for it",
        proof: Proof::Planned {
            feature: Some(Feature::Roulette),
            count: |work| work.draws(Decision::Roulette),
            change: |scene| {
                scene.render.mode = Mode::Path;
                scene.render.roulette = false;
            },
        },
    },
    Case {
        left_out: "looking for light",
        when: "nothing shines",
        counted: "rays beyond those from the eye",
        proof: Proof::Planned {
            feature: Some(Feature::Light),
            count: |work| work.rays.total() - work.rays.camera,
            change: |scene| {
                put_lights_out(scene);
                scene.background = Background::default();
                scene.render.mode = Mode::Path;
            },
        },
    },
    Case {
        left_out: "choosing among the lobes of a material, and powers of cosines",
        when: "`specular` is black (mode path)",
        counted: "materials with a specular lobe",
        proof: Proof::Own(lobe_choice),
    },
    Case {
        left_out: "following mirrors and glass",
        when: "no ray meets any (mode direct)",
        counted: "bounce rays",
        proof: Proof::Own(no_mirror),
    },
    Case {
        left_out: "everything",
        when: "nothing is there, one sample",
        counted: "random numbers, and rays beyond one a pixel",
        proof: Proof::Planned {
            feature: None,
            count: |work| work.all_draws() + work.rays.total() - work.pixels,
            change: |scene| {
                *scene = Scene::default();
                scene.render.samples_per_pixel = 1;
            },
        },
    },
];

/// Holds a render of the changed scene against one that does `feature`, or everything, for nothing.
pub fn prove(
    bench: &Bench<'_>,
    feature: Option<Feature>,
    count: fn(&Work) -> u64,
    change: fn(&mut Scene),
) -> Measured {
    let trial = trial_of(&bench.changed(change))?;
    let planned = trial.prepared();
    let plan = planned.plan();
    let forced = planned.clone().with_plan(match feature {
        Some(feature) => plan.forcing(feature),
        None => plan.forcing_everything(),
    });
    let settings = planned.settings();
    let work = |scene| {
        let pixels = (0..settings.height).flat_map(|y| (0..settings.width).map(move |x| (x, y)));
        count(&Work::of(scene, pixels, settings.samples_per_pixel))
    };
    Ok(Finding {
        count: work(planned),
        otherwise: work(&forced),
        same_bits: Some(trial.picture_hash(planned) == trial.picture_hash(&forced)),
        saving: trial.added_by(&forced, bench.pairs),
    })
}

/// Against materials with a lobe so dark that no bit of any sum shows it, which is chosen among and evaluated all the same.
fn lobe_choice(bench: &Bench<'_>) -> Measured {
    const DARK: f64 = 1e-30;
    let shine = |scene: &mut Scene, share: f64| {
        for material in scene.materials.values_mut() {
            if let Material::Phong {
                specular,
                shininess,
                ..
            } = material
            {
                (*specular, *shininess) = (Rgb::splat(share), 30.0);
            }
        }
    };
    let trial = trial_of(&bench.changed(|scene| {
        scene.render.mode = Mode::Path;
        shine(scene, 0.0);
    }))?;
    let mut dark = trial.scene().clone();
    shine(&mut dark, DARK);
    let with_lobe = trial.prepare(&dark)?.expect(NOBODY_CANCELS);
    let specular = |scene: &Scene| u64::from(Used::of(scene).lobes.contains("specular"));
    Ok(Finding {
        count: specular(trial.scene()),
        otherwise: specular(&dark),
        same_bits: Some(trial.picture_hash(trial.prepared()) == trial.picture_hash(&with_lobe)),
        saving: trial.added_by(&with_lobe, bench.pairs),
    })
}

/// Against a mirror that no ray meets: below the lowest object, and so small that it darkens nothing. How many rays there are otherwise
/// is told of the same with every object a mirror.
fn no_mirror(bench: &Bench<'_>) -> Measured {
    let bounds = bench.scene.measured_bounds()?;
    let trial = trial_of(&bench.changed(|scene| {
        scene.meshes.insert("speck".into(), grid(1).into());
        scene.materials.insert("mirror".into(), Material::default());
        scene.objects.push(Object {
            mesh: "speck".into(),
            material: Some("mirror".into()),
            scale: 1e-6,
            translate: bounds.center() - DVec3::Z * bounds.size().z,
            ..Object::default()
        });
    }))?;
    let mut scene = trial.scene().clone();
    scene.materials.insert("mirror".into(), Material::mirror());
    let unmet = trial.prepare(&scene)?.expect(NOBODY_CANCELS);
    for object in &mut scene.objects {
        object.material = Some("mirror".into());
    }
    let met = trial.prepare(&scene)?.expect(NOBODY_CANCELS);
    let bounces = |scene| outcome_of(scene, false).stats.rays.bounce;
    Ok(Finding {
        count: bounces(trial.prepared()) + bounces(&unmet),
        otherwise: bounces(&met),
        same_bits: Some(trial.picture_hash(trial.prepared()) == trial.picture_hash(&unmet)),
        saving: trial.added_by(&unmet, bench.pairs),
    })
}

/// Leaves only the background's light.
fn put_lights_out(scene: &mut Scene) {
    for light in &mut scene.lights {
        match light {
            Light::Point { intensity, .. } => *intensity = Rgb::ZERO,
            Light::Disk { radiance, .. } => *radiance = Rgb::ZERO,
        }
    }
    for material in scene.materials.values_mut() {
        if let Material::Emitter { radiance } = material {
            *radiance = Rgb::ZERO;
        }
    }
}

/// Paths of one bounce, whose last ray could only meet what is aimed at.
fn keep_to_aimed_light(scene: &mut Scene) {
    scene.render.mode = Mode::Path;
    scene.render.max_bounces = 1;
    scene.render.light_sampling = LightSampling::Nee;
    // It is not aimed at, unless it is an image.
    scene.background = Background::default();
}

/// A floor that fills the picture, with a light before it, one behind it and a black one.
fn floor_before_one_of_three_lights() -> Scene {
    let mut scene = Scene::default();
    let floor = grid(1);
    scene.meshes.insert("floor".into(), floor.into());
    scene.objects.push(Object {
        mesh: "floor".into(),
        ..Object::default()
    });
    let point = |z: f64, intensity: f64| Light::Point {
        position: DVec3::new(0.3, 0.2, z),
        intensity: Rgb::splat(intensity),
    };
    scene.lights = vec![point(3.0, 1.0), point(-3.0, 1.0), point(2.0, 0.0)];
    scene.camera = Camera {
        eye: DVec3::new(0.1, -3.0, 8.0),
        target: DVec3::ZERO,
        vertical_fov: Degrees(30.0),
        ..Camera::default()
    };
    scene
}
