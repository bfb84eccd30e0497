//! Objects: a mesh, its placement, and the grid of its copies. Lengths are in scene units, angles in degrees.

use crate::geometry::TriangleMesh;
use crate::math::{DBounds, DMat3, DVec3, Degrees};

/// A placed mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// What people call it.
    pub name: String,
    /// The mesh, as the scene file names it: a path relative to that file, or `builtin:NAME`.
    pub mesh: String,
    /// Name of the material; `None` is the default material.
    pub material: Option<String>,
    /// Whether shading normals are interpolated (the mesh's own, else averaged by angle) or the faces are flat.
    pub smooth: bool,
    /// Edges whose faces meet at more than this angle stay sharp where `smooth` averages normals; 180° keeps none.
    pub crease_angle: Degrees,
    /// Whether triangles that turn the other way round than their neighbours, and closed surfaces that look inwards, are turned; see
    /// [`Winding`](crate::geometry::Winding).
    pub repair_winding: bool,
    /// Uniform scale, not 0.
    pub scale: f64,
    /// Degrees about X, then Y, then Z.
    pub rotate: DVec3,
    /// Moved by this, after scale and rotation.
    pub translate: DVec3,
    /// A grid of copies.
    pub copies: Copies,
}

impl Default for Object {
    fn default() -> Self {
        Self {
            name: String::new(),
            mesh: String::new(),
            material: None,
            smooth: false,
            crease_angle: Degrees(180.0),
            repair_winding: false,
            scale: 1.0,
            rotate: DVec3::ZERO,
            translate: DVec3::ZERO,
            copies: Copies::default(),
        }
    }
}

/// A grid of equal objects: copy `i` is moved by `i · step` per axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Copies {
    /// How many along X, Y and Z, each at least 1.
    pub count: [u32; 3],
    /// Distance between neighbours along each axis.
    pub step: DVec3,
}

impl Default for Copies {
    fn default() -> Self {
        Self {
            count: [1; 3],
            step: DVec3::ZERO,
        }
    }
}

impl Copies {
    /// Number of copies in the grid.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.count
            .iter()
            .fold(1, |total, &n| total.saturating_mul(u64::from(n)))
    }

    /// The displacement of every copy, x fastest.
    pub fn offsets(&self) -> impl Iterator<Item = DVec3> + use<> {
        let Self {
            count: [nx, ny, nz],
            step,
        } = *self;
        (0..nz).flat_map(move |k| {
            (0..ny).flat_map(move |j| {
                (0..nx).map(move |i| step * DVec3::new(f64::from(i), f64::from(j), f64::from(k)))
            })
        })
    }
}

/// `p ↦ linear · p + translate`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Rotation times uniform scale.
    pub linear: DMat3,
    /// Applied last.
    pub translate: DVec3,
}

impl Placement {
    /// The world position of an object point.
    #[must_use]
    pub fn world_from_object(&self, point: DVec3) -> DVec3 {
        self.linear * point + self.translate
    }
}

impl Object {
    /// Where the first copy is: `world = translate + Rz·Ry·Rx·(scale·p)`.
    #[must_use]
    pub fn placement(&self) -> Placement {
        let axis = |degrees: f64, rotation: fn(f64, f64) -> DMat3| {
            let (sin, cos) = sin_cos_degrees(degrees);
            rotation(sin, cos)
        };
        let rx = axis(self.rotate.x, |s, c| {
            DMat3::from_cols(DVec3::X, DVec3::new(0.0, c, s), DVec3::new(0.0, -s, c))
        });
        let ry = axis(self.rotate.y, |s, c| {
            DMat3::from_cols(DVec3::new(c, 0.0, -s), DVec3::Y, DVec3::new(s, 0.0, c))
        });
        let rz = axis(self.rotate.z, |s, c| {
            DMat3::from_cols(DVec3::new(c, s, 0.0), DVec3::new(-s, c, 0.0), DVec3::Z)
        });
        Placement {
            linear: rz * ry * rx * self.scale,
            translate: self.translate,
        }
    }

    /// The world box of all copies of `mesh` placed as this object says.
    #[must_use]
    pub fn bounds_of(&self, mesh: &TriangleMesh) -> DBounds {
        let placement = self.placement();
        let corners = mesh.triangles.iter().flatten();
        let first = DBounds::of_points(
            corners.map(|&v| placement.world_from_object(mesh.positions[v as usize])),
        );
        if first.is_empty() {
            return first;
        }
        // The box of a grid is spanned by its first and last copies.
        let last = self.copies.step
            * DVec3::from_array(self.copies.count.map(|n| f64::from(n.max(1) - 1)));
        first.union(DBounds {
            min: first.min + last,
            max: first.max + last,
        })
    }
}

/// The degrees about X, then Y, then Z by which an object is turned whose rotation is this matrix. Where Y is turned by a right angle, the
/// turn about Z is 0.
#[must_use]
pub fn rotation_degrees(rotation: &DMat3) -> DVec3 {
    const SMALLEST_COSINE: f64 = 1e-9;
    let [x_axis, y_axis, z_axis] = [rotation.x_axis, rotation.y_axis, rotation.z_axis];
    let cosine_of_y = libm::hypot(x_axis.x, x_axis.y);
    let y = libm::atan2(-x_axis.z, cosine_of_y);
    let (x, z) = if cosine_of_y > SMALLEST_COSINE {
        (
            libm::atan2(y_axis.z, z_axis.z),
            libm::atan2(x_axis.y, x_axis.x),
        )
    } else {
        (libm::atan2(-z_axis.y, y_axis.y), 0.0)
    };
    DVec3::new(x, y, z).map(f64::to_degrees)
}

/// Sine and cosine of an angle in degrees, exact at multiples of 90°, so that a quarter turn moves no vertex by a
/// rounding error; the same on every platform.
fn sin_cos_degrees(degrees: f64) -> (f64, f64) {
    let quarter_turns = (degrees / 90.0).round();
    let (sin, cos) = libm::sincos((degrees - quarter_turns * 90.0).to_radians());
    match quarter_turns.rem_euclid(4.0) {
        0.0 => (sin, cos),
        1.0 => (cos, -sin),
        2.0 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: DVec3, b: DVec3) -> bool {
        (a - b).length() < 1e-14
    }

    #[test]
    fn rotation_is_about_x_then_y_then_z() {
        let object = Object {
            rotate: DVec3::new(90.0, 90.0, 0.0),
            ..Object::default()
        };
        let placement = object.placement();
        // Y goes to Z by the first turn, Z to X by the second.
        assert_eq!(placement.world_from_object(DVec3::Y), DVec3::X);
        let object = Object {
            rotate: DVec3::new(30.0, 0.0, 90.0),
            scale: 2.0,
            translate: DVec3::X,
            ..Object::default()
        };
        let tilted = object.placement().world_from_object(DVec3::Y);
        assert!(close(
            tilted,
            DVec3::X + 2.0 * DVec3::new(-(0.75_f64.sqrt()), 0.0, 0.5)
        ));
    }

    #[test]
    fn a_rotation_is_told_in_degrees() {
        let turned = |rotate: DVec3| {
            let object = Object {
                rotate,
                ..Object::default()
            };
            object.placement().linear
        };
        for rotate in [
            DVec3::new(20.0, -35.0, 110.0),
            DVec3::new(-170.0, 80.0, -95.0),
            DVec3::new(30.0, 90.0, 40.0),
            DVec3::new(-30.0, -90.0, 0.0),
        ] {
            let rotation = turned(rotate);
            let again = turned(rotation_degrees(&rotation));
            assert!(again.abs_diff_eq(rotation, 1e-14), "{rotate}");
        }
        for quarter in [
            DVec3::new(90.0, 0.0, 0.0),
            DVec3::new(0.0, 0.0, -90.0),
            DVec3::ZERO,
        ] {
            assert_eq!(rotation_degrees(&turned(quarter)), quarter);
        }
    }

    #[test]
    fn quarter_turns_are_exact() {
        for (degrees, expected) in [
            (0.0, (0.0, 1.0)),
            (90.0, (1.0, 0.0)),
            (-90.0, (-1.0, 0.0)),
            (540.0, (0.0, -1.0)),
        ] {
            assert_eq!(sin_cos_degrees(degrees), expected, "{degrees}");
        }
        let (sin, cos) = sin_cos_degrees(200.0);
        assert!(
            (sin - 200_f64.to_radians().sin()).abs() < 1e-15
                && (cos - 200_f64.to_radians().cos()).abs() < 1e-15
        );
    }

    #[test]
    fn copies_fill_a_grid_and_its_box() {
        let mesh = TriangleMesh {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            triangles: vec![[0, 1, 2]],
            ..TriangleMesh::default()
        };
        let copies = Copies {
            count: [3, 2, 1],
            step: DVec3::new(2.0, -5.0, 1.0),
        };
        let offsets: Vec<_> = copies.offsets().collect();
        assert_eq!(offsets.len() as u64, copies.total());
        assert_eq!(offsets[1], DVec3::new(2.0, 0.0, 0.0));
        assert_eq!(offsets[5], DVec3::new(4.0, -5.0, 0.0));
        let bounds = Object {
            copies,
            ..Object::default()
        }
        .bounds_of(&mesh);
        assert_eq!(
            (bounds.min, bounds.max),
            (DVec3::new(0.0, -5.0, 0.0), DVec3::new(5.0, 1.0, 0.0))
        );
    }
}
