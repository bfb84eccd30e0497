//! Where nodes are in the world.

use super::accessor::beyond;
use super::document::{Document, Index, Node};
use crate::geometry::{TriangleMesh, face_normal};
use crate::io::mesh_reading::{List, Malformed, Place};
use crate::math::{DMat3, DVec3};
use crate::scene::{Object, rotation_degrees};

/// `p ↦ linear · p + translate`, of any kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// Any linear map, a flat one too.
    pub linear: DMat3,
    /// Applied last.
    pub translate: DVec3,
}

impl Affine {
    const IDENTITY: Self = Self {
        linear: DMat3::IDENTITY,
        translate: DVec3::ZERO,
    };

    /// First `inner`, then this.
    fn after(&self, inner: &Self) -> Self {
        Self {
            linear: self.linear * inner.linear,
            translate: self.linear * inner.translate + self.translate,
        }
    }

    fn is_finite(&self) -> bool {
        self.linear.is_finite() && self.translate.is_finite()
    }

    fn of_node(node: &Node) -> Self {
        if let Some(matrix) = &node.matrix {
            let column = |i: usize| DVec3::new(matrix[4 * i], matrix[4 * i + 1], matrix[4 * i + 2]);
            return Self {
                linear: DMat3::from_cols(column(0), column(1), column(2)),
                translate: column(3),
            };
        }
        let scale = DVec3::from_array(node.scale.unwrap_or([1.0; 3]));
        Self {
            linear: rotation(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]))
                * DMat3::from_diagonal(scale),
            translate: DVec3::from_array(node.translation.unwrap_or_default()),
        }
    }
}

/// The rotation of a quaternion of any length; none where it has none.
fn rotation([x, y, z, w]: [f64; 4]) -> DMat3 {
    let length_squared = x * x + y * y + z * z + w * w;
    if length_squared == 0.0 {
        return DMat3::IDENTITY;
    }
    let s = 2.0 / length_squared;
    DMat3::from_cols(
        DVec3::new(
            1.0 - s * (y * y + z * z),
            s * (x * y + z * w),
            s * (x * z - y * w),
        ),
        DVec3::new(
            s * (x * y - z * w),
            1.0 - s * (x * x + z * z),
            s * (y * z + x * w),
        ),
        DVec3::new(
            s * (x * z + y * w),
            s * (y * z - x * w),
            1.0 - s * (x * x + y * y),
        ),
    )
}

/// A node of the scene and where it is.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    pub node: Index,
    pub world: Affine,
}

/// The nodes of the document's scene, parents before their children, in the order of the file. Where there are no scenes, those
/// of all nodes without parent.
///
/// # Errors
/// A node that is not there, that comes twice, or that is nowhere.
pub fn placed_nodes(document: &Document) -> Result<Vec<Placed>, Malformed> {
    let nodes = &document.nodes;
    let scenes = &document.scenes;
    let roots: Vec<Index> = if scenes.is_empty() {
        let mut has_parent = vec![false; nodes.len()];
        for &child in nodes.iter().flat_map(|node| &node.children) {
            if let Some(has_parent) = has_parent.get_mut(child as usize) {
                *has_parent = true;
            }
        }
        (0..)
            .zip(has_parent)
            .filter(|(_, has_parent)| !has_parent)
            .map(|(node, _)| node)
            .collect()
    } else {
        let scene = document.scene.unwrap_or(0);
        let record = scenes
            .get(scene as usize)
            .ok_or_else(|| beyond(List::Scenes, scene, scenes.len()))?;
        record.nodes.clone()
    };
    let mut is_placed = vec![false; nodes.len()];
    let mut placed = Vec::new();
    let mut waiting: Vec<(Index, Affine)> = roots
        .into_iter()
        .rev()
        .map(|node| (node, Affine::IDENTITY))
        .collect();
    while let Some((index, parent)) = waiting.pop() {
        let node = nodes
            .get(index as usize)
            .ok_or_else(|| beyond(List::Nodes, index, nodes.len()))?;
        let place = Place::Item(List::Nodes, index);
        if std::mem::replace(&mut is_placed[index as usize], true) {
            return Err(Malformed::at(
                place,
                "a node with one parent",
                "another one",
            ));
        }
        let world = parent.after(&Affine::of_node(node));
        if !world.is_finite() {
            return Err(Malformed::at(
                place,
                "a transform of finite numbers",
                "others",
            ));
        }
        placed.push(Placed { node: index, world });
        waiting.extend(node.children.iter().rev().map(|&child| (child, world)));
    }
    Ok(placed)
}

/// How far columns may be from equal length and right angles, relative to their length: numbers in files have 24 bits.
const TOLERANCE: f64 = 1e-6;
/// Angles, in degrees, within which a rotation is taken for quarter turns.
const QUARTER_TOLERANCE: f64 = 5e-6;

impl Affine {
    /// Scale, rotation and translation of an object that is placed so; `None` where no such three do it.
    #[must_use]
    pub fn as_object(&self) -> Option<Object> {
        let columns = [self.linear.x_axis, self.linear.y_axis, self.linear.z_axis];
        let lengths = columns.map(DVec3::length);
        let size = libm::cbrt(lengths[0] * lengths[1] * lengths[2]);
        if !size.is_finite() || size <= f64::MIN_POSITIVE {
            return None;
        }
        let is_even = lengths
            .iter()
            .all(|length| (length - size).abs() <= TOLERANCE * size);
        let [x, y, z] = columns.map(|column| column / size);
        let is_square = [x.dot(y), y.dot(z), z.dot(x)]
            .iter()
            .all(|cosine| cosine.abs() <= TOLERANCE);
        if !is_even || !is_square {
            return None;
        }
        let is_mirrored = x.cross(y).dot(z) < 0.0;
        let scale = if (size - 1.0).abs() < TOLERANCE * 1e-3 {
            1.0
        } else {
            size
        };
        let scale = if is_mirrored { -scale } else { scale };
        let rotate = rotation_degrees(&(self.linear * scale.recip())).map(|degrees| {
            let quarter = (degrees / 90.0).round() * 90.0;
            if (degrees - quarter).abs() < QUARTER_TOLERANCE {
                quarter + 0.0
            } else {
                degrees
            }
        });
        Some(Object {
            scale,
            rotate,
            translate: self.translate,
            ..Object::default()
        })
    }

    /// The mesh moved by this, its triangles facing the same way; those that lose their area are dropped. `None` where coordinates
    /// become infinite.
    #[must_use]
    pub fn apply(&self, mesh: &TriangleMesh) -> Option<TriangleMesh> {
        let moved = |&position: &DVec3| self.linear * position + self.translate;
        let positions: Vec<DVec3> = mesh.positions.iter().map(moved).collect();
        if !positions.iter().all(|position| position.is_finite()) {
            return None;
        }
        let [x, y, z] = [self.linear.x_axis, self.linear.y_axis, self.linear.z_axis];
        // Normals go by the inverse transposed, here times the determinant, which may be 0.
        let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
        let is_mirrored = x.cross(y).dot(z) < 0.0;
        let sign = if is_mirrored { -1.0 } else { 1.0 };
        let turned = |&normal: &DVec3| {
            let turned = (cofactors * normal * sign).normalize_or_zero() * normal.length();
            if turned.is_finite() {
                turned
            } else {
                DVec3::ZERO
            }
        };
        let triangle = |&[a, b, c]: &[u32; 3]| if is_mirrored { [a, c, b] } else { [a, b, c] };
        let has_area = |triangle: &[u32; 3]| {
            face_normal(triangle.map(|vertex| positions[vertex as usize])).is_some()
        };
        let triangles = mesh
            .triangles
            .iter()
            .map(triangle)
            .filter(has_area)
            .collect();
        Some(TriangleMesh {
            triangles,
            normals: mesh
                .normals
                .as_ref()
                .map(|normals| normals.iter().map(turned).collect()),
            positions,
            texture_coordinates: mesh.texture_coordinates.clone(),
            colors: mesh.colors.clone(),
        })
    }
}
