//! Names of parts of files: `chair.obj#wood` is the part `wood` of the file `chair.obj`.
//!
//! What a name means does not depend on which files there are: the part begins behind the first `#` that follows the extension of a
//! format with parts. Only where a file of the whole name exists is that file meant; see [`file_and_part`].

use std::path::Path;

/// File name extensions, in lower case, of formats whose files have parts.
const EXTENSIONS_WITH_PARTS: [&str; 7] = [".obj", ".ply", ".gltf", ".glb", ".mesh", ".msh", ".off"];

/// What stands between the file and the part.
const SEPARATOR: char = '#';

/// The name of the `part` of a `file`.
#[must_use]
pub fn with_part(file: &str, part: &str) -> String {
    format!("{file}{SEPARATOR}{part}")
}

/// Whether parts of the file of this name can be named.
#[must_use]
pub fn has_parts(file: &str) -> bool {
    EXTENSIONS_WITH_PARTS
        .iter()
        .any(|extension| ends_with(file, extension))
}

/// The file and the part in `name`, if it names a part.
#[must_use]
pub fn split(name: &str) -> Option<(&str, &str)> {
    let mut places = name.match_indices(SEPARATOR);
    let (at, _) = places.find(|&(at, _)| has_parts(&name[..at]))?;
    Some((&name[..at], &name[at + SEPARATOR.len_utf8()..]))
}

/// The file that `name` means, and its part if it names one. A file that is called so goes first.
#[must_use]
pub fn file_and_part(name: &str) -> (&str, Option<&str>) {
    match split(name) {
        Some((file, part)) if !Path::new(name).is_file() => (file, Some(part)),
        _ => (name, None),
    }
}

/// A name for what shows the mesh called `name`: that of its part, or of its file without folder and extension.
#[must_use]
pub fn short_name(name: &str) -> &str {
    match split(name) {
        Some((_, part)) if !part.is_empty() => part,
        _ => {
            let file = name.rsplit(['/', '\\', ':']).next().unwrap_or(name);
            file.split('.').next().unwrap_or(file)
        }
    }
}

fn ends_with(text: &str, extension: &str) -> bool {
    let start = text.len().checked_sub(extension.len());
    start.is_some_and(|start| {
        let end = text.as_bytes().get(start..);
        end.is_some_and(|end| end.eq_ignore_ascii_case(extension.as_bytes()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_stands_behind_the_extension_of_a_format_with_parts() {
        for (name, expected) in [
            ("a.obj#red", Some(("a.obj", "red"))),
            ("a.OBJ#", Some(("a.OBJ", ""))),
            ("b#1/a.glb#x/y#z", Some(("b#1/a.glb", "x/y#z"))),
            ("a.gltf#b.obj#c", Some(("a.gltf", "b.obj#c"))),
            ("ü.obj#ö", Some(("ü.obj", "ö"))),
            ("a.obj", None),
            ("a.off#inner", Some(("a.off", "inner"))),
            ("a.stl#red", None),
            ("#a.obj", None),
            ("builtin:ram#x", None),
        ] {
            assert_eq!(split(name), expected, "{name}");
        }
        assert_eq!(with_part("a.obj", "red"), "a.obj#red");
    }

    #[test]
    fn what_shows_a_mesh_is_called_like_its_part_or_its_file() {
        for (name, expected) in [
            ("a/b.obj#red", "red"),
            ("a/b.obj#", "b"),
            ("c:\\a\\b.stl", "b"),
            ("builtin:ram", "ram"),
        ] {
            assert_eq!(short_name(name), expected, "{name}");
        }
    }

    #[test]
    fn a_file_of_the_whole_name_goes_first() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.obj#red");
        let name = path.to_string_lossy();
        let (file, part) = file_and_part(&name);
        assert!(file.ends_with("a.obj") && part == Some("red"));
        std::fs::write(&path, "").expect("is written");
        assert_eq!(file_and_part(&name), (&*name, None));
    }
}
