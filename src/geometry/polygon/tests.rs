use super::*;
use crate::geometry::shapes::Random;
use std::f64::consts::TAU;

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "below the bound"
)]
fn below(random: &mut Random, bound: usize) -> usize {
    (random.unit() * bound as f64) as usize
}

/// Points of a plane as corners in space: on all three axes' planes and tilted, from both sides.
fn placements(points: &[DVec2]) -> Vec<Vec<DVec3>> {
    let frames = [
        [DVec3::X, DVec3::Y],
        [DVec3::Y, DVec3::Z],
        [DVec3::Z, DVec3::X],
        [DVec3::Y, DVec3::X],
        [DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.0, 1.0, 0.0)],
        [DVec3::new(1e20, 0.0, 0.0), DVec3::new(0.0, 0.0, 1e20)],
        [DVec3::new(1e-20, 0.0, 0.0), DVec3::new(0.0, 0.0, 1e-20)],
    ];
    let place = |[right, up]: [DVec3; 2]| {
        let corner = |point: &DVec2| right * point.x + up * point.y;
        points.iter().map(corner).collect()
    };
    frames.into_iter().map(place).collect()
}

fn area_vector(corners: &[DVec3]) -> DVec3 {
    newell_normal(corners, 1.0) * 0.5
}

/// All triangles turn the polygon's way, and there are n − 2: then they tile a polygon that does not cross itself.
#[track_caller]
fn assert_tiled(points: &[DVec2]) {
    for corners in placements(points) {
        let cut = assert_covered(&corners);
        let flat = flatten(&corners);
        for triangle in cut.triangles {
            let [a, b, c] = triangle.map(|corner| flat[corner as usize]);
            assert!(orientation(a, b, c) > 0.0, "{triangle:?} has no area");
        }
    }
}

/// The same, but triangles without area may be among them.
#[track_caller]
fn assert_covered(corners: &[DVec3]) -> Triangulation {
    let cut = triangulate(corners);
    assert!(!cut.crosses_itself, "{corners:?}: {cut:?}");
    assert_eq!(cut.triangles.len(), corners.len() - 2);
    let flat = flatten(corners);
    let whole = area_vector(corners);
    let mut sum = 0.0;
    for triangle in &cut.triangles {
        let [a, b, c] = triangle.map(|corner| flat[corner as usize]);
        assert!(orientation(a, b, c) >= 0.0, "{triangle:?} is turned over");
        let triangle = triangle.map(|corner| corners[corner as usize]);
        sum += area_vector(&triangle).dot(whole / whole.length());
    }
    let error = (sum - whole.length()).abs();
    assert!(error < 1e-9 * whole.length(), "{sum} for {whole}");
    cut
}

fn polygon(points: &[(f64, f64)]) -> Vec<DVec2> {
    points.iter().map(|&(x, y)| DVec2::new(x, y)).collect()
}

fn circle(n: u32, radius: impl FnMut(u32) -> f64) -> Vec<DVec2> {
    let point = |(i, radius): (u32, f64)| {
        let angle = TAU * f64::from(i) / f64::from(n);
        DVec2::new(libm::cos(angle), libm::sin(angle)) * radius
    };
    (0..n).zip((0..n).map(radius)).map(point).collect()
}

/// A band that winds inwards, `turns` times.
fn spiral(n: u32, turns: f64) -> Vec<DVec2> {
    let point = |i: u32, radius: f64| {
        let part = f64::from(i) / f64::from(n);
        let angle = TAU * turns * part;
        DVec2::new(libm::cos(angle), libm::sin(angle)) * (radius + turns * part)
    };
    let inner = (0..=n).rev().map(|i| point(i, 1.0));
    let outer = (0..=n).map(|i| point(i, 1.5));
    inner
        .chain(outer)
        .rev()
        .map(|p| DVec2::new(p.x, -p.y))
        .collect()
}

/// Thin teeth on a bar, rotated by `angle`.
fn comb(teeth: u32, angle: f64) -> Vec<DVec2> {
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    let width = f64::from(teeth);
    let mut points = vec![DVec2::new(width, -1.0), DVec2::new(width, 0.0)];
    for tooth in (0..teeth).rev().map(f64::from) {
        points.extend([
            DVec2::new(tooth + 0.75, width),
            DVec2::new(tooth + 0.5, 0.0),
        ]);
    }
    points.push(DVec2::new(0.0, -1.0));
    let turned = |p: DVec2| DVec2::new(cos * p.x - sin * p.y, sin * p.x + cos * p.y);
    points.into_iter().map(turned).collect()
}

#[test]
fn triangles_and_quadrilaterals_are_cut_as_one_expects() {
    let square = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
    assert_eq!(triangulate(&square).triangles, [[0, 1, 2], [2, 3, 0]]);
    assert_eq!(triangulate(&square[..3]).triangles, [[0, 1, 2]]);
    for few in 0..3 {
        assert_eq!(triangulate(&square[..few]), Triangulation::default());
    }
}

#[test]
fn convex_polygons_of_any_size_are_tiled() {
    for n in 3..60 {
        assert_tiled(&circle(n, |_| 1.0));
    }
    assert_tiled(&circle(1000, |_| 1.0));
}

#[test]
fn concave_polygons_are_tiled() {
    assert_tiled(&polygon(&[(0.0, 0.0), (2.0, 2.0), (0.0, 1.0), (-2.0, 2.0)]));
    assert_tiled(&polygon(&[
        (0.0, 0.0),
        (3.0, 0.0),
        (3.0, 3.0),
        (2.0, 3.0),
        (2.0, 1.0),
        (0.0, 1.0),
    ]));
    assert_tiled(&spiral(200, 5.0));
    for angle in [0.0, 0.3, TAU / 8.0] {
        assert_tiled(&comb(50, angle));
    }
}

#[test]
fn random_star_shaped_polygons_are_tiled() {
    let mut random = Random::new(1);
    for n in (4..40).chain([500]) {
        for _ in 0..20 {
            assert_tiled(&circle(n, |_| 0.05 + random.unit()));
        }
    }
}

#[test]
fn points_on_straight_edges_belong_to_triangles_with_area() {
    let n = 16;
    let side = |from: DVec2, to: DVec2| {
        (0..n).map(move |i| from + (to - from) * f64::from(i) / f64::from(n))
    };
    let corners = polygon(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]);
    let square: Vec<DVec2> = corners_of(&corners)
        .flat_map(|[_, a, b]| side(a, b))
        .collect();
    assert_tiled(&square);
    assert_tiled(&polygon(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (1.0, 3.0)]));
}

#[test]
fn a_hole_joined_by_a_bridge_stays_open() {
    let square = polygon(&[
        (0.0, 0.0),
        (4.0, 0.0),
        (4.0, 4.0),
        (0.0, 4.0),
        (0.0, 0.0),
        (1.0, 1.0),
        (1.0, 3.0),
        (3.0, 3.0),
        (3.0, 1.0),
        (1.0, 1.0),
    ]);
    assert_tiled(&square);
}

#[test]
fn a_polygon_that_touches_itself_is_covered() {
    let cases = [
        // A tooth that reaches the opposite side.
        polygon(&[
            (0.0, 0.0),
            (4.0, 0.0),
            (4.0, 3.0),
            (3.0, 3.0),
            (2.0, 0.0),
            (1.0, 3.0),
            (0.0, 3.0),
        ]),
        // Two teeth back to back in a groove: a corner at the tip of what is no ear.
        polygon(&[
            (0.0, 1.0),
            (2.0, 0.0),
            (4.0, 1.0),
            (4.0, 3.0),
            (3.0, 3.0),
            (2.0, 0.0),
            (1.0, 3.0),
            (0.0, 3.0),
        ]),
        // Two squares that meet in a corner, walked as one.
        polygon(&[
            (0.0, 0.0),
            (1.0, 0.0),
            (1.0, 1.0),
            (2.0, 1.0),
            (2.0, 2.0),
            (1.0, 2.0),
            (1.0, 1.0),
            (0.0, 1.0),
        ]),
        // The tooth reaches a corner.
        polygon(&[
            (0.0, 0.0),
            (2.0, 0.0),
            (4.0, 0.0),
            (4.0, 3.0),
            (3.0, 3.0),
            (2.0, 0.0),
            (1.0, 3.0),
            (0.0, 3.0),
        ]),
        // A spike, and a point said twice.
        polygon(&[
            (0.0, 0.0),
            (2.0, 0.0),
            (3.0, 0.0),
            (2.0, 0.0),
            (2.0, 2.0),
            (2.0, 2.0),
            (0.0, 2.0),
        ]),
        // A slit.
        polygon(&[
            (0.0, 0.0),
            (2.0, 0.0),
            (1.0, 1.0),
            (2.0, 0.0),
            (2.0, 2.0),
            (0.0, 2.0),
        ]),
    ];
    for points in cases {
        for corners in placements(&points) {
            assert_covered(&corners);
        }
    }
}

#[test]
fn polygons_that_cross_themselves_are_reported() {
    let pentagram: Vec<DVec2> = (0..5).map(|i| circle(5, |_| 1.0)[2 * i % 5]).collect();
    let cases = [
        (
            "bow tie",
            polygon(&[(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 1.0)]),
        ),
        (
            "even bow tie",
            polygon(&[(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)]),
        ),
        ("pentagram", pentagram),
    ];
    for (name, points) in cases {
        for corners in placements(&points) {
            let cut = triangulate(&corners);
            assert!(cut.crosses_itself, "{name}");
            assert_eq!(cut.triangles.len(), corners.len() - 2);
        }
    }
}

#[test]
fn repeated_points_and_lines_give_triangles_without_area() {
    let line: Vec<DVec3> = (0..9)
        .map(|i| DVec3::new(0.1, 0.7, 0.3) * f64::from(i % 5))
        .collect();
    assert_eq!(triangulate(&line).triangles.len(), 7);
    assert_eq!(triangulate(&[DVec3::ONE; 6]).triangles.len(), 4);
}

/// The outer border of a random figure of unit squares, with every grid point on it, counter-clockwise.
///
/// Many figures touch themselves in corners, where the border keeps to its square or crosses over to the next.
fn polyomino(squares: usize, random: &mut Random, keeps_left: bool) -> Vec<DVec2> {
    let directions = [(1, 0), (0, 1), (-1, 0), (0, -1)];
    let mut figure = vec![(0, 0)];
    while figure.len() < squares {
        let (x, y) = figure[below(random, figure.len())];
        let (dx, dy) = directions[below(random, 4)];
        if !figure.contains(&(x + dx, y + dy)) {
            figure.push((x + dx, y + dy));
        }
    }
    let is_in = |x: i32, y: i32| figure.contains(&(x, y));
    // The square to the left of the edge that leaves a grid point in a direction is in, the one to the right is not.
    let is_border = |(x, y): (i32, i32), direction: usize| match direction {
        0 => is_in(x, y) && !is_in(x, y - 1),
        1 => is_in(x - 1, y) && !is_in(x, y),
        2 => is_in(x - 1, y - 1) && !is_in(x - 1, y),
        _ => is_in(x, y - 1) && !is_in(x - 1, y - 1),
    };
    let start = *figure.iter().min().expect("at least one square");
    let (mut point, mut direction) = (start, 0);
    let mut border = Vec::new();
    loop {
        border.push(DVec2::new(f64::from(point.0), f64::from(point.1)));
        let (dx, dy) = directions[direction];
        point = (point.0 + dx, point.1 + dy);
        let turns = if keeps_left { [1, 0, 3] } else { [3, 0, 1] };
        let mut next = turns.iter().map(|turn| (direction + turn) % 4);
        direction = next
            .find(|&next| is_border(point, next))
            .expect("a border is closed");
        if (point, direction) == (start, 0) {
            return border;
        }
    }
}

#[test]
fn figures_of_squares_are_covered_even_where_they_touch_themselves() {
    let mut random = Random::new(9);
    for round in 0..600 {
        let border = polyomino(1 + round % 60, &mut random, round % 2 == 0);
        let mut places: Vec<_> = border
            .iter()
            .map(|p| (p.x.to_bits(), p.y.to_bits()))
            .collect();
        places.sort_unstable();
        places.dedup();
        if places.len() == border.len() {
            assert_tiled(&border);
        } else {
            let corners: Vec<DVec3> = border.iter().map(|p| p.extend(1.0)).collect();
            assert_covered(&corners);
        }
    }
}

#[test]
fn any_points_at_all_give_n_minus_2_triangles() {
    let mut random = Random::new(3);
    for round in 0..3000_u32 {
        let n = 3 + round % 40;
        // On a coarse grid many points coincide or lie on lines.
        let coarse = if round % 2 == 0 { 4.0 } else { 1e6 };
        let scale = [1.0, 1e-320, 1e300, f64::MAX][(round % 4) as usize];
        let mut coordinate = || ((random.unit() * coarse).floor() / coarse - 0.5) * scale;
        let corners: Vec<DVec3> = (0..n)
            .map(|_| DVec3::new(coordinate(), coordinate(), coordinate()))
            .collect();
        let cut = triangulate(&corners);
        assert_eq!(cut.triangles.len(), corners.len() - 2);
        assert!(cut.triangles.iter().flatten().all(|&corner| corner < n));
    }
}

/// A star of triangles around one point, which every third corner shares, counter-clockwise over `angle` from +X.
fn fan(triangles: u32, angle: f64) -> Vec<DVec2> {
    let at = |angle: f64| DVec2::new(libm::cos(angle), libm::sin(angle));
    let step = angle / f64::from(triangles);
    (0..triangles)
        .flat_map(|i| {
            let start = step * f64::from(i);
            [DVec2::ZERO, at(start), at(start + 0.9 * step)]
        })
        .collect()
}

/// Half a fan, and the other half with its triangles in clockwise order: at the point they share, as many corners turn left
/// as right, and no edge of one half leads into a corner of the other.
fn twisted_fan(triangles: u32) -> Vec<DVec2> {
    let mut corners = fan(triangles / 2, 0.5 * TAU);
    let turned = fan(triangles / 2, 0.5 * TAU);
    for triangle in turned.chunks(3).rev() {
        corners.extend(triangle.iter().map(|&corner| -corner));
    }
    corners
}

#[test]
fn many_corners_on_few_points_are_covered() {
    for triangles in [2, 3, 10, 31] {
        assert_covered(
            &fan(triangles, TAU)
                .iter()
                .map(|p| p.extend(0.0))
                .collect::<Vec<_>>(),
        );
    }
}

/// Counts what time goes into: visits of nodes, at worst about √n for each of at most 3 n questions.
#[test]
fn a_hundred_thousand_corners_take_no_time_to_speak_of() {
    let n = 100_000;
    let mut random = Random::new(5);
    let mut anywhere = |side: f64| -> Vec<DVec2> {
        let mut coordinate = || {
            let unit = random.unit();
            if side > 0.0 {
                (unit * side).floor()
            } else {
                unit
            }
        };
        (0..n)
            .map(|_| DVec2::new(coordinate(), coordinate()))
            .collect()
    };
    let (noise, lattice, coarse_lattice) = (anywhere(0.0), anywhere(100.0), anywhere(3.0));
    let cases = [
        ("circle", circle(n, |_| 1.0)),
        ("ragged circle", circle(n, |_| 0.5 + random.unit())),
        ("spiral", spiral(n / 2, 100.0)),
        ("comb", comb(n / 2, 0.0)),
        ("slanted comb", comb(n / 2, 0.7)),
        ("noise", noise),
        ("a hundred lines of a hundred points", lattice),
        ("nine points", coarse_lattice),
        ("one point", vec![DVec2::ONE; n as usize]),
        ("fan", fan(n / 3, TAU)),
        ("twisted fan", twisted_fan(n / 3)),
    ];
    for (name, points) in cases {
        let corners: Vec<DVec3> = points.iter().map(|p| p.extend(0.0)).collect();
        blockers::VISITS.set(0);
        let cut = triangulate(&corners);
        let visits = blockers::VISITS.get();
        assert_eq!(cut.triangles.len(), corners.len() - 2);
        let questions = 3.0 * points.len() as f64;
        assert!(
            (visits as f64) < 2.0 * questions * (points.len() as f64).sqrt(),
            "{name}: {visits} visits"
        );
    }
}
