//! What a picture's file tells about how it came to be: the scene with its settings, so that it can be opened and rendered again, and
//! how wrong the picture is.

use std::io::{self, BufRead, BufReader, Cursor, Seek};
use std::path::Path;

use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, Text};
use png::text_metadata::ITXtChunk;
use serde::{Deserialize, Serialize};

use super::save::portable_text;
use super::scene_file::SceneFile;
use super::unless::cancelled;
use super::whole_file::open_file;
use crate::control::CancelToken;
use crate::render::{ErrorEstimate, Image, Region};
use crate::scene::Scene;

/// Keyword of the PNG text, and name of the OpenEXR attribute, that holds the text of the scene file.
const SCENE_KEYWORD: &str = "raymini.scene";
/// The same of the error.
const ERROR_KEYWORD: &str = "raymini.error";
/// The same of the region, where the picture is a part of what the scene says.
const REGION_KEYWORD: &str = "raymini.region";
/// The same of [`Image::hash`] of what was rendered: in a PNG, which rounds it, and in an OpenEXR file of values that were rounded before.
pub(super) const HASH_KEYWORD: &str = "raymini.image_hash";
/// What stands there where the hash is not known.
const UNKNOWN_HASH: &str = "unknown";

/// The most bytes of such a text that are read.
const MOST_BYTES: usize = 16 << 20;

/// How a picture came to be.
#[derive(Clone, Copy, Debug)]
pub struct Origin<'a> {
    /// What was rendered.
    pub scene: &'a Scene,
    /// How wrong it was then, where that is known.
    pub error: Option<WrittenError>,
    /// Which part of what the scene says the picture is; `None` for all of it.
    pub region: Option<Region>,
    /// What its values are.
    pub values: Values<'a>,
}

/// What the values of a picture are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Values<'a> {
    /// Those that were rendered.
    #[default]
    Rendered,
    /// Those of a file that had rounded what was rendered, and its hash, where that is known.
    Rounded(Option<&'a str>),
}

/// How wrong a picture is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WrittenError {
    /// Root of the mean square error, in units of radiance.
    pub rmse: f64,
    /// Mean of error² / (truth² + 0.01).
    pub relmse: f64,
    /// Mean samples of a pixel.
    pub samples_per_pixel: f64,
}

impl WrittenError {
    /// √relmse: 0.03 is called 3 % noise.
    #[must_use]
    pub fn noise(&self) -> f64 {
        self.relmse.sqrt()
    }
}

impl From<&ErrorEstimate> for WrittenError {
    fn from(error: &ErrorEstimate) -> Self {
        Self {
            rmse: error.rmse.value,
            relmse: error.relmse.value,
            samples_per_pixel: error.samples_per_pixel,
        }
    }
}

/// What a picture's file tells of its origin.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WrittenOrigin {
    /// The scene file; meshes and images relative to the picture's folder.
    pub scene: Option<String>,
    /// How wrong the picture is.
    pub error: Option<WrittenError>,
    /// Which part of what the scene says the picture is; `None` for all of it.
    pub region: Option<Region>,
    /// The hash of what was rendered, where the file's own values are not that; empty where it is not known.
    pub rendered_hash: Option<String>,
}

/// What is written into a file: keywords and their texts, and what its values are.
#[derive(Clone, Debug, Default)]
pub(super) struct OriginTexts<'a> {
    texts: Vec<(&'static str, String)>,
    values: Values<'a>,
}

impl<'a> Origin<'a> {
    /// What to write into a file at `path`.
    pub(super) fn texts(&self, path: &Path) -> OriginTexts<'a> {
        // What cannot be said in the file is no reason to have no picture.
        let scene = portable_text(self.scene, path).ok();
        let error = self
            .error
            .and_then(|error| serde_json::to_string(&error).ok());
        let region = self
            .region
            .and_then(|region| serde_json::to_string(&region).ok());
        let scene = scene.map(|text| (SCENE_KEYWORD, text));
        let error = error.map(|text| (ERROR_KEYWORD, text));
        let region = region.map(|text| (REGION_KEYWORD, text));
        OriginTexts {
            texts: scene.into_iter().chain(error).chain(region).collect(),
            values: self.values,
        }
    }
}

impl OriginTexts<'_> {
    /// The hash of what was rendered, for a PNG file of `image`; `None` where it is not known.
    ///
    /// # Errors
    /// When cancelled.
    pub fn png_hash(&self, image: &Image, cancel: &CancelToken) -> io::Result<Option<String>> {
        match self.values {
            Values::Rendered => image.hash_unless(cancel).ok_or_else(cancelled).map(Some),
            Values::Rounded(hash) => Ok(hash.map(str::to_owned)),
        }
    }

    /// The chunks of a PNG file.
    pub fn png_chunks(&self) -> impl Iterator<Item = ITXtChunk> {
        self.texts.iter().map(|(keyword, text)| {
            let mut chunk = ITXtChunk::new(*keyword, text);
            chunk.compressed = true;
            chunk
        })
    }

    /// The attributes of an OpenEXR file.
    pub fn exr_attributes(&self) -> impl Iterator<Item = (Text, AttributeValue)> {
        // Values that were rendered have the hash themselves.
        let hash = match self.values {
            Values::Rendered => None,
            Values::Rounded(hash) => Some((HASH_KEYWORD, hash.unwrap_or(UNKNOWN_HASH))),
        };
        let texts = self.texts.iter();
        let texts = texts.map(|(keyword, text)| (*keyword, text.as_str()));
        texts.chain(hash).map(|(keyword, text)| {
            let bytes = text.as_bytes().into();
            let text = AttributeValue::Text(Text::from_bytes_unchecked(bytes));
            (Text::from(keyword), text)
        })
    }
}

impl WrittenOrigin {
    /// Width and height of the picture that the scene says, of which this one may be a part.
    #[must_use]
    pub fn picture_size(&self) -> Option<(u32, u32)> {
        let file = SceneFile::parse(self.scene.as_ref()?, "").ok()?;
        let render = &file.scene.render;
        Some((render.width, render.height))
    }

    fn of_png(info: &png::Info<'_>) -> Self {
        let text = |keyword: &str| {
            let chunk = info.utf8_text.iter().find(|chunk| chunk.keyword == keyword);
            let mut chunk = chunk?.clone();
            chunk.decompress_text_with_limit(MOST_BYTES).ok()?;
            chunk.get_text().ok()
        };
        let mut hashes = info.uncompressed_latin1_text.iter();
        let hash = hashes.find(|chunk| chunk.keyword == HASH_KEYWORD);
        let hash = hash.map_or(UNKNOWN_HASH, |chunk| &chunk.text);
        Self::of_texts(text, Some(hash))
    }

    /// What the file at `path` tells: nothing where it is no picture of a kind that can.
    ///
    /// # Errors
    /// Why it cannot be read, in a plain sentence that does not name the file.
    pub fn of_file(path: &Path) -> Result<Self, String> {
        let file = BufReader::new(open_file(path, "a picture")?);
        Ok(Self::read(file)?.unwrap_or_default())
    }

    /// What the picture at `path` tells.
    ///
    /// # Errors
    /// Those of [`Self::of_file`], and that it is no picture of a kind that can.
    pub(super) fn of_render(path: &Path) -> Result<Self, String> {
        let file = BufReader::new(open_file(path, "a picture")?);
        Self::read(file)?.ok_or_else(|| {
            "this is neither a PNG nor an OpenEXR file, or its first bytes are damaged".to_owned()
        })
    }

    /// [`Self::of_file`] of a file that begins with these bytes.
    ///
    /// # Errors
    /// What is wrong with them, in a plain sentence.
    pub fn of_bytes(bytes: &[u8]) -> Result<Self, String> {
        Ok(Self::read(Cursor::new(bytes))?.unwrap_or_default())
    }

    /// `None` where it is no picture of a kind that can tell.
    fn read(mut file: impl BufRead + Seek) -> Result<Option<Self>, String> {
        let begin = file.fill_buf().map_err(|error| error.to_string())?;
        if begin.starts_with(b"\x89PNG") {
            let mut options = png::DecodeOptions::default();
            // A damaged text would count as none.
            options.set_skip_ancillary_crc_failures(false);
            let reader = png::Decoder::new_with_options(file, options).read_info();
            let reader = reader.map_err(|error| format!("not a whole PNG file: {error}"))?;
            return Ok(Some(Self::of_png(reader.info())));
        }
        if begin.starts_with(&exr::meta::magic_number::BYTES) {
            let meta = MetaData::read_from_buffered(file, false);
            let meta = meta.map_err(|error| format!("not a whole OpenEXR file: {error}"))?;
            return Ok(Some(Self::of_exr(&meta)));
        }
        Ok(None)
    }

    fn of_exr(meta: &MetaData) -> Self {
        let text = |keyword: &str| {
            let attributes = &meta.headers.first()?.own_attributes.other;
            match attributes.get(&Text::from(keyword))? {
                AttributeValue::Text(text) => String::from_utf8(text.as_slice().to_vec()).ok(),
                _ => None,
            }
        };
        let hash = text(HASH_KEYWORD);
        Self::of_texts(text, hash.as_deref())
    }

    fn of_texts(text: impl Fn(&str) -> Option<String>, hash: Option<&str>) -> Self {
        let (error, region) = (text(ERROR_KEYWORD), text(REGION_KEYWORD));
        let is_hash = |hash: &&str| hash.len() == 64 && hash.bytes().all(|b| b.is_ascii_hexdigit());
        Self {
            scene: text(SCENE_KEYWORD),
            error: error.and_then(|text| serde_json::from_str(&text).ok()),
            region: region.and_then(|text| serde_json::from_str(&text).ok()),
            rendered_hash: hash
                .map(|hash| Some(hash).filter(is_hash).unwrap_or_default().to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::{CancelToken, Progress};
    use crate::io::{
        LoadedScene, absolute_mesh, demo_scene, load_scene, save_scene, write_image, write_render,
    };
    use crate::math::Degrees;
    use crate::render::{Image, Interval};
    use crate::scene::{Display, Output};
    use std::fs;

    fn load(path: &Path) -> Result<LoadedScene, String> {
        let loaded = load_scene(path, &CancelToken::new(), &Progress::new());
        let loaded = loaded.map_err(|error| error.to_string())?;
        Ok(loaded.expect("nobody cancels"))
    }

    fn interval(value: f64) -> Interval {
        Interval {
            value,
            low: 0.0,
            high: 1.0,
        }
    }

    #[test]
    fn a_render_is_opened_as_the_scene_that_was_rendered() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mesh = folder.path().join("three.off");
        fs::write(&mesh, "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").expect("written");
        let mut scene = demo_scene();
        scene.camera.vertical_fov = Degrees(31.25);
        scene.objects[1].name = "Widder \u{1f40f} am Fluß".to_owned();
        scene.objects[1].mesh = absolute_mesh(&mesh.to_string_lossy(), Path::new("."));
        let error = ErrorEstimate {
            samples_per_pixel: 7.5,
            rmse: interval(0.25),
            relmse: interval(0.125),
            percentile_999: interval(0.0),
            unmeasured_pixels: 0,
        };
        let origin = Origin {
            scene: &scene,
            error: Some((&error).into()),
            region: None,
            values: Values::Rendered,
        };
        let plain = folder.path().join("scene.toml");
        save_scene(&scene, &plain).expect("saved");
        let expected = load(&plain).expect("a scene file").scene;
        for name in ["picture.png", "picture.exr"] {
            let path = folder.path().join(name);
            write_render(&Image::black(3, 2), &[], &origin, &path).expect("written");
            assert_eq!(load(&path).expect("a render").scene, expected, "{name}");
            let found = WrittenOrigin::of_file(&path).expect("a picture");
            let written = WrittenError {
                rmse: 0.25,
                relmse: 0.125,
                samples_per_pixel: 7.5,
            };
            assert_eq!(found.error, Some(written), "{name}");
        }
    }

    #[test]
    fn a_picture_that_does_not_tell_is_refused_in_words() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for name in ["picture.png", "picture.exr"] {
            let path = folder.path().join(name);
            let (display, output) = (Display::default(), Output::default());
            write_image(&Image::black(3, 2), &[], &display, &output, &path).expect("written");
            let expected = format!(
                "{}: this picture does not tell what was rendered, as pictures of RayMini do",
                path.display()
            );
            assert_eq!(load(&path).expect_err("no scene"), expected);
        }
    }

    /// Wherever the damage is that keeps the scene from being read.
    #[test]
    fn a_damaged_picture_is_called_so() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let scene = demo_scene();
        let origin = Origin {
            scene: &scene,
            error: None,
            region: None,
            values: Values::Rendered,
        };
        for (name, mark) in [("picture.png", &b"iTXt"[..]), ("picture.exr", b"channels")] {
            let path = folder.path().join(name);
            write_render(&Image::black(3, 2), &[], &origin, &path).expect("written");
            let whole = fs::read(&path).expect("a picture");
            let error_with = |bytes: &[u8]| {
                fs::write(&path, bytes).expect("written");
                load(&path).expect_err("is damaged")
            };
            for first in [&b"\0"[..], b"\0\0\0\0", b""] {
                let mut bytes = whole.clone();
                bytes[..first.len()].copy_from_slice(first);
                bytes.truncate(if first.is_empty() { 3 } else { bytes.len() });
                let error = error_with(&bytes);
                assert!(error.ends_with("or its first bytes are damaged"), "{error}");
            }
            let place = whole.windows(mark.len()).position(|bytes| bytes == mark);
            let place = place.expect("is there") + mark.len() + 20;
            let mut errors = vec![error_with(&whole[..place])];
            // OpenEXR has no sums to check.
            if name == "picture.png" {
                let mut bytes = whole.clone();
                bytes[place] ^= 0xff;
                errors.push(error_with(&bytes));
            }
            for error in errors {
                assert!(error.contains(": not a whole "), "{error}");
            }
        }
    }
}
