//! What one light is chosen from, by power: in mode `path` the lights of the scene and the triangles of emitting objects, in
//! mode `direct`, which sums the lights, the triangles alone.

use std::f64::consts::PI;

use super::alias::AliasTable;
use super::geometry::PreparedGeometry;
use super::light::{LightSample, PreparedLight};
use super::material::PreparedMaterial;
use crate::accel::AimingError;
use crate::geometry::Triangle;
use crate::math::{Ray, Vec2, Vec3, color::luminance, robust, warp};

/// The lights of a scene and how likely each is to be aimed at.
#[derive(Clone, Debug, Default)]
pub struct Emitters {
    items: Vec<Emitter>,
    table: AliasTable,
    /// What all of them emit.
    power: f64,
    /// For each object, the density per prepared area with which its points are aimed at; 0 for those that do not shine.
    pdf_area: Vec<f32>,
}

/// Something to aim at.
#[derive(Clone, Copy, Debug)]
enum Emitter {
    /// A light, by its number.
    Light(u32),
    /// A triangle of an emitting object.
    Triangle {
        triangle: Triangle,
        error: AimingError,
        area: f32,
        radiance: Vec3,
    },
}

/// A light aimed at.
#[derive(Clone, Copy, Debug)]
pub struct Aim {
    /// Its point and what that sends, divided by the probability of the choice.
    pub sample: LightSample,
    /// Density with which the direction was chosen, per steradian; `None` where no other strategy can find the light.
    pub pdf_solid_angle: Option<f32>,
    /// Number of the light, where it is one.
    pub light: Option<u32>,
}

impl Emitters {
    pub fn new(
        lights: &[PreparedLight],
        geometry: &PreparedGeometry,
        materials: &[PreparedMaterial],
    ) -> Self {
        let mut items = Vec::new();
        let mut powers = Vec::new();
        for (index, light) in (0..).zip(lights) {
            items.push(Emitter::Light(index));
            powers.push(light.power());
        }
        let lights_power: f64 = powers.iter().sum();
        let mut objects_power = 0.0;
        for (object, material) in geometry.objects().iter().zip(materials) {
            let PreparedMaterial::Emitter { radiance } = *material else {
                continue;
            };
            for index in object.triangles.clone() {
                let placed = geometry.triangle(index);
                let triangle = placed.in_scene();
                let area = triangle.area();
                items.push(Emitter::Triangle {
                    triangle,
                    error: placed.aiming_error(),
                    area,
                    radiance,
                });
                let power = power_per_area(radiance) * f64::from(area);
                powers.push(power);
                objects_power += power;
            }
        }
        let total = lights_power + objects_power;
        #[expect(clippy::cast_possible_truncation, reason = "rendering is f32")]
        let pdf_area = materials.iter().map(|material| match material {
            PreparedMaterial::Emitter { radiance } if total > 0.0 => {
                (power_per_area(*radiance) / total) as f32
            }
            _ => 0.0,
        });
        Self {
            power: total,
            table: AliasTable::new(&powers),
            pdf_area: pdf_area.collect(),
            items,
        }
    }

    /// Whether there is nothing to aim at.
    pub fn is_empty(&self) -> bool {
        self.table.is_empty()
    }

    /// What all of them emit in W of the prepared scene, up to the factor of [`PreparedLight::power`].
    pub fn power(&self) -> f64 {
        self.power
    }

    /// Aims at one light from `from`: `choice` and `u` uniform over the unit square. `None` where there is none.
    pub fn aim(&self, lights: &[PreparedLight], from: Vec3, choice: Vec2, u: Vec2) -> Option<Aim> {
        if self.table.is_empty() {
            return None;
        }
        let item = self.table.draw(choice);
        let probability = self.table.probability(item);
        Some(match self.items[item] {
            Emitter::Light(index) => {
                let light = &lights[index as usize];
                let mut sample = light.sample(from, u);
                sample.irradiance /= probability;
                let towards = Ray::new(from, sample.position - from);
                let pdf = light
                    .visible_disk()
                    .map(|disk| probability * disk.pdf_solid_angle(&towards, 1.0));
                Aim {
                    sample,
                    pdf_solid_angle: pdf,
                    light: Some(index),
                }
            }
            Emitter::Triangle {
                triangle,
                error: aiming_error,
                area,
                radiance,
            } => {
                let (position, error) = triangle.point(warp::triangle(u));
                let normal = triangle.normal();
                let towards = position - from;
                let pdf = pdf_from_area(probability / area, normal, towards);
                // In front of the surface by its rounding error, so that the triangle does not shadow itself.
                let error = error + aiming_error.from(towards.length());
                let position = robust::offset_origin(position, error, normal, -towards);
                let irradiance = if pdf.is_finite() {
                    radiance / pdf
                } else {
                    Vec3::ZERO
                };
                Aim {
                    sample: LightSample {
                        position,
                        irradiance,
                    },
                    pdf_solid_angle: Some(pdf),
                    light: None,
                }
            }
        })
    }

    /// Density with which a ray from `from` that meets the emitting `object` at `towards` from there was aimed at, per
    /// steradian; `normal` is the geometric one at the point met.
    pub fn pdf_of_object(&self, object: usize, normal: Vec3, towards: Vec3) -> f32 {
        pdf_from_area(self.pdf_area[object], normal, towards)
    }

    /// Density with which the disk light number `index` is aimed at along `ray`, which meets it at `t`, per steradian.
    pub fn pdf_of_disk(&self, lights: &[PreparedLight], index: usize, ray: &Ray, t: f32) -> f32 {
        if self.table.is_empty() {
            return 0.0;
        }
        lights[index].visible_disk().map_or(0.0, |disk| {
            self.table.probability(index) * disk.pdf_solid_angle(ray, t)
        })
    }
}

/// Emitted power of a surface of this radiance per area, both sides.
fn power_per_area(radiance: Vec3) -> f64 {
    2.0 * PI * f64::from(luminance(radiance))
}

/// A density per area, seen from a point from which the area's point lies at `towards`, as one per steradian; infinite for a
/// surface seen edge-on.
fn pdf_from_area(pdf_area: f32, normal: Vec3, towards: Vec3) -> f32 {
    let distance_squared = towards.length_squared();
    let cosine = normal.dot(towards).abs() / distance_squared.sqrt();
    pdf_area * distance_squared / cosine
}
