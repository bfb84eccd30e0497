//! What lights to aim at are chosen from: in mode `path` the lights of the scene and the triangles of emitting objects; in mode `direct`
//! the same where the lights are too many to sum, else the triangles alone.
//!
//! Few are chosen among by power, which costs the same wherever the light is wanted; many by what they may give there.

use std::f64::consts::PI;

use super::geometry::PreparedGeometry;
use super::light::{LightSample, PreparedLight};
use super::light_tree::{LightTree, Luminary, Receiver, Shines};
use super::material::PreparedMaterial;
use super::shares;
use crate::accel::AimingError;
use crate::control::CancelToken;
use crate::geometry::Triangle;
use crate::math::{Bounds, Ray, Vec2, Vec3, color::luminance, robust, warp};

/// The most things that are chosen among by power. The tree's choice depends on where the light is wanted, and costs as much as
/// a ray; it pays where most lights are far from most places.
const MOST_BY_POWER: usize = 32;

/// The least share of the choice by power, before all are scaled to sum to 1: power says little about what one place sees. It
/// leaves 14 of the 24 digits of a random number to the point of the light.
const LEAST_SHARE: f64 = 1.0 / 1024.0;

/// Triangles between two looks at the cancel token.
const CHUNK: u32 = 1 << 14;

/// The lights of a scene and how likely each is to be aimed at.
#[derive(Clone, Debug, Default)]
pub struct Emitters {
    /// The lights, where they are chosen from, then the triangles of emitting objects.
    items: Vec<Emitter>,
    holds_lights: bool,
    /// For each object, the number of its first triangle, and the item that is this triangle if the object shines.
    first: Vec<(u32, usize)>,
    /// What all of them emit.
    power: f64,
    choice: Choice,
}

/// How one of the items is chosen.
#[derive(Clone, Debug)]
enum Choice {
    /// By these cumulative shares; there are none where nothing shines.
    ByPower(Vec<f32>),
    ByPlace(LightTree),
}

impl Default for Choice {
    fn default() -> Self {
        Self::ByPower(Vec::new())
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
        normal: Vec3,
        error: AimingError,
        area: f32,
        radiance: Vec3,
    },
}

/// One of the items, chosen.
#[derive(Clone, Copy, Debug)]
pub struct Chosen<'a> {
    emitter: &'a Emitter,
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
    /// All of `lights`, which are none where they are not chosen from, and the triangles that shine; `None` when cancelled.
    pub fn new(
        lights: &[PreparedLight],
        geometry: &PreparedGeometry,
        materials: &[PreparedMaterial],
        cancel: &CancelToken,
    ) -> Option<Self> {
        let mut items = Vec::new();
        for index in 0..lights.len() {
            items.push(Emitter::Light(u32::try_from(index).expect("fewer lights")));
        }
        let mut first = Vec::new();
        for (object, material) in geometry.objects().iter().zip(materials) {
            first.push((object.triangles.start, items.len()));
            let Some(radiance) = material.emission().filter(|&light| light != Vec3::ZERO) else {
                continue;
            };
            for index in object.triangles.clone() {
                if index % CHUNK == 0 && cancel.is_cancelled() {
                    return None;
                }
                let placed = geometry.triangle(index);
                let triangle = placed.in_scene();
                items.push(Emitter::Triangle {
                    triangle,
                    normal: triangle.normal(),
                    error: placed.aiming_error(),
                    area: triangle.area(),
                    radiance,
                });
            }
        }
        let powers: Vec<_> = items.iter().map(|item| item.power(lights)).collect();
        let power = powers.iter().sum();
        let choice = if items.len() > MOST_BY_POWER {
            let luminaries: Vec<_> = items.iter().map(|item| item.luminary(lights)).collect();
            Choice::ByPlace(LightTree::build(&luminaries, cancel)?)
        } else {
            Choice::ByPower(shares_by_power(&powers, power))
        };
        Some(Self {
            items,
            power,
            first,
            holds_lights: !lights.is_empty(),
            choice,
        })
    }

    /// Whether there is nothing to aim at.
    pub fn is_empty(&self) -> bool {
        match &self.choice {
            Choice::ByPower(shares) => shares.is_empty(),
            Choice::ByPlace(tree) => tree.is_empty(),
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

    /// Chooses one of them to light `at` for each of `numbers`, uniform over the unit square, and calls `choose(index, chosen)`, in no
    /// particular order. None is chosen where all is dark, and now and then where most give nothing.
    pub fn choose_each<'a>(
        &'a self,
        at: &Receiver,
        numbers: impl Iterator<Item = Vec2>,
        mut choose: impl FnMut(u32, Chosen<'a>),
    ) {
        match &self.choice {
            Choice::ByPower(_) => {
                for (index, u) in (0..).zip(numbers) {
                    if let Some((chosen, _)) = self.choose_by_power(u.x) {
                        choose(index, chosen);
                    }
                }
            }
            Choice::ByPlace(tree) => tree.choose_each(at, numbers, |index, item, probability| {
                let emitter = &self.items[item];
                let chosen = Chosen {
                    emitter,
                    probability,
                };
                choose(index, chosen);
            }),
        }
    }

    /// Aims at one of them from `at`: `u` uniform over the unit square; so is `choice`, asked for where the choice needs more
    /// digits. `None` as for [`Self::choose_each`].
    #[inline]
    pub fn aim(
        &self,
        lights: &[PreparedLight],
        at: &Receiver,
        choice: impl FnOnce() -> Vec2,
        u: Vec2,
    ) -> Option<Aim> {
        let (chosen, u) = match &self.choice {
            Choice::ByPower(_) => {
                let (chosen, rest) = self.choose_by_power(u.x)?;
                (chosen, Vec2::new(rest, u.y))
            }
            Choice::ByPlace(tree) => (self.choose_by_place(tree, at, choice())?, u),
        };
        Some(chosen.aim(lights, at, u))
    }

    /// The one that `u` stands for, and what is left of `u`, uniform in `[0, 1)` again.
    #[inline]
    fn choose_by_power(&self, u: f32) -> Option<(Chosen<'_>, f32)> {
        let Choice::ByPower(shares) = &self.choice else {
            return None;
        };
        if shares.is_empty() {
            return None;
        }
        let (item, rest) = shares::draw(shares, u);
        let chosen = Chosen {
            emitter: &self.items[item],
            probability: shares::share_of(shares, item),
        };
        Some((chosen, rest))
    }

    fn choose_by_place(&self, tree: &LightTree, at: &Receiver, u: Vec2) -> Option<Chosen<'_>> {
        let (item, probability) = tree.choose(at, u)?;
        Some(Chosen {
            emitter: &self.items[item],
            probability,
        })
    }

    /// How likely `item` is chosen at `at`.
    fn probability(&self, item: usize, at: &Receiver) -> f32 {
        match &self.choice {
            Choice::ByPower(shares) if shares.is_empty() => 0.0,
            Choice::ByPower(shares) => shares::share_of(shares, item),
            Choice::ByPlace(tree) => tree.probability(item, at),
        }
    }

    /// Density, per steradian, with which a ray from `at` that meets the emitting `object` in `triangle`, at the vector `towards` from
    /// `at`, was aimed at it; `normal`: the geometric one at the point met.
    pub fn pdf_of_object(
        &self,
        at: &Receiver,
        (object, triangle): (usize, u32),
        normal: Vec3,
        towards: Vec3,
    ) -> f32 {
        let (first_triangle, first_item) = self.first[object];
        let item = first_item + (triangle - first_triangle) as usize;
        let Emitter::Triangle { area, .. } = self.items[item] else {
            unreachable!("the triangles of an emitting object are items");
        };
        pdf_from_area(self.probability(item, at) / area, normal, towards)
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
        lights[index].visible_disk().map_or(0.0, |disk| {
            self.probability(index, at) * disk.pdf_solid_angle(ray, t)
        })
    }
}

/// Cumulative shares of the choice by `powers`, whose sum is `total`.
fn shares_by_power(powers: &[f64], total: f64) -> Vec<f32> {
    let mut shares = Vec::new();
    if total > 0.0 {
        let least = total * LEAST_SHARE;
        let weight = |&power: &f64| if power > 0.0 { power.max(least) } else { 0.0 };
        let weights: Vec<_> = powers.iter().map(weight).collect();
        shares::append_shares(&weights, &mut shares);
    }
    shares
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

impl Chosen<'_> {
    /// Number of the light, where it is one.
    pub fn light(&self) -> Option<u32> {
        match self.emitter {
            Emitter::Light(index) => Some(*index),
            Emitter::Triangle { .. } => None,
        }
    }

    /// Aims at a point of it from `at`: `u` uniform over the unit square.
    #[inline]
    pub fn aim(&self, lights: &[PreparedLight], at: &Receiver, u: Vec2) -> Aim {
        let probability = self.probability;
        let from = at.position;
        match *self.emitter {
            Emitter::Light(index) => {
                let light = &lights[index as usize];
                let mut sample = match light {
                    PreparedLight::Disk(disk) if light.visible_disk().is_none() => {
                        disk.sample_alone(at, u)
                    }
                    _ => light.sample(from, u),
                };
                sample.irradiance /= probability;
                sample.solid_angle /= probability;
                let can_be_met = light.visible_disk().is_some();
                Aim {
                    sample,
                    pdf_solid_angle: can_be_met.then(|| sample.solid_angle.recip()),
                    light: Some(index),
                }
            }
            Emitter::Triangle {
                triangle,
                normal,
                error: aiming_error,
                area,
                radiance,
            } => {
                let (position, error) = triangle.point(warp::triangle(u));
                let towards = position - from;
                let distance = towards.length();
                let pdf = pdf_from_area(probability / area, normal, towards);
                // In front of the surface by its rounding error, so that the triangle does not shadow itself.
                let error = error + aiming_error.from(distance);
                let position = robust::offset_origin(position, error, normal, -towards);
                let solid_angle = if pdf.is_finite() { pdf.recip() } else { 0.0 };
                Aim {
                    sample: LightSample {
                        position,
                        wi: (position - from).normalize_or_zero(),
                        solid_angle,
                        irradiance: radiance * solid_angle,
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
