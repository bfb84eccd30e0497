//! The corners of faces: `v`, `v/vt`, `v//vn` or `v/vt/vn`.

use crate::io::mesh_reading::{self, Malformed};

/// What a corner names, as indices from 0 in the lists of the file, which may not be as long yet.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    /// The vertex.
    pub position: u32,
    /// The normal, or [`NONE`].
    normal: u32,
    /// The texture coordinate, or [`NONE`].
    texture: u32,
}

/// Stands for no normal or texture coordinate.
const NONE: u32 = u32::MAX;

impl mesh_reading::Corner for Corner {
    fn position(self) -> usize {
        self.position as usize
    }
}

/// How many vertices, normals and texture coordinates there are so far.
#[derive(Clone, Copy)]
pub struct Counts {
    pub positions: usize,
    pub normals: usize,
    pub textures: usize,
}

/// A word of the text and its line.
#[derive(Clone, Copy)]
pub struct Word<'a> {
    pub line: u64,
    pub word: &'a [u8],
}

impl Word<'_> {
    fn expected(self, expected: impl Into<String>) -> Malformed {
        Malformed::at_token(self.line, expected, self.word)
    }

    /// The index that `number` in this word means, where there are `count` things called `what` so far.
    fn index(self, number: i64, count: usize, what: &str) -> Result<u32, Malformed> {
        let index = if number < 0 {
            i64::try_from(count).ok().map(|count| count + number)
        } else {
            Some(number - 1)
        };
        let index = index.and_then(|index| u32::try_from(index).ok());
        index.filter(|&index| index != NONE).ok_or_else(|| {
            self.expected(match count {
                0 => format!("a {what} number above 0"),
                _ => format!("a {what} number above 0 or from -{count} to -1"),
            })
        })
    }
}

impl Corner {
    /// The corner that `word` says, where there are so many of what it names so far. Texture coordinates that cannot be are none:
    /// many files name some that they do not have.
    ///
    /// # Errors
    /// When it is none, or a vertex or normal counts back beyond the first.
    pub fn read(word: Word, counts: Counts) -> Result<Self, Malformed> {
        let Counts {
            positions,
            normals,
            textures,
        } = counts;
        let parts = Parts::of(word.word);
        let parts = parts.ok_or_else(|| word.expected("a corner such as 1, 1/2, 1//3 or 1/2/3"))?;
        Ok(Self {
            position: word.index(parts.position, positions, "vertex")?,
            normal: match parts.normal {
                Some(normal) => word.index(normal, normals, "normal")?,
                None => NONE,
            },
            texture: parts
                .texture
                .and_then(|texture| word.index(texture, textures, "texture coordinate").ok())
                .unwrap_or(NONE),
        })
    }

    /// The normal it names, if it does.
    pub fn normal(self) -> Option<u32> {
        (self.normal != NONE).then_some(self.normal)
    }

    /// The texture coordinate it names, if it does.
    pub fn texture(self) -> Option<u32> {
        (self.texture != NONE).then_some(self.texture)
    }

    /// Whether it names what is not among so many `positions` and `normals`.
    pub fn is_beyond(self, positions: usize, normals: usize) -> bool {
        let has_normal = self.normal == NONE || (self.normal as usize) < normals;
        self.position as usize >= positions || !has_normal
    }

    /// Says what is wrong where [`Corner::is_beyond`]; `line`: that of its face.
    pub fn check(self, line: u64, positions: usize, normals: usize) -> Result<(), Malformed> {
        if !self.is_beyond(positions, normals) {
            return Ok(());
        }
        let (index, count, what) = if self.position as usize >= positions {
            (self.position, positions, "vertex")
        } else {
            (self.normal, normals, "normal")
        };
        let expected = format!("a {what} number of at most {count}");
        let found = (u64::from(index) + 1).to_string();
        Err(Malformed::in_line(line, expected, found))
    }
}

/// The numbers of a corner as they are written.
struct Parts {
    position: i64,
    texture: Option<i64>,
    normal: Option<i64>,
}

impl Parts {
    fn of(word: &[u8]) -> Option<Self> {
        let (position, rest) = split_number(word)?;
        let position = position?;
        let Some(rest) = rest.strip_prefix(b"/") else {
            return rest.is_empty().then_some(Self {
                position,
                texture: None,
                normal: None,
            });
        };
        let (texture, rest) = split_number(rest)?;
        let rest = rest.strip_prefix(b"/").unwrap_or(rest);
        let (normal, rest) = split_number(rest)?;
        rest.is_empty().then_some(Self {
            position,
            texture,
            normal,
        })
    }
}

/// No number of as many digits is too large.
const DIGITS_THAT_FIT: usize = 18;

/// The whole number at the front, if there is one, and what follows it; too large ones are the largest. `None` for a sign alone.
fn split_number(text: &[u8]) -> Option<(Option<i64>, &[u8])> {
    let (is_negative, digits) = match text {
        [b'-', rest @ ..] => (true, rest),
        _ => (false, text),
    };
    let mut value = 0_i64;
    let mut length = 0;
    while let Some(digit) = digits.get(length).map(|byte| byte.wrapping_sub(b'0'))
        && digit <= 9
    {
        value = if length < DIGITS_THAT_FIT {
            value * 10 + i64::from(digit)
        } else {
            value.saturating_mul(10).saturating_add(i64::from(digit))
        };
        length += 1;
    }
    let rest = &digits[length..];
    if length == 0 {
        return (!is_negative).then_some((None, rest));
    }
    Some((Some(if is_negative { -value } else { value }), rest))
}
