//! Files as scenes name them, and what a name says of a file.

use std::path::{Component, Path, PathBuf};

use super::builtin;
use super::part_name::{self, with_part};
use super::radiance_file::RADIANCE_EXTENSIONS;

/// File name extensions, in lower case, of pictures that may tell what was rendered.
pub const RENDER_EXTENSIONS: &[&str] = &["png", "exr"];

/// Whether `path` is taken for a scene file rather than a mesh.
#[must_use]
pub fn is_scene_file(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

/// Whether `path` is taken for a picture that may tell what was rendered.
#[must_use]
pub fn is_render_file(path: &Path) -> bool {
    path.extension().is_some_and(|extension| {
        RENDER_EXTENSIONS
            .iter()
            .any(|known| extension.eq_ignore_ascii_case(known))
    })
}

/// Whether `path` is taken for an image that can be a background.
#[must_use]
pub fn is_image_file(path: &Path) -> bool {
    path.extension().is_some_and(|extension| {
        RADIANCE_EXTENSIONS
            .iter()
            .any(|known| extension.eq_ignore_ascii_case(known))
    })
}

/// The name under which a scene keeps the mesh that a file in `folder` calls `written`: a path from the root, so that it means
/// the same wherever the scene is saved.
#[must_use]
pub fn absolute_mesh(written: &str, folder: &Path) -> String {
    if written.starts_with(builtin::PREFIX) {
        return written.to_owned();
    }
    match part_name::split(written) {
        Some((file, part)) => with_part(&absolute_image(file, folder), part),
        None => absolute_image(written, folder),
    }
}

/// The name under which a scene keeps the image that a file in `folder` calls `written`; like [`absolute_mesh`], without what
/// is built in.
#[must_use]
pub fn absolute_image(written: &str, folder: &Path) -> String {
    let path = folder.join(written);
    // Fails for an empty path only, which then cannot be read either.
    let path = std::path::absolute(&path).unwrap_or(path);
    without_dots(&path).to_string_lossy().into_owned()
}

/// `path` without `.` and without `x/..`, so that one file has one name.
fn without_dots(path: &Path) -> PathBuf {
    let mut result = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir
                if matches!(result.components().next_back(), Some(Component::Normal(_))) =>
            {
                result.pop();
            }
            other => result.push(other),
        }
    }
    result
}

/// How a scene file in `folder`, an absolute path, calls the mesh kept under `name`.
pub(super) fn relative_mesh(name: &str, folder: &Path) -> String {
    match part_name::split(name) {
        Some((file, part)) => with_part(&relative_path(file, folder), part),
        None => relative_path(name, folder),
    }
}

/// How a scene file in `folder`, an absolute path, calls the image kept under `name`.
pub(super) fn relative_path(name: &str, folder: &Path) -> String {
    let (path, folder) = (Path::new(name), without_dots(folder));
    let (mut there, mut here) = (path.components().peekable(), folder.components().peekable());
    // On another drive, or built in: the full name.
    if !path.is_absolute() || there.peek() != here.peek() {
        return name.to_owned();
    }
    while there.peek().is_some() && there.peek() == here.peek() {
        there.next();
        here.next();
    }
    let steps: PathBuf = here.map(|_| Component::ParentDir).chain(there).collect();
    // Scene files use the slash of the web on every system.
    steps
        .components()
        .map(|c| c.as_os_str().to_string_lossy())
        .collect::<Vec<_>>()
        .join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_parts_stay_as_they_are() {
        let name = absolute_mesh("x/../a.obj#../b/./c", Path::new("/home"));
        assert_eq!(name, "/home/a.obj#../b/./c");
        assert_eq!(
            relative_mesh(&name, Path::new("/home/b")),
            "../a.obj#../b/./c"
        );
    }

    #[test]
    fn mesh_names_survive_moving_the_scene() {
        let name = absolute_mesh("../assets/./ram.off", Path::new("/home/a/scenes"));
        assert_eq!(name, "/home/a/assets/ram.off");
        assert_eq!(
            relative_path(&name, Path::new("/home/a/scenes")),
            "../assets/ram.off"
        );
        assert_eq!(
            relative_path(&name, Path::new("/home/b")),
            "../a/assets/ram.off"
        );
        assert_eq!(relative_path(&name, Path::new("/home/a/assets")), "ram.off");
        assert_eq!(absolute_mesh("builtin:ram", Path::new("/x")), "builtin:ram");
        assert_eq!(relative_path("builtin:ram", Path::new("/x")), "builtin:ram");
    }
}
