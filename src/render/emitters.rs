//! What one light is chosen from: in mode `path` the lights of the scene and the triangles of emitting objects; in mode
//! `direct` too where the lights are too many to sum, else the triangles alone.
//!
//! Few are chosen among by power, which costs the same wherever the light is wanted; many by what they may give there.

use std::f64::consts::PI;

use super::alias::AliasTable;
use super::geometry::PreparedGeometry;
use super::light::{LightSample, PreparedLight};
use super::light_tree::{LightTree, Luminary, Receiver, Shines};
use super::material::PreparedMaterial;
use crate::accel::AimingError;
use crate::geometry::Triangle;
use crate::math::{Bounds, Ray, Vec2, Vec3, color::luminance, robust, warp};

/// The most things that are chosen among by power. The tree's choice depends on where the light is wanted, and costs as much as
/// a ray; it pays where most lights are far from most places.
const MOST_BY_POWER: usize = 32;

/// The lights of a scene and how likely each is to be aimed at.
#[derive(Clone, Debug, Default)]
pub struct Emitters {
    /// The lights, where they are chosen from, then the triangles of emitting objects.
    items: Vec<Emitter>,
    holds_lights: bool,
    /// What all of them emit.
    power: f64,
    choice: Choice,
}

/// How one of the items is chosen.
#[derive(Clone, Debug)]
enum Choice {
    ByPower {
        table: AliasTable,
        /// For each object, the density per prepared area with which its points are aimed at; 0 for those that do not shine.
        pdf_area: Vec<f32>,
    },
    ByPlace {
        tree: LightTree,
        /// For each object, the number of its first triangle, and the item that is this triangle if the object shines.
        first: Vec<(u32, usize)>,
    },
}

impl Default for Choice {
    fn default() -> Self {
        Self::ByPower {
            table: AliasTable::default(),
            pdf_area: Vec::new(),
        }
    }
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

/// One of the items, chosen.
#[derive(Clone, Copy, Debug)]
pub struct Chosen {
    emitter: Emitter,
    /// How likely that was.
    pub probability: f32,
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
    /// All of `lights`, which are none where they are not chosen from, and the emitting triangles.
    pub fn new(
        lights: &[PreparedLight],
        geometry: &PreparedGeometry,
        materials: &[PreparedMaterial],
    ) -> Self {
        let mut items = Vec::new();
        for index in 0..lights.len() {
            items.push(Emitter::Light(u32::try_from(index).expect("fewer lights")));
        }
        let mut first = Vec::new();
        for (object, material) in geometry.objects().iter().zip(materials) {
            first.push((object.triangles.start, items.len()));
            let PreparedMaterial::Emitter { radiance } = *material else {
                continue;
            };
            items.extend(object.triangles.clone().map(|index| {
                let placed = geometry.triangle(index);
                let triangle = placed.in_scene();
                Emitter::Triangle {
                    triangle,
                    error: placed.aiming_error(),
                    area: triangle.area(),
                    radiance,
                }
            }));
        }
        let powers: Vec<_> = items.iter().map(|item| item.power(lights)).collect();
        let power = powers.iter().sum();
        let choice = if items.len() > MOST_BY_POWER {
            let luminaries: Vec<_> = items.iter().map(|item| item.luminary(lights)).collect();
            let tree = LightTree::build(&luminaries);
            Choice::ByPlace { tree, first }
        } else {
            by_power(&powers, power, materials)
        };
        Self {
            items,
            power,
            holds_lights: !lights.is_empty(),
            choice,
        }
    }

    /// Whether there is nothing to aim at.
    pub fn is_empty(&self) -> bool {
        match &self.choice {
            Choice::ByPower { table, .. } => table.is_empty(),
            Choice::ByPlace { tree, .. } => tree.is_empty(),
        }
    }

    /// What all of them emit in W of the prepared scene, up to the factor of [`PreparedLight::power`].
    pub fn power(&self) -> f64 {
        self.power
    }

    /// Whether lights are chosen from, not triangles alone.
    pub fn holds_lights(&self) -> bool {
        self.holds_lights
    }

    /// One of them for light at `at`: `u` uniform over the unit square. `None` where there is none, and now and then where most
    /// give nothing.
    pub fn choose(&self, at: &Receiver, u: Vec2) -> Option<Chosen> {
        let (item, probability) = match &self.choice {
            Choice::ByPower { table, .. } if table.is_empty() => return None,
            Choice::ByPower { table, .. } => {
                let item = table.draw(u);
                (item, table.probability(item))
            }
            Choice::ByPlace { tree, .. } => tree.choose(at, u)?,
        };
        Some(Chosen {
            emitter: self.items[item],
            probability,
        })
    }

    /// Aims at one of them from `at`: `choice` and `u` uniform over the unit square. `None` as for [`Self::choose`].
    pub fn aim(
        &self,
        lights: &[PreparedLight],
        at: &Receiver,
        choice: Vec2,
        u: Vec2,
    ) -> Option<Aim> {
        Some(self.choose(at, choice)?.aim(lights, at.position, u))
    }

    /// Density with which a ray from `at` that meets the emitting `object` in `triangle` at `towards` from there was aimed at,
    /// per steradian; `normal` is the geometric one at the point met.
    pub fn pdf_of_object(
        &self,
        at: &Receiver,
        (object, triangle): (usize, u32),
        normal: Vec3,
        towards: Vec3,
    ) -> f32 {
        let pdf_area = match &self.choice {
            Choice::ByPower { pdf_area, .. } => pdf_area[object],
            Choice::ByPlace { tree, first } => {
                let (first_triangle, first_item) = first[object];
                let item = first_item + (triangle - first_triangle) as usize;
                let Emitter::Triangle { area, .. } = self.items[item] else {
                    unreachable!("the triangles of an emitting object are items");
                };
                tree.probability(item, at) / area
            }
        };
        pdf_from_area(pdf_area, normal, towards)
    }

    /// Density with which the disk light number `index` is aimed at from `at` along `ray`, which meets it at `t`, per
    /// steradian.
    pub fn pdf_of_disk(
        &self,
        lights: &[PreparedLight],
        at: &Receiver,
        index: usize,
        (ray, t): (&Ray, f32),
    ) -> f32 {
        if self.is_empty() {
            return 0.0;
        }
        lights[index].visible_disk().map_or(0.0, |disk| {
            let probability = match &self.choice {
                Choice::ByPower { table, .. } => table.probability(index),
                Choice::ByPlace { tree, .. } => tree.probability(index, at),
            };
            probability * disk.pdf_solid_angle(ray, t)
        })
    }
}

/// The choice by power alone: `powers` of the lights and triangles, and their sum.
fn by_power(powers: &[f64], total: f64, materials: &[PreparedMaterial]) -> Choice {
    #[expect(clippy::cast_possible_truncation, reason = "rendering is f32")]
    let pdf_area = materials.iter().map(|material| match material {
        PreparedMaterial::Emitter { radiance } if total > 0.0 => {
            (power_per_area(*radiance) / total) as f32
        }
        _ => 0.0,
    });
    Choice::ByPower {
        table: AliasTable::new(powers),
        pdf_area: pdf_area.collect(),
    }
}

impl Emitter {
    /// All that it emits in W of the prepared scene, up to the factor of [`PreparedLight::power`].
    fn power(&self, lights: &[PreparedLight]) -> f64 {
        match *self {
            Self::Light(index) => lights[index as usize].power(),
            Self::Triangle { area, radiance, .. } => power_per_area(radiance) * f64::from(area),
        }
    }

    /// What a choice by place looks at.
    fn luminary(&self, lights: &[PreparedLight]) -> Luminary {
        match *self {
            Self::Light(index) => lights[index as usize].luminary(),
            Self::Triangle {
                triangle,
                area,
                radiance,
                ..
            } => {
                // Points on it are rounded, and shine from in front of it by as much.
                let corners = triangle.bounds();
                let largest = corners.min.abs().max(corners.max.abs()).max_element();
                let rounding = Vec3::splat(largest * robust::gamma(16));
                Luminary {
                    bounds: Bounds {
                        min: corners.min - rounding,
                        max: corners.max + rounding,
                    },
                    shines: Shines::BothSides(triangle.normal()),
                    intensity: f64::from(luminance(radiance)) * f64::from(area),
                }
            }
        }
    }
}

impl Chosen {
    /// Number of the light, where it is one.
    pub fn light(&self) -> Option<u32> {
        match self.emitter {
            Emitter::Light(index) => Some(index),
            Emitter::Triangle { .. } => None,
        }
    }

    /// Aims at a point of it from `from`: `u` uniform over the unit square.
    pub fn aim(&self, lights: &[PreparedLight], from: Vec3, u: Vec2) -> Aim {
        let probability = self.probability;
        match self.emitter {
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
        }
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
