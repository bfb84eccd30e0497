//! The triangles of a scene as one PLY mesh in world units, for other ray tracers to be measured on.

use std::io::{self, Write};
use std::sync::Arc;

use crate::geometry::TriangleMesh;
use crate::io::ply;
use crate::math::DVec3;
use crate::scene::{Object, Scene, SceneError};

/// Writes all triangles of the scene, copies too, as a PLY file in world units ([`ply::write_triangles`]): in the order of the prepared
/// scene's triangles, corners counter-clockwise seen from outside.
///
/// # Errors
/// What `out` returns, and that there are too many vertices.
///
/// # Panics
/// When a mesh of the scene is not loaded; a prepared scene's are.
pub fn write_mesh(scene: &Scene, out: &mut dyn Write) -> io::Result<()> {
    let placed: Vec<(&Object, Arc<TriangleMesh>)> = scene
        .objects
        .iter()
        .map(|object| Ok((object, scene.shown_mesh_of(object)?)))
        .collect::<Result<_, SceneError>>()
        .expect("meshes are loaded");
    let total = |count: fn(&TriangleMesh) -> usize| {
        let of_object = |(object, mesh): &(&Object, Arc<TriangleMesh>)| {
            object.copies.total().saturating_mul(count(mesh) as u64)
        };
        placed.iter().map(of_object).fold(0, u64::saturating_add)
    };
    let vertices = placed.iter().flat_map(|(object, mesh)| {
        let placement = object.placement();
        let in_world = move |&p: &DVec3| placement.world_from_object(p);
        let in_world: Vec<_> = mesh.positions.iter().map(in_world).collect();
        let copy = move |offset| in_world.clone().into_iter().map(move |p| p + offset);
        object.copies.offsets().flat_map(copy)
    });
    let mut first = 0_u32;
    let faces = placed.iter().flat_map(|(object, mesh)| {
        let is_mirrored = object.placement().linear.determinant() < 0.0;
        let count = u32::try_from(mesh.positions.len()).unwrap_or(u32::MAX);
        let start = first;
        // Within what was counted before anything is written.
        let copies = u32::try_from(object.copies.total()).unwrap_or(u32::MAX);
        first = first.saturating_add(count.saturating_mul(copies));
        (0..copies).flat_map(move |copy| {
            mesh.triangles.iter().map(move |&[a, b, c]| {
                let corners = if is_mirrored { [a, c, b] } else { [a, b, c] };
                corners.map(|corner| start + copy * count + corner)
            })
        })
    });
    ply::write_triangles(
        (
            total(|mesh| mesh.positions.len()),
            vertices.map(|p| p.as_vec3().to_array()),
        ),
        (total(|mesh| mesh.triangles.len()), faces),
        out,
    )
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::control::CancelToken;
    use crate::geometry::shapes;
    use crate::math::Vec3;
    use crate::render::PreparedScene;
    use crate::scene::Copies;

    /// The file's triangles are the prepared scene's, in their order and orientation, back in the world.
    #[test]
    fn the_file_holds_what_rays_meet() {
        let mut scene = Scene::default();
        scene
            .meshes
            .insert("ball".into(), Arc::new(shapes::icosphere(1)));
        scene
            .meshes
            .insert("soup".into(), Arc::new(shapes::soup(9, 0.3, 1)));
        let object = |mesh: &str, scale: f64| Object {
            name: mesh.into(),
            mesh: mesh.into(),
            scale,
            rotate: DVec3::new(10.0, 20.0, 30.0),
            ..Object::default()
        };
        scene.objects = vec![
            object("soup", -0.5),
            Object {
                copies: Copies {
                    count: [2, 1, 3],
                    step: DVec3::new(3.0, 0.0, 2.5),
                },
                ..object("ball", 1.5)
            },
            object("soup", 2.0),
        ];
        let mut bytes = Vec::new();
        write_mesh(&scene, &mut bytes).expect("a vector takes all");

        let end = b"end_header\n";
        let start = bytes.windows(end.len()).position(|part| part == end);
        let data = &bytes[start.expect("there is an end") + end.len()..];
        let vertex_count = 9 * 3 + 6 * scene.meshes["ball"].positions.len() + 9 * 3;
        let (vertices, faces) = data.split_at(12 * vertex_count);
        let vertex = |bytes: &[u8]| -> DVec3 {
            let [x, y, z] = [0, 1, 2].map(|i| f32::from_le_bytes(bytes.as_chunks().0[i]));
            Vec3::new(x, y, z).as_dvec3()
        };
        let vertices: Vec<_> = vertices.chunks(12).map(vertex).collect();

        let prepared = PreparedScene::prepare(&scene, None, &CancelToken::new());
        let prepared = prepared.expect("is right").expect("nobody cancels");
        let (geometry, faces) = (prepared.geometry(), faces.chunks(13));
        assert_eq!(faces.len() as u64, scene.triangle_count());
        for (id, face) in (0..).zip(faces) {
            let corners = geometry.triangle(id).in_scene().corners;
            for (corner, index) in corners.iter().zip(face[1..].as_chunks().0) {
                let index = u32::from_le_bytes(*index) as usize;
                let expected = geometry.frame().world_from_prepared(corner.as_dvec3());
                assert!(vertices[index].abs_diff_eq(expected, 1e-5), "triangle {id}");
            }
        }
    }
}
