//! The beginning of an OFF file: its keyword and its counts.

use crate::io::mesh_reading::{Cursor, Malformed, number, whole};

/// The keyword's prefixes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "six facts, each true or not")]
pub struct Keyword {
    /// `ST`: texture coordinates follow the vertices.
    pub texture: bool,
    /// `C`: colours do.
    pub color: bool,
    /// `N`: normals do.
    pub normal: bool,
    /// Whether normals follow the colours: `NC`, as `MeshLab` writes it. Elsewhere `CN` is written, and normals come first.
    pub normal_is_late: bool,
    /// `4`: positions are homogeneous.
    pub homogeneous: bool,
    /// `n`: the dimension is given.
    pub dimension: bool,
}

impl Keyword {
    /// The keyword at the start of `word`, and what is glued to it.
    pub fn of(word: &[u8]) -> Option<(Self, &[u8])> {
        let mut keyword = Self::default();
        let mut rest = word;
        loop {
            if let Some(behind) = without_prefix(rest, b"OFF") {
                let is_whole = behind.is_empty() || behind[0].is_ascii_digit();
                return is_whole.then_some((keyword, behind));
            }
            let (prefix, length) = match rest {
                [b'S' | b's', b'T' | b't', ..] => (&mut keyword.texture, 2),
                [b'C' | b'c', ..] => {
                    keyword.normal_is_late = keyword.normal;
                    (&mut keyword.color, 1)
                }
                [b'N', ..] => (&mut keyword.normal, 1),
                [b'4', ..] => (&mut keyword.homogeneous, 1),
                [b'n', ..] => (&mut keyword.dimension, 1),
                _ => return None,
            };
            if std::mem::replace(prefix, true) {
                return None;
            }
            rest = &rest[length..];
        }
    }
}

/// What follows `prefix`, in letters of any case.
fn without_prefix<'a>(word: &'a [u8], prefix: &[u8]) -> Option<&'a [u8]> {
    let (head, tail) = word.split_at_checked(prefix.len())?;
    head.eq_ignore_ascii_case(prefix).then_some(tail)
}

/// What the beginning of the file says about the rest.
#[derive(Clone, Copy, Debug)]
pub struct Header {
    pub keyword: Keyword,
    pub vertices: u64,
    pub faces: u64,
    /// Whether there is neither a keyword nor a number of edges: so begin files of tetrahedra, too.
    pub is_bare: bool,
}

impl Header {
    /// Numbers with which a vertex begins, on however many lines: its position, and its normal where colours do not come first.
    pub fn numbers_per_vertex(&self) -> usize {
        let Keyword {
            homogeneous,
            normal,
            normal_is_late,
            ..
        } = self.keyword;
        let position = if homogeneous { 4 } else { 3 };
        let normal = if normal && !normal_is_late { 3 } else { 0 };
        position + normal
    }

    /// Numbers that the keyword says stand behind the vertex's colour: a normal, and a texture coordinate.
    pub fn numbers_behind_color(&self) -> usize {
        let normal = if self.keyword.normal_is_late { 3 } else { 0 };
        let texture = if self.keyword.texture { 2 } else { 0 };
        normal + texture
    }

    /// Reads the keyword, if there is one, and the counts.
    ///
    /// # Errors
    /// The first word that is none of them, or says what cannot be shown.
    pub fn read(cursor: &mut Cursor) -> Result<Self, Malformed> {
        const EXPECTED: &str =
            "OFF (or COFF, NOFF, STOFF, 4OFF) or the numbers of vertices and faces";
        let mut keyword = Keyword::default();
        let mut glued: &[u8] = &[];
        let mut ahead = cursor.clone();
        let Some(first) = ahead.find_word().then(|| ahead.word()).flatten() else {
            return Err(cursor.at_end(EXPECTED));
        };
        let line = ahead.line();
        if let Some((found, rest)) = Keyword::of(first) {
            (keyword, glued) = (found, rest);
            *cursor = ahead;
        } else if whole(first).is_none() {
            return Err(Malformed::at_token(line, EXPECTED, first));
        }
        let has_keyword = Keyword::of(first).is_some();
        read_dimension(cursor, keyword, &mut glued)?;
        let counts = read_counts(cursor, keyword, glued)?;
        Ok(Self {
            keyword,
            vertices: counts.vertices,
            faces: counts.faces,
            is_bare: !has_keyword && !counts.has_edges,
        })
    }
}

/// Reads the dimension where the keyword announces it, and refuses what cannot be shown.
fn read_dimension<'a>(
    cursor: &mut Cursor<'a>,
    keyword: Keyword,
    glued: &mut &'a [u8],
) -> Result<(), Malformed> {
    const EXPECTED: &str = "the dimension 3 after nOFF";
    if !keyword.dimension {
        return Ok(());
    }
    if keyword.homogeneous {
        return Err(in_three_dimensions(cursor.line(), "4nOFF"));
    }
    let word = if glued.is_empty() {
        cursor.next_word(EXPECTED)?
    } else {
        std::mem::take(glued)
    };
    match whole(word) {
        Some(3) => Ok(()),
        _ => Err(Malformed::at_token(cursor.line(), EXPECTED, word)),
    }
}

struct Counts {
    vertices: u64,
    faces: u64,
    has_edges: bool,
}

/// Reads the counts; `glued` is the first if it stuck to the keyword.
fn read_counts<'a>(
    cursor: &mut Cursor<'a>,
    keyword: Keyword,
    glued: &'a [u8],
) -> Result<Counts, Malformed> {
    const VERTICES: &str = "the number of vertices";
    const FACES: &str = "the number of faces";
    const EDGES: &str = "the number of edges";
    let word = if glued.is_empty() {
        cursor.next_word(VERTICES)?
    } else {
        glued
    };
    if word.eq_ignore_ascii_case(b"BINARY") {
        return Err(Malformed::at_token(cursor.line(), "OFF as text", word));
    }
    let vertices = cursor.count(word, VERTICES)?;
    if vertices > u64::from(u32::MAX) {
        let expected = "fewer than 2^32 vertices";
        return Err(Malformed::at_token(cursor.line(), expected, word));
    }
    let on_one_line = cursor.line_has_word();
    let word = cursor.next_word(FACES)?;
    let faces = cursor.count(word, FACES)?;
    let has_edges = !on_one_line || cursor.line_has_word();
    if has_edges {
        let word = cursor.next_word(EDGES)?;
        if number(word).is_none() {
            return Err(Malformed::at_token(cursor.line(), EDGES, word));
        }
    }
    if keyword.homogeneous && cursor.line_has_word() {
        // What programs of polytopes write: another format of the same name.
        return Err(in_three_dimensions(cursor.line(), "4OFF with cells"));
    }
    expect_end_of_line(cursor, "the end of the line after the counts")?;
    Ok(Counts {
        vertices,
        faces,
        has_edges,
    })
}

fn in_three_dimensions(line: u64, found: &str) -> Malformed {
    Malformed::in_line(line, "OFF of three dimensions", found)
}

/// Says what stands on the line that should end here.
pub fn expect_end_of_line(cursor: &mut Cursor, expected: &str) -> Result<(), Malformed> {
    match cursor.word() {
        Some(word) => Err(Malformed::at_token(cursor.line(), expected, word)),
        None => Ok(()),
    }
}
