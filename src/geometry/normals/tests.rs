use super::*;
use crate::geometry::shapes::{cuboid, icosphere as sphere};
use crate::math::{DVec2, power_of_two};

fn normals_of(mesh: &TriangleMesh, crease: Degrees) -> CornerNormals {
    corner_normals(mesh, crease, &CancelToken::new()).expect("nobody cancels")
}

/// A cube of edge 2 around the origin, two triangles per side.
fn cube() -> TriangleMesh {
    cuboid(DVec3::NEG_ONE, DVec3::ONE)
}

fn scaled(mesh: &TriangleMesh, factor: f64) -> TriangleMesh {
    let positions = mesh.positions.iter().map(|p| *p * factor).collect();
    TriangleMesh {
        positions,
        ..mesh.clone()
    }
}

/// A sphere whose triangles share no vertex, as each lies elsewhere on its image, has the normals of one whose triangles do.
#[test]
fn seams_of_images_are_not_seen_in_normals() {
    let whole = sphere(2);
    let corners = whole.triangles.iter().flatten();
    let mut apart = TriangleMesh {
        positions: corners.map(|&v| whole.positions[v as usize]).collect(),
        triangles: whole.triangles.clone(),
        ..TriangleMesh::default()
    };
    let mut next = 0..;
    for corner in apart.triangles.iter_mut().flatten() {
        *corner = next.next().expect("has no end");
    }
    apart.texture_coordinates = Some(vec![DVec2::ZERO; apart.positions.len()]);
    assert_eq!(per_corner(&apart, 180.0), per_corner(&whole, 180.0));
    apart.texture_coordinates = None;
    assert_ne!(per_corner(&apart, 180.0), per_corner(&whole, 180.0));
}

/// The normal of each corner, after checking that all are unit vectors.
fn per_corner(mesh: &TriangleMesh, crease: f64) -> Vec<[DVec3; 3]> {
    let shading = normals_of(mesh, Degrees(crease));
    for normal in &shading.normals {
        assert!((normal.length() - 1.0).abs() < 1e-14, "{normal}");
    }
    let corners = shading.corners.iter();
    corners
        .map(|corner| corner.map(|id| shading.normals[id as usize]))
        .collect()
}

fn assert_flat(mesh: &TriangleMesh, crease: f64) {
    for (triangle, normals) in per_corner(mesh, crease).iter().enumerate() {
        let face = face_normal(mesh.corners(triangle)).expect("an area");
        assert!(normals.iter().all(|n| n.distance(face) < 1e-14));
    }
}

#[test]
fn a_cube_is_flat_up_to_89_degrees_and_round_from_91() {
    let cube = cube();
    for crease in [0.0, 30.0, 89.9, -5.0, f64::NAN] {
        assert_flat(&cube, crease);
    }
    // The two triangles of a side share their normals: 6 sides of 4 corners.
    assert_eq!(normals_of(&cube, Degrees(30.0)).normals.len(), 24);
    for crease in [90.1, 180.0, 1000.0] {
        let normals = per_corner(&cube, crease);
        for (triangle, corners) in cube.triangles.iter().zip(normals) {
            for (&vertex, normal) in triangle.iter().zip(corners) {
                // By symmetry along the diagonal, although some sides have two triangles there and some one.
                let diagonal = cube.positions[vertex as usize] / 3.0_f64.sqrt();
                assert!(normal.distance(diagonal) < 1e-14, "{normal} {diagonal}");
            }
        }
        assert_eq!(normals_of(&cube, Degrees(crease)).normals.len(), 8);
    }
}

#[test]
fn normals_of_a_sphere_are_nearly_radial() {
    let sphere = sphere(4);
    assert_eq!(sphere.triangles.len(), 20 * 256);
    for (triangle, normals) in per_corner(&sphere, 30.0).iter().enumerate() {
        let radial = sphere.corners(triangle);
        for (normal, radial) in normals.iter().zip(radial) {
            assert!(normal.distance(radial) < 4e-3, "{normal} {radial}");
        }
    }
    let shading = normals_of(&sphere, Degrees(30.0));
    assert_eq!(shading.normals.len(), sphere.positions.len());
}

#[test]
fn scale_changes_nothing() {
    let sphere = sphere(2);
    let base = normals_of(&sphere, Degrees(40.0));
    for exponent in [-900, -60, 60, 900] {
        let factor = power_of_two(exponent);
        assert_eq!(normals_of(&scaled(&sphere, factor), Degrees(40.0)), base);
    }
    for factor in [1e-300, 1e-20, 1e20, 1e300, f64::MAX] {
        let shading = normals_of(&scaled(&sphere, factor), Degrees(40.0));
        assert_eq!(shading.corners, base.corners);
        for (normal, expected) in shading.normals.iter().zip(&base.normals) {
            assert!(normal.distance(*expected) < 1e-12, "{factor}");
        }
    }
}

#[test]
fn a_sliver_has_a_normal_and_a_line_has_none() {
    let sliver = |height: f64| [DVec3::ZERO, DVec3::X, DVec3::new(0.5, height, 0.0)];
    for height in [1e-6, 1e-12, 1e-200] {
        let normal = face_normal(sliver(height)).expect("an area");
        assert!(normal.distance(DVec3::Z) < 1e-9, "{height}");
    }
    assert_eq!(face_normal(sliver(0.0)), None);
    let point = DVec3::new(0.1, 0.2, 0.3);
    assert_eq!(face_normal([point; 3]), None);
    let (far, apart) = (DVec3::X * 1e308, DVec3::new(1e308, 0.0, 1e-308));
    assert_eq!(face_normal([far, far, apart]), None);
    assert_eq!(
        face_normal([far, apart, DVec3::new(1e308, 1e-308, 0.0)]),
        Some(DVec3::NEG_X)
    );
    assert_eq!(face_normal([point, point, DVec3::X]), None);
    // 3 · 0.1 is not 0.3 in binary; as decimals the points are on a line.
    assert_eq!(
        face_normal([DVec3::ZERO, point, DVec3::new(0.3, 0.6, 0.9)]),
        None
    );
}

#[test]
fn faces_back_to_back_keep_their_own_normals() {
    let mesh = TriangleMesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        triangles: vec![[0, 1, 2], [0, 2, 1]],
        ..TriangleMesh::default()
    };
    for crease in [0.0, 90.0, 180.0] {
        let normals = per_corner(&mesh, crease);
        assert_eq!(normals, [[DVec3::Z; 3], [DVec3::NEG_Z; 3]], "{crease}");
    }
}

#[test]
fn a_face_that_is_there_twice_counts_once() {
    let clean = sphere(1);
    let mut repeated = clean.clone();
    for (index, &[a, b, c]) in clean.triangles.iter().enumerate() {
        let again = [[a, b, c], [b, c, a], [a, c, b]];
        repeated.triangles.extend(&again[..index % 4]);
    }
    assert!(repeated.triangles.len() > 2 * clean.triangles.len());
    for crease in [0.0, 25.0, 40.0, 180.0] {
        let expected = per_corner(&clean, crease);
        let found = per_corner(&repeated, crease);
        assert_eq!(found[..expected.len()], expected, "{crease}");
    }
}

#[test]
fn a_triangle_without_area_takes_a_neighbours_normal_or_up() {
    let mesh = TriangleMesh {
        positions: vec![
            DVec3::ZERO,
            DVec3::X,
            DVec3::Y,
            DVec3::X * 2.0,
            DVec3::X * 3.0,
        ],
        triangles: vec![[0, 1, 3], [0, 2, 1], [3, 4, 4]],
        ..TriangleMesh::default()
    };
    for crease in [30.0, 180.0] {
        let normals = per_corner(&mesh, crease);
        assert_eq!(normals[0], [DVec3::NEG_Z, DVec3::NEG_Z, DVec3::Z]);
        assert_eq!(normals[2], [DVec3::Z; 3]);
    }
}

#[test]
fn the_files_normals_win_where_they_are_not_zero() {
    let mut cube = cube();
    let own = DVec3::new(1.0, 2.0, 3.0);
    let mut normals = vec![own * 1e200; 8];
    normals[0] = DVec3::ZERO;
    normals[1] = own * 5e-324;
    cube.normals = Some(normals);
    let shading = per_corner(&cube, 30.0);
    for (triangle, corners) in cube.triangles.iter().zip(shading) {
        let face = face_normal(triangle.map(|v| cube.positions[v as usize])).expect("an area");
        for (&vertex, normal) in triangle.iter().zip(corners) {
            let expected = match vertex {
                0 => face,
                1 => DVec3::new(1.0, 2.0, 3.0) / 14.0_f64.sqrt(),
                _ => own / own.length(),
            };
            assert!(normal.distance(expected) < 1e-14, "vertex {vertex}");
        }
    }
}

/// Pages of a book: thirty faces meet in one edge, neighbours 12° apart.
#[test]
fn many_faces_at_one_edge_join_their_neighbours() {
    let pages = 30;
    let mut mesh = TriangleMesh {
        positions: vec![DVec3::ZERO, DVec3::Z],
        ..TriangleMesh::default()
    };
    // The pages are not in the order of their angle.
    for page in (0..pages).map(|page| page * 7 % pages) {
        let angle = Degrees(f64::from(page) * 12.0).radians();
        mesh.positions
            .push(DVec3::new(libm::cos(angle), libm::sin(angle), 0.5));
        let outer = u32::try_from(mesh.positions.len() - 1).expect("few");
        mesh.triangles.push([0, outer, 1]);
    }
    assert_flat(&mesh, 11.0);
    // From 13° on, all join in a ring whose average vanishes.
    assert_flat(&mesh, 13.0);
    mesh.triangles.retain(|&[_, outer, _]| {
        let page = mesh.positions[outer as usize];
        page.x > 0.5
    });
    let normals = normals_of(&mesh, Degrees(13.0)).normals;
    assert_eq!(normals.len(), 2 + mesh.triangles.len());
    assert!(normals[0].distance(DVec3::NEG_Y) < 1e-12, "{}", normals[0]);
}

#[test]
fn an_empty_mesh_and_unused_vertices_have_no_normals() {
    let mut mesh = TriangleMesh::default();
    assert_eq!(normals_of(&mesh, Degrees(30.0)), CornerNormals::default());
    mesh.positions = vec![DVec3::ONE; 3];
    mesh.normals = Some(vec![DVec3::ONE; 3]);
    assert_eq!(normals_of(&mesh, Degrees(30.0)), CornerNormals::default());
}

#[test]
fn there_are_no_normals_when_cancelled() {
    let cancel = CancelToken::new();
    cancel.cancel();
    assert_eq!(corner_normals(&cube(), Degrees(30.0), &cancel), None);
}
