//! The parts of a mesh file: which triangles wear which material.

use std::collections::HashMap;
use std::ops::Range;

use foldhash::fast::RandomState;

use crate::geometry::TriangleMesh;

/// Which triangles of a mesh belong to which part. Every triangle belongs to one, or there are no parts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshParts {
    parts: Vec<Part>,
    /// Runs of triangles, those of one part beside each other.
    runs: Vec<Range<u32>>,
}

#[derive(Clone, Debug, PartialEq)]
struct Part {
    name: String,
    /// Its runs among all.
    runs: Range<usize>,
}

/// Takes note of parts while triangles are read.
#[derive(Debug, Default)]
pub struct PartsInOrder<'a> {
    names: Vec<&'a [u8]>,
    numbers: HashMap<&'a [u8], u32, RandomState>,
    /// The number of the part that goes on from a triangle.
    runs: Vec<(u32, u32)>,
}

impl<'a> PartsInOrder<'a> {
    /// The number of the part called `name`.
    pub fn number(&mut self, name: &'a [u8]) -> u32 {
        let next = u32::try_from(self.names.len()).unwrap_or(u32::MAX);
        let number = *self.numbers.entry(name).or_insert(next);
        if number == next {
            self.names.push(name);
        }
        number
    }

    /// Says that the triangles from the one of index `triangle` on belong to the part of this number.
    pub fn go_on(&mut self, triangle: usize, number: u32) {
        let triangle = u32::try_from(triangle).unwrap_or(u32::MAX);
        match self.runs.last_mut() {
            Some((_, last)) if *last == number => {}
            Some((start, last)) if *start == triangle => *last = number,
            _ => self.runs.push((triangle, number)),
        }
    }

    /// The parts of a mesh of so many `triangles`, in the order of their first triangle; those without one are left out. Triangles
    /// before the first run belong to a part without a name.
    #[must_use]
    pub fn into_parts(mut self, triangles: usize) -> MeshParts {
        let triangles = u32::try_from(triangles).unwrap_or(u32::MAX);
        let is_named = self.names.iter().any(|name| !name.is_empty());
        if !is_named || triangles == 0 {
            return MeshParts::default();
        }
        if self.runs.first().is_none_or(|&(start, _)| start > 0) {
            let unnamed = self.number(b"");
            self.runs.insert(0, (0, unnamed));
        }
        let ends = self.runs.iter().skip(1).map(|&(start, _)| start);
        let ends: Vec<u32> = ends.chain([triangles]).collect();
        let mut runs: Vec<(u32, Range<u32>)> = self
            .runs
            .iter()
            .zip(ends)
            .map(|(&(start, number), end)| (number, start..end))
            .filter(|(_, run)| !run.is_empty())
            .collect();
        // In the order of the first triangle, whatever the order of the names.
        let mut first = vec![u32::MAX; self.names.len()];
        for (number, run) in &runs {
            let first = &mut first[*number as usize];
            *first = run.start.min(*first);
        }
        runs.sort_by_key(|(number, run)| (first[*number as usize], run.start));
        let mut parts: Vec<Part> = Vec::new();
        let mut last = None;
        for (index, (number, _)) in runs.iter().enumerate() {
            match parts.last_mut() {
                Some(part) if last == Some(*number) => part.runs.end = index + 1,
                _ => parts.push(Part {
                    name: String::from_utf8_lossy(self.names[*number as usize]).into_owned(),
                    runs: index..index + 1,
                }),
            }
            last = Some(*number);
        }
        MeshParts {
            parts,
            runs: runs.into_iter().map(|(_, run)| run).collect(),
        }
    }
}

impl MeshParts {
    /// Their names, in the order of their first triangle; that of faces without material is empty.
    #[must_use]
    pub fn names(&self) -> impl ExactSizeIterator<Item = &str> {
        self.parts.iter().map(|part| part.name.as_str())
    }

    /// Whether the file has none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }
}

/// Cuts parts out of a mesh.
pub struct PartCutter<'a> {
    mesh: &'a TriangleMesh,
    parts: &'a MeshParts,
    by_name: HashMap<&'a str, &'a Part, RandomState>,
    /// The vertex of the part for each of the mesh, once a part is cut; [`NONE`] between two parts.
    vertices: Vec<u32>,
}

/// Stands for no vertex.
const NONE: u32 = u32::MAX;

impl<'a> PartCutter<'a> {
    /// Nothing is cut yet. `parts` are those of `mesh`.
    #[must_use]
    pub fn new(mesh: &'a TriangleMesh, parts: &'a MeshParts) -> Self {
        // Names that are no UTF-8 may have become the same: the first is meant.
        let named = parts.parts.iter().rev();
        Self {
            mesh,
            parts,
            by_name: named.map(|part| (part.name.as_str(), part)).collect(),
            vertices: Vec::new(),
        }
    }

    /// The names of all parts, as [`MeshParts::names`] gives them.
    #[must_use]
    pub fn names(&self) -> impl ExactSizeIterator<Item = &'a str> + use<'a> {
        self.parts.names()
    }

    /// The part called `name` as a mesh of its own, with the vertices that it uses; `None` where there is no such part.
    pub fn cut(&mut self, name: &str) -> Option<TriangleMesh> {
        let part = *self.by_name.get(name)?;
        self.vertices.resize(self.mesh.positions.len(), NONE);
        let runs = self.parts.runs[part.runs.clone()].iter();
        let triangles =
            runs.flat_map(|run| &self.mesh.triangles[run.start as usize..run.end as usize]);
        let mut used = Vec::new();
        let triangles = triangles.map(|triangle| {
            triangle.map(|vertex| {
                let vertex_of_part = &mut self.vertices[vertex as usize];
                if *vertex_of_part == NONE {
                    // There are no more than in the mesh.
                    *vertex_of_part = u32::try_from(used.len()).unwrap_or(NONE);
                    used.push(vertex);
                }
                *vertex_of_part
            })
        });
        let triangles = triangles.collect();
        for &vertex in &used {
            self.vertices[vertex as usize] = NONE;
        }
        Some(TriangleMesh {
            positions: of_vertices(&used, &self.mesh.positions),
            triangles,
            normals: self
                .mesh
                .normals
                .as_ref()
                .map(|all| of_vertices(&used, all)),
            texture_coordinates: self
                .mesh
                .texture_coordinates
                .as_ref()
                .map(|all| of_vertices(&used, all)),
            colors: self.mesh.colors.as_ref().map(|all| of_vertices(&used, all)),
        })
    }
}

/// The values of the vertices that are `used`, of those of `all`.
fn of_vertices<T: Copy>(used: &[u32], all: &[T]) -> Vec<T> {
    used.iter().map(|&vertex| all[vertex as usize]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::DVec3;

    /// A strip of `count` triangles.
    fn strip(count: u32) -> TriangleMesh {
        let vertex = |i: u32| DVec3::new(f64::from(i), f64::from(i % 2), 0.0);
        TriangleMesh {
            positions: (0..count + 2).map(vertex).collect(),
            triangles: (0..count).map(|i| [i, i + 1, i + 2]).collect(),
            normals: Some((0..count + 2).map(|i| vertex(i) * 2.0).collect()),
            ..TriangleMesh::default()
        }
    }

    fn names(parts: &MeshParts) -> Vec<&str> {
        parts.names().collect()
    }

    #[test]
    fn parts_are_cut_with_the_vertices_they_use() {
        let mesh = strip(6);
        let mut order = PartsInOrder::default();
        // Triangle 0 comes before the first name; 1, 2 and 5 are red, 3 and 4 blue; nothing is green.
        for (triangle, name) in [
            (1, "red"),
            (2, "red"),
            (3, "green"),
            (3, "blue"),
            (5, "red"),
            (6, "last"),
        ] {
            let number = order.number(name.as_bytes());
            order.go_on(triangle, number);
        }
        let parts = order.into_parts(6);
        assert_eq!(names(&parts), ["", "red", "blue"]);
        let mut cutter = PartCutter::new(&mesh, &parts);
        for (name, expected) in [
            ("blue", &[3, 4][..]),
            ("red", &[1, 2, 5]),
            ("", &[0]),
            ("blue", &[3, 4]),
        ] {
            let part = cutter.cut(name).expect("is there");
            assert_eq!(part.validate(), Ok(()));
            let corners = (0..part.triangles.len()).map(|i| part.corners(i));
            let expected = expected.iter().map(|&i| mesh.corners(i));
            assert!(corners.eq(expected), "{name}");
            let normals = part.normals.as_ref().expect("the mesh has some");
            assert!(
                part.positions
                    .iter()
                    .zip(normals)
                    .all(|(p, n)| *n == *p * 2.0)
            );
            assert!(
                part.triangles
                    .iter()
                    .flatten()
                    .any(|&v| v as usize + 1 == part.positions.len())
            );
        }
        assert_eq!(cutter.cut("green"), None);
    }

    #[test]
    fn without_names_there_are_no_parts() {
        assert!(PartsInOrder::default().into_parts(3).is_empty());
        let mut order = PartsInOrder::default();
        let red = order.number(b"red");
        order.go_on(0, red);
        assert_eq!(names(&order.into_parts(3)), ["red"]);
        let mut order = PartsInOrder::default();
        order.number(b"red");
        assert_eq!(names(&order.into_parts(3)), [""]);
        let mut order = PartsInOrder::default();
        let unnamed = order.number(b"");
        order.go_on(0, unnamed);
        assert!(order.into_parts(3).is_empty());
    }
}
