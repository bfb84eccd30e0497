//! Cutting a reference to a triangle in two at a plane.

use super::item::Item;
use crate::geometry::Triangle;
use crate::math::{Bounds, Vec3};

/// The parts of `item`, of `triangle`, before and behind the plane at `position` across `axis`; `None` where there is none.
/// At least one is there.
///
/// A part's box holds every point of the triangle that is on its side and in the item's box: edges are cut in `f64`, and the
/// points rounded outwards by more than was lost.
/// Source: Stich, Friedrich, Dietrich, Spatial Splits in Bounding Volume Hierarchies, HPG 2009, 4.3.
pub(super) fn halves(
    item: &Item,
    triangle: &Triangle,
    axis: usize,
    position: f32,
) -> [Option<Item>; 2] {
    let [mut before, mut behind] = [Bounds::EMPTY; 2];
    let [a, b, c] = triangle.corners;
    for corner in [a, b, c] {
        if corner[axis] <= position {
            before = before.with_point(corner);
        }
        if corner[axis] >= position {
            behind = behind.with_point(corner);
        }
    }
    for (start, end) in [(a, b), (b, c), (c, a)] {
        let (first, last) = (start[axis].min(end[axis]), start[axis].max(end[axis]));
        if first < position && position < last {
            let crossing = around_crossing(start, end, axis, position);
            before = before.union(crossing);
            behind = behind.union(crossing);
        }
    }
    before.max[axis] = before.max[axis].min(position);
    behind.min[axis] = behind.min[axis].max(position);

    let whole = item.extent().bounds();
    let halves = [before, behind].map(|half| half.intersection(whole));
    if halves.iter().all(Bounds::is_empty) {
        return [Some(*item), None];
    }
    halves.map(|half| (!half.is_empty()).then(|| item.with_bounds(half.min, half.max)))
}

/// A box around the point where an edge, whose ends are on different sides, crosses a plane.
fn around_crossing(start: Vec3, end: Vec3, axis: usize, position: f32) -> Bounds {
    // Some ten roundings of numbers at most twice as large as the coordinates.
    const MARGIN: f64 = f64::EPSILON * 16.0;
    let margin = f64::from(start.abs().max(end.abs()).max_element()) * MARGIN;
    let (start, end) = (start.as_dvec3(), end.as_dvec3());
    let share = (f64::from(position) - start[axis]) / (end[axis] - start[axis]);
    let point = start + (end - start) * share;
    Bounds {
        min: (point - margin).as_vec3().map(f32::next_down),
        max: (point + margin).as_vec3().map(f32::next_up),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::Random;
    use crate::math::DVec3;

    #[test]
    fn a_corner_cut_off_leaves_tight_boxes() {
        let triangle = Triangle {
            corners: [Vec3::ZERO, Vec3::X * 4.0, Vec3::Y * 4.0],
        };
        let halves = halves(&Item::new(&triangle, 7), &triangle, 0, 3.0);
        let [before, behind] = halves.map(|half| half.expect("there is a part"));
        assert_eq!((before.triangle(), behind.triangle()), (7, 7));
        let [before, behind] = [before, behind].map(|half| half.extent().bounds());
        assert_eq!(before.max, Vec3::new(3.0, 4.0, 0.0));
        assert_eq!(behind.min, Vec3::new(3.0, 0.0, 0.0));
        assert_eq!(behind.max.x, 4.0);
        // The crossing is moved by far less than a digit, rounded to the nearest number, and that to the next one.
        let most = 1_f32.next_up().next_up();
        assert!(1.0 < behind.max.y && behind.max.y <= most, "{behind:?}");
    }

    #[test]
    fn a_triangle_in_the_plane_is_whole_on_both_sides() {
        let corners = [Vec3::X, Vec3::X + Vec3::Y, Vec3::X + Vec3::Z];
        let triangle = Triangle { corners };
        let whole = Item::new(&triangle, 0);
        for half in halves(&whole, &triangle, 0, 1.0) {
            let half = half.expect("both hold it").extent().bounds();
            assert_eq!(half, whole.extent().bounds());
        }
    }

    /// No point of the triangle on a side may lie outside that side's box, or rays would miss it: above all not those where
    /// edges cross the plane. Parts are cut again.
    #[test]
    fn boxes_hold_every_point_of_their_side() {
        let mut random = Random::new(1);
        let mut tried = 0;
        for turn in 0..3000 {
            let mut point = || random.in_cube().as_vec3();
            let mut corners = [point(), point(), point()];
            if turn % 3 == 0 {
                corners[2] = corners[1] + point() * 1e-6;
            }
            let triangle = Triangle { corners };
            let mut item = Item::new(&triangle, 0);
            for _ in 0..4 {
                let axis = turn % 3;
                let Bounds { min, max } = item.extent().bounds();
                #[expect(clippy::cast_possible_truncation, reason = "a position")]
                let position = min[axis] + (max[axis] - min[axis]) * random.unit() as f32;
                if !(min[axis] < position && position < max[axis]) {
                    break;
                }
                let halves = halves(&item, &triangle, axis, position);
                for point in points(&triangle, axis, position, &mut random) {
                    if !holds(&item, point) {
                        continue;
                    }
                    tried += 1;
                    for (side, half) in halves.iter().enumerate() {
                        let plane = f64::from(position);
                        if [point[axis] <= plane, point[axis] >= plane][side] {
                            let is_held = half.as_ref().is_some_and(|half| holds(half, point));
                            assert!(is_held, "{point} of {corners:?} at {position}");
                        }
                    }
                }
                item = halves[turn / 3 % 2]
                    .or(halves[0])
                    .or(halves[1])
                    .expect("a part");
            }
        }
        assert!(tried > 50_000, "only {tried} points");
    }

    fn holds(item: &Item, point: DVec3) -> bool {
        let Bounds { min, max } = item.extent().bounds();
        min.as_dvec3().cmple(point).all() && point.cmple(max.as_dvec3()).all()
    }

    /// Points within a triangle, and those where its edges cross the plane.
    fn points(triangle: &Triangle, axis: usize, position: f32, random: &mut Random) -> Vec<DVec3> {
        let [a, b, c] = triangle.corners.map(Vec3::as_dvec3);
        let mut points = Vec::new();
        for (start, end) in [(a, b), (b, c), (c, a)] {
            let share = (f64::from(position) - end[axis]) / (start[axis] - end[axis]);
            if 0.0 < share && share < 1.0 {
                let mut point = end + (start - end) * share;
                point[axis] = f64::from(position);
                points.push(point);
            }
        }
        for _ in 0..10 {
            let (u, v) = (random.unit(), random.unit());
            let (u, v) = if u + v > 1.0 {
                (1.0 - u, 1.0 - v)
            } else {
                (u, v)
            };
            points.push(a + (b - a) * u + (c - a) * v);
        }
        points
    }
}
