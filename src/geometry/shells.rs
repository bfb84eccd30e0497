//! Connected surfaces: which of their faces turn the other way round than most, and which of them look inwards.

use std::collections::BTreeMap;

use super::TriangleMesh;
use crate::math::{DBounds, DVec3};

/// Faces joined across the edges that exactly two of them share: sets that are united, each face with its own sense of turning
/// against that of the face that stands for its set.
///
/// Source: union-find with parity; Tarjan, Efficiency of a Good But Not Linear Set Union Algorithm, 1975.
pub struct Shells {
    /// A face nearer to the one that stands for the set; itself where it does.
    parents: Vec<u32>,
    /// Whether a face turns the other way round than its parent.
    opposed: Vec<bool>,
    /// Of a face, and once settled of a set: whether an edge is open.
    open: Vec<bool>,
    /// The same: whether an edge is between faces that turn round in opposite ways.
    mixed: Vec<bool>,
    contradictions: u64,
}

/// A closed surface.
#[derive(Clone, Debug)]
pub struct Shell {
    /// The face that stands for it.
    pub root: usize,
    /// Its first face.
    pub first_face: usize,
    /// Whether some of its faces turn the other way round than others.
    pub is_mixed: bool,
    /// A corner, from which volumes are measured: that of a small surface far from others would be lost from afar.
    origin: DVec3,
    /// Six times its volume; negative where most faces look inwards.
    volume: f64,
    bounds: DBounds,
}

/// The most surfaces that others may lie in.
const MOST_OUTER_SHELLS: usize = 1000;

/// The least volume of a surface, as a share of the cube of its diagonal, that is told from rounding: a sheet folded on itself has no other
/// volume.
const LEAST_VOLUME: f64 = 1e-9;

impl Shells {
    /// As many sets as there are `faces`, of one face each.
    ///
    /// # Panics
    /// When there are 2³².
    #[must_use]
    pub fn new(faces: usize) -> Self {
        Self {
            parents: (0..u32::try_from(faces).expect("fewer than 2^32 faces")).collect(),
            opposed: vec![false; faces],
            open: vec![false; faces],
            mixed: vec![false; faces],
            contradictions: 0,
        }
    }

    /// Notes that an edge of `face` is open.
    ///
    /// # Panics
    /// When there is no such face.
    pub fn open_at(&mut self, face: usize) {
        self.open[face] = true;
    }

    /// Joins two faces across an edge; `opposed`: one turns the other way round than the other.
    ///
    /// # Panics
    /// When there is no such face.
    pub fn join(&mut self, a: usize, b: usize, opposed: bool) {
        let ((root_a, turned_a), (root_b, turned_b)) = (self.find(a), self.find(b));
        let between_roots = turned_a != (turned_b != opposed);
        if root_a != root_b {
            // The lower number stands for both, whatever the order of edges.
            let (root, child) = (root_a.min(root_b), root_a.max(root_b));
            self.parents[child] = u32::try_from(root).expect("a face's number");
            self.opposed[child] = between_roots;
        } else if between_roots {
            self.contradictions += 1;
        }
        self.mixed[a] |= opposed;
    }

    /// The face that stands for the set of `face`, and whether `face` turns the other way round.
    ///
    /// # Panics
    /// When there is no such face.
    pub fn find(&mut self, face: usize) -> (usize, bool) {
        let parent = |shells: &Self, face: usize| shells.parents[face] as usize;
        let (mut root, mut turned) = (face, false);
        while parent(self, root) != root {
            turned ^= self.opposed[root];
            root = parent(self, root);
        }
        // The next search finds it at once.
        let (mut at, mut rest) = (face, turned);
        while at != root {
            let next = parent(self, at);
            let own = self.opposed[at];
            self.parents[at] = u32::try_from(root).expect("a face's number");
            self.opposed[at] = rest;
            rest ^= own;
            at = next;
        }
        (root, turned)
    }

    /// Tells the faces that stand for sets what was noted of the others; to be called when all are joined.
    pub fn settle(&mut self) {
        for face in 0..self.parents.len() {
            let (root, _) = self.find(face);
            self.open[root] |= self.open[face];
            self.mixed[root] |= self.mixed[face];
        }
    }

    /// Edges at which no way round fits, as on a Möbius strip.
    #[must_use]
    pub fn contradictions(&self) -> u64 {
        self.contradictions
    }

    /// Of each face, whether it turns the other way round than most of its surface.
    #[must_use]
    pub fn turned(&mut self) -> Vec<bool> {
        let faces = self.parents.len();
        if !self.mixed.contains(&true) {
            return vec![false; faces];
        }
        let mut sides: BTreeMap<usize, [u64; 2]> = BTreeMap::new();
        for face in 0..faces {
            let (root, turned) = self.find(face);
            if self.mixed[root] {
                sides.entry(root).or_default()[usize::from(turned)] += 1;
            }
        }
        let is_turned = |face| {
            let (root, turned) = self.find(face);
            let side = sides.get(&root);
            side.is_some_and(|&[along, against]| turned == (against <= along))
        };
        (0..faces).map(is_turned).collect()
    }

    /// The surfaces without open edges, once the faces that are [turned](Self::turned) are turned back; faces that are `left_out` do not
    /// count. `mesh`: the one that all these faces are of.
    ///
    /// # Panics
    /// When `mesh` or `turned` has fewer faces than `left_out`.
    #[must_use]
    pub fn closed(
        &mut self,
        mesh: &TriangleMesh,
        left_out: &[bool],
        turned: &[bool],
    ) -> Vec<Shell> {
        let mut shells: BTreeMap<usize, Shell> = BTreeMap::new();
        for (face, _) in left_out.iter().enumerate().filter(|(_, out)| !**out) {
            let (root, _) = self.find(face);
            if self.open[root] {
                continue;
            }
            let corners = mesh.corners(face);
            let shell = shells.entry(root).or_insert(Shell {
                root,
                first_face: face,
                is_mixed: self.mixed[root],
                origin: corners[0],
                volume: 0.0,
                bounds: DBounds::EMPTY,
            });
            let [a, b, c] = corners.map(|corner| corner - shell.origin);
            let volume = a.dot(b.cross(c));
            shell.volume += if turned[face] { -volume } else { volume };
            for corner in corners {
                shell.bounds = shell.bounds.with_point(corner);
            }
        }
        shells.into_values().collect()
    }
}

impl Shell {
    /// Those of the closed surfaces whose faces look inwards, but for those that lie in others: these bound a hollow.
    pub fn inside_out(shells: &[Self]) -> impl Iterator<Item = &Self> {
        let is_solid = |shell: &&Self| {
            shell.volume.abs() > LEAST_VOLUME * shell.bounds.size().length().powi(3)
        };
        let (mut outer, inner): (Vec<&Self>, Vec<&Self>) = shells
            .iter()
            .filter(is_solid)
            .partition(|shell| shell.volume > 0.0);
        outer.sort_by(|a, b| b.volume.total_cmp(&a.volume));
        outer.truncate(MOST_OUTER_SHELLS);
        inner.into_iter().filter(move |shell| {
            let is_hollow = |outer: &&Self| {
                outer.bounds.contains(shell.bounds.min) && outer.bounds.contains(shell.bounds.max)
            };
            !outer.iter().any(is_hollow)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::Random;

    /// A chain of faces in which some are turned, joined in random order: the fewer are found.
    #[test]
    fn the_fewer_faces_are_the_turned_ones() {
        let mut random = Random::new(7);
        for _ in 0..50 {
            let turned: Vec<bool> = (0..40).map(|_| random.bits().is_multiple_of(5)).collect();
            let mut joints: Vec<usize> = (0..39).collect();
            joints.sort_by_cached_key(|_| random.bits());
            let mut shells = Shells::new(40);
            for joint in joints {
                shells.join(joint, joint + 1, turned[joint] != turned[joint + 1]);
            }
            shells.settle();
            let fewer = turned.iter().filter(|&&turned| turned).count();
            let expected = fewer.min(40 - fewer) as u64;
            let found = shells.turned().into_iter().filter(|&turned| turned);
            assert_eq!(found.count() as u64, expected);
            assert_eq!(shells.contradictions(), 0);
        }
    }

    #[test]
    fn a_strip_of_one_side_contradicts_itself_once() {
        let mut shells = Shells::new(5);
        for face in 0..5 {
            shells.join(face, (face + 1) % 5, face == 0);
        }
        assert_eq!(shells.contradictions(), 1);
    }
}
