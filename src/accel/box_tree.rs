//! A tree of boxes over things that are not triangles of one mesh: whole placed meshes, disk lights.

use super::slabs::MARGIN;
use crate::math::{Bounds, Ray};

/// From this depth on, splits halve the number of boxes, so that no tree is deeper than [`MAX_DEPTH`].
const HALVED_FROM: usize = 30;
/// Depth of the deepest tree: halvings of 2³² boxes come on top.
const MAX_DEPTH: usize = HALVED_FROM + 33;

/// The most boxes that are sorted along each axis for the best split; more are halved, at a tenth of the time. Only the upper levels
/// of large trees notice.
const MOST_SORTED: usize = 4096;

/// A binary tree over boxes, split by the surface area heuristic over their centres; where they are very many, in halves.
#[derive(Clone, Debug, Default)]
pub struct BoxTree {
    /// The root is the first; empty where there are no boxes.
    nodes: Vec<Node>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Bounds,
    content: Content,
}

#[derive(Clone, Copy, Debug)]
enum Content {
    /// Number of the box in the order given.
    Item(u32),
    /// Index of the first of two neighbouring children.
    Children(u32),
}

impl BoxTree {
    /// The tree over `boxes`, of which none is empty and there are fewer than 2³¹.
    ///
    /// # Panics
    /// When there are more.
    #[must_use]
    pub fn build(boxes: &[Bounds]) -> Self {
        let count = u32::try_from(boxes.len())
            .ok()
            .filter(|&count| count < 1 << 31);
        let mut items: Vec<u32> = (0..count.expect("fewer than 2^31 boxes")).collect();
        let mut tree = Self::default();
        if items.is_empty() {
            return tree;
        }
        tree.nodes.reserve_exact(2 * items.len() - 1);
        tree.nodes.push(Node {
            bounds: Bounds::EMPTY,
            content: Content::Item(0),
        });
        // Slot of the node, its part of `items`, its depth.
        let mut open = vec![(0, 0..items.len(), 0)];
        while let Some((slot, range, depth)) = open.pop() {
            let part = &mut items[range.clone()];
            let bounds = around(boxes, part);
            let content = if let &[item] = &*part {
                Content::Item(item)
            } else {
                let middle = range.start + split(boxes, part, depth >= HALVED_FROM);
                let first = tree.nodes.len();
                tree.nodes.extend([tree.nodes[slot]; 2]);
                open.push((first + 1, middle..range.end, depth + 1));
                open.push((first, range.start..middle, depth + 1));
                Content::Children(u32::try_from(first).expect("twice the number of boxes"))
            };
            tree.nodes[slot] = Node { bounds, content };
        }
        tree
    }

    /// Memory of the nodes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.nodes)
    }

    /// The box around all boxes; empty when there are none.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        self.nodes.first().map_or(Bounds::EMPTY, |root| root.bounds)
    }

    /// Visits the boxes that `ray` may pass in `0 < t < t_max`, roughly in the order in which it passes them, until all that is left begins
    /// beyond the `t` that the last call of `visit` returned.
    #[inline]
    pub fn walk(&self, ray: &Ray, t_max: f32, visit: impl FnMut(u32) -> f32) {
        self.walk_grown(ray, t_max, 0.0, visit);
    }

    /// [`Self::walk`] with every box larger by `slack`, which is 0 or several units in the last place of the ray's origin, on
    /// every side: for things that do not meet the ray itself but one that lies so near.
    #[inline]
    pub fn walk_grown(&self, ray: &Ray, t_max: f32, slack: f32, mut visit: impl FnMut(u32) -> f32) {
        let slabs = Slabs::new(ray, slack);
        let mut limit = t_max;
        let mut stack = [(0_u32, 0.0_f32); MAX_DEPTH];
        let mut waiting = 0;
        let Some(root) = self.nodes.first() else {
            return;
        };
        let mut next = slabs.enter(&root.bounds).map(|_| 0);
        loop {
            if let Some(index) = next {
                next = match self.nodes[index as usize].content {
                    Content::Item(item) => {
                        limit = visit(item);
                        None
                    }
                    Content::Children(first) => {
                        let child = |index: u32| {
                            let enter = slabs.enter(&self.nodes[index as usize].bounds)?;
                            (enter <= limit).then_some((index, enter))
                        };
                        match (child(first), child(first + 1)) {
                            (Some(a), Some(b)) => {
                                let (near, far) = if b.1 < a.1 { (b, a) } else { (a, b) };
                                stack[waiting] = far;
                                waiting += 1;
                                Some(near.0)
                            }
                            (a, b) => a.or(b).map(|(index, _)| index),
                        }
                    }
                };
                continue;
            }
            if waiting == 0 {
                return;
            }
            waiting -= 1;
            let (index, enter) = stack[waiting];
            next = (enter <= limit).then_some(index);
        }
    }

    /// Visits the boxes that have a point in common with `bounds`.
    pub fn overlapping(&self, bounds: &Bounds, mut visit: impl FnMut(u32)) {
        // One of each level, and both children of the last.
        let mut stack = [0_u32; MAX_DEPTH + 1];
        let mut waiting = usize::from(!self.nodes.is_empty());
        while waiting > 0 {
            waiting -= 1;
            let node = &self.nodes[stack[waiting] as usize];
            if node.bounds.intersection(*bounds).is_empty() {
                continue;
            }
            match node.content {
                Content::Item(item) => visit(item),
                Content::Children(first) => {
                    stack[waiting..waiting + 2].copy_from_slice(&[first + 1, first]);
                    waiting += 2;
                }
            }
        }
    }
}

/// A ray prepared for tests against many boxes.
struct Slabs {
    /// The ray's origin as the lower sides of the boxes see it, moved up instead of each of them down.
    from_low: [f32; 3],
    from_high: [f32; 3],
    inverse: [f32; 3],
}

impl Slabs {
    fn new(ray: &Ray, slack: f32) -> Self {
        Self {
            from_low: (ray.origin + slack).to_array(),
            from_high: (ray.origin - slack).to_array(),
            inverse: ray.direction.to_array().map(f32::recip),
        }
    }

    /// Where the ray enters the box, not before its start; `None` where it misses it for certain. NaN, from a ray within a
    /// plane (0 · ∞), bounds nothing.
    #[inline]
    fn enter(&self, bounds: &Bounds) -> Option<f32> {
        let (mut enter, mut exit) = (0.0_f32, f32::INFINITY);
        for axis in 0..3 {
            let low = (bounds.min[axis] - self.from_low[axis]) * self.inverse[axis];
            let high = (bounds.max[axis] - self.from_high[axis]) * self.inverse[axis];
            let (near, far) = if low < high { (low, high) } else { (high, low) };
            // Products, which leave infinite distances infinite: those of a ray along the planes.
            let near = near * (1.0 - MARGIN.copysign(near)) - f32::MIN_POSITIVE;
            let far = far * (1.0 + MARGIN.copysign(far)) + f32::MIN_POSITIVE;
            let unknown = low.is_nan() || high.is_nan();
            if !unknown && near > enter {
                enter = near;
            }
            if !unknown && far < exit {
                exit = far;
            }
        }
        (enter <= exit).then_some(enter)
    }
}

fn around(boxes: &[Bounds], items: &[u32]) -> Bounds {
    items
        .iter()
        .fold(Bounds::EMPTY, |all, &item| all.union(boxes[item as usize]))
}

/// Sorts at least two `items` along one axis and returns where to cut: where the surface area heuristic is least over all
/// axes, or in the middle.
fn split(boxes: &[Bounds], items: &mut [u32], halve: bool) -> usize {
    // Ties by number, so that the tree depends on the boxes alone.
    let along = |axis: usize| {
        let center = move |item: u32| boxes[item as usize].center()[axis];
        move |a: &u32, b: &u32| center(*a).total_cmp(&center(*b)).then(a.cmp(b))
    };
    let sort = |items: &mut [u32], axis: usize| items.sort_unstable_by(along(axis));
    let middle = items.len() / 2;
    if halve {
        return middle;
    }
    if items.len() > MOST_SORTED {
        let longest = around(boxes, items).size().max_position();
        items.select_nth_unstable_by(middle, along(longest));
        return middle;
    }
    let mut best = (f64::INFINITY, 0, items.len() / 2);
    let mut after = vec![0.0; items.len()];
    for axis in 0..3 {
        sort(items, axis);
        let mut right = Bounds::EMPTY;
        for (index, &item) in items.iter().enumerate().rev() {
            right = right.union(boxes[item as usize]);
            after[index] = f64::from(right.half_area());
        }
        let mut left = Bounds::EMPTY;
        for cut in 1..items.len() {
            left = left.union(boxes[items[cut - 1] as usize]);
            let cost =
                f64::from(left.half_area()) * cut as f64 + after[cut] * (items.len() - cut) as f64;
            if cost < best.0 {
                best = (cost, axis, cut);
            }
        }
    }
    let (_, axis, cut) = best;
    sort(items, axis);
    cut
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::Random;
    use crate::math::Vec3;

    fn boxes(count: usize, size: f32) -> Vec<Bounds> {
        let mut random = Random::new(11);
        (0..count)
            .map(|_| {
                let min = random.in_cube().as_vec3();
                let reach = random.in_cube().as_vec3().abs() * size;
                Bounds {
                    min,
                    max: min + reach,
                }
            })
            .collect()
    }

    /// Every box whose inside the ray passes is visited, for rays in all directions, also along axes and from planes.
    #[test]
    fn no_box_on_the_way_is_left_out() {
        for (count, size) in [(1, 0.5), (2, 0.5), (300, 0.2), (300, 0.0), (1000, 1.5)] {
            let boxes = boxes(count, size);
            let tree = BoxTree::build(&boxes);
            let mut random = Random::new(5);
            let mut met = 0;
            for turn in 0..2000_usize {
                let aim = boxes[turn % count].center();
                let mut origin = random.in_cube().as_vec3() * 3.0;
                if turn % 3 == 0 {
                    origin.x = boxes[turn % count].min.x;
                }
                if turn % 5 == 0 {
                    origin.y = aim.y;
                    origin.z = aim.z;
                }
                let ray = Ray::new(origin, aim - origin);
                if ray.direction == Vec3::ZERO {
                    continue;
                }
                let mut visited = vec![false; count];
                tree.walk(&ray, f32::INFINITY, |item| {
                    visited[item as usize] = true;
                    f32::INFINITY
                });
                // Every box was aimed at once in a while, and others lie on the way.
                assert!(
                    visited[turn % count],
                    "{count} boxes of {size}, turn {turn}"
                );
                met += visited.iter().filter(|&&hit| hit).count();
                for (bounds, hit) in boxes.iter().zip(&visited) {
                    let inside = (1..64).any(|step| bounds.contains(ray.at(step as f32 / 32.0)));
                    assert!(*hit || !inside);
                }
            }
            assert!(count < 3 || met < 2000 * count, "boxes are left out at all");
        }
    }

    #[test]
    fn the_boxes_that_overlap_are_those_that_do() {
        for (count, size) in [(0, 0.5), (1, 0.5), (300, 0.2), (300, 0.0), (1000, 1.5)] {
            let boxes = boxes(count, size);
            let tree = BoxTree::build(&boxes);
            let mut random = Random::new(6);
            for _ in 0..200 {
                let corners = [(); 2].map(|()| random.in_cube().as_vec3());
                let asked = Bounds::of_points(corners);
                let overlaps = |bounds: &Bounds| !bounds.intersection(asked).is_empty();
                let expected: Vec<usize> = (0..count).filter(|&i| overlaps(&boxes[i])).collect();
                let mut found = Vec::new();
                tree.overlapping(&asked, |item| found.push(item as usize));
                found.sort_unstable();
                assert_eq!(found, expected);
            }
        }
    }

    #[test]
    fn what_lies_beyond_the_limit_is_not_visited() {
        let boxes: Vec<Bounds> = (0..100)
            .map(|i| Bounds {
                min: Vec3::new(i as f32, 0.0, 0.0),
                max: Vec3::new(i as f32 + 0.5, 1.0, 1.0),
            })
            .collect();
        let tree = BoxTree::build(&boxes);
        let ray = Ray::new(Vec3::new(-1.0, 0.5, 0.5), Vec3::X);
        let mut visited = Vec::new();
        tree.walk(&ray, f32::INFINITY, |item| {
            visited.push(item);
            if item >= 3 { 4.5 } else { f32::INFINITY }
        });
        assert_eq!(visited, [0, 1, 2, 3]);
        let mut count = 0;
        tree.walk(&ray, 10.2, |_| {
            count += 1;
            10.2
        });
        assert_eq!(count, 10);
    }

    #[test]
    fn equal_boxes_make_a_shallow_tree() {
        let tree = BoxTree::build(&vec![boxes(1, 0.3)[0]; 5000]);
        let mut depth = 0;
        let mut open = vec![(0_u32, 1)];
        while let Some((index, level)) = open.pop() {
            depth = depth.max(level);
            if let Content::Children(first) = tree.nodes[index as usize].content {
                open.extend([(first, level + 1), (first + 1, level + 1)]);
            }
        }
        assert!(depth <= MAX_DEPTH, "{depth}");
        assert!(BoxTree::build(&[]).bounds().is_empty());
    }
}
