//! What is made once and not again, or not at all: geometry, trees, tables, hits, samples.

use std::sync::Arc;

use super::{
    Bench, Case, Finding, Measured, NOBODY_CANCELS, Proof, outcome_of, prepare, seconds_of,
    trial_of,
};
use crate::analysis::cost::{Share, paired};
use crate::geometry::TriangleMesh;
use crate::math::{DVec3, Degrees};
use crate::render::{PreparedScene, PrimaryHitStore};
use crate::scene::{
    Background, Camera, Light, LightSampling, Material, Mode, Object, RadianceMap, Rgb, Scene,
    Texels, TextureImage,
};

/// See the module's description.
pub const CASES: &[Case] = &[
    Case {
        left_out: "layers",
        when: "none are written",
        counted: "layers kept",
        proof: Proof::Own(layers),
    },
    Case {
        left_out: "normals",
        when: "objects are flat",
        counted: "bytes",
        proof: Proof::Own(normals),
    },
    Case {
        left_out: "coordinates of textures",
        when: "no object has a texture",
        counted: "bytes beside meshes and images",
        proof: Proof::Own(textures),
    },
    Case {
        left_out: "triangles and tree, again",
        when: "camera, lights or materials change",
        counted: "trees built",
        proof: Proof::Own(tree_again),
    },
    Case {
        left_out: "the choice among lights, again",
        when: "the camera changes, or a material that does not shine",
        counted: "choices made",
        proof: Proof::Own(light_choice_again),
    },
    Case {
        left_out: "tables to aim at a sky",
        when: "it is only met by chance, or not seen",
        counted: "bytes",
        proof: Proof::Own(sky_tables),
    },
    Case {
        left_out: "rays from the eye, again",
        when: "in the window, lights or materials change, one ray a pixel",
        counted: "eye rays",
        proof: Proof::Own(eye_rays_again),
    },
    Case {
        left_out: "samples of quiet pixels",
        when: "a render stops at a noise",
        counted: "samples beyond the first 16 of the quietest pixel",
        proof: Proof::Own(quiet_pixels),
    },
];

/// A square of side 40 about the origin, as `count` × `count` squares of two triangles each.
pub fn grid(count: u32) -> TriangleMesh {
    let corner = |x: u32, y: u32| y * (count + 1) + x;
    let at = |number: u32| 40.0 * (f64::from(number) / f64::from(count) - 0.5);
    let rows = 0..=count;
    let squares = (0..count).flat_map(|y| (0..count).map(move |x| (x, y)));
    TriangleMesh {
        positions: rows
            .flat_map(|y| (0..=count).map(move |x| DVec3::new(at(x), at(y), 0.0)))
            .collect(),
        triangles: squares
            .flat_map(|(x, y)| {
                let [a, b] = [corner(x, y), corner(x + 1, y)];
                let [c, d] = [corner(x + 1, y + 1), corner(x, y + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect(),
        ..TriangleMesh::default()
    }
}

/// The scene with such a square in place of its objects, seen from above.
pub fn of_grid(bench: &Bench<'_>, count: u32) -> Scene {
    bench.changed(|scene| {
        scene.objects = vec![Object {
            mesh: "grid".into(),
            ..Object::default()
        }];
        scene.meshes.insert("grid".into(), Arc::new(grid(count)));
        scene.camera = Camera {
            eye: DVec3::new(0.1, -3.0, 8.0),
            target: DVec3::ZERO,
            ..Camera::default()
        };
    })
}

fn layers(bench: &Bench<'_>) -> Measured {
    let trial = trial_of(bench.scene)?;
    let [without, with] = [false, true].map(|layers| outcome_of(trial.prepared(), layers));
    Ok(Finding {
        count: without.layers.len() as u64,
        otherwise: with.layers.len() as u64,
        same_bits: Some(without.image.hash() == with.image.hash()),
        saving: trial.added_by_layers(bench.pairs),
    })
}

/// Normals of a plane, whose interpolated ones are those of its faces.
fn normals(bench: &Bench<'_>) -> Measured {
    let trial = trial_of(&of_grid(bench, 64))?;
    let mut scene = trial.scene().clone();
    scene.objects[0].smooth = true;
    let flat = trial.prepared();
    let smooth = trial.prepare(&scene)?.expect(NOBODY_CANCELS);
    Ok(Finding {
        count: flat.geometry().normal_bytes() as u64,
        otherwise: smooth.geometry().normal_bytes() as u64,
        same_bits: Some(trial.picture_hash(flat) == trial.picture_hash(&smooth)),
        saving: trial.added_by(&smooth, bench.pairs),
    })
}

/// Textures of a plane with texture coordinates: none, or a white image.
fn textures(bench: &Bench<'_>) -> Measured {
    const SIDE: u32 = 512;
    let mut scene = of_grid(bench, 64);
    let mut mesh = grid(64);
    let coordinates = mesh.positions.iter().map(|position| position.truncate());
    mesh.texture_coordinates = Some(coordinates.collect());
    scene.meshes.insert("grid".into(), Arc::new(mesh));
    let mut material = Material::default();
    scene.materials.insert("grid".into(), material.clone());
    scene.objects[0].material = Some("grid".into());
    let trial = trial_of(&scene)?;

    let mut scene = trial.scene().clone();
    let white = Texels::Bytes(vec![[255; 3]; (SIDE * SIDE) as usize]);
    let white = TextureImage::new(SIDE, SIDE, white);
    scene.textures.insert("white".into(), Arc::new(white));
    if let Some(textures) = material.textures_mut() {
        textures.diffuse_image = Some("white".into());
    }
    scene.materials.insert("grid".into(), material);
    let plain = trial.prepared();
    let textured = trial.prepare(&scene)?.expect(NOBODY_CANCELS);
    Ok(Finding {
        count: plain.texture_bytes() as u64,
        otherwise: textured.texture_bytes() as u64,
        same_bits: Some(trial.picture_hash(plain) == trial.picture_hash(&textured)),
        saving: trial.added_by(&textured, bench.pairs),
    })
}

/// How much longer preparing `scene` takes after `other` than after `known`.
fn saved_in_preparing(
    bench: &Bench<'_>,
    scene: &Scene,
    known: Option<&PreparedScene>,
    other: Option<&PreparedScene>,
) -> Share {
    paired(
        bench.pairs,
        || seconds_of(|| prepare(scene, known)),
        || seconds_of(|| prepare(scene, other)),
    )
}

fn have_same_picture(a: &PreparedScene, b: &PreparedScene) -> bool {
    let [a, b] = [a, b].map(|scene| outcome_of(scene, false).image.hash());
    a == b
}

fn tree_again(bench: &Bench<'_>) -> Measured {
    let before = prepare(bench.scene, None)?;
    let moved = bench.changed(|scene| scene.camera.eye += DVec3::splat(0.1));
    let is_built =
        |after: &PreparedScene| u64::from(!Arc::ptr_eq(after.geometry(), before.geometry()));
    let (kept, anew) = (prepare(&moved, Some(&before))?, prepare(&moved, None)?);
    Ok(Finding {
        count: is_built(&kept),
        otherwise: is_built(&anew),
        same_bits: Some(have_same_picture(&kept, &anew)),
        saving: Some(saved_in_preparing(bench, &moved, Some(&before), None)),
    })
}

/// The choice among 2,000 lights, after a change of the camera alone.
fn light_choice_again(bench: &Bench<'_>) -> Measured {
    let mut scene = bench.changed(|scene| {
        scene.render.mode = Mode::Path;
        let light = |number: u32| Light::Point {
            position: DVec3::new(f64::from(number % 50), f64::from(number / 50), 9.0),
            intensity: Rgb::splat(0.1),
        };
        scene.lights = (0..2000).map(light).collect();
    });
    let before = prepare(&scene, None)?;
    let mut other = scene.clone();
    other.lights[0].move_to(DVec3::splat(7.0));
    let other = prepare(&other, Some(&before))?;
    scene.camera.eye += DVec3::splat(0.1);
    let is_made = |after: &PreparedScene| u64::from(!after.shares_light_choice(&before));
    let kept = prepare(&scene, Some(&before))?;
    let anew = prepare(&scene, Some(&other))?;
    Ok(Finding {
        count: is_made(&kept),
        otherwise: is_made(&anew),
        same_bits: Some(have_same_picture(&kept, &anew)),
        saving: Some(saved_in_preparing(
            bench,
            &scene,
            Some(&before),
            Some(&other),
        )),
    })
}

/// Of an image of half a million pixels.
fn sky_tables(bench: &Bench<'_>) -> Measured {
    const SIDE: u32 = 512;
    let met = bench.changed(|scene| {
        let pixel = |number: u32| [f32::from(u8::from(number.is_multiple_of(97))) + 0.1; 3];
        let pixels = (0..2 * SIDE * SIDE).map(pixel).collect();
        let (map, _) = RadianceMap::cleaned(2 * SIDE, SIDE, pixels);
        scene.images.insert("sky".into(), map.into());
        scene.background = Background::Image {
            image: "sky".into(),
            up: DVec3::Z,
            rotation: Degrees(0.0),
            scale: 1.0,
        };
        scene.render.mode = Mode::Path;
        scene.render.light_sampling = LightSampling::Bsdf;
    });
    let mut aimed_at = met.clone();
    aimed_at.render.light_sampling = LightSampling::Mis;
    // With the tree, and without the sky.
    let before = prepare(bench.scene, None)?;
    let seconds = |scene: &Scene| seconds_of(|| prepare(scene, Some(&before)));
    Ok(Finding {
        count: prepare(&met, Some(&before))?.sky_table_bytes() as u64,
        otherwise: prepare(&aimed_at, Some(&before))?.sky_table_bytes() as u64,
        same_bits: None,
        saving: Some(paired(bench.pairs, || seconds(&met), || seconds(&aimed_at))),
    })
}

fn eye_rays_again(bench: &Bench<'_>) -> Measured {
    let trial = trial_of(&bench.changed(|scene| {
        scene.camera.aperture_radius = 0.0;
        scene.render.antialiasing = false;
    }))?;
    let store = PrimaryHitStore::default();
    let plain = trial.prepared();
    let known = plain.clone().with_primary_hits(&store);
    let [first, again] = [(); 2].map(|()| outcome_of(&known, false));
    Ok(Finding {
        count: again.stats.rays.camera,
        otherwise: first.stats.rays.camera,
        same_bits: Some(again.image.hash() == outcome_of(plain, false).image.hash()),
        saving: trial.added_beside(&known, plain, bench.pairs),
    })
}

/// A render to a noise at which the pixels of the background, which has none, have got no more samples than all get at first.
fn quiet_pixels(bench: &Bench<'_>) -> Measured {
    let mut scene = bench.changed(|scene| {
        scene.render.width = 120;
        scene.render.height = 90;
        scene.render.samples_per_pixel = 4096;
        scene.render.error_estimate = true;
        scene.render.stop.noise = Some(0.005);
        scene.render.adaptive = true;
    });
    let chosen = prepare(&scene, None)?;
    scene.render.adaptive = false;
    let even = prepare(&scene, Some(&chosen))?;
    let stats = |scene| outcome_of(scene, false).stats;
    let beyond_first = |scene| u64::from(stats(scene).sample_range[0].saturating_sub(16));
    let seconds = |scene| stats(scene).cpu_seconds;
    Ok(Finding {
        count: beyond_first(&chosen),
        otherwise: beyond_first(&even),
        same_bits: None,
        saving: Some(paired(bench.pairs, || seconds(&chosen), || seconds(&even))),
    })
}
