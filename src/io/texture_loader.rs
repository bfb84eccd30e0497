//! Images of materials by the names that scenes keep them under: files, and images within files of glTF (`chair.glb#image 0`).

use std::path::Path;

use super::gltf;
use super::mesh_source::load_beside;
use super::part_name::file_and_part;
use super::radiance_file::RadianceError;
use super::texture_file::{TextureFile, load_texture, parse_texture};
use super::whole_file::read_file;
use crate::control::{CancelToken, Progress};

/// Loads images one after the other. The file that holds the last one is kept: it may hold the next one, too.
#[derive(Default)]
pub struct TextureLoader {
    file: Option<(String, gltf::ImageFile)>,
}

/// Loads images again by their names. `None` when cancelled.
///
/// # Errors
/// Why the first that cannot be loaded cannot: no such file or image, or one that is malformed.
pub fn load_textures_again(
    names: &[String],
    cancel: &CancelToken,
) -> Result<Option<Vec<(String, TextureFile)>>, RadianceError> {
    let mut loader = TextureLoader::default();
    let mut loaded = Vec::new();
    for name in names {
        let Some(file) = loader.load(name, 0, cancel, &Progress::new())? else {
            return Ok(None);
        };
        loaded.push((name.clone(), file));
    }
    Ok(Some(loaded))
}

impl TextureLoader {
    /// Loads the image called `name`; `work`: by how much `progress` advances then. `None` when cancelled.
    ///
    /// # Errors
    /// When the file cannot be read, has no such image, or that is of a format without reader or malformed.
    pub fn load(
        &mut self,
        name: &str,
        work: u64,
        cancel: &CancelToken,
        progress: &Progress,
    ) -> Result<Option<TextureFile>, RadianceError> {
        if cancel.is_cancelled() {
            return Ok(None);
        }
        let (file, Some(part)) = file_and_part(name) else {
            return load_texture(Path::new(name), cancel, progress);
        };
        let bytes = self
            .image_in(file, part, cancel)
            .map_err(|reason| RadianceError {
                name: name.to_owned(),
                reason,
            })?;
        let Some(bytes) = bytes else {
            return Ok(None);
        };
        let loaded = parse_texture(name, &bytes, cancel, &Progress::new());
        progress.advance(work);
        loaded
    }

    /// The bytes of an image in a file; `None` when cancelled.
    fn image_in(
        &mut self,
        file: &str,
        part: &str,
        cancel: &CancelToken,
    ) -> Result<Option<Vec<u8>>, String> {
        let number = gltf::image_number(part).ok_or("there is no such image in the file")?;
        let is_at_hand = self.file.as_ref().is_some_and(|(known, _)| known == file);
        if !is_at_hand {
            let bytes = read_file(Path::new(file), "a file of glTF", cancel, &Progress::new())?;
            let Some(bytes) = bytes else {
                return Ok(None);
            };
            let read = gltf::ImageFile::new(bytes).map_err(|error| error.to_string())?;
            self.file = Some((file.to_owned(), read));
        }
        let Some((_, images)) = &mut self.file else {
            return Ok(None);
        };
        let mut load = |name: &str| load_beside(Path::new(file), name, cancel, &Progress::new());
        let image = images.image(number, &mut load);
        image.map_err(|error| error.to_string())
    }
}
