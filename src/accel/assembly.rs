//! What the rays of a scene meet: one structure over the triangles that occur once, and placed copies of shared structures
//! under a tree of boxes.
//!
//! A ray meets a copy as a local ray, rounded once ([`Place`]), with the same parameter `t`. All structures
//! compute that ray alike and ties go to the smaller id, so the answer is the same bits for any structure. Within one
//! copy a ray meets one mesh, and no ray passes between its triangles; between two copies that touch, two local rays may.
//!
//! Triangles are numbered part after part, copy after copy.

use std::ops::Range;
use std::sync::Arc;

use super::boxes::narrowed;
use super::placed::{Place, PlacedTriangle, outward};
use super::{Accelerator, BoxTree, Fan, Hit, Packet, PacketHits, Visits, half_area};
use crate::geometry::{Triangle, TriangleHit};
use crate::math::robust::gamma;
use crate::math::{Bounds, DBounds, DVec3, Ray, ScaledRotation, Vec3};
use rayon::prelude::*;

/// Triangles that belong together in the scene: those of one object.
#[derive(Clone, Debug)]
pub enum Part {
    /// This many of the triangles that occur once.
    Flat(u32),
    /// Copies of a shared structure.
    Copies(Copies),
    /// Copies of a shared structure, in place of this many of the triangles that occur once, which no ray meets any more.
    Moved(Copies, u32),
}

/// A shared structure in several places, all turned alike.
#[derive(Clone, Debug)]
pub struct Copies {
    /// Which of the shared structures.
    pub structure: usize,
    /// From local directions to those of the prepared scene.
    pub turn: ScaledRotation,
    /// Where the local origin of each copy is in the prepared scene.
    pub translations: Vec<DVec3>,
}

/// A flat structure and placed copies of shared ones; answers as one structure over all triangles would.
#[derive(Clone, Debug)]
pub struct Assembly {
    flat: Arc<Accelerator>,
    shared: Vec<Arc<Accelerator>>,
    parts: Vec<PlacedPart>,
    /// For each flat part, its first triangle in the flat structure and in the scene.
    flat_runs: Vec<(u32, u32)>,
    /// Part after part.
    copies: Vec<Copy>,
    /// Over the boxes of the copies; `None` where every copy is tried, as brute force does.
    tree: Option<BoxTree>,
    bounds: Bounds,
    /// No copy's local origin and radius together reach further from the scene's origin.
    reach: f64,
}

/// A part, and the ids of its triangles.
#[derive(Clone, Debug)]
struct PlacedPart {
    /// Its first triangle, and the first one after it.
    start: u32,
    end: u32,
    content: Content,
}

#[derive(Clone, Debug)]
enum Content {
    /// The first of its triangles in the flat structure.
    Flat(u32),
    Copies {
        structure: usize,
        turn: ScaledRotation,
        is_mirrored: bool,
        /// Index of its first copy among all copies.
        first: usize,
    },
}

#[derive(Clone, Copy, Debug)]
struct Copy {
    translation: DVec3,
    part: u32,
    first_triangle: u32,
}

impl Assembly {
    /// The scene of `parts`, of which the flat ones, and those that moved, are the triangles of `flat`, one after the other.
    ///
    /// # Panics
    /// When there are more triangles than `u32` can number, or the parts do not fit the structures.
    #[must_use]
    pub fn new(
        flat: impl Into<Arc<Accelerator>>,
        shared: Vec<Arc<Accelerator>>,
        parts: Vec<Part>,
    ) -> Self {
        let flat = flat.into();
        let mut assembly = Self {
            bounds: flat.bounds(),
            tree: None,
            reach: 0.0,
            shared,
            parts: Vec::with_capacity(parts.len()),
            flat_runs: Vec::new(),
            copies: Vec::new(),
            flat,
        };
        let mut boxes = Vec::new();
        let (mut start, mut in_flat) = (0, 0);
        for part in parts {
            let (end, content) = match part {
                Part::Flat(count) => {
                    let first = in_flat;
                    assembly.flat_runs.push((first, start));
                    in_flat += count;
                    (start + count, Content::Flat(first))
                }
                Part::Copies(copies) => assembly.place(copies, start, &mut boxes),
                Part::Moved(copies, count) => {
                    in_flat += count;
                    assembly.place(copies, start, &mut boxes)
                }
            };
            assembly.parts.push(PlacedPart {
                start,
                end,
                content,
            });
            start = end;
        }
        assert_eq!(
            in_flat as usize,
            assembly.flat.triangle_count(),
            "flat parts and triangles"
        );
        if !matches!(*assembly.flat, Accelerator::BruteForce(_)) {
            assembly.tree = Some(BoxTree::build(&boxes));
        }
        let all = boxes.iter().copied();
        assembly.bounds = all.fold(assembly.bounds, Bounds::union);
        assembly
    }

    /// Adds copies and their boxes; returns the first id after them, too.
    fn place(
        &mut self,
        Copies {
            structure,
            turn,
            translations,
        }: Copies,
        start: u32,
        boxes: &mut Vec<Bounds>,
    ) -> (u32, Content) {
        let shared = &self.shared[structure];
        let count = u32::try_from(shared.triangle_count()).expect("the structure counts in u32");
        let part = u32::try_from(self.parts.len()).expect("less parts than triangles");
        let around = (0..shared.triangle_count())
            .into_par_iter()
            .map(|id| {
                let corners = shared.triangle(id).corners;
                DBounds::of_points(corners.map(|corner| turn.apply(corner.as_dvec3())))
            })
            .reduce(|| DBounds::EMPTY, DBounds::union);

        let radius = around.max.abs().max(around.min.abs()).length();

        let first = self.copies.len();
        let mut end = start;
        for translation in translations {
            self.copies.push(Copy {
                translation,
                part,
                first_triangle: end,
            });
            end = end.checked_add(count).expect("ids are u32");
            boxes.push(rounded_outwards(
                around.min + translation,
                around.max + translation,
            ));
            self.reach = self.reach.max(translation.length() + radius);
        }
        let content = Content::Copies {
            structure,
            turn,
            is_mirrored: turn.is_mirrored(),
            first,
        };
        (end, content)
    }

    /// The nearest hit with `0 < t < t_max`, ties going to the smaller triangle id.
    #[must_use]
    #[inline]
    pub fn intersect(&self, ray: &Ray, t_max: f32) -> Option<Hit> {
        let flat = self.flat.intersect(ray, t_max);
        if self.copies.is_empty() {
            flat
        } else {
            self.intersect_copies(ray, t_max, flat)
        }
    }

    /// The nearest hit of each ray of `packet`, in their order: [`Self::intersect`] of each, but faster.
    #[must_use]
    pub fn intersect_packet(&self, packet: &Packet) -> PacketHits {
        let mut hits = self.flat.intersect_packet(packet);
        if !self.copies.is_empty() {
            for ((ray, t_max), hit) in packet.rays().zip(&mut hits) {
                *hit = self.intersect_copies(&ray, t_max, *hit);
            }
        }
        hits
    }

    /// Whether anything is hit with `0 < t < t_max`; stops at the first such hit.
    #[must_use]
    #[inline]
    pub fn occluded(&self, ray: &Ray, t_max: f32) -> bool {
        self.flat.occluded(ray, t_max) || !self.copies.is_empty() && self.copies_occlude(ray, t_max)
    }

    /// Which rays of `fan` are occluded, as bits in their order: [`Self::occluded`] of each up to 1, but faster.
    #[must_use]
    #[inline]
    pub fn occluded_fan(&self, fan: &Fan<'_>) -> u64 {
        let occluded = self.flat.occluded_fan(fan);
        if self.copies.is_empty() {
            return occluded;
        }
        occluded | fan.each(|ray| self.copies_occlude(ray, 1.0))
    }

    fn intersect_copies(&self, ray: &Ray, t_max: f32, flat: Option<Hit>) -> Option<Hit> {
        let mut best = flat.map(|hit| Hit {
            triangle: self.id_of_flat(hit.triangle),
            ..hit
        });
        self.walk_copies(ray, best.map_or(t_max, |hit| hit.t), |index| {
            // As near as the best so far counts, too: its id may be smaller.
            let limit = best.map_or(t_max, |hit| hit.t.next_up());
            if let Some((id, hit)) = self.intersect_copy(index, ray, limit) {
                best = Some(Hit::nearer(best, id, hit));
            }
            best.map_or(t_max, |hit| hit.t)
        });
        best
    }

    fn intersect_copy(&self, index: u32, ray: &Ray, t_max: f32) -> Option<(u32, TriangleHit)> {
        let copy = &self.copies[index as usize];
        let (structure, place, is_mirrored) = self.structure_of(copy);
        let hit = structure.intersect(&place.local_ray(ray)?, t_max)?;
        let barycentrics = outward(hit.barycentrics, is_mirrored);
        let id = copy.first_triangle + hit.triangle;
        Some((
            id,
            TriangleHit {
                t: hit.t,
                barycentrics,
            },
        ))
    }

    fn copies_occlude(&self, ray: &Ray, t_max: f32) -> bool {
        let mut occluded = false;
        self.walk_copies(ray, t_max, |index| {
            let (structure, place, _) = self.structure_of(&self.copies[index as usize]);
            let local = place.local_ray(ray);
            occluded = occluded || local.is_some_and(|local| structure.occluded(&local, t_max));
            if occluded { -1.0 } else { t_max }
        });
        occluded
    }

    /// Visits every copy that may be hit in `0 < t < t_max`.
    ///
    /// With u the unit roundoff, b a copy's place and r its radius about it: a local ray is off by u per coordinate of its
    /// origin and of its direction, and a hit's `t` by u again. So the point at `t` on the ray itself is within
    /// u (|o − b| + 2 t |d|) of the copy along every axis, and t |d| is at most |o − b| + r. Together that is at most
    /// 3u (|o| + |b| + r), by which boxes count as larger. Adding that to the origin rounds once more; the rest of the factor
    /// pays for terms in u² and for computing the bound.
    #[inline]
    fn walk_copies(&self, ray: &Ray, t_max: f32, mut visit: impl FnMut(u32) -> f32) {
        let Some(tree) = &self.tree else {
            for index in (0..).take(self.copies.len()) {
                visit(index);
            }
            return;
        };
        #[expect(clippy::cast_possible_truncation, reason = "a bound with a reserve")]
        let slack = (ray.origin.length() + self.reach as f32) * gamma(6);
        tree.walk_grown(ray, t_max, slack, visit);
    }

    /// What [`Assembly::intersect`], or [`Assembly::occluded`] where `any_hit`, visits.
    #[must_use]
    pub fn visits(&self, ray: &Ray, t_max: f32, any_hit: bool) -> Visits {
        let mut visits = self.flat.visits(ray, t_max, any_hit);
        if self.copies.is_empty() || any_hit && self.flat.occluded(ray, t_max) {
            return visits;
        }
        let mut limit = t_max;
        if !any_hit && let Some(hit) = self.flat.intersect(ray, t_max) {
            limit = hit.t;
        }
        self.walk_copies(ray, limit, |index| {
            visits.nodes += 1;
            let (structure, place, _) = self.structure_of(&self.copies[index as usize]);
            let Some(local) = place.local_ray(ray) else {
                return limit;
            };
            let reach = if limit < t_max {
                limit.next_up()
            } else {
                t_max
            };
            visits += structure.visits(&local, reach, any_hit);
            if any_hit {
                limit = if structure.occluded(&local, t_max) {
                    -1.0
                } else {
                    t_max
                };
            } else if let Some(hit) = structure.intersect(&local, reach) {
                limit = limit.min(hit.t);
            }
            limit
        });
        visits
    }

    /// The box around each copy.
    pub(super) fn copy_boxes(&self) -> impl Iterator<Item = Bounds> {
        self.copies.iter().map(|copy| {
            let (structure, place, _) = self.structure_of(copy);
            let Bounds { min, max } = structure.bounds();
            let ends = [min, max].map(Vec3::as_dvec3);
            let corner = |bits: usize| {
                let local = DVec3::new(
                    ends[bits & 1].x,
                    ends[bits >> 1 & 1].y,
                    ends[bits >> 2 & 1].z,
                );
                place.turn.apply(local) + place.translation
            };
            narrowed(&DBounds::of_points((0..8).map(corner)))
        })
    }

    /// The structures, each once, with half the area of the boxes it fills in the scene, all its copies together.
    pub(super) fn structures_and_areas(&self) -> impl Iterator<Item = (&Accelerator, f64)> {
        let area_of = |bounds: &Bounds| {
            if bounds.is_empty() {
                0.0
            } else {
                half_area(bounds)
            }
        };
        let mut areas = vec![0.0; self.shared.len()];
        for copy in &self.copies {
            if let Content::Copies {
                structure, turn, ..
            } = &self.parts[copy.part as usize].content
            {
                let local = area_of(&self.shared[*structure].bounds());
                areas[*structure] += local * turn.scale().powi(2);
            }
        }
        let shared = self.shared.iter().map(|structure| &**structure).zip(areas);
        std::iter::once((&*self.flat, area_of(&self.flat.bounds()))).chain(shared)
    }

    /// The same scene in other structures: `build` gets the triangles of each, the flat one first. `None` where `build` returns `None`.
    pub fn rebuilt(
        &self,
        mut build: impl FnMut(Vec<Triangle>) -> Option<Accelerator>,
    ) -> Option<Self> {
        let flat = build(self.flat.triangles().collect())?;
        let shared = self
            .shared
            .iter()
            .map(|structure| build(structure.triangles().collect()).map(Arc::new))
            .collect::<Option<_>>()?;
        Some(self.with_structures(flat, shared))
    }

    /// The same scene in these structures over the same triangles.
    ///
    /// # Panics
    /// When they are over others.
    #[must_use]
    pub fn with_structures(&self, flat: Accelerator, shared: Vec<Arc<Accelerator>>) -> Self {
        let part = |(index, part): (usize, &PlacedPart)| match part.content {
            Content::Flat(_) => Part::Flat(part.end - part.start),
            Content::Copies {
                structure, turn, ..
            } => Part::Copies(Copies {
                structure,
                turn,
                translations: self
                    .copies_of(index)
                    .map(|(_, _, translations)| translations.collect())
                    .unwrap_or_default(),
            }),
        };
        let parts = self.parts.iter().enumerate().map(part).collect();
        Self::new(flat, shared, parts)
    }

    /// The structure over the triangles that occur once.
    #[must_use]
    pub fn flat(&self) -> &Arc<Accelerator> {
        &self.flat
    }

    fn structure_of(&self, copy: &Copy) -> (&Accelerator, Place<'_>, bool) {
        let Content::Copies {
            structure,
            ref turn,
            is_mirrored,
            ..
        } = self.parts[copy.part as usize].content
        else {
            unreachable!("copies belong to parts with copies");
        };
        let place = Place {
            turn,
            translation: copy.translation,
        };
        (&self.shared[structure], place, is_mirrored)
    }

    /// The scene's id of a triangle of the flat structure.
    fn id_of_flat(&self, in_flat: u32) -> u32 {
        let after = self.flat_runs.partition_point(|run| run.0 <= in_flat);
        let (first, id) = self.flat_runs[after - 1];
        id + (in_flat - first)
    }

    /// The triangles of part `index` in [`Self::flat`]; `None` where they are those of copies.
    #[must_use]
    pub fn flat_range(&self, index: usize) -> Option<Range<u32>> {
        let part = &self.parts[index];
        match part.content {
            Content::Flat(first) => Some(first..first + (part.end - part.start)),
            Content::Copies { .. } => None,
        }
    }

    /// Number of triangles, all copies counted.
    #[must_use]
    pub fn triangle_count(&self) -> u32 {
        self.parts.last().map_or(0, |part| part.end)
    }

    /// Number of the part that the triangle `id` belongs to.
    #[must_use]
    #[inline]
    pub fn part_of(&self, id: u32) -> usize {
        self.parts.partition_point(|part| part.end <= id)
    }

    /// The triangle `id`.
    #[must_use]
    #[expect(
        clippy::inline_always,
        reason = "hot, and too large to be inlined in every form of the code that renders"
    )]
    #[inline(always)]
    pub fn triangle(&self, id: u32) -> PlacedTriangle<'_> {
        let index = self.part_of(id);
        let part = &self.parts[index];
        let number = id - part.start;
        let (triangle, place) = match part.content {
            Content::Flat(first) => (self.flat.triangle((first + number) as usize), None),
            Content::Copies {
                structure,
                ref turn,
                is_mirrored,
                first,
            } => {
                let shared = &self.shared[structure];
                let count = shared.triangle_count();
                let (copy, in_copy) = (number as usize / count, number as usize % count);
                let mut triangle = shared.triangle(in_copy);
                triangle.corners = outward(triangle.corners, is_mirrored);
                let translation = self.copies[first + copy].translation;
                (triangle, Some(Place { turn, translation }))
            }
        };
        PlacedTriangle {
            part: index,
            number,
            triangle,
            place,
        }
    }

    /// The structure that part `index` shares, and how and where its copies are; `None` for a flat part.
    #[must_use]
    pub fn copies_of(
        &self,
        index: usize,
    ) -> Option<(
        &Arc<Accelerator>,
        &ScaledRotation,
        impl Iterator<Item = DVec3>,
    )> {
        let part = &self.parts[index];
        let Content::Copies {
            structure,
            ref turn,
            first,
            ..
        } = part.content
        else {
            return None;
        };
        let structure = &self.shared[structure];
        let count = (part.end - part.start) as usize / structure.triangle_count();
        let copies = self.copies[first..first + count].iter();
        Some((structure, turn, copies.map(|copy| copy.translation)))
    }

    /// The box around all triangles; empty when there are none.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The structures' name as people write it.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.flat.name()
    }

    /// Memory of all structures, each counted once, and of the copies' places.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let shared: usize = self.shared.iter().map(|structure| structure.bytes()).sum();
        let tree = self.tree.as_ref().map_or(0, BoxTree::bytes);
        self.flat.bytes() + shared + tree + size_of_val(&*self.copies)
    }
}

/// The smallest `f32` box around one in `f64`.
fn rounded_outwards(min: DVec3, max: DVec3) -> Bounds {
    let down = |x: f64, narrow: f32| {
        if f64::from(narrow) > x {
            narrow.next_down()
        } else {
            narrow
        }
    };
    let up = |x: f64, narrow: f32| {
        if f64::from(narrow) < x {
            narrow.next_up()
        } else {
            narrow
        }
    };
    let (low, high) = (min.as_vec3(), max.as_vec3());
    Bounds {
        min: Vec3::new(down(min.x, low.x), down(min.y, low.y), down(min.z, low.z)),
        max: Vec3::new(up(max.x, high.x), up(max.y, high.y), up(max.z, high.z)),
    }
}

#[cfg(test)]
mod tests;
