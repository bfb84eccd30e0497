//! What loaded files leave to say to the user.

use std::path::Path;

use crate::geometry::{LostDigits, TriangleMesh};
use crate::io::builtin;
use crate::io::mesh_file::MeshFile;
use crate::io::part_name::file_and_part;
use crate::io::radiance_file::RadianceFile;
use crate::io::texture_file::TextureFile;

/// What a loaded mesh file leaves to say to the user; `name` is what the user calls it.
#[must_use]
pub fn mesh_warnings(name: &str, file: &MeshFile) -> Vec<String> {
    file.warnings
        .iter()
        .map(|warning| format!("{name}: {warning}"))
        .collect()
}

/// What is to be said of `meshes` of the file called `name` where digits of their coordinates were lost before it was written: of the one
/// that lost most.
#[must_use]
pub fn lost_digits_warning<'a>(
    name: &str,
    meshes: impl IntoIterator<Item = &'a TriangleMesh>,
) -> Option<String> {
    let lost = meshes.into_iter().filter_map(LostDigits::of);
    let worst = lost.max_by(|a, b| a.of_edge.total_cmp(&b.of_edge))?;
    Some(format!(
        "{name}: {worst}; what was lost is not in the file: move it to the origin in the program that made it, and write it again"
    ))
}

/// What an image file loaded as a background leaves to say to the user; `name` is what the user calls it.
#[must_use]
pub fn image_warnings(name: &str, file: &RadianceFile) -> Vec<String> {
    let (width, height) = (file.map.width(), file.map.height());
    let stretched = format!(
        "the image is {width}×{height}; one that shows all directions is twice as wide as high, {STRETCHED}"
    );
    let is_stretched = u64::from(width) != 2 * u64::from(height);
    file.warnings
        .iter()
        .chain(is_stretched.then_some(&stretched))
        .map(|warning| format!("{name}: {warning}"))
        .collect()
}

/// What the file of a texture leaves to say to the user; `name` is what the user calls it.
#[must_use]
pub fn texture_warnings(name: &str, file: &TextureFile) -> Vec<String> {
    file.warnings
        .iter()
        .map(|warning| format!("{name}: {warning}"))
        .collect()
}

/// By these words the warning of files outside of the scene is known.
pub const READ_FROM_OUTSIDE: &str = "the scene file reads this from outside of";

/// By these words the warning of a background is known that is no image of all directions.
pub const STRETCHED: &str = "so it is stretched";

/// What is said when a scene file in `folder` has a mesh or image read from outside of the folder that holds `folder`. Scenes
/// and meshes in folders side by side are how people keep them; what lies further away the author of the file need not know.
/// Links are followed: the path may look harmless.
pub fn outside_warning(path: &str, folder: &Path) -> Option<String> {
    if path.starts_with(builtin::PREFIX) {
        return None;
    }
    let is_here = folder.as_os_str().is_empty();
    let folder = std::fs::canonicalize(if is_here { Path::new(".") } else { folder }).ok()?;
    // Everything lies in the root.
    let is_folder = |folder: &&Path| folder.parent().is_some();
    let around = folder.parent().filter(is_folder).unwrap_or(&folder);
    let (file, _) = file_and_part(path);
    let real = std::fs::canonicalize(file).unwrap_or_else(|_| file.into());
    let outside = !real.starts_with(around);
    outside.then(|| format!("{path}: {READ_FROM_OUTSIDE} {}", around.display()))
}
