//! An indexed triangle mesh: its checks and its OFF file.

use glam::DVec3;
use std::collections::HashMap;
use std::fmt::Write;

pub struct Mesh {
    pub vertices: Vec<DVec3>,
    /// Corners in counter-clockwise order seen from outside.
    pub faces: Vec<[usize; 3]>,
}

/// Decimals written to the file: a thousandth of a triangle's edge.
const DECIMALS: f64 = 1e5;

impl Mesh {
    /// Twice the area, along the outward normal.
    pub fn area_vector(&self, [a, b, c]: [usize; 3]) -> DVec3 {
        let v = &self.vertices;
        (v[b] - v[a]).cross(v[c] - v[a])
    }

    pub fn bounds(&self) -> (DVec3, DVec3) {
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        self.vertices
            .iter()
            .fold(start, |(low, high), &v| (low.min(v), high.max(v)))
    }

    /// For each vertex the faces around it.
    pub fn faces_by_vertex(&self) -> Vec<Vec<usize>> {
        let mut around = vec![Vec::new(); self.vertices.len()];
        for (i, face) in self.faces.iter().enumerate() {
            for &corner in face {
                around[corner].push(i);
            }
        }
        around
    }

    /// Rounds coordinates to what the file can hold, so that checks see what readers will.
    pub fn round(&mut self) {
        for v in &mut self.vertices {
            // Adding zero turns a negative zero into a plain one.
            *v = (*v * DECIMALS).round() / DECIMALS + 0.0;
        }
    }

    /// Keeps only the connected piece with the most faces, and only the vertices in use.
    pub fn keep_largest_piece(&mut self) {
        let around = self.faces_by_vertex();
        let mut piece_of = vec![usize::MAX; self.faces.len()];
        let mut sizes = Vec::new();
        for seed in 0..self.faces.len() {
            if piece_of[seed] != usize::MAX {
                continue;
            }
            let piece = sizes.len();
            sizes.push(0);
            piece_of[seed] = piece;
            let mut open = vec![seed];
            while let Some(face) = open.pop() {
                sizes[piece] += 1;
                for &next in self.faces[face].iter().flat_map(|&corner| &around[corner]) {
                    if piece_of[next] == usize::MAX {
                        piece_of[next] = piece;
                        open.push(next);
                    }
                }
            }
        }
        let largest = (0..sizes.len()).max_by_key(|&piece| sizes[piece]);
        let mut piece = piece_of.into_iter();
        self.faces.retain(|_| piece.next() == largest);
        self.drop_unused_vertices();
    }

    pub fn drop_unused_vertices(&mut self) {
        let mut renamed = HashMap::new();
        let mut kept = Vec::new();
        for corner in self.faces.iter_mut().flatten() {
            *corner = *renamed.entry(*corner).or_insert_with(|| {
                kept.push(self.vertices[*corner]);
                kept.len() - 1
            });
        }
        self.vertices = kept;
    }

    /// Checks that the mesh is a closed, oriented manifold standing on z = 0.
    pub fn verify(&self) -> Result<(), String> {
        let mut directed = HashMap::new();
        for face in &self.faces {
            if self.area_vector(*face).length() < 1e-9 {
                return Err(format!("degenerate face {face:?}"));
            }
            for k in 0..3 {
                *directed.entry((face[k], face[(k + 1) % 3])).or_insert(0) += 1;
            }
        }
        for (&(a, b), &uses) in &directed {
            if uses != 1 || directed.get(&(b, a)) != Some(&1) {
                return Err(format!("edge {a}-{b} is not shared by two opposite faces"));
            }
        }
        self.verify_fans()?;
        let volume: f64 = self
            .faces
            .iter()
            .map(|f| self.area_vector(*f).dot(self.vertices[f[0]]))
            .sum();
        if volume <= 0.0 {
            return Err("the faces look inwards".to_owned());
        }
        let floor = self.bounds().0.z;
        if floor != 0.0 {
            return Err(format!("stands on z = {floor}, not 0"));
        }
        Ok(())
    }

    /// Checks that the faces around each vertex form one closed fan: no two cones meeting at
    /// their tips.
    fn verify_fans(&self) -> Result<(), String> {
        for (centre, around) in self.faces_by_vertex().iter().enumerate() {
            let next: HashMap<usize, usize> = around
                .iter()
                .map(|&f| opposite_edge(self.faces[f], centre))
                .collect();
            let Some(&start) = next.keys().next() else {
                return Err(format!("vertex {centre} is unused"));
            };
            let mut walker = start;
            let mut steps = 0;
            while steps == 0 || (walker != start && steps <= around.len()) {
                walker = *next
                    .get(&walker)
                    .ok_or_else(|| format!("open fan at vertex {centre}"))?;
                steps += 1;
            }
            if steps != around.len() {
                return Err(format!("vertex {centre} joins several sheets"));
            }
        }
        Ok(())
    }

    /// The mesh as text in the Object File Format.
    pub fn to_off(&self) -> String {
        let mut text = String::from("OFF\n# Sculpted by examples/sculpt.rs\n");
        let _ = writeln!(text, "{} {} 0", self.vertices.len(), self.faces.len());
        for v in &self.vertices {
            let _ = writeln!(text, "{} {} {}", v.x, v.y, v.z);
        }
        for [a, b, c] in &self.faces {
            let _ = writeln!(text, "3 {a} {b} {c}");
        }
        text
    }
}

/// The edge of a triangle that faces one of its corners, in the triangle's direction.
fn opposite_edge(face: [usize; 3], corner: usize) -> (usize, usize) {
    match face.iter().position(|&c| c == corner) {
        Some(0) => (face[1], face[2]),
        Some(1) => (face[2], face[0]),
        _ => (face[0], face[1]),
    }
}
