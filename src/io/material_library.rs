//! The files of materials that a mesh file names: only those beside it or below are read.

use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};

use super::mesh_file::MaterialLibrary;
use super::mtl::{self, MtlMaterial};
use super::shorten::shortened;
use super::whole_file::read_bounded_file;
use crate::control::{CancelToken, Progress};

/// The most bytes of a file of materials: a hundred thousand fit.
const MOST_BYTES: u64 = 64 << 20;

/// Materials by name.
pub type Definitions = HashMap<String, MtlMaterial>;

/// The materials of the files that the mesh file at `path` names; of two of one name the first counts. What cannot be read, or is not to
/// be, is a warning. `None` when cancelled.
pub fn load_libraries(
    path: &Path,
    libraries: &[MaterialLibrary],
    warnings: &mut Vec<String>,
    cancel: &CancelToken,
) -> Option<Definitions> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut definitions = Definitions::new();
    for MaterialLibrary { line, name } in libraries {
        for name in names_in(name, folder) {
            let at = || {
                format!(
                    "{}:{line}: the file of materials \"{}\"",
                    path.display(),
                    shortened(name)
                )
            };
            let file = match path_below(name, folder) {
                Ok(file) => file,
                Err(reason) => {
                    warnings.push(format!("{} {reason}", at()));
                    continue;
                }
            };
            let expected = "a file of materials";
            match read_bounded_file(&file, expected, MOST_BYTES, cancel, &Progress::new()) {
                Ok(None) => return None,
                Ok(Some(bytes)) => {
                    let name = name.replace('\\', "/");
                    let folder = Path::new(&name).parent().unwrap_or(Path::new(""));
                    take(&file, folder, &bytes, &mut definitions, warnings, cancel)?;
                }
                Err(reason) => warnings.push(format!("{} is left out: {reason}", at())),
            }
        }
    }
    Some(definitions)
}

/// The names of files in what follows `mtllib`: one, which may hold blanks, or several between them.
fn names_in<'a>(text: &'a str, folder: &Path) -> Vec<&'a str> {
    let is_one = path_below(text, folder).is_ok_and(|file| file.is_file());
    let has_several = || {
        let mut words = text.split_whitespace();
        words.all(|word| {
            Path::new(word)
                .extension()
                .is_some_and(|end| end.eq_ignore_ascii_case("mtl"))
        })
    };
    if is_one || !has_several() {
        vec![text]
    } else {
        text.split_whitespace().collect()
    }
}

/// The file in `folder` or below that `name` means.
///
/// # Errors
/// That it means another, in words that follow its name.
pub fn path_below(name: &str, folder: &Path) -> Result<PathBuf, &'static str> {
    const OUTSIDE: &str = "is left out: only files beside the mesh or in folders below are read";
    // Files of Windows are read elsewhere too.
    let relative = PathBuf::from(name.replace('\\', "/"));
    let has_drive = name.as_bytes().get(1) == Some(&b':');
    let is_below = |component| matches!(component, Component::Normal(_) | Component::CurDir);
    if has_drive || !relative.components().all(is_below) {
        return Err(OUTSIDE);
    }
    let file = folder.join(relative);
    // Links are followed: the path may look harmless.
    let here = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    match (std::fs::canonicalize(&file), std::fs::canonicalize(here)) {
        (Ok(real), Ok(here)) if !real.starts_with(&here) => Err(OUTSIDE),
        _ => Ok(file),
    }
}

/// Adds what the `bytes` of a file of materials in a `folder` beside the mesh hold, images named from there; `None` when cancelled.
fn take(
    file: &Path,
    folder: &Path,
    bytes: &[u8],
    definitions: &mut Definitions,
    warnings: &mut Vec<String>,
    cancel: &CancelToken,
) -> Option<()> {
    let name = file.display();
    match mtl::parse(bytes, cancel, &Progress::new()) {
        Ok(None) => return None,
        Ok(Some(read)) => {
            warnings.extend(
                read.warnings
                    .iter()
                    .map(|warning| format!("{name}: {warning}")),
            );
            for (material, mut definition) in read.materials {
                let images = [&mut definition.diffuse_image, &mut definition.normal_image];
                for image in images.into_iter().flatten() {
                    let is_relative = Path::new(image.as_str()).is_relative();
                    if is_relative {
                        *image = folder.join(&*image).to_string_lossy().into_owned();
                    }
                }
                definitions.entry(material).or_insert(definition);
            }
        }
        Err(error) => warnings.push(format!("{name}: {error}; its materials are left out")),
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    /// What is found by the names, and what is warned of, without the folder.
    fn load(folder: &Path, names: &[&str]) -> (Vec<String>, Vec<String>) {
        let library = |(line, name): (usize, &&str)| MaterialLibrary {
            line: line as u64 + 1,
            name: (*name).to_owned(),
        };
        let libraries: Vec<_> = names.iter().enumerate().map(library).collect();
        let mut warnings = Vec::new();
        let path = folder.join("a.obj");
        let found = load_libraries(&path, &libraries, &mut warnings, &CancelToken::new());
        let mut found: Vec<_> = found.expect("nobody cancels").into_keys().collect();
        found.sort();
        let prefix = format!("{}/", folder.display());
        let warnings = warnings.iter().map(|warning| warning.replace(&prefix, ""));
        (found, warnings.collect())
    }

    #[test]
    fn only_files_beside_the_mesh_and_below_are_read() {
        let root = tempfile::tempdir().expect("a folder");
        let folder = root.path().join("models");
        fs::create_dir_all(folder.join("deep")).expect("is made");
        for (name, material) in [
            ("models/a.mtl", "a"),
            ("models/with blank.mtl", "blank"),
            ("models/deep/b.mtl", "b"),
            ("outside.mtl", "outside"),
        ] {
            fs::write(root.path().join(name), format!("newmtl {material}\n")).expect("is written");
        }
        let (found, warnings) = load(&folder, &["a.mtl", "./deep\\b.mtl", "with blank.mtl"]);
        assert_eq!(
            (found, warnings),
            (vec!["a".into(), "b".into(), "blank".into()], vec![])
        );
        let (found, warnings) = load(&folder, &["a.mtl deep/b.mtl"]);
        assert_eq!((found, warnings), (vec!["a".into(), "b".into()], vec![]));

        let absolute = root.path().join("outside.mtl");
        let absolute = absolute.to_string_lossy();
        for name in [
            "../outside.mtl",
            "deep/../../outside.mtl",
            "C:\\x\\outside.mtl",
            &absolute,
        ] {
            let (found, warnings) = load(&folder, &[name]);
            let shown = shortened(name);
            let expected = format!(
                "a.obj:1: the file of materials \"{shown}\" is left out: only files beside the mesh or in folders below are read"
            );
            assert_eq!((found, warnings), (vec![], vec![expected]), "{name}");
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(root.path().join("outside.mtl"), folder.join("link.mtl"))
                .expect("is made");
            let (found, warnings) = load(&folder, &["link.mtl"]);
            assert_eq!((found.len(), warnings.len()), (0, 1));
        }
    }

    #[test]
    fn what_is_missing_or_no_mtl_is_said_and_the_rest_is_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let write =
            |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("is written");
        write("a.mtl", "newmtl a\nKd 1 x 0\n");
        write("no.mtl", "<html>\n");
        let (found, warnings) = load(folder.path(), &["none.mtl", "a.mtl", "no.mtl"]);
        assert_eq!(found, ["a"]);
        let expected = [
            "a.obj:1: the file of materials \"none.mtl\" is left out: there is no such file",
            "a.mtl: 1 value that is no number in its range is ignored (line 2)",
            "no.mtl: line 1: expected newmtl or another keyword of MTL, found \"<html>\"; its materials are left out",
        ];
        assert_eq!(warnings, expected);
    }
}
