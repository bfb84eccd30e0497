//! The glass that light is in on its way, which absorbs some of it between any two surfaces, whatever those are of.

use std::collections::BTreeMap;

use super::material::PreparedMaterial;
use super::prepare::PreparedScene;
use super::specular::Specular;
use super::surface::SurfacePoint;
use crate::math::{Ray, Vec3};

/// The glass objects that a path has entered and not left, the newest last: where one stands in another, the inner one absorbs.
#[derive(Clone, Copy, Debug, Default)]
pub struct Media {
    objects: [usize; MOST_NESTED],
    count: usize,
}

/// Of more objects in one another, the outermost are forgotten.
const MOST_NESTED: usize = 8;

impl Media {
    /// The glass that `eye`, in prepared units, is in.
    pub fn at(scene: &PreparedScene, eye: Vec3) -> Self {
        // An eye is in what it takes to go out of whatever way one takes: an open mesh has no inside.
        let ways = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| axis + Vec3::new(0.013, 0.027, 0.041));
        let mut exited = ways
            .into_iter()
            .flat_map(|way| [way, -way])
            .map(|way| exited_objects(scene, Ray::new(eye, way)));
        let mut objects = exited.next().unwrap_or_default();
        for others in exited {
            objects.retain(|object| others.contains(object));
        }
        let mut media = Self::default();
        for object in objects.into_iter().rev() {
            media.enter(object);
        }
        media
    }

    /// Share of the light that comes through from `point`, which a ray meets, to where that began. `start`: how far from the eye that is,
    /// 0 for all but camera rays. Only to be asked for where [`PreparedScene::absorbs`] says so.
    // Inside the loops that follow paths, it makes them slower where nothing absorbs.
    #[inline(never)]
    pub fn transmittance_from(
        &self,
        scene: &PreparedScene,
        point: &SurfacePoint,
        start: f64,
    ) -> Vec3 {
        // Never seen to be entered, as by an eye in an open mesh, glass is left by its back.
        let unseen = (!point.front).then_some(point.object);
        let object = self.innermost().or(unseen);
        transmittance(scene, object, point.distance, start)
    }

    /// Share of the light that comes through along `ray` from its parameter `t`: all of it where that is infinite, as nothing is all
    /// around. `start`: see [`Self::transmittance_from`].
    #[inline(never)]
    pub fn transmittance_along(
        &self,
        scene: &PreparedScene,
        ray: &Ray,
        t: f32,
        start: f64,
    ) -> Vec3 {
        if t == f32::INFINITY {
            return Vec3::ONE;
        }
        transmittance(scene, self.innermost(), t * ray.direction.length(), start)
    }

    fn innermost(&self) -> Option<usize> {
        self.objects[..self.count].last().copied()
    }

    /// Goes through the boundary at `point`.
    pub fn cross(&mut self, point: &SurfacePoint) {
        if point.front {
            self.enter(point.object);
            return;
        }
        // What was never entered is the other side of what was: two objects may make one slab.
        let inside = &self.objects[..self.count];
        let place = inside.iter().rposition(|&entered| entered == point.object);
        if let Some(place) = place.or(self.count.checked_sub(1)) {
            self.objects.copy_within(place + 1..self.count, place);
            self.count -= 1;
        }
    }

    fn enter(&mut self, object: usize) {
        if self.count == MOST_NESTED {
            self.objects.rotate_left(1);
            self.count -= 1;
        }
        self.objects[self.count] = object;
        self.count += 1;
    }
}

/// The glass objects that `ray` goes out of without having entered them, in that order.
fn exited_objects(scene: &PreparedScene, mut ray: Ray) -> Vec<usize> {
    /// Where there are more surfaces, the eye is taken to be in nothing.
    const MOST_SURFACES: usize = 10_000;
    let mut entered = BTreeMap::<usize, i64>::new();
    let mut exited = Vec::new();
    for _ in 0..MOST_SURFACES {
        let Some(point) = scene.surface_along(&ray, f32::INFINITY) else {
            exited.retain(|object| entered[object] < 0);
            return exited;
        };
        if attenuation_of(scene, point.object).is_some() {
            let entered = entered.entry(point.object).or_default();
            *entered += if point.front { 1 } else { -1 };
            if *entered == -1 && !exited.contains(&point.object) {
                exited.push(point.object);
            }
        }
        ray = point.ray_through(ray.direction);
    }
    Vec::new()
}

/// What the inside of an object absorbs, per prepared unit; `None` where it is not of glass.
fn attenuation_of(scene: &PreparedScene, object: usize) -> Option<Vec3> {
    match *scene.material(object) {
        PreparedMaterial::Specular(Specular::Glass { attenuation, .. }) => Some(attenuation),
        _ => None,
    }
}

/// Share of the light that comes through `distance` inside an object, or in nothing, on a ray that began `start` from the eye.
fn transmittance(scene: &PreparedScene, object: Option<usize>, distance: f32, start: f64) -> Vec3 {
    let attenuation = object.and_then(|object| attenuation_of(scene, object));
    let Some(attenuation) = attenuation.filter(|attenuation| *attenuation != Vec3::ZERO) else {
        return Vec3::ONE;
    };
    #[expect(clippy::cast_possible_truncation, reason = "rendering is f32")]
    let distance = distance + start as f32;
    (-attenuation * distance).map(libm::expf)
}
