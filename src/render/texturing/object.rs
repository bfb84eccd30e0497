//! Textures at a hit: the part of an image that a ray's footprint covers gives the material and the normals there.

use std::sync::Arc;

use super::footprint::Footprint;
use super::pyramid::{Area, Pyramid};
use crate::accel::Hit;
use crate::geometry::TriangleMesh;
use crate::math::{DVec2, DVec3, Vec3};
use crate::render::geometry::PreparedGeometry;
use crate::render::phong::Phong;
use crate::render::surface::SurfacePoint;

/// An object over which something varies.
#[derive(Debug)]
pub struct TexturedObject {
    /// Its coordinates and colours.
    pub mesh: Arc<TriangleMesh>,
    /// Whether its placement mirrors it.
    pub is_mirrored: bool,
    /// What its diffuse reflectance is multiplied by.
    pub diffuse: Option<Arc<Pyramid>>,
    /// What its normals are turned by.
    pub normals: Option<Arc<Pyramid>>,
    /// Whether the colours of its vertices count.
    pub has_colors: bool,
}

/// A triangle in space and on an image.
struct Mapped {
    /// From the first corner to the others.
    edges: [DVec3; 2],
    /// The same on the image.
    edges_on_image: [DVec2; 2],
    /// The first corner on the image.
    first_on_image: DVec2,
}

impl TexturedObject {
    /// The material at `point`, which `hit` made, where that of the whole object is `phong`. The point's normals become those that the
    /// image says.
    pub fn at(
        &self,
        geometry: &PreparedGeometry,
        footprint: &Footprint,
        phong: &Phong,
        point: &mut SurfacePoint,
        hit: &Hit,
    ) -> Phong {
        let object = &geometry.objects()[point.object];
        let in_copy = (hit.triangle - object.triangles.start) % object.triangles_per_copy;
        let [a, b, c] = self.mesh.triangles[in_copy as usize];
        let corners = if self.is_mirrored {
            [a, c, b]
        } else {
            [a, b, c]
        };

        let mut color = Vec3::ONE;
        if self.has_colors
            && let Some(colors) = &self.mesh.colors
        {
            let [a, b, c] = corners.map(|corner| colors[corner as usize]);
            let [_, v, w] = hit.barycentrics;
            color = a + (b - a) * v + (c - a) * w;
        }
        if self.diffuse.is_some() || self.normals.is_some() {
            let in_scene = geometry.triangle(hit.triangle).in_scene().corners;
            if let Some(mapped) = self.mapped(corners, in_scene) {
                let area = mapped.area(footprint, point, hit.barycentrics);
                if let Some(image) = &self.diffuse {
                    color *= image.mean(&area);
                }
                if let Some((image, axes)) = self.normals.as_ref().zip(mapped.axes()) {
                    point.turn_normal(image.mean(&area), axes);
                }
            }
        }
        phong.with_diffuse(phong.diffuse * color)
    }

    /// The triangle of these `corners` of the mesh, which lie there `in_scene`; `None` where it is on no image.
    fn mapped(&self, corners: [u32; 3], in_scene: [Vec3; 3]) -> Option<Mapped> {
        let coordinates = self.mesh.texture_coordinates.as_ref()?;
        let on_image = corners.map(|corner| coordinates[corner as usize]);
        let in_scene = in_scene.map(Vec3::as_dvec3);
        Some(Mapped {
            edges: [in_scene[1] - in_scene[0], in_scene[2] - in_scene[0]],
            edges_on_image: [on_image[1] - on_image[0], on_image[2] - on_image[0]],
            first_on_image: on_image[0],
        })
    }
}

impl Mapped {
    /// What a ray that makes this point stands for on the image.
    fn area(&self, footprint: &Footprint, point: &SurfacePoint, weights: [f32; 3]) -> Area {
        let [_, v, w] = weights.map(f64::from);
        let [ab, ac] = self.edges_on_image;
        let middle = self.first_on_image + ab * v + ac * w;
        let normal = self.edges[0].cross(self.edges[1]);
        let sides = footprint.on_plane(point.distance, point.wo, normal);
        Area {
            middle,
            sides: sides.map(|side| self.on_image(side, normal)),
        }
    }

    /// A vector in the triangle's plane, on the image. `normal`: of the triangle, twice its area long. Not finite for a triangle without
    /// area.
    fn on_image(&self, vector: DVec3, normal: DVec3) -> DVec2 {
        let [ab, ac] = self.edges;
        let per_area = normal / normal.length_squared();
        let (v, w) = (
            vector.cross(ac).dot(per_area),
            ab.cross(vector).dot(per_area),
        );
        self.edges_on_image[0] * v + self.edges_on_image[1] * w
    }

    /// The directions in which the first and the second coordinate grow alone, of any length; `None` where the triangle is a line or a
    /// point on the image.
    fn axes(&self) -> Option<[DVec3; 2]> {
        let ([ab, ac], [on_ab, on_ac]) = (self.edges, self.edges_on_image);
        let determinant = on_ab.perp_dot(on_ac);
        let sign = determinant.signum();
        let first = (ab * on_ac.y - ac * on_ab.y) * sign;
        let second = (ac * on_ab.x - ab * on_ac.x) * sign;
        let usable = determinant != 0.0 && first.is_finite() && second.is_finite();
        usable.then_some([first, second])
    }
}
