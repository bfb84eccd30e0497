//! The glass that light is in on its way, which absorbs some of it between any two surfaces, whatever those are of.

use super::material::PreparedMaterial;
use super::prepare::PreparedScene;
use super::specular::Specular;
use super::surface::SurfacePoint;
use crate::math::{Ray, Vec3};

/// The glass objects that a path has entered and not left, the newest last: where one stands in another, the inner one absorbs.
#[derive(Clone, Copy, Debug, Default)]
pub struct Media {
    objects: [u32; MOST_NESTED],
    count: usize,
}

/// Of more objects in one another, the outermost are forgotten.
const MOST_NESTED: usize = 8;

impl Media {
    /// The glass that `eye`, in prepared units, is in.
    pub fn at(scene: &PreparedScene, eye: Vec3) -> Self {
        // An eye is in what all ways out leave: an open mesh has no inside.
        let ways = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| axis + Vec3::new(0.013, 0.027, 0.041));
        let mut left = ways
            .into_iter()
            .flat_map(|way| [way, -way])
            .map(|way| objects_left(scene, Ray::new(eye, way)));
        let mut objects = left.next().unwrap_or_default();
        for others in left {
            objects.retain(|object| others.contains(object));
        }
        let mut media = Self::default();
        for object in objects.into_iter().rev() {
            media.enter(object);
        }
        media
    }

    /// Share of the light that is left at `point`, which a ray meets. `start`: how far from the eye the ray began, 0 for all but camera
    /// rays. That is all of it where [`PreparedScene::absorbs`] is false.
    #[inline(never)]
    pub fn left_at(&self, scene: &PreparedScene, point: &SurfacePoint, start: f64) -> Vec3 {
        // Never seen to be entered, as by an eye in an open mesh, glass is left by its back.
        let unseen = (!point.front).then_some(point.object);
        let object = self.innermost().or(unseen);
        left_after(scene, object, point.distance, start)
    }

    /// Share of the light that is left along `ray` up to its parameter `t`: all of it where that is infinite, as nothing is all around.
    /// `start`: see [`Self::left_at`].
    #[inline(never)]
    pub fn left_along(&self, scene: &PreparedScene, ray: &Ray, t: f32, start: f64) -> Vec3 {
        if t == f32::INFINITY {
            return Vec3::ONE;
        }
        left_after(scene, self.innermost(), t * ray.direction.length(), start)
    }

    fn innermost(&self) -> Option<usize> {
        let innermost = self.objects[..self.count].last();
        innermost.map(|&object| object as usize)
    }

    /// Goes through the boundary at `point`.
    pub fn cross(&mut self, point: &SurfacePoint) {
        #[expect(
            clippy::cast_possible_truncation,
            reason = "there are fewer objects than triangles"
        )]
        let object = point.object as u32;
        if point.front {
            self.enter(object);
            return;
        }
        // What was never entered is the other side of what was: two objects may make one slab.
        let inside = &self.objects[..self.count];
        let place = inside.iter().rposition(|&entered| entered == object);
        if let Some(place) = place.or(self.count.checked_sub(1)) {
            self.objects.copy_within(place + 1..self.count, place);
            self.count -= 1;
        }
    }

    fn enter(&mut self, object: u32) {
        if self.count == MOST_NESTED {
            self.objects.rotate_left(1);
            self.count -= 1;
        }
        self.objects[self.count] = object;
        self.count += 1;
    }
}

/// The glass objects that `ray` leaves without having entered them, in that order.
fn objects_left(scene: &PreparedScene, mut ray: Ray) -> Vec<u32> {
    /// Where there are more surfaces, the eye is taken to be in nothing.
    const MOST_SURFACES: usize = 10_000;
    let mut entered = std::collections::BTreeMap::<usize, i64>::new();
    let mut left = Vec::new();
    for _ in 0..MOST_SURFACES {
        let Some(point) = scene.surface_along(&ray, f32::INFINITY) else {
            left.retain(|object| entered[object] < 0);
            return left
                .into_iter()
                .filter_map(|object| u32::try_from(object).ok())
                .collect();
        };
        if attenuation_of(scene, point.object).is_some() {
            let entered = entered.entry(point.object).or_default();
            *entered += if point.front { 1 } else { -1 };
            if *entered == -1 && !left.contains(&point.object) {
                left.push(point.object);
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

/// Share of the light that is left inside an object, or in nothing, after `distance` on a ray that began `start` from the eye.
fn left_after(scene: &PreparedScene, object: Option<usize>, distance: f32, start: f64) -> Vec3 {
    let attenuation = object.and_then(|object| attenuation_of(scene, object));
    let Some(attenuation) = attenuation.filter(|attenuation| *attenuation != Vec3::ZERO) else {
        return Vec3::ONE;
    };
    #[expect(clippy::cast_possible_truncation, reason = "rendering is f32")]
    let distance = distance + start as f32;
    (-attenuation * distance).map(libm::expf)
}
