//! What rays do not visit: nodes of a tree that is not needed, or that they miss, or more than they ask for.

use super::once::of_grid;
use super::{Bench, Case, Finding, Measured, Proof, outcome_of, prepare, seconds_of};
use crate::accel::{Accelerator, BuildQuality, Hit, Visits, WideTree, bytes_for_counts};
use crate::analysis::bench::{RayKind, generate};
use crate::analysis::cost::paired;
use crate::control::{CancelToken, Progress};
use crate::math::Ray;
use crate::render::PreparedScene;
use crate::scene::Camera;

/// See the module's description.
pub const CASES: &[Case] = &[
    Case {
        left_out: "nodes of a tree",
        when: "few triangles: one leaf",
        counted: "nodes visited by the eye rays of two triangles",
        proof: Proof::Own(nodes_of_few_triangles),
    },
    Case {
        left_out: "nodes",
        when: "a ray from the eye misses the scene's box",
        counted: "nodes visited for a camera that looks away, one sample a pixel",
        proof: Proof::Own(nodes_of_rays_that_miss),
    },
    Case {
        left_out: "what lies beyond the occlusion radius",
        when: "always",
        counted: "rays that are answered otherwise than by the nearest hit of all",
        proof: Proof::Own(beyond_the_radius),
    },
    Case {
        left_out: "counts of nodes",
        when: "outside `bench`",
        counted: "bytes for them that looking for the nearest hit keeps",
        proof: Proof::Own(node_counts),
    },
];

/// Rays from the eye through the middle of each pixel that looks at the scene's box.
fn eye_rays(scene: &PreparedScene) -> Vec<Ray> {
    let settings = scene.settings();
    let pixels = (0..settings.height).flat_map(|y| (0..settings.width).map(move |x| (x, y)));
    pixels
        .filter_map(|(x, y)| scene.camera().ray(f64::from(x) + 0.5, f64::from(y) + 0.5))
        .map(|from_eye| from_eye.ray)
        .collect()
}

fn nodes_visited(structure: &Accelerator, rays: &[Ray]) -> u64 {
    let visits = |ray| structure.visits(ray, f32::INFINITY, false);
    rays.iter().map(|ray| visits(ray).nodes).sum()
}

fn nearest_hits(structure: &Accelerator, rays: &[Ray]) -> Vec<Option<Hit>> {
    let hit = |ray| structure.intersect(ray, f32::INFINITY);
    rays.iter().map(hit).collect()
}

/// Against the same leaf below a node of its own.
fn nodes_of_few_triangles(bench: &Bench<'_>) -> Measured {
    let scene = prepare(&of_grid(bench, 1), None)?;
    let rays = eye_rays(&scene);
    let accelerator = scene.geometry().accelerator();
    let triangles = (0..accelerator.triangle_count()).map(|id| accelerator.triangle(id).in_scene());
    let triangles: Vec<_> = triangles.collect();
    let (cancel, progress) = (CancelToken::new(), Progress::new());
    let tree = WideTree::build(&triangles, BuildQuality::Best, &cancel, &progress);
    let leaf = tree.expect(super::NOBODY_CANCELS);
    let tree = Accelerator::Wide(leaf.clone().below_a_node());
    let leaf = Accelerator::Wide(leaf);
    let seconds = |structure| seconds_of(|| nearest_hits(structure, &rays));
    Ok(Finding {
        count: nodes_visited(&leaf, &rays),
        otherwise: nodes_visited(&tree, &rays),
        same_bits: Some(nearest_hits(&leaf, &rays) == nearest_hits(&tree, &rays)),
        saving: Some(paired(bench.pairs, || seconds(&leaf), || seconds(&tree))),
    })
}

/// Against rays that go away from the box, and are asked about all the same.
fn nodes_of_rays_that_miss(bench: &Bench<'_>) -> Measured {
    let looking = prepare(bench.scene, None)?;
    let away = bench.changed(|scene| {
        let Camera { eye, target, .. } = scene.camera;
        scene.camera.target = eye + (eye - target);
        scene.render.samples_per_pixel = 1;
    });
    let away = prepare(&away, Some(&looking))?;
    let accelerator = looking.geometry().accelerator();
    let nodes = |rays: &[Ray]| -> u64 {
        let visits = |ray| accelerator.visits(ray, f32::INFINITY, false);
        rays.iter().map(|ray| visits(ray).nodes).sum()
    };
    // They start where those of the camera enter the box, and so leave it.
    let leaving = |ray: &Ray| Ray {
        direction: -ray.direction,
        ..*ray
    };
    let leaving: Vec<_> = eye_rays(&looking).iter().map(leaving).collect();
    let any_hit = || {
        let hit = |ray| accelerator.intersect(ray, f32::INFINITY).is_some();
        leaving.iter().filter(|ray| hit(ray)).count()
    };
    let picture = || outcome_of(&away, false).image;
    Ok(Finding {
        count: nodes(&eye_rays(&away)),
        otherwise: nodes(&leaving),
        same_bits: Some(any_hit() == 0),
        saving: Some(paired(
            bench.pairs,
            || seconds_of(picture),
            || seconds_of(|| (any_hit(), picture())),
        )),
    })
}

/// Occlusion asks for any hit up to its radius; without one, every ray would look for its nearest hit and throw far ones away.
fn beyond_the_radius(bench: &Bench<'_>) -> Measured {
    let prepared = prepare(bench.scene, None)?;
    let accelerator = prepared.geometry().accelerator();
    let sets = generate(&prepared).expect("rays of a scene are rays");
    let name = RayKind::AmbientOcclusion.name();
    let rays: Vec<_> = sets.iter().filter(|set| set.name() == name).collect();
    let rays = || rays.iter().flat_map(|set| set.rays());
    let within = |(ray, reach): &(Ray, f32)| accelerator.occluded(ray, *reach);
    let of_all = |(ray, reach): &(Ray, f32)| {
        let hit = accelerator.intersect(ray, f32::INFINITY);
        hit.is_some_and(|hit| hit.t < *reach)
    };
    let any = |(ray, _): &(Ray, f32)| accelerator.occluded(ray, f32::INFINITY);
    let differ = |a: &dyn Fn(&(Ray, f32)) -> bool, b: &dyn Fn(&(Ray, f32)) -> bool| {
        rays().filter(|ray| a(ray) != b(ray)).count() as u64
    };
    let seconds = |answer: &dyn Fn(&(Ray, f32)) -> bool| {
        seconds_of(|| rays().filter(|ray| answer(ray)).count())
    };
    Ok(Finding {
        count: differ(&within, &of_all),
        otherwise: differ(&any, &of_all),
        same_bits: None,
        saving: Some(paired(
            bench.pairs,
            || seconds(&within),
            || seconds(&of_all),
        )),
    })
}

/// Whether a question counts is decided by its type.
fn node_counts(bench: &Bench<'_>) -> Measured {
    let scene = prepare(bench.scene, None)?;
    let structure = scene.geometry().accelerator().flat();
    let rays = eye_rays(&scene);
    let plain = || nearest_hits(structure, &rays);
    let counted = || -> (Vec<Visits>, Vec<Option<Hit>>) {
        let ask = |ray| structure.intersect_counting(ray, f32::INFINITY);
        rays.iter().map(ask).unzip()
    };
    let [without, with] = bytes_for_counts();
    Ok(Finding {
        count: without as u64,
        otherwise: with as u64,
        same_bits: Some(plain() == counted().1),
        saving: Some(paired(
            bench.pairs,
            || seconds_of(plain),
            || seconds_of(counted),
        )),
    })
}
