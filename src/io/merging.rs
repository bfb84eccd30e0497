//! Objects as one mesh, for all that knows only meshes.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::gltf::Affine;
use crate::geometry::TriangleMesh;
use crate::math::{DVec2, Vec3};
use crate::memory::require;
use crate::scene::Object;

/// Bytes that a triangle takes.
const BYTES_PER_TRIANGLE: u64 = 12;
/// Bytes that a vertex takes with all that it may have.
const BYTES_PER_VERTEX: u64 = 24 + 24 + 16 + 12;

/// Objects as one mesh.
pub struct Merged {
    /// Their triangles where they are.
    pub mesh: TriangleMesh,
    /// The index of the first triangle of each object.
    pub firsts: Vec<usize>,
}

/// The objects as one mesh; of their grids of copies, the first counts. Normals are kept where all have them.
///
/// # Errors
/// That they are too many, in a plain sentence.
pub fn merge(
    objects: &[Object],
    meshes: &BTreeMap<String, Arc<TriangleMesh>>,
) -> Result<Merged, String> {
    let mesh_of = |object: &Object| meshes.get(&object.mesh);
    let all = || objects.iter().filter_map(mesh_of);
    let vertices: u64 = all().map(|mesh| mesh.positions.len() as u64).sum();
    let triangles: u64 = all().map(|mesh| mesh.triangles.len() as u64).sum();
    if vertices.max(triangles) > u64::from(u32::MAX / 2) {
        return Err(format!(
            "its objects have {triangles} triangles in all, too many for one mesh"
        ));
    }
    require(vertices * BYTES_PER_VERTEX + triangles * BYTES_PER_TRIANGLE)
        .map_err(|short| format!("its objects as one mesh take about {short}"))?;

    let has_normals = all().all(|mesh| mesh.normals.is_some());
    let has_textures = all().any(|mesh| mesh.texture_coordinates.is_some());
    let has_colors = all().any(|mesh| mesh.colors.is_some());
    let mut whole = TriangleMesh::default();
    let mut firsts = Vec::with_capacity(objects.len());
    let (mut normals, mut textures, mut colors) = (Vec::new(), Vec::new(), Vec::new());
    for object in objects {
        firsts.push(whole.triangles.len());
        let Some(mesh) = mesh_of(object) else {
            continue;
        };
        let placement = object.placement();
        let world = Affine {
            linear: placement.linear,
            translate: placement.translate,
        };
        let moved = world
            .apply(mesh)
            .ok_or("its objects reach beyond what numbers hold")?;
        let first = u32::try_from(whole.positions.len())
            .map_err(|_| "its objects have too many vertices")?;
        whole.positions.extend(moved.positions);
        let end = whole.positions.len();
        whole.triangles.extend(
            moved
                .triangles
                .iter()
                .map(|triangle| triangle.map(|vertex| first + vertex)),
        );
        if has_normals {
            normals.extend(moved.normals.into_iter().flatten());
        }
        if has_textures {
            textures.extend(moved.texture_coordinates.into_iter().flatten());
            textures.resize(end, DVec2::ZERO);
        }
        if has_colors {
            colors.extend(moved.colors.into_iter().flatten());
            colors.resize(end, Vec3::ONE);
        }
    }
    whole.normals = (has_normals && !normals.is_empty()).then_some(normals);
    whole.texture_coordinates = has_textures.then_some(textures);
    whole.colors = has_colors.then_some(colors);
    Ok(Merged {
        mesh: whole,
        firsts,
    })
}
