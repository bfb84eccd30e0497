//! Disk lights as things that rays hit: the nearest one, and whether any is in the way.

use super::light::{PreparedDisk, PreparedLight};
use crate::accel::{BoxTree, Fan};
use crate::math::{Bounds, Ray};

/// The most disks that are tried one after the other. A tree is faster over more: over sixteen it takes as long for the nearest and
/// a tenth less for shadows.
const MOST_IN_A_ROW: usize = 12;

/// The disk lights that rays meet.
#[derive(Clone, Debug, Default)]
pub struct VisibleDisks {
    /// Each with the number of the light.
    disks: Vec<(u32, PreparedDisk)>,
    boxes: Vec<Bounds>,
    /// Over their boxes; `None` where there are few.
    tree: Option<BoxTree>,
}

/// Where a ray meets a disk.
#[derive(Clone, Copy, Debug)]
pub struct DiskHit<'a> {
    pub disk: &'a PreparedDisk,
    /// Number of the light.
    pub light: usize,
    /// Where on the ray.
    pub t: f32,
}

impl VisibleDisks {
    pub fn new(lights: &[PreparedLight]) -> Self {
        let visible = |(index, light): (u32, &PreparedLight)| Some((index, *light.visible_disk()?));
        let disks: Vec<_> = (0..).zip(lights).filter_map(visible).collect();
        let boxes: Vec<_> = disks.iter().map(|(_, disk)| disk.bounds()).collect();
        let tree = (disks.len() > MOST_IN_A_ROW).then(|| BoxTree::build(&boxes));
        Self { disks, boxes, tree }
    }

    /// Boxes around all of them: each one's where they are few, else a single one.
    pub fn boxes(&self) -> Vec<Bounds> {
        match &self.tree {
            Some(tree) => vec![tree.bounds()],
            None => self.boxes.clone(),
        }
    }

    /// The disk that `ray` meets first in `0 < t < t_max`; of several at one place the first in the description.
    #[inline]
    pub fn nearest(&self, ray: &Ray, t_max: f32) -> Option<DiskHit<'_>> {
        let mut nearest: Option<(f32, usize)> = None;
        self.walk(ray, t_max, |index| {
            if let Some(t) = self.disks[index].1.intersect_before(ray, t_max)
                && nearest.is_none_or(|other| (t, index) < other)
            {
                nearest = Some((t, index));
            }
            nearest.map_or(t_max, |(t, _)| t)
        });
        nearest.map(|(t, index)| {
            let (light, ref disk) = self.disks[index];
            DiskHit {
                disk,
                light: light as usize,
                t,
            }
        })
    }

    /// Whether a disk other than the light number `except` is in the way in `0 < t < t_max`.
    #[inline]
    pub fn occlude(&self, ray: &Ray, t_max: f32, except: Option<u32>) -> bool {
        let mut occluded = false;
        self.walk(ray, t_max, |index| {
            let (light, disk) = &self.disks[index];
            occluded |= Some(*light) != except && disk.intersect(ray, t_max).is_some();
            // Nothing lies before the start: no more is visited.
            if occluded { f32::NEG_INFINITY } else { t_max }
        });
        occluded
    }

    /// Along which rays of `fan` a disk other than the light number `except` is in the way, as bits.
    #[inline]
    pub fn occlude_fan(&self, fan: &Fan<'_>, except: Option<u32>) -> u64 {
        let bounds = fan.bounds();
        let is_in_reach = |((light, _), disk_bounds): (&(u32, PreparedDisk), &Bounds)| {
            Some(*light) != except && !disk_bounds.intersection(bounds).is_empty()
        };
        // The boxes of many disks are in the tree.
        if self.tree.is_none() && !self.disks.iter().zip(&self.boxes).any(is_in_reach) {
            return 0;
        }
        fan.each(|ray| self.occlude(ray, 1.0, except))
    }

    /// Visits the disks that `ray` may meet until all that is left lies beyond what `visit` returned.
    #[inline]
    fn walk(&self, ray: &Ray, t_max: f32, mut visit: impl FnMut(usize) -> f32) {
        if let Some(tree) = &self.tree {
            tree.walk(ray, t_max, |index| visit(index as usize));
        } else {
            for index in 0..self.disks.len() {
                if visit(index) < 0.0 {
                    return;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::Random;
    use crate::math::{DBounds, DVec3, SceneFrame, Vec3};
    use crate::scene::{Facing, Light, Rgb};

    /// Disks of all sizes, some tilted and some not, every fifth where another is, every seventh invisible.
    fn lights(count: usize) -> Vec<PreparedLight> {
        let mut random = Random::new(21);
        let frame = SceneFrame::around(&DBounds {
            min: -DVec3::ONE,
            max: DVec3::ONE * 0.99,
        });
        let mut lights: Vec<PreparedLight> = Vec::new();
        for index in 0..count {
            if index % 5 == 4 {
                lights.push(lights[index - 1]);
                continue;
            }
            let mut normal = random.in_cube();
            if index % 3 == 0 {
                normal = DVec3::AXES[index % 9 / 3];
            }
            let light = Light::Disk {
                center: random.in_cube(),
                facing: Facing::Normal(normal),
                radius: 0.3 * random.unit().powi(6),
                radiance: Rgb::ONE,
                visible: index % 7 != 6,
            };
            lights.push(PreparedLight::new(&light, &frame));
        }
        lights
    }

    /// The reference tries all disks one after the other.
    #[test]
    fn the_tree_answers_as_trying_all_does() {
        for count in [0, 1, MOST_IN_A_ROW, MOST_IN_A_ROW + 3, 400, 5000] {
            let lights = lights(count);
            let found = VisibleDisks::new(&lights);
            let in_a_row = VisibleDisks {
                tree: None,
                ..found.clone()
            };
            let mut random = Random::new(8);
            let mut hits = 0;
            for turn in 0..4000_usize {
                let origin = random.in_cube().as_vec3() * if turn % 2 == 0 { 1.0 } else { 1e4 };
                let aim = match lights.get(turn % count.max(1)) {
                    Some(PreparedLight::Disk(disk)) => {
                        let bounds = disk.bounds();
                        let share = random.in_cube().as_vec3() * 0.5 + 0.5;
                        bounds.min + share * bounds.size()
                    }
                    _ => Vec3::ZERO,
                };
                let mut ray = Ray::new(origin, aim - origin);
                if turn % 11 == 0 {
                    // In the plane of a face of its box.
                    ray.direction.x = 0.0;
                    ray.origin.x = aim.x;
                }
                let t_max = if turn % 4 == 0 { f32::INFINITY } else { 1.5 };
                let of = |disks: &VisibleDisks| {
                    let hit = disks.nearest(&ray, t_max);
                    hit.map(|hit| (hit.t.to_bits(), hit.light))
                };
                let hit = of(&found);
                assert_eq!(hit, of(&in_a_row), "{count} disks, {ray:?}");
                hits += usize::from(hit.is_some());
                for except in [None, hit.and_then(|(_, light)| u32::try_from(light).ok())] {
                    assert_eq!(
                        found.occlude(&ray, t_max, except),
                        in_a_row.occlude(&ray, t_max, except)
                    );
                }
            }
            assert!(count == 0 || hits > 800, "{count} disks: {hits} hits");
        }
    }
}
