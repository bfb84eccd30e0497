//! MTL, the material library format that goes with OBJ: text, one statement per line.
//!
//! ```text
//! newmtl wood          # what follows is of this material
//! Kd 0.6 0.4 0.2       # diffuse reflectance
//! Ks 0.1 0.1 0.1       # specular reflectance
//! Ns 60                # exponent of the highlight
//! Ke 0 0 0             # emitted radiance, of later programs
//! d 1                  # opacity; or Tr, what is left to 1
//! Ni 1.5               # index of refraction
//! illum 2              # how it is shaded, by a number; see [`MtlMaterial::to_material`]
//! map_Kd oak.png       # an image in place of Kd
//! norm bark.png        # normals; or map_Bump, bump
//! ```
//!
//! - A colour of one number is grey. Colours by files (`spectral`) or as `xyz` are ignored with a warning, as are numbers out of range.
//! - Names of images are kept; options before them are skipped, with a warning where they would change what is seen.
//! - Of two materials of one name the later one counts.
//! - Known statements that nothing here shows (`Ka`, `Tf`, `sharpness`, `Pr` and others) are skipped. Others are counted; a text of
//!   such alone is no MTL file.
//!
//! Source: Alias/Wavefront, MTL material format, 1995.

mod material;
mod write;

#[cfg(test)]
mod tests;

pub use material::MtlMaterial;
pub use write::{plain, write};

use std::collections::HashMap;

use foldhash::fast::RandomState;

use super::mesh_reading::{Cursor, Malformed, Place, Seen, Watch, number, whole};
use crate::control::{CancelToken, Progress};
use crate::scene::Rgb;

/// What an MTL file held.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MtlFile {
    /// The materials with their names, in the order of the file.
    pub materials: Vec<(String, MtlMaterial)>,
    /// What was ignored, in sentences with line numbers.
    pub warnings: Vec<String>,
}

/// Reads an MTL file from its bytes.
///
/// `progress` advances by the bytes read; setting its total is the caller's. Returns `None` when cancelled.
///
/// # Errors
/// The first statement nobody knows, where the text has no material.
pub fn parse(
    bytes: &[u8],
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<MtlFile>, Malformed> {
    let mut reader = Reader {
        cursor: Cursor::new(bytes),
        materials: Vec::new(),
        numbers: HashMap::default(),
        current: None,
        notes: Notes::default(),
    };
    let mut watch = Watch::new(cancel, progress);
    let mut index = 0;
    while reader.cursor.find_word() {
        if watch.report_item(index, reader.cursor.position()).is_none() {
            return Ok(None);
        }
        index += 1;
        reader.statement();
    }
    // Cancelling comes too late here: the work is done.
    let _ = watch.report(reader.cursor.position());
    reader.finish().map(Some)
}

/// The name that the rest of a statement says: all of it, but a comment that stands apart. (`Material #25` is a name.)
#[must_use]
pub fn name_in(rest: &[u8]) -> &[u8] {
    let is_blank = |byte: Option<&u8>| byte.is_none_or(u8::is_ascii_whitespace);
    let comment = (0..rest.len()).find(|&at| {
        let before = at.checked_sub(1).and_then(|before| rest.get(before));
        rest[at] == b'#' && is_blank(before) && is_blank(rest.get(at + 1))
    });
    rest[..comment.unwrap_or(rest.len())].trim_ascii()
}

/// What is ignored.
#[derive(Debug, Default)]
struct Notes<'a> {
    values: Seen,
    images: Seen,
    moved: Seen,
    homeless: Seen,
    repeated: Seen,
    unknown: Seen,
    /// The first statement nobody knows: its line and its word.
    first_unknown: Option<(u64, &'a [u8])>,
}

struct Reader<'a> {
    cursor: Cursor<'a>,
    /// Finished ones, by their names as they stand in the file.
    materials: Vec<(&'a [u8], MtlMaterial)>,
    /// The number of each name among them.
    numbers: HashMap<&'a [u8], usize, RandomState>,
    /// The one at hand.
    current: Option<(&'a [u8], MtlMaterial)>,
    notes: Notes<'a>,
}

impl Reader<'_> {
    fn statement(&mut self) {
        let line = self.cursor.line();
        let place = Place::Line(line);
        let word = self.cursor.word().unwrap_or_default();
        let keyword = word.to_ascii_lowercase();
        if keyword == b"newmtl" {
            self.keep_current();
            let name = name_in(self.cursor.rest_of_line());
            if self.numbers.contains_key(name) {
                self.notes.repeated.at(place);
            }
            self.current = Some((name, MtlMaterial::default()));
            return;
        }
        let Self {
            cursor,
            current,
            notes,
            ..
        } = self;
        let mut nobodys = MtlMaterial::default();
        let material = match current {
            Some((_, material)) => material,
            None => &mut nobodys,
        };
        let is_right = match &keyword[..] {
            b"kd" => set(&mut material.diffuse, color(cursor)),
            b"ks" => set(&mut material.specular, color(cursor)),
            b"ke" => set(&mut material.emission, color(cursor)),
            b"ns" => set(&mut material.shininess, not_negative(cursor.word())),
            b"ni" => set(&mut material.ior, not_negative(cursor.word())),
            b"d" => set(&mut material.opacity, share(cursor)),
            b"tr" => {
                let opacity = share(cursor).map(|transparency| 1.0 - transparency);
                // Where both are written and disagree, the other one is what programs mean.
                let stated = material.opacity.or(opacity);
                opacity.is_some() && set(&mut material.opacity, stated)
            }
            b"illum" => set(&mut material.illumination, cursor.word().and_then(whole)),
            b"map_kd" => set(&mut material.diffuse_image, image(cursor, &mut notes.moved)),
            b"norm" => set(&mut material.normal_image, image(cursor, &mut notes.moved)),
            b"map_bump" | b"bump" => {
                let image = image(cursor, &mut notes.moved);
                let is_right = image.is_some();
                material.normal_image = material.normal_image.take().or(image);
                is_right
            }
            known if is_passed_over(known) => true,
            known if is_image(known) => {
                notes.images.at(place);
                true
            }
            _ => {
                notes.unknown.at(place);
                notes.first_unknown.get_or_insert((line, word));
                cursor.rest_of_line();
                return;
            }
        };
        if current.is_none() {
            notes.homeless.at(place);
        } else if !is_right {
            notes.values.at(place);
        }
        cursor.rest_of_line();
    }

    fn keep_current(&mut self) {
        let Some((name, material)) = self.current.take() else {
            return;
        };
        let next = self.materials.len();
        let number = *self.numbers.entry(name).or_insert(next);
        if number == next {
            self.materials.push((name, material));
        } else {
            self.materials[number].1 = material;
        }
    }

    fn finish(mut self) -> Result<MtlFile, Malformed> {
        self.keep_current();
        let notes = &self.notes;
        if let (Some((line, word)), true) = (notes.first_unknown, self.materials.is_empty()) {
            let expected = "newmtl or another keyword of MTL";
            return Err(Malformed::at_token(line, expected, word));
        }
        let warnings = [
            notes.values.counted(
                "value that is no number in its range is ignored",
                "values that are no numbers in their range are ignored",
            ),
            notes.homeless.counted(
                "statement before the first newmtl is ignored",
                "statements before the first newmtl are ignored",
            ),
            notes.repeated.counted(
                "material is there twice; the later one counts",
                "materials are there more than once; the later ones count",
            ),
            notes
                .images
                .found("images other than those of Kd and of normals are ignored"),
            notes.moved.found(
                "images are not moved, scaled, cut off at their edges or made steeper, as options say",
            ),
            notes.unknown.counted(
                "statement of another kind is ignored",
                "statements of other kinds are ignored",
            ),
        ];
        let in_text = |(name, material): (&[u8], MtlMaterial)| {
            (String::from_utf8_lossy(name).into_owned(), material)
        };
        Ok(MtlFile {
            materials: self.materials.into_iter().map(in_text).collect(),
            warnings: warnings.into_iter().flatten().collect(),
        })
    }
}

/// Statements of which nothing is shown.
fn is_passed_over(keyword: &[u8]) -> bool {
    let known: [&[u8]; 11] = [
        b"ka",
        b"tf",
        b"sharpness",
        b"pr",
        b"pm",
        b"ps",
        b"pc",
        b"pcr",
        b"aniso",
        b"anisor",
        b"map_aat",
    ];
    known.contains(&keyword)
}

/// Statements that name images which are not shown.
fn is_image(keyword: &[u8]) -> bool {
    keyword.starts_with(b"map_") || [&b"disp"[..], b"decal", b"refl"].contains(&keyword)
}

/// Sets `place` to a value that is right, and says whether it is.
fn set<T>(place: &mut Option<T>, value: Option<T>) -> bool {
    let is_right = value.is_some();
    if is_right {
        *place = value;
    }
    is_right
}

fn not_negative(word: Option<&[u8]>) -> Option<f64> {
    number(word?).filter(|value| value.is_finite() && *value >= 0.0)
}

/// A number from 0 to 1, perhaps behind an option.
fn share(cursor: &mut Cursor) -> Option<f64> {
    let mut word = cursor.word();
    if word == Some(b"-halo") {
        word = cursor.word();
    }
    not_negative(word).filter(|value| *value <= 1.0)
}

/// One number for all channels, or three.
fn color(cursor: &mut Cursor) -> Option<Rgb> {
    let red = not_negative(cursor.word())?;
    let Some(green) = cursor.word() else {
        return Some(Rgb::splat(red));
    };
    Some(Rgb::new(
        red,
        not_negative(Some(green))?,
        not_negative(cursor.word())?,
    ))
}

/// The name of an image, behind its options; that they would change what is seen is noted in `moved`.
fn image(cursor: &mut Cursor, moved: &mut Seen) -> Option<String> {
    let place = Place::Line(cursor.line());
    let mut rest = name_in(cursor.rest_of_line());
    let mut has_moved = false;
    while let Some((is_heeded, behind)) = after_option(rest) {
        has_moved |= !is_heeded;
        rest = behind;
    }
    if has_moved {
        moved.at(place);
    }
    (!rest.is_empty()).then(|| String::from_utf8_lossy(rest).into_owned())
}

/// What follows the option at the beginning, if there is one, and whether the option changes nothing.
fn after_option(text: &[u8]) -> Option<(bool, &[u8])> {
    let (option, mut rest) = first_word(text)?;
    // How many numbers follow, and what each has to be for nothing to change.
    let (numbers, usual) = match &option.to_ascii_lowercase()[..] {
        b"-o" | b"-t" => (3, Some(0.0)),
        b"-s" => (3, Some(1.0)),
        b"-bm" => (1, Some(1.0)),
        b"-mm" => (2, None),
        b"-boost" | b"-texres" => (1, None),
        b"-clamp" => {
            let (word, behind) = first_word(rest)?;
            return Some((!word.eq_ignore_ascii_case(b"on"), behind));
        }
        b"-blendu" | b"-blendv" | b"-cc" | b"-imfchan" | b"-type" => {
            return Some((true, first_word(rest)?.1));
        }
        _ => return None,
    };
    let mut changes_nothing = true;
    // Of three numbers the last ones may be missing.
    for _ in 0..numbers {
        let Some((word, behind)) = first_word(rest) else {
            break;
        };
        let Some(value) = number(word) else {
            break;
        };
        changes_nothing &= usual.is_none_or(|usual| value == usual);
        rest = behind;
    }
    Some((changes_nothing, rest))
}

/// The first word, and what follows it.
fn first_word(text: &[u8]) -> Option<(&[u8], &[u8])> {
    let text = text.trim_ascii_start();
    let length = text.iter().position(u8::is_ascii_whitespace);
    let (word, rest) = text.split_at(length.unwrap_or(text.len()));
    (!word.is_empty()).then_some((word, rest.trim_ascii_start()))
}
