//! Vertices that become several, where corners at one position differ.

use std::collections::HashMap;
use std::hash::Hash;

use foldhash::fast::RandomState;

use crate::math::{DVec2, DVec3, Vec3};

/// What corners at one position may differ in.
pub trait Attribute: Copy + Default + PartialEq {
    /// The same for equal ones, and for those alone.
    type Key: Copy + Eq + Hash;

    /// Its key.
    fn key(self) -> Self::Key;
}

impl Attribute for DVec2 {
    type Key = [u64; 2];

    fn key(self) -> Self::Key {
        // −0 + 0 is 0.
        self.to_array().map(|value| (value + 0.0).to_bits())
    }
}

impl Attribute for DVec3 {
    type Key = [u64; 3];

    fn key(self) -> Self::Key {
        self.to_array().map(|value| (value + 0.0).to_bits())
    }
}

impl<A: Attribute, B: Attribute> Attribute for (A, B) {
    type Key = (A::Key, B::Key);

    fn key(self) -> Self::Key {
        (self.0.key(), self.1.key())
    }
}

impl Attribute for Vec3 {
    type Key = [u32; 3];

    fn key(self) -> Self::Key {
        self.to_array().map(|value| (value + 0.0).to_bits())
    }
}

/// Triangles whose corners are vertices of one attribute each.
pub struct Split<A> {
    /// Three vertices each: first those of the file, then further ones.
    pub triangles: Vec<[u32; 3]>,
    /// One for each vertex; that of a position without corner is the default.
    pub attributes: Vec<A>,
    /// The position of each further vertex.
    further: Vec<u32>,
}

/// Splits as many vertices as there are `positions` where corners, each of a position and an attribute, have others than the first there.
///
/// `go_on` is asked at every triangle, by its index; `Ok(None)` when it says so.
///
/// # Errors
/// When there are more vertices than can be numbered.
///
/// # Panics
/// When a corner has none of the positions.
pub fn split<A: Attribute>(
    positions: usize,
    triangles: impl ExactSizeIterator<Item = [(u32, A); 3]>,
    mut go_on: impl FnMut(u64) -> Option<()>,
) -> Result<Option<Split<A>>, TooMany> {
    let mut of_positions: Vec<Option<A>> = vec![None; positions];
    let mut vertices = HashMap::<(u32, A::Key), u32, RandomState>::default();
    let mut further = Vec::new();
    let mut of_further = Vec::new();
    let mut split = Vec::with_capacity(triangles.len());
    for (index, corners) in (0..).zip(triangles) {
        if go_on(index).is_none() {
            return Ok(None);
        }
        let mut triangle = [0; 3];
        for (vertex, (position, attribute)) in triangle.iter_mut().zip(corners) {
            let of_position = &mut of_positions[position as usize];
            *vertex = if *of_position.get_or_insert(attribute) == attribute {
                position
            } else {
                let next = u32::try_from(positions + further.len()).map_err(|_| TooMany)?;
                let vertex = *vertices.entry((position, attribute.key())).or_insert(next);
                if vertex == next {
                    further.push(position);
                    of_further.push(attribute);
                }
                vertex
            };
        }
        split.push(triangle);
    }
    let of_positions = of_positions.into_iter().map(Option::unwrap_or_default);
    Ok(Some(Split {
        triangles: split,
        attributes: of_positions.chain(of_further).collect(),
        further,
    }))
}

/// There are more vertices than can be numbered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooMany;

impl<A> Split<A> {
    /// Gives the further vertices what `list` has for their positions.
    pub fn extend<T: Copy>(&self, list: &mut Vec<T>) {
        list.reserve_exact(self.further.len());
        for &position in &self.further {
            list.push(list[position as usize]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vertex_becomes_several_only_where_corners_differ() {
        let (a, b) = (DVec2::new(0.5, -0.0), DVec2::new(0.5, 0.0));
        let other = DVec2::X;
        let triangles = [
            [(0, a), (1, a), (2, other)],
            [(0, b), (1, other), (2, other)],
            [(0, other), (1, other), (2, a)],
            [(2, b), (1, a), (0, b)],
        ];
        let read = split(4, triangles.into_iter(), |_| Some(())).expect("few");
        let read = read.expect("nobody cancels");
        let expected = [[0, 1, 2], [0, 4, 2], [5, 4, 6], [6, 1, 0]];
        assert_eq!(read.triangles, expected);
        let attributes = [a, a, other, DVec2::ZERO, other, other, a];
        assert_eq!(read.attributes, attributes);
        let mut list = vec!['a', 'b', 'c', 'd'];
        read.extend(&mut list);
        assert_eq!(list, ['a', 'b', 'c', 'd', 'b', 'a', 'c']);
        let cancelled = split(4, triangles.into_iter(), |index| (index < 2).then_some(()));
        assert!(matches!(cancelled, Ok(None)));
    }
}
