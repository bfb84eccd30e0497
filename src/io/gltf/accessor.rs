//! Numbers in buffers. Nothing is taken for granted: every place is checked before it is read, and how much is read is bounded by what
//! the file holds.

use std::borrow::Cow;
use std::cell::Cell;

use super::document::{Accessor, Document, Index};
use crate::io::mesh_reading::{List, Malformed, Place};

/// Numbers that may be read of any file.
const FREE_NUMBERS: u64 = 1 << 20;
/// Beyond that, how many for each byte of the file and of those it refers to. A number stands in one byte at least, and may be read
/// several times where lists overlap; lists that are the same are read once.
const NUMBERS_PER_BYTE: u64 = 4;

/// A document and the bytes that it refers to.
pub struct Data<'a> {
    pub document: &'a Document,
    buffers: Vec<Cow<'a, [u8]>>,
    /// Numbers that may still be read.
    left: Cell<u64>,
}

/// How a number is stored.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of_code(code: u32) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The number at the beginning of `bytes`, which are enough. Normalised ones are shares of the largest.
    fn read(self, bytes: &[u8], normalized: bool) -> f64 {
        let two = || [bytes[0], bytes[1]];
        let four = || [bytes[0], bytes[1], bytes[2], bytes[3]];
        let share = |value: f64, largest: f64| {
            if normalized {
                (value / largest).max(-1.0)
            } else {
                value
            }
        };
        match self {
            Self::I8 => share(f64::from(i8::from_le_bytes([bytes[0]])), 127.0),
            Self::U8 => share(f64::from(bytes[0]), 255.0),
            Self::I16 => share(f64::from(i16::from_le_bytes(two())), 32767.0),
            Self::U16 => share(f64::from(u16::from_le_bytes(two())), 65535.0),
            Self::U32 => share(f64::from(u32::from_le_bytes(four())), 4_294_967_295.0),
            Self::F32 => f64::from(f32::from_le_bytes(four())),
        }
    }
}

/// Equal pieces of bytes at equal distances, checked to be there.
struct Pieces<'a> {
    bytes: &'a [u8],
    stride: usize,
    length: usize,
    count: usize,
}

impl<'a> Pieces<'a> {
    fn iter(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        let Self {
            bytes,
            stride,
            length,
            count,
        } = *self;
        (0..count).map(move |index| &bytes[index * stride..index * stride + length])
    }
}

fn place(accessor: Index) -> Place {
    Place::Item(List::Accessors, accessor)
}

impl<'a> Data<'a> {
    /// `bytes`: how many the file has, and those it refers to.
    pub fn new(document: &'a Document, buffers: Vec<Cow<'a, [u8]>>, bytes: u64) -> Self {
        let left = FREE_NUMBERS.max(bytes.saturating_mul(NUMBERS_PER_BYTE));
        Self {
            document,
            buffers,
            left: Cell::new(left),
        }
    }

    fn accessor(&self, index: Index) -> Result<&'a Accessor, Malformed> {
        let all = &self.document.accessors;
        all.get(index as usize)
            .ok_or_else(|| beyond(List::Accessors, index, all.len()))
    }

    /// The elements of an accessor of `N` numbers each.
    pub fn vectors<const N: usize>(
        &self,
        index: Index,
        expected: &str,
    ) -> Result<Vec<[f64; N]>, Malformed> {
        let accessor = self.accessor(index)?;
        let width = match accessor.kind.as_str() {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 0,
        };
        if width != N {
            return Err(Malformed::at(
                place(index),
                expected,
                format!(
                    "those of type {}",
                    crate::io::shorten::shortened(&accessor.kind)
                ),
            ));
        }
        let component = Component::of_code(accessor.component_type).ok_or_else(|| {
            let found = accessor.component_type.to_string();
            Malformed::at(place(index), "a component type from 5120 to 5126", found)
        })?;
        let count = self.spend(index, accessor.count, N)?;
        let element = |bytes: &[u8]| -> [f64; N] {
            std::array::from_fn(|i| {
                component.read(&bytes[i * component.bytes()..], accessor.normalized)
            })
        };
        let length = N * component.bytes();
        let mut elements = match accessor.buffer_view {
            Some(view) => {
                let pieces = self.pieces(index, view, accessor.byte_offset, length, count)?;
                pieces.iter().map(element).collect()
            }
            None => vec![[0.0; N]; count],
        };
        if let Some(sparse) = &accessor.sparse {
            let replaced = self.spend(index, sparse.count, N)?;
            let kind = Component::of_code(sparse.indices.component_type);
            let kind =
                kind.filter(|kind| matches!(kind, Component::U8 | Component::U16 | Component::U32));
            let kind = kind.ok_or_else(|| {
                Malformed::at(place(index), "sparse indices of an unsigned type", "others")
            })?;
            let indices = self.pieces(
                index,
                sparse.indices.buffer_view,
                sparse.indices.byte_offset,
                kind.bytes(),
                replaced,
            )?;
            let values = self.pieces(
                index,
                sparse.values.buffer_view,
                sparse.values.byte_offset,
                length,
                replaced,
            )?;
            for (at, value) in indices.iter().zip(values.iter()) {
                let at = kind.read(at, false);
                // Whole and not negative.
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "read of a u32"
                )]
                let element_at = elements.get_mut(at as usize);
                let element_at = element_at.ok_or_else(|| {
                    Malformed::at(
                        place(index),
                        format!("sparse indices below {count}"),
                        at.to_string(),
                    )
                })?;
                *element_at = element(value);
            }
        }
        Ok(elements)
    }

    /// The whole numbers of an accessor.
    pub fn indices(&self, index: Index) -> Result<Vec<u32>, Malformed> {
        const EXPECTED: &str = "indices of an unsigned type";
        let code = self.accessor(index)?.component_type;
        let is_unsigned = matches!(
            Component::of_code(code),
            Some(Component::U8 | Component::U16 | Component::U32)
        );
        if !is_unsigned {
            return Err(Malformed::at(
                place(index),
                EXPECTED,
                format!("component type {code}"),
            ));
        }
        let numbers = self.vectors::<1>(index, EXPECTED)?;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "read of a u32"
        )]
        let whole = |[number]: [f64; 1]| number as u32;
        Ok(numbers.into_iter().map(whole).collect())
    }

    /// The bytes of a buffer view.
    pub fn view(&self, index: Index) -> Result<&[u8], Malformed> {
        let views = &self.document.buffer_views;
        let view = views
            .get(index as usize)
            .ok_or_else(|| beyond(List::BufferViews, index, views.len()))?;
        let buffer = self.buffers.get(view.buffer as usize);
        let buffer =
            buffer.ok_or_else(|| beyond(List::Buffers, view.buffer, self.buffers.len()))?;
        let end = view.byte_offset.saturating_add(view.byte_length);
        slice(buffer, view.byte_offset, end).ok_or_else(|| {
            let expected = format!("at most {} bytes, those of its buffer", buffer.len());
            Malformed::at(
                Place::Item(List::BufferViews, index),
                expected,
                format!("bytes {} to {end}", view.byte_offset),
            )
        })
    }

    /// `count` pieces of `length` bytes each in a view, from an offset on.
    fn pieces(
        &self,
        accessor: Index,
        view: Index,
        offset: u64,
        length: usize,
        count: usize,
    ) -> Result<Pieces<'_>, Malformed> {
        let bytes = self.view(view)?;
        let stride = self.document.buffer_views[view as usize].byte_stride;
        let stride = stride
            .filter(|&stride| stride != 0)
            .unwrap_or(length as u64);
        if stride < length as u64 {
            let expected = format!("a stride of at least {length} bytes");
            return Err(Malformed::at(
                Place::Item(List::BufferViews, view),
                expected,
                stride.to_string(),
            ));
        }
        let needed = (count as u64)
            .saturating_sub(1)
            .saturating_mul(stride)
            .saturating_add(length as u64);
        let needed = if count == 0 { 0 } else { needed };
        let end = offset.saturating_add(needed);
        let whole = slice(bytes, offset, end).ok_or_else(|| {
            let expected = format!("elements within the {} bytes of its view", bytes.len());
            Malformed::at(
                place(accessor),
                expected,
                format!("bytes {offset} to {end}"),
            )
        })?;
        Ok(Pieces {
            bytes: whole,
            stride: usize::try_from(stride).unwrap_or(usize::MAX),
            length,
            count,
        })
    }

    /// Takes note that `count` elements are to be read.
    fn spend(&self, accessor: Index, count: u64, width: usize) -> Result<usize, Malformed> {
        self.spend_at(place(accessor), count, width)?;
        // Fits, as there was as much left.
        Ok(usize::try_from(count).unwrap_or(usize::MAX))
    }

    /// Takes note that so many vertices are made for what stands at `place`.
    ///
    /// # Errors
    /// That they are more than the file accounts for.
    pub fn spend_vertices(&self, place: Place, count: u64) -> Result<(), Malformed> {
        self.spend_at(place, count, 3)
    }

    fn spend_at(&self, place: Place, count: u64, width: usize) -> Result<(), Malformed> {
        let left = self
            .left
            .get()
            .checked_sub(count.saturating_mul(width as u64))
            .ok_or_else(|| {
                let expected = "no more elements than a file of this size accounts for";
                Malformed::at(place, expected, count.to_string())
            })?;
        self.left.set(left);
        Ok(())
    }
}

fn slice(bytes: &[u8], start: u64, end: u64) -> Option<&[u8]> {
    bytes.get(usize::try_from(start).ok()?..usize::try_from(end).ok()?)
}

/// What is said of a number in a list that is not that long.
pub fn beyond(list: List, index: Index, length: usize) -> Malformed {
    Malformed::at(
        Place::Item(list, index),
        format!("one of {length} {list}"),
        "none of that number",
    )
}
