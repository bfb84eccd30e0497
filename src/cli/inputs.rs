//! What a command reads stays as it is: whatever would be written in its place is refused, or gets another name.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};

use crate::io;
use crate::scene::Scene;

/// Whether two names stand for one file, there or not.
pub(super) fn is_same_file(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| {
        std::fs::canonicalize(path).ok().or_else(|| {
            let absolute = std::path::absolute(path).ok()?;
            let folder = std::fs::canonicalize(absolute.parent()?).ok()?;
            Some(folder.join(absolute.file_name()?))
        })
    };
    let have_one_place = || place(a).is_some_and(|a| place(b) == Some(a));
    are_links_of_one_file(a, b) || have_one_place()
}

/// Whether two names are hard links of one file.
#[cfg(unix)]
fn are_links_of_one_file(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let number = |path| std::fs::metadata(path).map(|found| (found.dev(), found.ino()));
    number(a).is_ok_and(|a| number(b).is_ok_and(|b| a == b))
}

/// The standard library does not tell, and to replace one link leaves the other as it is.
#[cfg(not(unix))]
fn are_links_of_one_file(_a: &Path, _b: &Path) -> bool {
    false
}

/// Whether a mesh or an image of `scene` is read from the file at `path`.
fn is_read(scene: &Scene, path: &Path) -> bool {
    // What is not there is read by nobody.
    let Ok(place) = std::fs::canonicalize(path) else {
        return false;
    };
    let meshes = scene.meshes.keys().map(|name| io::file_and_part(name).0);
    let images = scene.images.keys().chain(scene.textures.keys());
    let mut names = meshes.chain(images.map(String::as_str)).map(Path::new);
    names.any(|name| std::fs::canonicalize(name).is_ok_and(|read| read == place))
}

/// Refuses to write `what` to `path` where `scene` is read from there; `own` is its file, where it has one.
pub(super) fn refuse_input(
    scene: &Scene,
    own: Option<&Path>,
    path: &Path,
    what: &str,
) -> Result<()> {
    if is_read(scene, path) || own.is_some_and(|own| is_same_file(own, path)) {
        let name = path.display();
        bail!("{name}: the scene is read from it; {what} would take its place");
    }
    Ok(())
}

/// A name in `folder` for a picture of what is called `stem`: `stem.png`, or where there is such a file `stem-1.png` and so on.
#[must_use]
pub fn new_picture(folder: &Path, stem: &OsStr) -> PathBuf {
    let named = |ending: &str| {
        let mut name = stem.to_owned();
        name.push(ending);
        folder.join(name)
    };
    let mut path = named(".png");
    let mut number = 0_u64;
    // A link that leads nowhere is somebody's too.
    while path.symlink_metadata().is_ok() {
        number += 1;
        path = named(&format!("-{number}.png"));
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_file_has_many_names() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("a"), "there").expect("is written");
        std::fs::create_dir(path("b")).expect("a folder");
        for (a, b, is_same) in [
            ("a", "./a", true),
            ("a", "b/../a", true),
            ("c", "b/../c", true),
            ("a", "c", false),
            ("c", "b/c", false),
        ] {
            assert_eq!(is_same_file(&path(a), &path(b)), is_same, "{a} {b}");
        }
        #[cfg(unix)]
        {
            std::fs::hard_link(path("a"), path("d")).expect("a link");
            std::os::unix::fs::symlink(path("a"), path("e")).expect("a link");
            assert!(is_same_file(&path("a"), &path("d")) && is_same_file(&path("e"), &path("a")));
        }
    }

    #[test]
    fn a_new_picture_has_a_name_that_nothing_has() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        let new = || new_picture(folder, OsStr::new("box.v2"));
        assert_eq!(new(), folder.join("box.v2.png"));
        std::fs::write(folder.join("box.v2.png"), "precious").expect("is written");
        assert_eq!(new(), folder.join("box.v2-1.png"));
        std::fs::create_dir(folder.join("box.v2-1.png")).expect("a folder");
        assert_eq!(new(), folder.join("box.v2-2.png"));
        assert_eq!(
            new_picture(Path::new(""), OsStr::new("none")),
            Path::new("none.png")
        );
    }
}
