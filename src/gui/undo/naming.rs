//! What an edit did, in words that follow "Undo".

use crate::scene::{Camera, Light, Material, Object, RenderSettings, Scene};

/// What changed between two scenes that are not the same, such as "moving the camera".
#[must_use]
pub fn name_of_change(before: &Scene, after: &Scene) -> String {
    added_or_removed(before, after)
        .or_else(|| object_change(before, after))
        .or_else(|| light_change(before, after))
        .or_else(|| material_change(before, after))
        .unwrap_or_else(|| setting_change(before, after).to_owned())
}

/// Objects, lights or materials that came, went or are called otherwise.
fn added_or_removed(before: &Scene, after: &Scene) -> Option<String> {
    if let Some((verb, index)) = one_more_or_less(&before.objects, &after.objects) {
        let objects = if verb == "adding" { after } else { before };
        return Some(format!("{verb} {}", object_name(&objects.objects, index)));
    }
    if let Some((verb, index)) = one_more_or_less(&before.named_lights(), &after.named_lights()) {
        let scene = if verb == "adding" { after } else { before };
        return Some(format!("{verb} {}", scene.light_label(index)));
    }
    if let Some((verb, index)) = one_more_or_less(&before.bookmarks, &after.bookmarks) {
        let scene = if verb == "adding" { after } else { before };
        return Some(format!("{verb} bookmark {}", scene.bookmarks[index].name));
    }
    let only_in = |a: &Scene, b: &Scene| {
        let mut names = a.materials.keys();
        names.find(|name| !b.materials.contains_key(*name)).cloned()
    };
    match (only_in(before, after), only_in(after, before)) {
        // One that has become a preset has taken its name.
        (Some(old), Some(new)) if before.materials[&old] != after.materials[&new] => {
            let [a, b] = [&before.materials[&old], &after.materials[&new]];
            Some(change_of_material(&old, a, b))
        }
        (Some(old), Some(_)) => Some(format!("renaming material {old}")),
        (Some(old), None) => Some(format!("removing material {old}")),
        (None, Some(new)) => Some(format!("adding material {new}")),
        (None, None) => None,
    }
}

/// "adding" or "removing", and the place of the first that was, where the lists differ in length.
fn one_more_or_less<T: PartialEq>(before: &[T], after: &[T]) -> Option<(&'static str, usize)> {
    let differs = |(a, b): (&T, &T)| a != b;
    let shorter = before.len().min(after.len());
    let place = before
        .iter()
        .zip(after)
        .position(differs)
        .unwrap_or(shorter);
    match before.len().cmp(&after.len()) {
        std::cmp::Ordering::Less => Some(("adding", place)),
        std::cmp::Ordering::Greater => Some(("removing", place)),
        std::cmp::Ordering::Equal => None,
    }
}

fn object_name(objects: &[Object], index: usize) -> String {
    match objects.get(index) {
        Some(object) if !object.name.trim().is_empty() => object.name.clone(),
        _ => format!("object {}", index + 1),
    }
}

fn object_change(before: &Scene, after: &Scene) -> Option<String> {
    let pairs = before.objects.iter().zip(&after.objects);
    let (index, (a, b)) = pairs.enumerate().find(|(_, (a, b))| a != b)?;
    let name = object_name(&before.objects, index);
    let what = [
        (a.name != b.name, "renaming"),
        (a.mesh != b.mesh, "changing the mesh of"),
        (a.material != b.material, "changing the material of"),
        // What turns and grows about its middle moves too.
        (a.rotate != b.rotate, "turning"),
        (a.scale != b.scale, "scaling"),
        (a.translate != b.translate, "moving"),
        (a.smooth != b.smooth, "changing the smoothness of"),
        (
            a.repair_winding != b.repair_winding,
            "changing the winding of",
        ),
        (
            a.crease_angle != b.crease_angle,
            "changing the crease angle of",
        ),
    ];
    Some(format!("{} {name}", first(&what).unwrap_or("changing")))
}

fn light_change(before: &Scene, after: &Scene) -> Option<String> {
    let mut lights = 0..before.lights.len();
    if let Some(index) = lights.find(|&index| before.light_name(index) != after.light_name(index)) {
        return Some(format!("renaming {}", before.light_label(index)));
    }
    let pairs = before.lights.iter().zip(&after.lights);
    let (index, (a, b)) = pairs.enumerate().find(|(_, (a, b))| a != b)?;
    let name = before.light_label(index);
    let kind = std::mem::discriminant::<Light>;
    Some(if kind(a) != kind(b) {
        format!("changing the kind of {name}")
    } else if a.position() != b.position() {
        format!("moving {name}")
    } else if a.target() != b.target() {
        format!("aiming {name}")
    } else {
        format!("changing {name}")
    })
}

fn material_change(before: &Scene, after: &Scene) -> Option<String> {
    let mut pairs = before.materials.iter().zip(&after.materials);
    let ((name, a), (_, b)) = pairs.find(|(a, b)| a != b)?;
    Some(change_of_material(name, a, b))
}

fn change_of_material(name: &str, before: &Material, after: &Material) -> String {
    let kind = std::mem::discriminant::<Material>;
    if kind(before) == kind(after) {
        format!("changing material {name}")
    } else {
        format!("changing the kind of material {name}")
    }
}

/// Everything that there is one of.
fn setting_change(before: &Scene, after: &Scene) -> &'static str {
    camera_change(&before.camera, &after.camera)
        .or_else(|| render_change(&before.render, &after.render))
        .or_else(|| {
            let (a, b) = (&before.display, &after.display);
            let (c, d) = (&before.output, &after.output);
            first(&[
                (
                    before.background != after.background,
                    "changing the background",
                ),
                (before.bookmarks != after.bookmarks, "changing a bookmark"),
                (a.exposure != b.exposure, "changing the exposure"),
                (a.tone_curve != b.tone_curve, "changing the tone curve"),
                (a.gamma != b.gamma, "changing the gamma"),
                (c.png_bits != d.png_bits, "changing the depth of PNG files"),
                (c.layers != d.layers, "keeping layers or not"),
            ])
        })
        .unwrap_or("the last edit")
}

fn camera_change(a: &Camera, b: &Camera) -> Option<&'static str> {
    let is_moved = a.eye != b.eye || a.target != b.target || a.up != b.up;
    first(&[
        (is_moved, "moving the camera"),
        (
            a.vertical_fov != b.vertical_fov,
            "changing the field of view",
        ),
        (
            a.aperture_radius != b.aperture_radius,
            "changing the lens radius",
        ),
        (a.focus_distance != b.focus_distance, "changing the focus"),
    ])
}

fn render_change(a: &RenderSettings, b: &RenderSettings) -> Option<&'static str> {
    let size = |settings: &RenderSettings| [settings.width, settings.height];
    let structure = |settings: &RenderSettings| (settings.accelerator, settings.accelerator_build);
    first(&[
        (a.mode != b.mode, "changing the mode"),
        (size(a) != size(b), "changing the size of the picture"),
        (
            a.samples_per_pixel != b.samples_per_pixel,
            "changing the samples",
        ),
        (a.stop != b.stop, "changing when to stop"),
        (a.adaptive != b.adaptive, "switching adaptive samples"),
        (
            a.error_estimate != b.error_estimate,
            "switching the estimate of the error",
        ),
        (a.seed != b.seed, "changing the seed"),
        (a.sampler != b.sampler, "changing the sampler"),
        (a.max_bounces != b.max_bounces, "changing the bounces"),
        (a.roulette != b.roulette, "switching roulette"),
        (
            a.light_sampling != b.light_sampling,
            "changing the light search",
        ),
        (a.filter != b.filter, "changing the pixel filter"),
        (a.shadows != b.shadows, "changing the shadows"),
        (
            a.shadow_samples != b.shadow_samples,
            "changing the shadow rays",
        ),
        (
            a.ambient_occlusion != b.ambient_occlusion,
            "changing the occlusion",
        ),
        (a.mirror != b.mirror, "switching mirrors"),
        (a.glass != b.glass, "switching glass"),
        (
            a.depth_of_field != b.depth_of_field,
            "switching depth of field",
        ),
        (a.antialiasing != b.antialiasing, "switching anti-aliasing"),
        (a.phong != b.phong, "changing the Phong model"),
        (a.clamp != b.clamp, "changing the clamp"),
        (structure(a) != structure(b), "changing the structure"),
    ])
}

/// The name of the first change that there is.
fn first(changes: &[(bool, &'static str)]) -> Option<&'static str> {
    let mut changes = changes.iter();
    changes.find_map(|&(is_there, name)| is_there.then_some(name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::DVec3;

    fn scene() -> Scene {
        let object = |name: &str| Object {
            name: name.to_owned(),
            ..Object::default()
        };
        Scene {
            objects: vec![object("ram"), object("")],
            lights: vec![Light::Point {
                position: DVec3::ONE,
                intensity: DVec3::ONE,
            }],
            materials: [("clay".to_owned(), Material::default())].into(),
            ..Scene::default()
        }
    }

    #[test]
    fn edits_are_named_in_words() {
        let name = |edit: fn(&mut Scene)| {
            let mut after = scene();
            edit(&mut after);
            name_of_change(&scene(), &after)
        };
        let names = [
            name(|s| s.camera.aperture_radius = 0.1),
            name(|s| s.camera.eye.x = 5.0),
            name(|s| s.objects[1].scale = 2.0),
            name(|s| drop(s.objects.remove(0))),
            name(|s| s.objects.push(Object::default())),
            name(|s| s.lights[0].move_to(DVec3::ZERO)),
            name(|s| {
                s.materials
                    .extend([("chrome".to_owned(), Material::mirror())]);
            }),
            name(|s| {
                s.materials
                    .extend([("clay".to_owned(), Material::mirror())]);
            }),
            name(|s| s.render.width = 7),
            name(|s| s.render.sampler = crate::scene::SamplerChoice::Independent),
            name(|s| s.display.exposure = 1.0),
        ];
        assert_eq!(
            names,
            [
                "changing the lens radius",
                "moving the camera",
                "scaling object 2",
                "removing ram",
                "adding object 3",
                "moving light 1",
                "adding material chrome",
                "changing the kind of material clay",
                "changing the size of the picture",
                "changing the sampler",
                "changing the exposure",
            ]
        );
    }
}
